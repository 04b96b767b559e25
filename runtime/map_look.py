"""How maps look, in one table: the page (its bright theme is in `view/page/look.css`), the picture
of `rfnav map` and that of an episode have the same colours for the same things."""

import colorsys
import zlib
from collections.abc import Iterable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

RGB = tuple[int, int, int]

COLOURS: Final[dict[str, str]] = {
    "unknown": "#e6e2d9", "free": "#fffefb", "wall": "#343a44", "drop": "#b00d28",
    "path": "#0b7d75", "plan": "#0b7d75", "frontier": "#2a6fc9", "taken": "#b34a00",
    "zone": "#c40f2c", "thing": "#4c5360", "goal": "#1a7f37", "place": "#6b3fa0",
    "belief": "#8a4fd0", "halo": "#fffefb",
}  # fmt: skip
"""By what it is for, `--map-` of the page."""

ROOM_HUES_DEG: Final[dict[str, int]] = {
    "hallway": 5, "living room": 48, "dining room": 90, "kitchen": 150, "bathroom": 195,
    "bedroom": 245, "study": 310,
}  # fmt: skip
SATURATION, LIGHTNESS = 0.48, 0.60
STRENGTH: Final = 0.28  # of a room's colour over free floor


def room_hue(name: str) -> int:
    """Degrees; a type that the table has not gets one by its name, everywhere the same."""
    return ROOM_HUES_DEG.get(name, zlib.crc32(name.encode()) % 360)


def room_tint(name: str) -> RGB:
    """What free floor of such a room is painted with."""
    hue = colorsys.hls_to_rgb(room_hue(name) / 360, LIGHTNESS, SATURATION)
    red, green, blue = (
        round(free + STRENGTH * (255 * part - free))
        for free, part in zip(rgb("free"), hue, strict=True)
    )
    return red, green, blue


def rgb(name: str) -> RGB:
    """A colour of the table as three numbers to 255."""
    red, green, blue = bytes.fromhex(COLOURS[name].removeprefix("#"))
    return red, green, blue


def dots_from_middle(cells_xy: Iterable[Any]) -> NDArray[np.float64]:
    """(N, 2) m, a frontier's dots -> the same, the nearest to their middle first: on one of them
    its id is written, as the middle itself may lie beside them all."""
    dots = np.array(list(cells_xy), float).reshape(-1, 2)
    away = np.hypot(*(dots - dots.mean(axis=0)).T) if len(dots) else np.zeros(0)
    return dots[np.argsort(away, kind="stable")]
