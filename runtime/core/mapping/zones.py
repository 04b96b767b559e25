"""Where the robot may not be: polygons over the map, and how far each cell is outside of them.

The map itself keeps what the camera told of such places. Planner and frontiers take them for walls
that are known exactly: the body fits beside one, or it does not, whatever a gap between furniture
might be forgiven. A robot that is in one all the same, pushed there or told of it too late, may
leave it, and go no deeper.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from runtime.core.geometry import GridFrame
from runtime.core.mapping.windows import Window, inside, joined, part_frame, widened
from runtime.core.types import F32, F64, Mask, Pose

REACH_M: Final = 2.1  # no body, with what planning pays for, wants more clearance than that
_WITHIN_CELL = math.sqrt(0.5)  # of its side: no place in it is farther from its middle
_ROUNDING_M = 1e-3
_LEAVING_M = 0.35  # round a robot that must leave a zone, which is open there, and twice the way
CORNERS: Final = (3, 64)  # of a polygon
FAR_M: Final = 1000.0  # no corner is farther from where the map began
LEAST_M2: Final = 0.01  # within a polygon; one of less is a slip of the hand


@dataclass(frozen=True)
class Zone:
    """A simple polygon, (x, y) m of the map frame by corner, that is kept out of; or an `area`,
    which is kept within."""

    name: str
    corners_xy: tuple[tuple[float, float], ...]
    area: bool = False

    @property
    def middle_xy(self) -> tuple[float, float]:
        """The mean of its corners."""
        x, y = np.mean(self.corners_xy, axis=0)
        return float(x), float(y)

    def outside_m(self, xy: tuple[float, float]) -> float:
        """How far a point is from the polygon, m; less than 0 within."""
        rows, cols = np.array([xy[1]]), np.array([xy[0]])
        away = min(float(_to_segment(rows, cols, a, b)[0, 0]) for a, b in _sides(self))
        return -away if _within(self, rows, cols)[0, 0] else away


def wrong_corners(corners_xy: Sequence[tuple[float, float]]) -> str:
    """What keeps corners from being a zone's; "" for nothing."""
    least, most = CORNERS
    if not least <= len(corners_xy) <= most:
        return f"has {len(corners_xy)} corners, must have {least} to {most}"
    if not all(math.isfinite(v) and abs(v) <= FAR_M for xy in corners_xy for v in xy):
        return f"has a corner that is no place: x and y must be within {FAR_M:g} m"
    zone = Zone("", tuple(corners_xy))
    sides = list(_sides(zone))
    for i, one in enumerate(sides):
        for k in range(i + 2, len(sides)):
            if (k + 1) % len(sides) != i and _cross(*one, *sides[k]):
                return f"crosses itself: side {i + 1} and side {k + 1}"
    twice_m2 = sum(a[0] * b[1] - b[0] * a[1] for a, b in sides)
    if abs(twice_m2) / 2 < LEAST_M2:
        return (
            f"has next to nothing in it: {abs(twice_m2) / 2:.3f} m2, must be {LEAST_M2:g} or more"
        )
    return ""


@dataclass(frozen=True)
class _Part:
    """A zone over a window of the map. edge_m: (r, c) how far the cell, all of it, is outside of
    what is kept out of, m; within it less than 0. It is right up to REACH_M either way."""

    zone: Zone
    window: Window
    edge_m: F32

    def at(self, row: int, col: int) -> float:
        """The same of one cell of the map."""
        rows, cols = self.window
        if rows.start <= row < rows.stop and cols.start <= col < cols.stop:
            return float(self.edge_m[row - rows.start, col - cols.start])
        return REACH_M


@dataclass(frozen=True)
class TooNear:
    """How much too near to a zone the robot is, m, and where: so much of the zone is open to it, so
    that it can leave."""

    zone: Zone
    lacks_m: float
    at_xy: tuple[float, float]

    @property
    def within_m(self) -> float:
        """How far round the robot it is open."""
        return _LEAVING_M + 2 * self.lacks_m if self.lacks_m < REACH_M else math.inf


