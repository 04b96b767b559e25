"""What is said of a file whose list is fixed: the names of its classes, and what its shapes do not
tell. Somebody says it when the file is taken in, or the file does in its metadata."""

import ast
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from models.detection.boxes import Scaling
from models.errors import ModelFileError
from models.toml_text import read_toml
from models.words.class_maps import BUILT_IN, ClassMap, built_in, own_map
from models.words.class_names import check_names, read_names

CLASSES_FILE, MAP_FILE, CONTRACT_FILE = "classes.txt", "classes.toml", "contract.toml"
"""Files beside a detector that was taken in: names, names with a map, and what was told."""


IMAGENET = Scaling(False, (123.675, 116.28, 103.53), (58.395, 57.12, 57.375))
NORMALISE = {
    "none": Scaling(False, (0, 0, 0), (255, 255, 255)),
    "imagenet": IMAGENET,
    "nanodet": Scaling(True, IMAGENET.mean[::-1], IMAGENET.deviation[::-1]),
    "yolox": Scaling(True, (0, 0, 0), (1, 1, 1)),
}


class Told(NamedTuple):
    """By the keys of CONTRACT_FILE, which are those in a file's metadata, too: a layout, one of
    NORMALISE, and one of the class lists that are built in; "" where nothing is told."""

    layout: str = ""
    normalise: str = ""
    classes: str = ""


class FileClasses(NamedTuple):
    """The `names` of a file's classes, () where nobody knows; who says so; a map if one came."""

    names: tuple[str, ...]
    where: str
    own: ClassMap | None = None


def read_told(beside: Path, metadata: Mapping[str, str]) -> Told:
    """What the CONTRACT_FILE in the directory says, else the metadata. Raises ModelFileError."""
    path, said = beside / CONTRACT_FILE, dict[str, str]()
    if path.is_file():
        try:
            said = read_toml(path)
        except (OSError, ValueError) as error:
            raise ModelFileError(f"{path}: not a readable TOML file ({error})") from error
        wrong = [k for k, v in said.items() if k not in Told._fields or not isinstance(v, str)]
        if wrong:
            raise ModelFileError(
                f"{path}: {wrong[0]} is of no use; known are {', '.join(Told._fields)}, each a text"
            )
    return Told(*(said.get(key) or metadata.get(key, "") for key in Told._fields))


def scaling(name: str, path: Path) -> Scaling:
    """One of NORMALISE, or ModelFileError."""
    if name not in NORMALISE:
        raise ModelFileError(
            f"{path}: normalise {name!r} is unknown; known are {', '.join(NORMALISE)}"
        )
    return NORMALISE[name]


def file_classes(
    file: Path | None, told: Told, metadata: Mapping[str, str], path: Path
) -> FileClasses:
    """From a file of names or with a map, else a list that is built in, else the metadata `names`
    of the detector at `path`. Raises ModelFileError."""
    if file is not None and file.suffix == ".toml":
        own = own_map(file)
        names = tuple(own.words)
        check_names(names, str(file))
        return FileClasses(names, str(file), own)
    if file is not None:
        return FileClasses(read_names(file), str(file))
    if told.classes:
        return FileClasses(built_in(told.classes), told.classes)
    names = _parse_names(metadata.get("names", ""))
    if names:
        check_names(names, str(path))
    return FileClasses(names, str(path))


def no_names(path: Path, count: int) -> ModelFileError:
    """What is wrong with a file whose classes nobody names; `count` of them, or 0."""
    return ModelFileError(
        f"{path}: its {f'{count} ' if count else ''}classes have no names; give a text file with "
        f"one name a line, a .toml map, or {' or '.join(BUILT_IN)} to `rfnav models import` with "
        "--classes"
    )


def _parse_names(written: str) -> tuple[str, ...]:
    """Ultralytics writes a Python dict or list literal into the file's metadata."""
    try:
        value = ast.literal_eval(written)
    except (ValueError, SyntaxError, MemoryError, RecursionError):
        return ()
    if isinstance(value, dict):
        try:
            value = [value[key] for key in sorted(value)]
        except TypeError:  # keys of several kinds have no order
            return ()
    return tuple(str(v) for v in value) if isinstance(value, list | tuple) else ()
