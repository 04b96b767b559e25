"""Objects whose place an image shows without them, for they were taken away, or does not show."""

from collections.abc import Iterable
from typing import Final

import numpy as np

from runtime.core.geometry import map_to_optical, project
from runtime.core.objects.instances import Instance
from runtime.core.types import F64, Mount, Observation

LOOKS: Final = (
    4  # that see through its place, and none that sees it between, after which it is gone
)
NEAR_M: Final = 3.0  # from so near
READ_M: Final = (
    6.0  # what is told to be farther is none: some cameras so tell what they cannot read
)
BEYOND_M: Final = 0.3  # farther than the thing all has to be that is read there
SHARE: Final = 0.9  # of what is read
LEAST: Final = 0.5  # of the points looked at that tell anything
FRONT_M: Final = 0.2  # deep is what of a thing has to be shown,
HIDES_M: Final = 0.15  # nearer than that is what hides it,
HIDDEN: Final = 0.9  # of the points looked at out of the image or behind something
CELLS: Final = 6  # of a thing that are looked at,
HEIGHTS: Final = (0.25, 0.5, 0.75)  # at these shares of what is between its lowest and its highest


def seen_through(things: Iterable[Instance], obs: Observation, mount: Mount) -> list[Instance]:
    """Those of some things, none of which was detected, in whose place the image shows what is
    beyond."""
    found = list(things)
    if not found:
        return []
    middles = np.array([(*thing.xy, thing.z_m) for thing in found])
    through = _beyond_m(middles, obs, mount) > BEYOND_M
    return [
        t for t, passed in zip(found, through, strict=True) if passed and _all_of(t, obs, mount)
    ]


def hidden(thing: Instance, obs: Observation, mount: Mount) -> bool:
    """Whether an image shows too little of a thing's place: it is out of the image, or something
    stands before it. What is not near is not asked about."""
    away = np.hypot(*(thing.cells_xy - obs.pose.xy).T)
    return bool(away.min() <= NEAR_M) and covered(thing, obs, mount, NEAR_M)


def covered(thing: Instance, obs: Observation, mount: Mount, within_m: float) -> bool:
    """The same of what is so near: a thing against the other side of a wall is covered by it."""
    away = np.hypot(*(thing.cells_xy - obs.pose.xy).T)
    front = thing.cells_xy[away <= away.min() + FRONT_M]
    beyond_m = _beyond_m(_points(thing, front), obs, mount, within_m)
    lost = beyond_m < -HIDES_M  # where nothing is read is none
    return bool(lost.sum() >= HIDDEN * len(lost))


def _all_of(thing: Instance, obs: Observation, mount: Mount) -> bool:
    """Whether it is so all over the thing, of which the middle may be a gap."""
    beyond = _beyond_m(_points(thing, thing.cells_xy), obs, mount)
    told = beyond[np.isfinite(beyond)]
    return len(told) >= LEAST * len(beyond) and (told > BEYOND_M).sum() >= SHARE * len(told)


def _points(thing: Instance, cells_xy: F64) -> F64:
    """(N, 3) m, map frame: some all over a thing on some of its cells, (M, 2) m."""
    few = np.linspace(0, len(cells_xy) - 1, min(CELLS, len(cells_xy))).astype(int)
    high = thing.low_m + np.array(HEIGHTS) * (thing.high_m - thing.low_m)
    cells = np.repeat(cells_xy[few], len(high), axis=0)
    return np.column_stack([cells, np.tile(high, len(few))])


def _beyond_m(points: F64, obs: Observation, mount: Mount, within_m: float = NEAR_M) -> F64:
    """(N, 3) m, map frame -> (N,) how much farther than each the image reads there, m; NaN where it
    reads nothing, -inf where a point is out of view or too far away."""
    optical = map_to_optical(points, obs.pose, mount)
    beyond = np.full(len(points), -np.inf)
    at = np.flatnonzero((optical[:, 2] > 0.1) & (optical[:, 2] <= within_m))
    col, row = np.rint(project(optical[at], obs.intrinsics)).astype(np.int64).T
    height, width = obs.depth_m.shape
    inside = (col >= 0) & (col < width) & (row >= 0) & (row < height)
    at, read = at[inside], obs.depth_m[row[inside], col[inside]]
    beyond[at] = np.where((read > 0) & (read <= READ_M), read - optical[at, 2], np.nan)
    return beyond