class ZoneLayer:
    """The zones over one map."""

    def __init__(self) -> None:
        self.zones: tuple[Zone, ...] = ()
        self._frame: GridFrame | None = None
        self._parts: list[_Part] = []
        self._barred: Mask = np.zeros((0, 0), bool)

    def put(self, zones: tuple[Zone, ...], frame: GridFrame) -> Window | None:
        """Have these in place of those before. The window of the map that is concerned, None for
        nothing."""
        if zones == self.zones:
            return None
        before = self.about(self.zones, frame)
        self.zones, self._frame = zones, None
        now = self.about(zones, frame)
        return joined(before, now) if now is not None else before

    def barred(self, frame: GridFrame) -> Mask:
        """(R, C) cells that are kept out of."""
        self._over(frame)
        return self._barred

    def openings(self, frame: GridFrame, pose: Pose, clear_m: float) -> tuple[TooNear, ...]:
        """The zones to which the robot does not keep so much clearance."""
        here = frame.cell(pose.x_m, pose.y_m)
        lacking = ((part.zone, clear_m - part.at(*here)) for part in self._over(frame))
        xy = pose.x_m, pose.y_m
        return tuple(
            TooNear(zone, lacks_m + _ROUNDING_M, xy) for zone, lacks_m in lacking if lacks_m > 0
        )

    def about(self, zones: Sequence[Zone], frame: GridFrame) -> Window | None:
        """The window of the map that these of its zones concern; None for none."""
        window: Window | None = None
        for part in self._over(frame):
            if part.zone in zones:
                window = joined(window, part.window)
        return window

    def clearance(
        self, frame: GridFrame, window: Window, openings: Sequence[TooNear] = ()
    ) -> tuple[F32, F32]:
        """(r, c) m of a window of the map: how far zones are; and how far they are for planning,
        what is open counting as that much farther."""
        shape = window[0].stop - window[0].start, window[1].stop - window[1].start
        true_m, told_m = (np.full(shape, REACH_M, np.float32) for _ in range(2))
        for part in self._over(frame):
            both = _common(window, part.window)
            if both is None:
                continue
            here, edge_m = inside(both, window), part.edge_m[inside(both, part.window)]
            true_m[here] = np.minimum(true_m[here], edge_m)
            for opening in openings:
                if opening.zone is part.zone:
                    edge_m = _opened(edge_m, part_frame(frame, both), opening)
            told_m[here] = np.minimum(told_m[here], edge_m)
        return true_m, told_m

    def _over(self, frame: GridFrame) -> list[_Part]:
        """The zones over that map, drawn anew where it is another than before."""
        if frame != self._frame:
            self._frame = frame
            self._parts = [_drawn(zone, frame) for zone in self.zones]
            self._barred = np.zeros(frame.shape, bool)
            for part in self._parts:
                self._barred[part.window] |= part.edge_m < 0
        return self._parts


def room_within(area: Zone, frame: GridFrame) -> F32:
    """(r, c) m: how far each cell, all of it, is within an area; less than 0 outside."""
    return _drawn(area, frame).edge_m


def _drawn(zone: Zone, frame: GridFrame) -> _Part:
    """Exact, where other layers count by cells: the body may go as near as it fits."""
    whole = slice(0, frame.rows), slice(0, frame.cols)
    window = whole if zone.area else _about(zone.corners_xy, frame)
    y, x = _middles(part_frame(frame, window))
    away_m = np.full((len(y), len(x)), REACH_M)
    for a, b in _sides(zone):
        near = _common(_about((a, b), frame), window)
        if near is not None:
            rows, cols = inside(near, window)
            away_m[rows, cols] = np.minimum(away_m[rows, cols], _to_segment(y[rows], x[cols], a, b))
    out = _within(zone, y, x) == zone.area
    signed = np.where(out, away_m, -away_m) - _WITHIN_CELL * frame.resolution_m
    return _Part(zone, window, signed.astype(np.float32))


