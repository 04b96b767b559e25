"""Other people's detectors: tried, copied into the cache, and known by a name from then on.

What is imported is listed in `$XDG_DATA_HOME/rf-nav/models.toml`, in the manifest's format.
"""

import json
import os
import re
import shutil
import tempfile
import time
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from models.checksum import sha256
from models.detection.detections import Detector
from models.detection.detector import (
    MODEL_FILE,
    TEXTS_FILE,
    TOKENIZER_FILE,
    TOWER_FILE,
    open_detector,
)
from models.detection.grounding import GroundingDetector
from models.detection.told import CLASSES_FILE
from models.errors import ModelFileError
from models.store import manifest
from models.words.text_encoder import TextEncoder
from models.words.vocabulary import load_vocabulary

NAME = re.compile(r"[a-z0-9][a-z0-9._-]{0,39}")
HEAD = "# Models that `rfnav models import` took in.\n"
SHOWN = 12
"""Classes named on a line."""


@dataclass(frozen=True)
class Imported:
    """What an import found: the detector's capabilities, and what a 640x480 frame took, ms."""

    path: Path
    capabilities: dict[str, Any]
    frame_ms: float


def import_detector(
    file: Path, name: str, encoder: TextEncoder, classes: Path | None, texts: Path | None
) -> Imported:
    """Try an ONNX detector and keep it as `name`. Raises ModelFileError, keeping nothing.

    `classes`: names of a fixed list, one a line. `texts`: rows (.npz) or the text tower (.onnx, its
    tokenizer.json beside it) of a prompted one or of CLIP's kind, the tokenizer (.json) of a
    grounding one. A name imported before is replaced.
    """
    if not NAME.fullmatch(name):
        raise ModelFileError(f"{name!r}: not a name; use up to 40 of a-z, 0-9, '.', '_' and '-'")
    if name in manifest.load_manifest(manifest.MANIFEST, users=False):
        raise ModelFileError(f"{name}: is a model of the project; choose another name")
    home = manifest.cache_dir() / name
    try:
        home.parent.mkdir(parents=True, exist_ok=True)
        work = Path(tempfile.mkdtemp(prefix=".partial-", dir=home.parent))
    except OSError as error:
        raise ModelFileError(f"{home.parent}: cannot be written ({error.strerror})") from error
    try:
        origins = _copy(_wanted(file, classes, texts), work)
        detector, frame_ms = _tried(work, encoder, origins)
        shutil.rmtree(home, ignore_errors=True)
        os.replace(work, home)
    except OSError as error:
        raise ModelFileError(f"{error.filename or home}: {error.strerror or error}") from error
    finally:
        shutil.rmtree(work, ignore_errors=True)
    _enter(name, home, origins, str(detector.capabilities["contract"]))
    return Imported(home, detector.capabilities, frame_ms)


def _wanted(file: Path, classes: Path | None, texts: Path | None) -> dict[str, Path]:
    """Names in the cache -> files that are copied there."""
    files = {MODEL_FILE: file}
    if classes is not None:
        files[CLASSES_FILE] = classes
    if texts is not None and texts.suffix == ".npz":
        files[TEXTS_FILE] = texts
    elif texts is not None and texts.suffix == ".json":
        files[TOKENIZER_FILE] = texts
    elif texts is not None:
        files |= {TOWER_FILE: texts, TOKENIZER_FILE: texts.parent / TOKENIZER_FILE}
    return files


def _copy(files: dict[str, Path], work: Path) -> dict[str, Path]:
    for name, source in files.items():
        if not source.is_file():
            raise ModelFileError(f"{source}: no such file")
        shutil.copyfile(source, work / name)
    return {name: source.resolve() for name, source in files.items()}


def _tried(work: Path, encoder: TextEncoder, origins: dict[str, Path]) -> tuple[Detector, float]:
    """The detector, after it has answered for frames of several kinds as its contract says."""
    try:
        detector = open_detector(work, "auto", encoder)
        words = load_vocabulary()
        detector.set_vocabulary(words.objects, words.rooms)
        if isinstance(detector, GroundingDetector):
            detector.look_for(0)  # else it need not look
        return detector, _trial_ms(detector, work / MODEL_FILE)
    except ModelFileError as error:
        said = str(error)
        for copy, origin in origins.items():
            said = said.replace(str(work / copy), str(origin))
        raise ModelFileError(said) from error


def _trial_ms(detector: Detector, path: Path) -> float:
    noise = np.random.default_rng(0).integers(0, 255, (480, 640, 3), dtype=np.uint8)
    for frame in (noise[:1, :1], np.zeros_like(noise), noise):
        began_s = time.perf_counter()
        seen = detector.detect(np.ascontiguousarray(frame))
        took_s = time.perf_counter() - began_s
        if not (np.isfinite(seen.boxes_px).all() and (seen.scores <= 1).all()):
            raise ModelFileError(
                f"{path}: gives scores above 1; export it with its last activation, so that they "
                "are in 0..1"
            )
    return 1000 * took_s


def _enter(name: str, home: Path, origins: dict[str, Path], contract: str) -> None:
    path = manifest.user_manifest()
    known = tomllib.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    files = [
        {
            "name": file,
            "bytes": (home / file).stat().st_size,
            "sha256": sha256(home / file),
            "sources": [{"file": str(origin)}],
        }
        for file, origin in origins.items()
    ]
    known[name] = {
        "task": "detector",
        "licence": "unknown",
        "about": f"imported from {origins[MODEL_FILE]}",
        "contract": contract,
        "files": files,
    }
    partial = path.with_suffix(".partial")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        partial.write_text(HEAD + "".join(_section(n, body) for n, body in known.items()), "utf-8")
        os.replace(partial, path)
    except OSError as error:
        raise ModelFileError(f"{path}: cannot be written ({error.strerror})") from error


def _section(name: str, body: dict[str, Any]) -> str:
    lines = [f"\n[{_toml(name)}]"]
    lines += [f"{key} = {_toml(value)}" for key, value in body.items() if key != "files"]
    for file in body["files"]:
        sources = ", ".join(f"{{ file = {_toml(s['file'])} }}" for s in file["sources"])
        lines.append(f"[[{_toml(name)}.files]]")
        lines += [f"{key} = {_toml(file[key])}" for key in ("name", "bytes", "sha256")]
        lines.append(f"sources = [{sources}]")
    return "\n".join(lines) + "\n"


def _toml(value: object) -> str:
    """A string or a number as TOML; JSON's escapes are TOML's."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


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
