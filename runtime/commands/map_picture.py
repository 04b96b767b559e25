"""What the service knows of the home as a picture: of its answers on `rfnav/map`, `rfnav/things`,
`rfnav/zones` and `rfnav/places`."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, Final

import cv2
import numpy as np

from runtime.commands.map_sheet import INK, KEY, Sheet, bgr
from runtime.core.types import U8
from runtime.map_look import dots_from_middle, room_tint
from runtime.service.told_map import unpacked

Told = Mapping[str, Any]

SURE: Final = 0.5  # of a thing that is drawn
DOT_PX: Final = 3
NOWHERE: Final[Told] = MappingProxyType({})
ROOM_CELLS: Final = 150  # of a type of room whose name is written
CELLS: Final = (("unknown", 0), ("floor", 1), ("obstacle", 2))
SPOTS: Final = 40  # where a room's name may stand, at most


def picture(
    told: Told, things: Sequence[Told], zones: Sequence[Told] = (), places: Told = NOWHERE
) -> U8:
    """(H, W, 3) blue, green, red; y is up. SensorError for an answer that is no map."""
    sheet = Sheet.of(told)
    _floor(sheet, told)
    _name_frontiers(sheet, told)
    _draw_things(sheet, told, things)
    for zone in zones:
        sheet.line([*zone["polygon"], zone["polygon"][0]], "zone")
    sheet.line(told["path_xy"], "driven")
    for frontier in told["frontiers"]:
        for xy in frontier["cells_xy"]:
            sheet.dot(xy, _kind(frontier, told), DOT_PX)
    sheet.dotted(told["planned_xy"], "planned")
    if told["toward_xy"] is not None:
        sheet.cross(told["toward_xy"], "planned")
    for name, at in places.items():
        if at:
            sheet.cross(at[:2], "place")
            sheet.name(name, at[:2], KEY["place"])
    _name_rooms(sheet, told)
    if told["pose"] is not None:
        sheet.robot(*told["pose"])
    return sheet.finished()


def _floor(sheet: Sheet, told: Told) -> None:
    cells, rooms = (unpacked(told, name) for name in ("cells", "rooms"))
    colours = np.full((*cells.shape, 3), KEY["unknown"], np.uint8)
    for kind, value in CELLS:
        if (cells == value).any():
            colours[cells == value] = sheet.colour(kind)
    for index, name in enumerate(told["room_names"]):
        colours[(rooms == index) & (cells == 1)] = bgr(room_tint(name))
    px = sheet.cell_px
    sheet.image[:] = np.flipud(colours).repeat(px, axis=0).repeat(px, axis=1)


def _kind(frontier: Told, told: Told) -> str:
    return "taken" if frontier["id"] == told["elected"] else "frontier"


def _name_frontiers(sheet: Sheet, told: Told) -> None:
    """Each on a dot of its own; the one that is taken first."""
    for frontier in sorted(told["frontiers"], key=lambda one: one["id"] != told["elected"]):
        dots = dots_from_middle(frontier["cells_xy"])
        if len(dots):
            colour = KEY[_kind(frontier, told)]
            sheet.middle(str(frontier["id"]), dots.tolist(), colour, 0.42, must=True)


def _draw_things(sheet: Sheet, told: Told, things: Sequence[Told]) -> None:
    """The goal, then the surest first: they have the room. What has none for its name is left
    out."""
    sought = [thing for thing in things if thing["name"] == told["goal"]]
    others = [t for t in things if t["confidence"] >= SURE and t["name"] != told["goal"]]
    boxes = []
    for thing in (*sought, *others):
        goal = thing["name"] == told["goal"]
        kind = "sought" if goal else "thing"
        sure = f"{thing['name']} {100 * thing['confidence']:.0f}%"
        if sheet.name(sure, thing["xy"], KEY[kind], 0.65 if goal else 0.5, must=goal):
            boxes.append((thing["xy"], thing["size_m"], kind))
    for box in reversed(boxes):  # what is sought lies above
        sheet.box(*box)


def _name_rooms(sheet: Sheet, told: Told) -> None:
    """In the midst of the largest part that is told to be of a type, as far as there is room."""
    rooms, cells = unpacked(told, "rooms"), unpacked(told, "cells")
    r, (x, y) = sheet.resolution_m, sheet.origin_xy
    for index, name in enumerate(told["room_names"]):
        mask = ((rooms == index) & (cells == 1)).astype(np.uint8)
        if mask.sum() < ROOM_CELLS:
            continue
        inside = cv2.distanceTransform(np.pad(mask, 1), cv2.DIST_L2, 3)[1:-1, 1:-1]
        found = np.argsort(inside, axis=None)[::-1][: mask.sum() // 2]
        some = found[:: max(1, len(found) // SPOTS)]
        cols, rows = some % mask.shape[1], some // mask.shape[1]
        spots = np.stack([x + (cols + 0.5) * r, y + (rows + 0.5) * r], axis=-1)
        sheet.middle(name, spots.tolist(), INK, 0.7, must=False)