def _opened(edge_m: F32, frame: GridFrame, opening: TooNear) -> F32:
    if math.isinf(opening.within_m):
        return edge_m + np.float32(opening.lacks_m)
    y, x = _middles(frame)
    away_m = np.hypot(x - opening.at_xy[0], (y - opening.at_xy[1])[:, None])
    more_m = np.where(away_m <= opening.within_m, opening.lacks_m, 0.0)
    return edge_m + more_m.astype(np.float32)


def _middles(frame: GridFrame) -> tuple[F64, F64]:
    """(R,) y and (C,) x of the cells' middles, m."""
    rows = np.arange(frame.rows, dtype=np.float64) + (frame.first_row + 0.5)
    cols = np.arange(frame.cols, dtype=np.float64) + (frame.first_col + 0.5)
    return rows * frame.resolution_m + frame.y0_m, cols * frame.resolution_m + frame.x0_m


def _about(points_xy: Sequence[tuple[float, float]], frame: GridFrame) -> Window:
    """The window of the grid that holds the points, and REACH_M round them."""
    cells = frame.cells(np.array(points_xy, np.float64))
    (top, left), (bottom, right) = cells.min(axis=0).tolist(), cells.max(axis=0).tolist()
    held = slice(top, bottom + 1), slice(left, right + 1)
    return widened(held, math.ceil(REACH_M / frame.resolution_m), frame)


def _common(a: Window, b: Window) -> Window | None:
    rows = slice(max(a[0].start, b[0].start), min(a[0].stop, b[0].stop))
    cols = slice(max(a[1].start, b[1].start), min(a[1].stop, b[1].stop))
    return (rows, cols) if rows.start < rows.stop and cols.start < cols.stop else None


def _sides(zone: Zone) -> Iterator[tuple[tuple[float, float], tuple[float, float]]]:
    corners = zone.corners_xy
    return zip(corners, (*corners[1:], corners[0]), strict=True)


def _to_segment(y: F64, x: F64, a: tuple[float, float], b: tuple[float, float]) -> F64:
    """(R,) and (C,) m -> (R, C) m from each point to a segment."""
    along = b[0] - a[0], b[1] - a[1]
    square = along[0] ** 2 + along[1] ** 2
    dx, dy = x - a[0], (y - a[1])[:, None]
    share = np.clip((dx * along[0] + dy * along[1]) / max(square, 1e-12), 0.0, 1.0)
    return np.asarray(np.hypot(dx - share * along[0], dy - share * along[1]), np.float64)


def _within(zone: Zone, y: F64, x: F64) -> Mask:
    """(R,) and (C,) m -> (R, C) whether each point is within the polygon: whether a ray along x
    crosses an odd number of its sides."""
    found = np.zeros((len(y), len(x)), bool)
    for (ax, ay), (bx, by) in _sides(zone):
        rows = np.flatnonzero((ay > y) != (by > y))
        if len(rows):
            crossed = ax + (y[rows] - ay) * ((bx - ax) / (by - ay))
            found[rows] ^= x < crossed[:, None]
    return found


def _cross(
    a: tuple[float, float], b: tuple[float, float], c: tuple[float, float], d: tuple[float, float]
) -> bool:
    """Whether two segments have a point in common."""

    def side(p: tuple[float, float], q: tuple[float, float], r: tuple[float, float]) -> float:
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    def on(p: tuple[float, float], q: tuple[float, float], r: tuple[float, float]) -> bool:
        return all(min(p[i], q[i]) <= r[i] <= max(p[i], q[i]) for i in (0, 1))

    first, second = (side(c, d, a), side(c, d, b)), (side(a, b, c), side(a, b, d))
    if first[0] * first[1] < 0 and second[0] * second[1] < 0:
        return True
    touches = zip((*first, *second), ((c, d, a), (c, d, b), (a, b, c), (a, b, d)), strict=True)
    return any(value == 0 and on(*three) for value, three in touches)
