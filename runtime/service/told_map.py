"""Cells of a map as `rfnav/map` answers them: a byte each, by rows from the smallest y, zlib and
base64."""

import base64
import zlib
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from runtime.core.types import U8
from runtime.errors import SensorError

LEVEL: Final = 1  # of zlib
MOST_CELLS: Final = 1 << 25


def packed(cells: U8) -> str:
    return base64.b64encode(zlib.compress(cells.tobytes(), LEVEL)).decode("ascii")


def unpacked(told: Mapping[str, Any], name: str, most_cells: int = MOST_CELLS) -> U8:
    """(rows, cols) of an answer's `cells` or `rooms`, row 0 at the smallest y. SensorError, one
    line, for what is none."""
    rows, cols = told.get("rows"), told.get("cols")
    if not isinstance(rows, int) or not isinstance(cols, int):
        raise SensorError("rfnav/map: rows and cols must be whole numbers")
    if not (rows > 0 < cols and rows * cols <= most_cells):
        raise SensorError(f"rfnav/map: {rows} x {cols} cells are no map")
    try:
        raw = zlib.decompressobj().decompress(base64.b64decode(told[name]), rows * cols + 1)
    except (KeyError, TypeError, ValueError, zlib.error) as error:
        raise SensorError(f"rfnav/map: {name}: cannot be read: {type(error).__name__}") from error
    if len(raw) != rows * cols:
        raise SensorError(f"rfnav/map: {name}: {len(raw)} cells in place of {rows * cols}")
    return np.frombuffer(raw, np.uint8).reshape(rows, cols)
