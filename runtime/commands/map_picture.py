"""What the service knows of the home as a picture: of its answers on `rfnav/map`, `rfnav/things`,
`rfnav/zones` and `rfnav/places`."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Final

import cv2
import numpy as np

from runtime.core.types import U8
from runtime.errors import SensorError
from runtime.service.told_map import MOST_CELLS, unpacked

Colour = tuple[int, int, int]  # blue, green, red
Point = tuple[int, int]
Told = Mapping[str, Any]

SIDE_PX: Final = 1400  # the longer side of the map, at least about
SMALLEST_PX, LARGEST_PX = 1, 10  # of a cell
KEY_PX, MARGIN_PX = 44, 8
SURE: Final = 0.5  # of a thing that is named; what is less sure is a dot alone
FONT: Final = cv2.FONT_HERSHEY_SIMPLEX
UNKNOWN, FREE, OBSTACLE = (222, 218, 214), (255, 255, 255), (64, 56, 48)
INK, THING, GOAL, DRIVEN, PLANNED, FRONTIER, ELECTED, ZONE, PLACE, ROBOT = (
    (40, 36, 32), (30, 110, 200), (30, 30, 200), (150, 150, 150), (200, 110, 30), (190, 150, 40),
    (60, 160, 40), (50, 50, 210), (150, 60, 130), (200, 80, 20),
)  # fmt: skip
TINTS: Final[tuple[Colour, ...]] = (
    (214, 234, 255), (226, 246, 222), (255, 236, 218), (240, 222, 250), (210, 248, 250),
    (250, 226, 226), (222, 240, 240), (236, 236, 208), (216, 224, 244), (244, 240, 222),
)  # fmt: skip
NO_ROOM: Final = 255
NOWHERE: Final[Told] = MappingProxyType({})
ROOM_CELLS: Final = 150  # of a type of room whose name is written


def picture(
    told: Told, things: Sequence[Told], zones: Sequence[Told] = (), places: Told = NOWHERE
) -> U8:
    """(H, W, 3) blue, green, red; y is up. SensorError for an answer that is no map."""
    sheet = _Sheet.of(told)
    _floor(sheet, told)
    for zone in zones:
        sheet.line([*zone["polygon"], zone["polygon"][0]], ZONE, 2)
    sheet.line(told["path_xy"], DRIVEN, 2)
    for frontier in told["frontiers"]:
        elected = frontier["id"] == told["elected"]
        for xy in frontier["cells_xy"]:
            sheet.dot(xy, ELECTED if elected else FRONTIER, 3)
    sheet.line(told["planned_xy"], PLANNED, 2)
    if told["toward_xy"] is not None:
        sheet.cross(told["toward_xy"], PLANNED)
    _name_things(sheet, told, things)
    for name, at in places.items():
        if at:
            sheet.cross(at[:2], PLACE)
            sheet.write(name, at[:2], PLACE)
    for frontier in told["frontiers"]:
        elected = frontier["id"] == told["elected"]
        sheet.write(str(frontier["id"]), frontier["xy"], ELECTED if elected else FRONTIER, 0.4)
    _name_rooms(sheet, told)
    if told["pose"] is not None:
        sheet.robot(*told["pose"])
    return np.concatenate([sheet.image, _key(sheet)])


@dataclass
class _Sheet:
    """Pixels over the map's cells, row 0 at the top; `taken`: where something is written."""

    image: U8
    cell_px: int
    resolution_m: float
    origin_xy: tuple[float, float]
    taken: list[tuple[int, int, int, int]] = field(default_factory=list)

    @classmethod
    def of(cls, told: Told) -> "_Sheet":
        rows, cols = told["rows"], told["cols"]
        if not rows or not cols or rows * cols > MOST_CELLS:
            raise SensorError(f"rfnav/map: {rows} x {cols} cells are no map to draw")
        px = max(SMALLEST_PX, min(LARGEST_PX, math.ceil(SIDE_PX / max(rows, cols))))
        image = np.zeros((rows * px, cols * px, 3), np.uint8)
        x, y = told["origin_xy"]
        return cls(image, px, told["resolution_m"], (x, y))

    def at(self, xy: Sequence[float]) -> Point:
        scale = self.cell_px / self.resolution_m
        x, y = (xy[0] - self.origin_xy[0]) * scale, (xy[1] - self.origin_xy[1]) * scale
        return round(x), round(self.image.shape[0] - y)

    def line(self, points: Sequence[Sequence[float]], colour: Colour, width: int) -> None:
        if len(points) > 1:
            drawn = np.array([self.at(xy) for xy in points], np.int32)
            cv2.polylines(self.image, [drawn], False, colour, width, cv2.LINE_AA)

    def dot(self, xy: Sequence[float], colour: Colour, radius: int) -> None:
        cv2.circle(self.image, self.at(xy), radius, colour, cv2.FILLED, cv2.LINE_AA)

    def cross(self, xy: Sequence[float], colour: Colour) -> None:
        cv2.drawMarker(self.image, self.at(xy), colour, cv2.MARKER_TILTED_CROSS, 16, 2, cv2.LINE_AA)

    def robot(self, x: float, y: float, yaw: float) -> None:
        ahead = [(0.28, 0.0), (-0.18, 0.17), (-0.08, 0.0), (-0.18, -0.17)]
        c, s = math.cos(yaw), math.sin(yaw)
        corners = [self.at((x + c * a - s * b, y + s * a + c * b)) for a, b in ahead]
        cv2.fillPoly(self.image, [np.array(corners, np.int32)], ROBOT, cv2.LINE_AA)

    def write(
        self, text: str, xy: Sequence[float], colour: Colour, size: float = 0.5, must: bool = False
    ) -> None:
        """Beside a point, where there is room; what has none is left out, unless it `must`."""
        plain = text.encode("ascii", "replace").decode("ascii")
        (width, height), base = cv2.getTextSize(plain, FONT, size, 1)
        x, y = self.at(xy)
        spots = [
            (x + 7, y + height // 2), (x - width - 7, y + height // 2), (x - width // 2, y - 8),
            (x - width // 2, y + height + 8),
        ]  # fmt: skip
        for left, low in spots:
            box = left, low - height, left + width, low + base
            if self._fits(box):
                break
        else:
            if not must:
                return
            left, low = spots[0]
            box = left, low - height, left + width, low + base
        self.taken.append(box)
        x0, y0, x1, y1 = (max(0, edge) for edge in box)
        under = self.image[max(0, y0 - 2) : y1, max(0, x0 - 2) : x1 + 2]
        under[:] = under // 8 + 223  # the words are read on whatever lies there
        cv2.putText(self.image, plain, (left, low), FONT, size, colour, 1, cv2.LINE_AA)

    def _fits(self, box: tuple[int, int, int, int]) -> bool:
        x0, y0, x1, y1 = box
        rows, cols = self.image.shape[:2]
        if x0 < 0 or y0 < 0 or x1 > cols or y1 > rows:
            return False
        return all(x1 < a or c < x0 or y1 < b or d < y0 for a, b, c, d in self.taken)


def _floor(sheet: _Sheet, told: Told) -> None:
    cells, rooms = (unpacked(told, name) for name in ("cells", "rooms"))
    colours = np.full((*cells.shape, 3), UNKNOWN, np.uint8)
    colours[cells == 1] = FREE
    for index in np.unique(rooms[rooms != NO_ROOM]):
        colours[(rooms == index) & (cells == 1)] = TINTS[int(index) % len(TINTS)]
    colours[cells == 2] = OBSTACLE
    px = sheet.cell_px
    sheet.image[:] = np.flipud(colours).repeat(px, axis=0).repeat(px, axis=1)


def _name_things(sheet: _Sheet, told: Told, things: Iterable[Told]) -> None:
    """The surest first: they have the room."""
    for thing in things:
        goal = thing["name"] == told["goal"]
        colour = GOAL if goal else THING
        sheet.dot(thing["xy"], colour, 6 if goal else 4)
        if thing["confidence"] >= SURE or goal:
            sure = f"{thing['name']} {100 * thing['confidence']:.0f}%"
            sheet.write(sure, thing["xy"], colour, 0.65 if goal else 0.5, must=goal)


def _name_rooms(sheet: _Sheet, told: Told) -> None:
    """In the midst of the largest part that is told to be of a type."""
    rooms, cells = unpacked(told, "rooms"), unpacked(told, "cells")
    for index, name in enumerate(told["room_names"]):
        mask = ((rooms == index) & (cells == 1)).astype(np.uint8)
        if mask.sum() < ROOM_CELLS:
            continue
        inside = cv2.distanceTransform(np.pad(mask, 1), cv2.DIST_L2, 3)[1:-1, 1:-1]
        row, col = np.unravel_index(int(inside.argmax()), inside.shape)
        r, (x, y) = sheet.resolution_m, sheet.origin_xy
        (width, _), _ = cv2.getTextSize(name, FONT, 0.7, 1)
        left_m = (width / 2 + 7) / sheet.cell_px * r  # `write` begins beside the point
        sheet.write(name, (x + (int(col) + 0.5) * r - left_m, y + (int(row) + 0.5) * r), INK, 0.7)


def _key(sheet: _Sheet) -> U8:
    """A strip that tells what is what, and how long a metre is."""
    strip: U8 = np.full((KEY_PX, sheet.image.shape[1], 3), 255, np.uint8)
    x, low = MARGIN_PX, KEY_PX // 2 + 5
    for name, colour in (
        ("floor", FREE), ("obstacle", OBSTACLE), ("unknown", UNKNOWN), ("frontier", FRONTIER),
        ("taken", ELECTED), ("driven", DRIVEN), ("planned", PLANNED), ("thing", THING),
        ("sought", GOAL), ("zone", ZONE), ("place", PLACE), ("robot", ROBOT),
    ):  # fmt: skip
        cv2.rectangle(strip, (x, low - 12), (x + 14, low + 2), colour, cv2.FILLED)
        cv2.rectangle(strip, (x, low - 12), (x + 14, low + 2), INK, 1)
        cv2.putText(strip, name, (x + 19, low), FONT, 0.45, INK, 1, cv2.LINE_AA)
        x += 31 + cv2.getTextSize(name, FONT, 0.45, 1)[0][0]
    metre = round(sheet.cell_px / sheet.resolution_m)
    right = strip.shape[1] - MARGIN_PX
    cv2.line(strip, (right - metre, low), (right, low), INK, 2)
    cv2.putText(strip, "1 m", (right - metre, low - 8), FONT, 0.45, INK, 1, cv2.LINE_AA)
    return strip
