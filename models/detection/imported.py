"""Other people's detectors, from a file or a URL: tried, kept in the cache, and known by a name
from then on (models/store/user_entries.py)."""

import os
import re
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from models.checksum import sha256
from models.detection.detector import MODEL_FILE, TEXTS_FILE, TOKENIZER_FILE, TOWER_FILE
from models.detection.told import CLASSES_FILE, CONTRACT_FILE, MAP_FILE, Told
from models.detection.trial import Limits, TrialReport, tried
from models.errors import ModelFileError
from models.store import manifest, sources, user_entries
from models.store.sources import Source
from models.words.class_maps import BUILT_IN, own_map
from models.words.class_names import read_names

NAME = re.compile(r"[a-z0-9][a-z0-9._-]{0,39}")
SHOWN = 12
"""Classes named on a line."""


@dataclass(frozen=True)
class Offer:
    """A detector to take in. `model` and `texts` are paths or URLs; `texts` are rows (.npz) or the
    text tower (.onnx, its tokenizer.json beside it) of a prompted one or of CLIP's kind, or the
    tokenizer (.json) of a grounding one. `classes` of a fixed list: a file with one name a line, a
    map (.toml), or one of BUILT_IN."""

    model: str
    name: str
    classes: str = ""
    texts: str = ""
    layout: str = ""
    normalise: str = ""
    licence: str = manifest.UNKNOWN


@dataclass(frozen=True)
class Imported:
    """What taking in a detector found; `pinned` is what of it came from elsewhere: the URLs, with
    their checksums."""

    path: Path
    trial: TrialReport
    pinned: dict[str, str]


def take_in(offer: Offer, limits: Limits, progress: manifest.Progress | None = None) -> Imported:
    """Try an ONNX detector and keep it by its name. Raises ModelFileError, keeping nothing.

    A name taken in before is replaced, but not what came from a URL by other content.
    """
    name, home = offer.name, manifest.cache_dir() / offer.name
    if not NAME.fullmatch(name):
        raise ModelFileError(f"{name!r}: not a name; use up to 40 of a-z, 0-9, '.', '_' and '-'")
    if name in manifest.load_manifest(manifest.MANIFEST, users=False):
        raise ModelFileError(f"{name}: is a model of the project; choose another name")
    origins = _origins(offer)
    try:
        home.parent.mkdir(parents=True, exist_ok=True)
        work = Path(tempfile.mkdtemp(prefix=".partial-", dir=home.parent))
    except OSError as error:
        raise ModelFileError(f"{home.parent}: cannot be written ({error.strerror})") from error
    try:
        for file, source in origins.items():
            sources.deliver(source, work, work, work / file, progress)
        pinned = _pinned(name, work, origins)
        trial = _tried(work, origins, limits)
        shutil.rmtree(home, ignore_errors=True)
        os.replace(work, home)
    except OSError as error:
        raise ModelFileError(f"{error.filename or home}: {error.strerror or error}") from error
    finally:
        shutil.rmtree(work, ignore_errors=True)
    user_entries.enter(
        name, home, origins, task="detector", licence=offer.licence,
        about=f"taken in from {_from(origins[MODEL_FILE])}",
        contract=str(trial.capabilities["contract"]),
    )  # fmt: skip
    return Imported(home, trial, pinned)


def _origins(offer: Offer) -> dict[str, Source]:
    """Names in the cache -> where each file comes from."""
    files = {MODEL_FILE: _source(offer.model)}
    texts = offer.texts.partition("?")[0]
    if texts.endswith(".npz"):
        files[TEXTS_FILE] = _source(texts)
    elif texts.endswith(".json"):
        files[TOKENIZER_FILE] = _source(texts)
    elif texts:
        folder = texts.rpartition("/")[0] or "."
        files |= {TOWER_FILE: _source(texts), TOKENIZER_FILE: _source(f"{folder}/tokenizer.json")}
    told = Told(offer.layout, offer.normalise)
    if offer.classes in BUILT_IN:
        told = told._replace(classes=offer.classes)
    elif offer.classes.endswith(".toml"):
        own_map(Path(offer.classes))  # so that what is wrong with it names this file
        files[MAP_FILE] = _text(Path(offer.classes))
    elif offer.classes:
        read_names(Path(offer.classes))
        files[CLASSES_FILE] = _text(Path(offer.classes))
    if any(told):
        lines = [f'{key} = "{value}"\n' for key, value in told._asdict().items() if value]
        files[CONTRACT_FILE] = Source(text="".join(lines))
    return files


def _source(place: str) -> Source:
    if "://" in place:
        return Source(url=place)
    if not Path(place).is_file():
        raise ModelFileError(f"{place}: no such file")
    return Source(file=str(Path(place).resolve()))


def _text(path: Path) -> Source:
    return Source(text=path.read_text(encoding="utf-8"))


def _from(source: Source) -> str:
    return source.file or source.url or "what was told"


def _pinned(name: str, work: Path, origins: dict[str, Source]) -> dict[str, str]:
    """Checksums of what came from URLs. Raises ModelFileError where that of the same name was
    another."""
    known = manifest.load_manifest().get(name)
    before = {
        file.name: file.sha256 for file in (known.files if known else ()) if file.sources[0].url
    }
    found = {}
    for file, source in origins.items():
        if not source.url:
            continue
        digest = found[source.url] = sha256(work / file)
        if before.get(file, digest) != digest:
            raise ModelFileError(
                f"{source.url}: refused: sha256 is {digest[:12]}…, that of {name} is pinned to "
                f"{before[file][:12]}…; if both are meant, add it by another name"
            )
    return found


def _tried(work: Path, origins: dict[str, Source], limits: Limits) -> TrialReport:
    try:
        return tried(work, limits)
    except ModelFileError as error:
        said = str(error)
        for copy, origin in origins.items():
            said = said.replace(str(work / copy), _from(origin))
        raise ModelFileError(said.replace(str(work), _from(origins[MODEL_FILE]))) from error


def describe(capabilities: dict[str, Any]) -> list[str]:
    """What a detector can and cannot do, in lines for a person."""
    fixed, matched = capabilities["classes"], capabilities.get("matched", {})
    unseen = capabilities.get("unseen", [])
    lines = [f"contract: {capabilities['contract']}"]
    if fixed is not None:
        how = "matched to the goal by similarity"
        if capabilities["class_map"]:
            how = f"{capabilities['class_map']}, each read as one of ours or none"
        lines.append(f"classes: a fixed list of {len(fixed)}, {how}")
        pairs = sorted((-s, c, n) for c, by in matched.items() for n, s in by.items())
        lines.append(
            f"matched: {', '.join(f'{c} <- {n} ({-s:.2f})' for s, c, n in pairs) or 'none'}"
        )
    else:
        lines.append("classes: any text")
    if unseen:
        lines.append(f"cannot be seen: {_some(unseen)}")
    lines.append(f"room types: {'yes' if capabilities['rooms'] else 'no'}")
    lines.append(f"region embeddings: {'yes' if capabilities['embeddings'] else 'no'}")
    return lines


def _some(names: list[str]) -> str:
    more = f", and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return (", ".join(names[:SHOWN]) or "none") + more
