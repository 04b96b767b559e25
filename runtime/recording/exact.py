"""Values as JSON that come back to the last bit: what was recorded must equal what a replay makes.

Python writes floats so that they read back the same. What JSON has no number for is a word ("nan",
"inf", "-inf"); arrays have their dtype and shape beside them, long ones as base64 of their bytes.
"""

import base64
import dataclasses
import functools
import json
import math
from collections.abc import Mapping
from enum import Enum
from typing import Any, Final, TypeVar, get_args, get_origin

import cattrs
import numpy as np

T = TypeVar("T")
LISTED: Final = 64  # elements of an array that a person may want to read


def exact(value: object) -> Any:
    """Dataclasses, mappings, sequences, enums and numpy values -> what JSON knows. Images (bytes)
    are told by their length."""
    match value:
        case None | bool() | int() | str() if not isinstance(value, Enum):
            return value
        case Enum():
            return value.value
        case float():
            return value if math.isfinite(value) else str(value)
        case np.generic():
            return exact(value.item())
        case np.ndarray():
            return _array(value)
        case bytes():
            return len(value)
        case Mapping():
            return {str(key): exact(item) for key, item in value.items()}
        case set() | frozenset():
            return [exact(item) for item in sorted(value)]
        case list() | tuple():
            return [exact(item) for item in value]
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {
            f.name: exact(getattr(value, f.name))
            for f in dataclasses.fields(value)
            if f.metadata.get("written", True)
        }
    raise TypeError(f"a {type(value).__name__} is not recorded")


def as_json(value: object) -> bytes:
    """A value's exact JSON."""
    return json.dumps(exact(value), allow_nan=False, separators=(",", ":")).encode()


def read(told: object, kind: type[T]) -> T:
    """What `exact` told, as a value of that type. ValueError when it is none."""
    try:
        return _converter().structure(told, kind)
    except (cattrs.BaseValidationError, TypeError, KeyError) as error:
        raise ValueError(f"not a {kind.__name__}: {error}") from error


def read_array(told: Mapping[str, Any]) -> np.ndarray[Any, Any]:
    """What `exact` told of an array."""
    dtype, shape = np.dtype(told["dtype"]), told["shape"]
    if "base64" in told:
        data = base64.b64decode(told["base64"])
        return np.frombuffer(data, dtype.newbyteorder("<")).astype(dtype).reshape(shape)
    values = [float(v) if isinstance(v, str) else v for v in told["values"]]
    return np.array(values, dtype).reshape(shape)


def _array(array: np.ndarray[Any, Any]) -> dict[str, object]:
    told: dict[str, object] = {"dtype": array.dtype.name, "shape": list(array.shape)}
    if array.size <= LISTED:
        return told | {"values": [exact(v) for v in array.ravel().tolist()]}
    data = np.ascontiguousarray(array, array.dtype.newbyteorder("<")).tobytes()
    return told | {"base64": base64.b64encode(data).decode()}


@functools.cache
def _converter() -> cattrs.Converter:
    converter = cattrs.Converter()
    converter.register_structure_hook_func(_is_array, lambda told, _: read_array(told))
    return converter


def _is_array(kind: Any) -> bool:
    return kind is np.ndarray or (get_origin(kind) is np.ndarray and bool(get_args(kind)))
