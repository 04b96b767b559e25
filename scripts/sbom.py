"""See scripts/sbom. What pyproject.toml asks for with the extra `robot`, and what that asks for, as
it is installed; the models that a robot needs, as models/manifest.toml has them."""

import json
import platform
import sys
import tomllib
from collections.abc import Iterable, Mapping
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

from cyclonedx.contrib.hash.factories import HashTypeFactory
from cyclonedx.contrib.license.factories import LicenseFactory
from cyclonedx.model.bom import Bom
from cyclonedx.model.component import Component, ComponentType
from cyclonedx.model.license import License
from cyclonedx.output import make_outputter
from cyclonedx.schema import OutputFormat, SchemaVersion
from cyclonedx.spdx import fixup_id
from packageurl import PackageURL
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parent.parent
CLASSIFIER = "License :: OSI Approved :: "
SPDX = {
    "MIT License": "MIT",
    "Mozilla Public License 2.0 (MPL 2.0)": "MPL-2.0",
    "Eclipse Public License 2.0 (EPL-2.0)": "EPL-2.0",
    "GNU Lesser General Public License v3 (LGPLv3)": "LGPL-3.0-only",
}
"""Of the classifiers those that say one licence; "BSD License" is several."""
SHORT = 60  # a licence's name; what is longer is its text


def main() -> int:
    if len(sys.argv) > 2:
        print("sbom: say scripts/sbom [FILE]", file=sys.stderr)
        return 2
    try:
        text = bill(ROOT)
    except PackageNotFoundError as error:
        print(f"sbom: {error.name} is not installed: run scripts/setup", file=sys.stderr)
        return 2
    if len(sys.argv) == 2:
        Path(sys.argv[1]).write_text(text, encoding="utf-8")
    else:
        print(text)
    return 0


def bill(root: Path) -> str:
    """CycloneDX 1.6, JSON. PackageNotFoundError for a package that should be here."""
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    manifest = tomllib.loads((root / "models" / "manifest.toml").read_text(encoding="utf-8"))
    bom = Bom()
    own = bom.metadata.component = Component(
        name=project["name"],
        version=project["version"],
        type=ComponentType.APPLICATION,
        bom_ref=project["name"],
        licenses=_licences(project["license"]),
    )
    asked = of_a_robot(project)
    there = installed(asked)
    parts = {name: package(found) for name, (found, _) in there.items()}
    used = models_of(manifest)
    others = [interpreter(), *(model(name, manifest[name]) for name in used)]
    for part in (*parts.values(), *others):
        bom.components.add(part)
    bom.register_dependency(own, [*(parts[n] for n in names(needed(asked))), *others])
    for name, (_, below) in there.items():
        bom.register_dependency(parts[name], [parts[other] for other in below])
    writer = make_outputter(bom, OutputFormat.JSON, SchemaVersion.V1_6)
    return writer.output_as_string(indent=1)


def of_a_robot(project: Mapping[str, Any]) -> list[str]:
    """Requirements of what scripts/bundle puts together: of RF-NAV and of the extras in `robot`."""
    extras = project["optional-dependencies"]
    chosen = sorted(name for text in extras["robot"] for name in Requirement(text).extras)
    return [*project["dependencies"], *(text for name in chosen for text in extras[name])]


def needed(requirements: Iterable[str], extras: Iterable[str] = ()) -> list[Requirement]:
    """What is asked for on this machine, without extras but those given."""
    chosen = [{"extra": extra} for extra in ("", *extras)]
    return [
        r
        for r in map(Requirement, requirements)
        if r.marker is None or any(r.marker.evaluate(extra) for extra in chosen)
    ]


def installed(requirements: Iterable[str]) -> dict[str, tuple[Distribution, list[str]]]:
    """By name: what is asked for, and what that asks for, to the end; each with the names of what
    it asks for itself, its extras that somebody asked for among it."""
    extras: dict[str, set[str]] = {}
    waiting = needed(requirements)
    while waiting:
        asked = waiting.pop()
        name = canonicalize_name(asked.name)
        if name in extras and asked.extras <= extras[name]:
            continue
        extras.setdefault(name, set()).update(asked.extras)
        waiting += needed(distribution(name).requires or (), extras[name])
    found = {name: distribution(name) for name in sorted(extras)}
    return {
        name: (one, names(needed(one.requires or (), extras[name]))) for name, one in found.items()
    }


def names(requirements: Iterable[Requirement]) -> list[str]:
    return [canonicalize_name(requirement.name) for requirement in requirements]


def package(found: Distribution) -> Component:
    """With the checksum of the archive where pip kept it: for what was built here."""
    name = canonicalize_name(found.name)
    direct = json.loads(found.read_text("direct_url.json") or "{}")
    checksums = direct.get("archive_info", {}).get("hashes", {})
    return Component(
        name=name,
        version=found.version,
        type=ComponentType.LIBRARY,
        bom_ref=f"pypi/{name}",
        purl=PackageURL("pypi", None, name, found.version),
        licenses=_licences(*licences(found)),
        hashes=[
            HashTypeFactory().from_hashlib_alg(kind, digest) for kind, digest in checksums.items()
        ],
    )


def licences(found: Distribution) -> list[str]:
    """As exactly as its metadata has it: an expression, an SPDX name, classifiers, a name."""
    told = found.metadata
    expression, by_hand = told.get("License-Expression"), told.get("License") or ""
    if expression or fixup_id(by_hand):
        return [expression or by_hand]
    classifiers = told.get_all("Classifier") or ()
    names = [c.removeprefix(CLASSIFIER) for c in classifiers if c.startswith(CLASSIFIER)]
    return [SPDX.get(name, name) for name in names] or [by_hand] * (len(by_hand) <= SHORT)


def interpreter() -> Component:
    return Component(
        name=platform.python_implementation().lower(),
        version=platform.python_version(),
        type=ComponentType.PLATFORM,
        bom_ref="python",
        licenses=_licences("Python-2.0"),
    )


def models_of(manifest: Mapping[str, Mapping[str, object]]) -> list[str]:
    """What every robot fetches, and what the default configuration names."""
    sys.path.insert(0, str(ROOT))  # this checkout's, wherever another one is installed
    from runtime.config import ModelsConfig

    named = ModelsConfig()
    chosen = {named.language, named.second_look, *named.detectors}
    return [name for name, entry in manifest.items() if entry.get("default") or name in chosen]


def model(name: str, entry: Mapping[str, object]) -> Component:
    """Each file of it with its sha256."""
    files = entry["files"]
    assert isinstance(files, list)
    inside = [
        Component(
            name=file["name"],
            type=ComponentType.FILE,
            bom_ref=f"model/{name}/{file['name']}",
            hashes=[HashTypeFactory().from_hashlib_alg("sha256", file["sha256"])],
        )
        for file in files
    ]
    return Component(
        name=name,
        type=ComponentType.MACHINE_LEARNING_MODEL,
        bom_ref=f"model/{name}",
        description=str(entry.get("about", "")),
        licenses=_licences(str(entry["licence"])),
        components=inside,
    )


def _licences(*names: str) -> list[License]:
    """An expression stands alone; names that are no SPDX ones are kept as they are."""
    return [LicenseFactory().make_from_string(name) for name in names if name]


if __name__ == "__main__":
    sys.exit(main())
