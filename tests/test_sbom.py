"""What is on a robot, as it is told to those who look for holes in it."""

import importlib.util
import json
import sys
import tomllib
from typing import Any

import pytest
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from places import ROOT

from runtime.config import ModelsConfig


def _load() -> Any:
    spec = importlib.util.spec_from_file_location("sbom", ROOT / "scripts" / "sbom.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


sbom = _load()


@pytest.fixture(scope="module")
def text() -> str:
    return sbom.bill(ROOT)


def test_it_is_cyclonedx(text: str) -> None:
    assert JsonStrictValidator(SchemaVersion.V1_6).validate_str(text) is None


def test_it_has_what_a_robot_needs_and_no_tools_of_ours(text: str) -> None:
    parts = {part["bom-ref"]: part for part in json.loads(text)["components"]}
    pins = dict(
        line.lower().replace("_", "-").split("==")
        for line in (ROOT / "constraints.txt").read_text().splitlines()
        if "==" in line
    )
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    for asked in (*project["dependencies"], *extras["agents"], *extras["mqtt"], *extras["view"]):
        name = asked.partition(">=")[0]
        assert parts[f"pypi/{name}"]["version"] == pins[name]
    assert "pypi/httpcore" in parts  # by way of httpx
    assert not {"pypi/pytest", "pypi/pybullet", "pypi/cyclonedx-python-lib"} & parts.keys()
    assert [p["name"] for p in parts.values() if not p["licenses"]] == []


def test_models_are_there_with_their_checksums(text: str) -> None:
    parts = {part["bom-ref"]: part for part in json.loads(text)["components"]}
    manifest = tomllib.loads((ROOT / "models" / "manifest.toml").read_text())
    named = ModelsConfig()
    for name in ("minilm", named.language, *named.detectors, named.second_look):
        entry = manifest[name]
        found = parts[f"model/{name}"]
        files = {f["name"]: f["hashes"] for f in found["components"]}
        assert files == {
            f["name"]: [{"alg": "SHA-256", "content": f["sha256"]}] for f in entry["files"]
        }
        [licence] = found["licenses"]
        assert entry["licence"] in (licence.get("expression"), licence.get("license", {}).get("id"))


def test_what_hangs_on_what_is_told_down_from_the_robot(text: str) -> None:
    below = {d["ref"]: d.get("dependsOn", []) for d in json.loads(text)["dependencies"]}
    reached, waiting = set(), ["rf-nav"]
    while waiting:
        waiting += [ref for ref in below.get(waiting[0], []) if ref not in reached]
        reached.add(waiting.pop(0))
    parts = {part["bom-ref"] for part in json.loads(text)["components"]}
    assert parts - reached == set()


def test_what_is_not_installed_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def missing(_: object) -> str:
        raise sbom.PackageNotFoundError("numpy")

    monkeypatch.setattr(sbom, "bill", missing)
    monkeypatch.setattr(sys, "argv", ["sbom"])
    assert sbom.main() == 2
    assert capsys.readouterr().err == "sbom: numpy is not installed: run scripts/setup\n"
