"""What a map is drawn on: lines, dots, boxes and words over its cells, and the strip that tells
what they are."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from types import MappingProxyType
from typing import Any, Final

import cv2
import numpy as np

from runtime.core.types import U8
from runtime.errors import SensorError
from runtime.map_look import RGB, rgb
from runtime.service.told_map import MOST_CELLS

Colour = tuple[int, int, int]  # blue, green, red
Point = tuple[int, int]
Box = tuple[int, int, int, int]  # left, top, right, bottom, px

SIDE_PX: Final = 1400  # the longer side of the map, at least about
SMALLEST_PX, LARGEST_PX = 1, 10  # of a cell
KEY_PX, MARGIN_PX = 44, 8
FONT: Final = cv2.FONT_HERSHEY_SIMPLEX
LIGHTER, TINTED = 0.62, 0.2  # a thing's box: than what it lies on; of its colour
BESIDE_PX, OFF_PX = 7, 26  # from a point to its name; where a line leads there
LEAST_SIDE_PX: Final = 8
DASH_PX: Final = 9
INK: Final = (40, 36, 32)


def bgr(colour: RGB) -> Colour:
    """As OpenCV has it."""
    return colour[2], colour[1], colour[0]


def _pale(name: str, share: float) -> RGB:
    """A colour of the table as it is seen through on free floor."""
    red, green, blue = (
        round(free + share * (full - free))
        for free, full in zip(rgb("free"), rgb(name), strict=True)
    )
    return red, green, blue


KEY: Final[Mapping[str, Colour]] = MappingProxyType({
    "floor": bgr(rgb("free")), "obstacle": bgr(rgb("wall")), "unknown": bgr(rgb("unknown")),
    "frontier": bgr(rgb("frontier")), "taken": bgr(rgb("taken")),
    "driven": bgr(_pale("path", 0.55)), "planned": bgr(rgb("plan")), "thing": bgr(rgb("thing")),
    "sought": bgr(rgb("goal")), "zone": bgr(rgb("zone")), "place": bgr(rgb("place")),
    "robot": bgr(rgb("path")),
})  # fmt: skip
"""What may be drawn, by its name in the strip below the map."""


@dataclass(frozen=True)
class MapWord:
    """Words in a `box`, `low` their base line; `point`: what a line leads to, None beside it."""

    text: str
    box: Box
    low: int
    size: float
    colour: Colour
    point: Point | None

    def lead(self, image: U8) -> None:
        """The line, onto (H, W, 3)."""
        if self.point:
            x0, y0, x1, y1 = self.box
            near = min(max(self.point[0], x0), x1), min(max(self.point[1], y0), y1)
            cv2.line(image, self.point, near, self.colour, 1, cv2.LINE_AA)

    def draw(self, image: U8) -> None:
        """The words, onto (H, W, 3)."""
        x0, y0, x1, y1 = (max(0, edge) for edge in self.box)
        under = image[max(0, y0 - 2) : y1, max(0, x0 - 2) : x1 + 2]
        under[:] = under // 8 + 223  # the words are read on whatever lies there
        at = self.box[0], self.low
        cv2.putText(image, self.text, at, FONT, self.size, self.colour, 1, cv2.LINE_AA)


@dataclass
class Sheet:
    """Pixels over the map's cells, row 0 at the top; `labels`: what is written above all else;
    `used`: the names in `KEY` of what was drawn."""

    image: U8
    cell_px: int
    resolution_m: float
    origin_xy: tuple[float, float]
    labels: list[MapWord] = field(default_factory=list)
    used: set[str] = field(default_factory=set)

    @classmethod
    def of(cls, told: Mapping[str, Any]) -> "Sheet":
        """For an answer on `rfnav/map`; SensorError where that is no map."""
        rows, cols = told["rows"], told["cols"]
        if not rows or not cols or rows * cols > MOST_CELLS:
            raise SensorError(f"rfnav/map: {rows} x {cols} cells are no map to draw")
        px = max(SMALLEST_PX, min(LARGEST_PX, math.ceil(SIDE_PX / max(rows, cols))))
        image = np.zeros((rows * px, cols * px, 3), np.uint8)
        x, y = told["origin_xy"]
        return cls(image, px, told["resolution_m"], (x, y))

    def colour(self, kind: str) -> Colour:
        """Of what is drawn now, and so told below the map."""
        self.used.add(kind)
        return KEY[kind]

    def at(self, xy: Sequence[float]) -> Point:
        """m -> px."""
        scale = self.cell_px / self.resolution_m
        x, y = (xy[0] - self.origin_xy[0]) * scale, (xy[1] - self.origin_xy[1]) * scale
        return round(x), round(self.image.shape[0] - y)

    def line(self, points: Sequence[Sequence[float]], kind: str) -> None:
        """Through two points or more."""
        if len(points) > 1:
            drawn = np.array([self.at(xy) for xy in points], np.int32)
            cv2.polylines(self.image, [drawn], False, self.colour(kind), 2, cv2.LINE_AA)

    def dotted(self, points: Sequence[Sequence[float]], kind: str) -> None:
        """The same, as dots in equal distance."""
        begin_px = 0.0
        for a, b in pairwise(np.array([self.at(xy) for xy in points], float).reshape(-1, 2)):
            long_px = float(np.hypot(*(b - a)))
            along = np.arange(begin_px, long_px, DASH_PX)
            for x, y in a + np.outer(along / max(long_px, 1.0), b - a):
                at = round(x), round(y)
                cv2.circle(self.image, at, 2, self.colour(kind), cv2.FILLED, cv2.LINE_AA)
            begin_px += DASH_PX * len(along) - long_px

    def dot(self, xy: Sequence[float], kind: str, radius_px: int) -> None:
        """Filled."""
        colour = self.colour(kind)
        cv2.circle(self.image, self.at(xy), radius_px, colour, cv2.FILLED, cv2.LINE_AA)

    def cross(self, xy: Sequence[float], kind: str) -> None:
        """Of two strokes."""
        how = self.colour(kind), cv2.MARKER_TILTED_CROSS, 16, 2, cv2.LINE_AA
        cv2.drawMarker(self.image, self.at(xy), *how)

    def box(self, xy: Sequence[float], size_m: Sequence[float], kind: str) -> None:
        """What stands there: lighter than the walls, with an outline; `size_m` along x, y."""
        (x, y), colour = self.at(xy), self.colour(kind)
        scale = self.cell_px / self.resolution_m / 2
        half_x, half_y = (max(LEAST_SIDE_PX // 2, round(side * scale)) for side in size_m[:2])
        low, high = (max(0, x - half_x), max(0, y - half_y)), (x + half_x, y + half_y)
        under = self.image[low[1] : high[1] + 1, low[0] : high[0] + 1]
        light = LIGHTER * 255 + (1 - LIGHTER) * under
        under[:] = (TINTED * np.array(colour) + (1 - TINTED) * light).astype(np.uint8)
        cv2.rectangle(self.image, low, high, colour, 2 if kind == "sought" else 1)

    def robot(self, x: float, y: float, yaw: float) -> None:
        """An arrow ahead."""
        ahead = [(0.28, 0.0), (-0.18, 0.17), (-0.08, 0.0), (-0.18, -0.17)]
        c, s = math.cos(yaw), math.sin(yaw)
        corners = [self.at((x + c * a - s * b, y + s * a + c * b)) for a, b in ahead]
        cv2.fillPoly(self.image, [np.array(corners, np.int32)], self.colour("robot"), cv2.LINE_AA)

    def name(
        self, text: str, xy: Sequence[float], colour: Colour, size: float = 0.5, must: bool = False
    ) -> bool:
        """On a point or beside it, else further off with a line to it. Where that has no room
        either it is left out, unless it `must`. Whether it will be written."""
        x, y = self.at(xy)
        plain, (width, height) = measured(text, size)
        beside = [
            (x - width // 2, y + height // 2),
            (x + BESIDE_PX, y + height // 2), (x - width - BESIDE_PX, y + height // 2),
            (x - width // 2, y - 8), (x - width // 2, y + height + 8),
        ]  # fmt: skip
        off = [
            (left, low) for low in (y - OFF_PX, y + OFF_PX + height)
            for left in (x + OFF_PX, x - width - OFF_PX, x - width // 2)
        ]  # fmt: skip
        return (
            self._write(plain, beside, size, colour)
            or self._write(plain, off, size, colour, (x, y))
            or (must and self._write(plain, beside[:1], size, colour, must=True))
        )

    def middle(
        self, text: str, spots: Iterable[Sequence[float]], colour: Colour, size: float, must: bool
    ) -> None:
        """On the first of these points, m, where there is room, within the picture."""
        plain, (width, height) = measured(text, size)
        rows, cols = self.image.shape[:2]
        points = []
        for xy in spots:
            x, y = self.at(xy)
            left, low = x - width // 2, y + height // 2
            points.append(
                (max(3, min(left, cols - width - 3)), max(height + 3, min(low, rows - 6)))
            )
        if not self._write(plain, points, size, colour) and must:
            self._write(plain, points[:1], size, colour, must=True)

    def _write(
        self, text: str, spots: Iterable[Point], size: float, colour: Colour,
        point: Point | None = None, must: bool = False,
    ) -> bool:  # fmt: skip
        (width, height), base = cv2.getTextSize(text, FONT, size, 1)
        for left, low in spots:
            box = left, low - height, left + width, low + base
            if must or self._fits(box):
                self.labels.append(MapWord(text, box, low, size, colour, point))
                return True
        return False

    def _fits(self, box: Box) -> bool:
        x0, y0, x1, y1 = box
        rows, cols = self.image.shape[:2]
        if x0 < 0 or y0 < 0 or x1 > cols or y1 > rows:
            return False
        taken = (label.box for label in self.labels)
        return all(x1 < a or c < x0 or y1 < b or d < y0 for a, b, c, d in taken)

    def finished(self) -> U8:
        """(H, W, 3): the map with its words, and below it what is what."""
        for label in self.labels:
            label.lead(self.image)
        for label in self.labels:
            label.draw(self.image)
        return np.concatenate([self.image, self._strip()])

    def _strip(self) -> U8:
        strip: U8 = np.full((KEY_PX, self.image.shape[1], 3), 255, np.uint8)
        x, low = MARGIN_PX, KEY_PX // 2 + 5
        for name in self._told():
            cv2.rectangle(strip, (x, low - 12), (x + 14, low + 2), KEY[name], cv2.FILLED)
            cv2.rectangle(strip, (x, low - 12), (x + 14, low + 2), INK, 1)
            cv2.putText(strip, name, (x + 19, low), FONT, 0.45, INK, 1, cv2.LINE_AA)
            x += 31 + cv2.getTextSize(name, FONT, 0.45, 1)[0][0]
        metre = round(self.cell_px / self.resolution_m)
        right = strip.shape[1] - MARGIN_PX
        cv2.line(strip, (right - metre, low), (right, low), INK, 2)
        cv2.putText(strip, "1 m", (right - metre, low - 8), FONT, 0.45, INK, 1, cv2.LINE_AA)
        return strip

    def _told(self) -> Iterator[str]:
        return (name for name in KEY if name in self.used)


def measured(text: str, size: float) -> tuple[str, tuple[int, int]]:
    """The words as the font can write them, and how wide and high they are, px."""
    plain = text.encode("ascii", "replace").decode("ascii")
    (width, height), _ = cv2.getTextSize(plain, FONT, size, 1)
    return plain, (width, height)
