"""TOML text -> values of plain types, and those -> frozen dataclasses. What is read is bounded in
size and depth before it is parsed."""

import difflib
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final, Literal, TypeVar, get_args, get_origin

import cattrs
from cattrs.errors import ClassValidationError

from runtime.errors import ConfigError

T = TypeVar("T")
FILE_BYTES: Final = 256 * 1024
DOTS: Final = 400  # of a line: a dotted key costs the parser the square of its parts
LARGEST_INT: Final = 2**53


class NotOfTypeError(Exception):
    """A value that is not of its field's type: `path`, the fields that lead to it, and `what` is
    wrong."""

    def __init__(self, path: tuple[str, ...], what: str) -> None:
        super().__init__(what)
        self.path, self.what = path, what


def read_toml(path: Path) -> dict[str, Any]:
    """A file's tables. ConfigError, one line."""
    try:
        with path.open("rb") as file:
            text = file.read(FILE_BYTES + 1)
    except (OSError, ValueError) as error:  # ValueError: a name with a zero byte in it
        why = getattr(error, "strerror", None) or error
        raise ConfigError(f"{path}: cannot be read ({why})") from error
    if len(text) > FILE_BYTES:
        raise ConfigError(f"{path}: is larger than {FILE_BYTES // 1024} KiB: no configuration is")
    try:
        return parse_toml(text.decode("utf-8"))
    except ValueError as error:
        raise ConfigError(f"{path}: not valid TOML: {error}") from error


def parse_toml(text: str) -> dict[str, Any]:
    """Tables of TOML text. ValueError, one line."""
    if any(line.count(".") > DOTS for line in text.splitlines()):
        raise ValueError(f"a line with more than {DOTS} dots")
    try:
        return tomllib.loads(text)
    except RecursionError as error:
        raise ValueError("nested too deep") from error


def structured(values: Mapping[str, Any], kind: type[T]) -> T:
    """Nested values -> a frozen dataclass. NotOfTypeError tells the field and what is right."""
    try:
        return _CONVERTER.structure(values, kind)
    except ClassValidationError as error:
        raise NotOfTypeError(*_first(error)) from None


def _converter() -> cattrs.Converter:
    converter = cattrs.Converter(forbid_extra_keys=True)
    for kind, accepted in ((bool, bool), (int, int), (float, (int, float)), (str, str)):
        converter.register_structure_hook(kind, _exactly(kind, accepted))
    converter.register_structure_hook_func(_is_literal, _one_of)
    converter.register_structure_hook_func(lambda kind: kind == tuple[str, ...], _names)
    return converter


def _exactly(kind: type, accepted: Any) -> Any:
    def convert(value: Any, _: Any) -> Any:
        if not isinstance(value, accepted) or (isinstance(value, bool) and kind is not bool):
            raise TypeError(f"is {value!r:.80}, must be of type {kind.__name__}")
        if isinstance(value, int) and abs(value) > LARGEST_INT:
            raise ValueError("is too large")
        return kind(value)

    return convert


def _names(value: Any, _: Any) -> tuple[str, ...]:
    if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
        raise TypeError(f"is {value!r:.80}, must be a list of texts")
    return tuple(value)


def _is_literal(kind: Any) -> bool:
    return get_origin(kind) is Literal


def _one_of(value: Any, kind: Any) -> Any:
    if not isinstance(value, str):
        raise TypeError(f"is {value!r:.80}, must be of type str")
    if value not in get_args(kind):
        raise ValueError(unknown(value, get_args(kind)))
    return value


def _first(error: BaseException, path: tuple[str, ...] = ()) -> tuple[tuple[str, ...], str]:
    """The first leaf of a cattrs error: the fields that lead to it, and what is wrong."""
    if isinstance(error, BaseExceptionGroup):
        inner = error.exceptions[0]
        name = _field_of(inner)
        return _first(inner, (*path, name) if name else path)
    return path, " ".join(str(error).split())


def _field_of(error: BaseException) -> str:
    notes = getattr(error, "__notes__", [])
    return next((str(n.name) for n in notes if hasattr(n, "name")), "")


def unknown(key: str, known: Iterable[str]) -> str:
    """What is said of a name that is none of the known ones."""
    names = sorted(known)
    if not names:
        return "unknown; there is none"
    near = difflib.get_close_matches(key, names, n=1, cutoff=0.5)
    told = ", ".join(name or '""' for name in names)
    return f"unknown; did you mean {near[0]}?" if near else f"unknown; known are {told}"


_CONVERTER: Final = _converter()
