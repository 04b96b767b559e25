"""Models by name: where they come from, where they lie, and whether they are what they claim.

A file counts only when its sha256 is the manifest's. What arrives with another is refused and
not kept; a download in progress has a temporary name, so that a file with its final name is
whole.
"""

import contextlib
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from models.checksum import sha256
from models.errors import ModelFileError
from models.store import sources
from models.toml_text import read_toml

PACKAGE = Path(__file__).parents[1]
MANIFEST = PACKAGE / "manifest.toml"

PERMISSIVE = frozenset(
    {"Apache-2.0", "MIT", "BSD-2-Clause", "BSD-3-Clause", "ISC", "0BSD", "Zlib", "Unlicense"}
    | {"CC0-1.0", "CC-BY-3.0", "CC-BY-4.0"}
)
"""Licences, by their SPDX names, under which a model is fetched without more ado."""
UNKNOWN = "unknown"

Progress = Callable[[str, int, int], None]
"""Called as (what is arriving, bytes so far, bytes in all or 0)."""


@dataclass(frozen=True)
class ModelFile:
    """One file of a model: its name in the cache, size in bytes (0: not told, the checksum has to
    do), checksum and sources in order."""

    name: str
    size: int
    sha256: str
    sources: tuple[sources.Source, ...]


@dataclass(frozen=True)
class Entry:
    """A model of the manifest."""

    name: str
    task: str
    files: tuple[ModelFile, ...]
    default: bool
    licence: str
    about: str
    contract: str
    style: str = "score"  # of a language or vision model: "score" or "reason"
    handler: str = ""  # of a vision model: see models/language/vision.py
    terms: str = ""  # where its licence can be read, if that is not permissive
    beside: str = ""  # of a scene layout: the detector whose features it was taught on

    @property
    def size(self) -> int:
        """Bytes of all files; 0 where that of one is not known."""
        return sum(f.size for f in self.files) if all(f.size for f in self.files) else 0


def check_licence(name: str, licence: str, accepted: str, command: str, terms: str = "") -> None:
    """Raise ModelFileError unless a licence is permissive, or was `accepted` by its name. `terms`:
    where it can be read."""
    choices = [one.split(" AND ") for one in licence.split(" OR ")]
    permissive = any(all(part in PERMISSIVE for part in parts) for parts in choices)
    if not permissive and accepted.lower() != licence.lower():
        raise ModelFileError(
            f"{name}: its licence is {licence}{f' ({terms})' if terms else ''}, which may ask "
            f"something of you; when you have read it, `{command} --accept-licence {licence}`"
        )


def cache_dir() -> Path:
    """`$XDG_CACHE_HOME/rf-nav/models`, with the XDG default."""
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "rf-nav" / "models"


def user_manifest() -> Path:
    """`$XDG_DATA_HOME/rf-nav/models.toml`, with the XDG default: what was imported or added."""
    base = os.environ.get("XDG_DATA_HOME") or str(Path.home() / ".local" / "share")
    return Path(base) / "rf-nav" / "models.toml"


def load_manifest(path: Path = MANIFEST, users: bool = True) -> dict[str, Entry]:
    """Read the manifest; with the project's, what the user imported, unless `users` is False.

    Raises ModelFileError naming the model whose entry is wrong.
    """
    try:
        table = read_toml(path)
    except (OSError, ValueError) as error:
        raise ModelFileError(f"{path}: not a readable manifest ({error})") from error
    entries = {name: _entry(path, name, body) for name, body in table.items()}
    if path == MANIFEST and users and user_manifest().is_file():
        return load_manifest(user_manifest()) | entries
    return entries


