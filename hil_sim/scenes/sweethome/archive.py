"""A `.sh3d` file: a zip with `Home.xml` and the contents that its furniture refers to."""

import io
import re
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Self
from urllib.parse import unquote

from hil_sim.scenes.format import SceneError

MAX_XML = 64 << 20
MAX_MODEL = 128 << 20
MAX_IMAGE = 32 << 20
"""Bytes, unpacked: more is taken for a damaged or a hostile file."""
_DAMAGE = (zipfile.BadZipFile, zlib.error, EOFError, OSError, RuntimeError, NotImplementedError)


@dataclass(frozen=True)
class ModelFiles:
    """A piece's 3D model as it is in the archive: `main` names the entry of `files`."""

    main: str
    files: dict[str, bytes]

    @property
    def kind(self) -> str:
        """ "obj", or what else it is: its suffix, or "unknown format"."""
        head = self.files[self.main][:4096]
        suffix = PurePosixPath(self.main).suffix.lower().lstrip(".")
        if suffix == "obj" or re.search(rb"^(v|mtllib|g|o) ", head, re.MULTILINE):
            return "obj"
        if head[:2] == b"MM":
            return "3ds"
        return suffix if re.fullmatch("[a-z0-9]{1,5}", suffix) else "unknown format"


class Archive:
    """An open `.sh3d`. SceneError names the file and the place of what cannot be used."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self._zip = zipfile.ZipFile(path)
        except FileNotFoundError:
            raise SceneError(f"{path}: no such file") from None
        except zipfile.BadZipFile as error:
            raise SceneError(f"{path}: not a Sweet Home 3D file (not a zip: {error})") from None
        except (OSError, ValueError, NotImplementedError) as error:
            raise SceneError(f"{path}: cannot be read: {error}") from None
        self._entries = {info.filename: info for info in self._zip.infolist()}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._zip.close()

    def home_xml(self) -> bytes:
        """The drawing. A file that holds it only as a Java object is refused with the remedy."""
        if "Home.xml" in self._entries:
            return self._read("Home.xml", MAX_XML)
        if "Home" in self._entries:
            raise SceneError(
                f"{self.path}: Home.xml: missing, the drawing is there only as a Java object; open "
                "and save it with Sweet Home 3D 5.3 or newer (version 7 was tried)"
            )
        raise SceneError(f"{self.path}: Home.xml: missing; not a Sweet Home 3D file")

    def model(self, name: str) -> ModelFiles | None:
        """The model that an attribute `model` names: "12/chair.obj" with what lies beside it, or
        "12", a file or a zip of its own. None when the archive does not hold it."""
        found = next((n for n in (name, unquote(name)) if n in self._entries), None)
        if found is None:
            return None
        folder, slash, _ = found.partition("/")
        if slash:
            names = [n for n in self._entries if n.startswith(f"{folder}/") and n[-1] != "/"]
            files = self._read_all(found, names)
            return ModelFiles(found, files)
        content = self._read(found, MAX_MODEL)
        return self._nested(found, content) if content[:2] == b"PK" else ModelFiles(
            found, {found: content}
        )  # fmt: skip

    def image(self, name: str) -> bytes | None:
        """A texture's bytes; None when the archive does not hold it."""
        found = next((n for n in (name, unquote(name)) if n in self._entries), None)
        return self._read(found, MAX_IMAGE) if found else None

    def _read_all(self, place: str, names: list[str]) -> dict[str, bytes]:
        if sum(self._entries[n].file_size for n in names) > MAX_MODEL:
            raise SceneError(f"{self.path}: {place}: more than {MAX_MODEL >> 20} MB unpacked")
        return {n: self._read(n, MAX_MODEL) for n in names}

    def _read(self, name: str, limit: int) -> bytes:
        return _read_entry(self._zip, self._entries[name], limit, f"{self.path}: {name}")

    def _nested(self, name: str, content: bytes) -> ModelFiles:
        place = f"{self.path}: {name}"
        try:
            inner = zipfile.ZipFile(io.BytesIO(content))
        except _DAMAGE as error:
            raise SceneError(f"{place}: damaged: {error}") from None
        infos = [info for info in inner.infolist() if not info.is_dir()]
        if sum(info.file_size for info in infos) > MAX_MODEL:
            raise SceneError(f"{place}: more than {MAX_MODEL >> 20} MB unpacked")
        files = {i.filename: _read_entry(inner, i, MAX_MODEL, place) for i in infos}
        main = min(files, key=_model_rank, default=None)
        return ModelFiles(main or name, files if main else {name: b""})


def _model_rank(name: str) -> tuple[int, str]:
    kinds = (".obj", ".3ds", ".dae", ".lws")
    suffix = PurePosixPath(name).suffix.lower()
    return (kinds.index(suffix) if suffix in kinds else len(kinds)), name


def _read_entry(file: zipfile.ZipFile, info: zipfile.ZipInfo, limit: int, place: str) -> bytes:
    if info.flag_bits & 1:
        raise SceneError(f"{place}: encrypted; save the home without a password")
    if info.file_size > limit:
        raise SceneError(f"{place}: more than {limit >> 20} MB unpacked")
    try:
        return file.read(info)  # never more than the size that was just checked
    except _DAMAGE as error:
        raise SceneError(f"{place}: damaged: {error}") from None