def _entry(path: Path, name: str, body: dict[str, Any]) -> Entry:
    try:
        files = tuple(
            ModelFile(
                name=_file_name(f["name"]),
                size=int(f.get("bytes", 0)),
                sha256=_text(f["sha256"]),
                sources=tuple(sources.Source(**s) for s in f["sources"]),
            )
            for f in body["files"]
        )
        return Entry(
            name=_file_name(name),
            task=_text(body["task"]),
            files=files,
            default=bool(body.get("default", False)),
            licence=_text(body["licence"]),
            about=_text(body.get("about", "")),
            contract=_text(body.get("contract", "")),
            style=_text(body.get("style", "score")),
            handler=_text(body.get("handler", "")),
            terms=_text(body.get("terms", "")),
            beside=_text(body.get("beside", "")),
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        wrong = " ".join(str(error).split())[:200]
        raise ModelFileError(f"{path}: model {name!r}: wrong or missing key: {wrong}") from error


def _text(value: object) -> str:
    if not isinstance(value, str) or not value.replace("\n", " ").isprintable():
        raise ValueError(f"{value!r:.60} is no text")
    return value


def _file_name(value: object) -> str:
    """One that stays in the folder that it is put in."""
    name = _text(value)
    if not name.strip(".") or "/" in name:
        raise ValueError(f"{name!r:.60} is no name of a file")
    return name


def entry(name: str, manifest: Path = MANIFEST) -> Entry:
    """The manifest's entry of that name; an unknown name lists the known ones."""
    known = load_manifest(manifest)
    if name not in known:
        raise ModelFileError(f"{name}: no such model; known are {', '.join(sorted(known))}")
    return known[name]


def fetch(
    name: str, progress: Progress | None = None, manifest: Path = MANIFEST, accepted: str = ""
) -> Path:
    """Path of a model, verified; what is missing or damaged is fetched first, from elsewhere only
    when its licence is permissive or `accepted`.

    One file: the path of the file. Several: the path of the directory that holds them.
    """
    model = entry(name, manifest)
    paths = [_obtain(model, f, progress, manifest, accepted) for f in model.files]
    return _location(model, paths)


def by_path(name: str) -> bool:
    """Whether this is the path of a file, or of a directory with a suffix, and no model's name."""
    path = Path(name)
    return bool(path.suffix) and (path.exists() or "/" in name)


def located(name: str) -> Path:
    """A path as it is, else a model's, fetched when it is not here."""
    return Path(name) if by_path(name) else fetch(name)


def first_file(name: str) -> Path:
    """A path to a file as it is, else the first of a model's files, fetched when it is not here.
    Raises ModelFileError."""
    path = located(name)
    return next(p for p in sorted(path.iterdir()) if p.is_file()) if path.is_dir() else path


def called(name: str) -> str:
    """What a model goes by: its name; of a path the name of the model whose only file has the same
    bytes, else the path."""
    path = Path(name)
    if not by_path(name) or not path.is_file():
        return name
    size = path.stat().st_size
    alike = [m for m in load_manifest().values() if len(m.files) == 1 and m.size == size]
    digest = sha256(path) if alike else ""
    return next((m.name for m in alike if m.files[0].sha256 == digest), name)


def locate(name: str, manifest: Path = MANIFEST) -> Path:
    """Path of a model that is already here, verified; never downloads.

    Raises ModelFileError with the command that repairs it.
    """
    model = entry(name, manifest)
    return _location(model, [_present(model, f, manifest) for f in model.files])


def verify(name: str, manifest: Path = MANIFEST) -> None:
    """Raise ModelFileError when a model is missing or damaged."""
    locate(name, manifest)


def _location(model: Entry, paths: list[Path]) -> Path:
    return paths[0] if len(paths) == 1 else cache_dir() / model.name


def _packaged(file: ModelFile, manifest: Path) -> Path | None:
    for source in file.sources:
        if source.file:
            return manifest.parent / source.file
    return None


def _present(model: Entry, file: ModelFile, manifest: Path) -> Path:
    remedy = f"run `rfnav models pull {model.name}`"
    cached = cache_dir() / model.name / file.name
    packaged = _packaged(file, manifest)
    if packaged is not None and len(model.files) == 1 and not cached.exists():
        path, remedy = packaged, "restore it from the repository"
    else:
        path = cached
    if not path.is_file():
        raise ModelFileError(f"{path}: model {model.name} is missing; {remedy}")
    found = sha256(path)
    if found != file.sha256:
        raise ModelFileError(
            f"{path}: damaged: sha256 {found[:12]}…, expected {file.sha256[:12]}…; {remedy}"
        )
    return path


def _obtain(
    model: Entry, file: ModelFile, progress: Progress | None, manifest: Path, accepted: str
) -> Path:
    try:
        return _present(model, file, manifest)
    except ModelFileError:
        pass
    if not all(source.here for source in file.sources):
        command = f"rfnav models pull {model.name}"
        check_licence(model.name, model.licence, accepted, command, model.terms)
    target = cache_dir() / model.name / file.name
    failures = []
    for source in file.sources:
        try:
            with _arriving(target) as (work, partial):
                most = file.size or sources.MOST_BYTES
                sources.deliver(source, manifest.parent, work, partial, progress, most)
                _admit(partial, file, target)
            return target
        except ModelFileError as error:
            failures.append(str(error))
    raise ModelFileError(
        f"{model.name}: {file.name}: {'; '.join(failures) or 'no source is given'}"
    )


def _admit(partial: Path, file: ModelFile, target: Path) -> None:
    found = sha256(partial)
    if found != file.sha256:
        raise ModelFileError(
            f"refused: sha256 is {found[:12]}…, {file.sha256[:12]}… is what it must be"
        )
    os.replace(partial, target)


@contextlib.contextmanager
def _arriving(target: Path) -> Iterator[tuple[Path, Path]]:
    """A scratch directory beside the target, gone afterwards, and the partial file in it."""
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        work = Path(tempfile.mkdtemp(prefix=".partial-", dir=target.parent))
    except OSError as error:
        raise ModelFileError(f"{target.parent}: cannot be written ({error.strerror})") from error
    try:
        yield work, work / target.name
    except OSError as error:
        raise ModelFileError(f"{target}: {error.strerror or error}") from error
    finally:
        shutil.rmtree(work, ignore_errors=True)
