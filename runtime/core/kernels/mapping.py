"""The compiled part of the navigation map: what a depth image shows, the masks of the evidence, the
boundary and its connected sets. Windows are rows and columns: top, bottom, left, right."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from runtime.core.kernels import _compiled
from runtime.core.types import F32, I32, U8, Mask

Ends = tuple[int, int, int, int]  # of a window: top, bottom, left, right


def solid(depth_m: F32, units: float, nearest_m: float, jump: int, same: int) -> F32:
    """(H, W) m -> a copy without flying pixels: see `mapping/solid_depth.py`. Inverse depth is
    compared in `units` to 1/m, what is nearer than `nearest_m` counting as there; a pixel flies
    that is more than `jump` off what is to either side, and more than `same` off its neighbours."""
    found = np.empty(depth_m.shape, np.float32)
    _compiled.solid(found, depth_m, units, nearest_m, jump, same)
    return found


class DepthView(NamedTuple):
    """Where a depth image was taken, and what of it counts. Heights are above the floor."""

    stride: int  # every n-th pixel of the image is used
    max_depth_m: float
    camera_m: float  # the camera's height
    floor_m: float  # points under this height are floor
    height_m: float  # those up to this one obstacles
    cosine: float  # of the yaw of the base
    sine: float
    x_m: float  # the camera in the grid, from its corner
    y_m: float
    per_m: float  # cells
    slack: float  # points are below the floor that are lower than `floor_m` and so much a m away
    lip_m: float  # behind a drop points that are so much below the floor belong to it
    drop_within_m: float  # a cell so near is told to have no floor; farther off an azimuth ends


class Weights(NamedTuple):
    """How evidence changes by a frame."""

    hits_needed: int  # points in a cell that make a hit, or a drop; in an azimuth that end it
    hit: int
    miss: int  # less, for a cell that shows floor and no obstacle
    most: int  # either way
    drop_most: int  # of a cell that drops; a frame counts 1


def integrate(
    evidence: NDArray[np.int16],
    drops: U8,
    depth_m: F32,
    directions: tuple[F32, F32, F32, F32],
    groups: I32,
    azimuths: int,
    view: DepthView,
    weights: Weights,
    cells_around: int,
    hole_pixels: int,
) -> tuple[F32, Ends | None, Ends | None]:
    """Books a depth image (H, W) in `evidence` and `drops` (R, C), in place. `directions` are
    forward, left, up and level reach of the used pixels (h, w), m to a metre of depth; `groups`
    which of the azimuths each is of, (h, w), or (1, w) where all of a column are of one. No point
    is farther from the camera than `cells_around`; those outside of the grid count at its rim. A
    point below the floor counts where its ray crosses the floor's plane. Returns (3, A) m by
    azimuth: the free range, which is up to the nearest obstacle, else the farthest floor, but
    neither beyond the floor seen before a drop nor beyond where `hole_pixels` one above the other,
    or more, would show floor and are of unknown depth; how far of that floor was seen; and how near
    it drops where no floor was seen before, 0 for nowhere. And the windows of what was seen, and of
    what drops. ValueError for shapes that do not fit."""
    range_m = np.empty((3, azimuths), np.float32)
    seen, dropped = _compiled.integrate(
        evidence, drops, depth_m, *directions, groups, range_m, *view, *weights, cells_around,
        hole_pixels,
    )  # fmt: skip
    return range_m, seen, dropped


class Through(NamedTuple):
    """What tells that a cell is seen through. Heights are above the floor."""

    max_depth_m: float  # cells farther off are not looked at, and what is read beyond is nothing
    lowest_m: float  # of eight heights at which a cell is looked at
    apart_m: float  # one from the next
    margin_m: float  # beyond the cell all that is read has to be, by so much
    slack: float  # and so much a m away
    miss: int  # less evidence, by a frame
    flat_m: float  # from so near, of a cell in which nothing stood at any of those heights


def see_through(
    evidence: NDArray[np.int16],
    stood: U8,
    depth_m: F32,
    grid: tuple[float, float, float, int],
    base: tuple[float, float, float, float],
    camera: tuple[float, ...],
    rules: Through,
) -> Ends | None:
    """Takes from the `evidence` (R, C) of cells with an obstacle that a depth image (H, W) m sees
    through, in place. `stood` (R, C): by a bit each the heights at which something was seen there.
    A cell is seen through where across all of it the image reads what is beyond it: at the lowest
    height, or at three at which something stood, while at none of those it is blocked or hidden,
    and nothing is read in it at any height between: a table's top is flat.
    `grid` is its corner, the side of a cell and how many cells around the camera are looked at;
    `base` x, y, cosine and sine of the yaw; `camera` its place on the base, the turn from its frame
    to the base's, by rows, and fx, fy, cx, cy. Returns the window of what changed, None for
    nothing. ValueError for shapes that do not fit."""
    return _compiled.see_through(evidence, stood, depth_m, *grid, *base, *camera, *rules)


def derive(
    evidence: NDArray[np.int16],
    drops: U8,
    bumped: Mask,
    swept: Mask,
    doubtful: Mask,
    masks: tuple[Mask, Mask, Mask],
    occupied_at: int,
    drop_at: int,
    window: Ends,
) -> tuple[Ends | None, Ends | None]:
    """Makes `masks` anew within a window, in place: occupied, free and unknown, all (R, C).
    Cells that drop are occupied. Obstacle cells less than five apart are one thing: what was only
    swept over, between them, is no floor; nor is it where floor is doubtful. Returns the windows of
    what changed and of what is known, None for nothing."""
    return _compiled.derive(
        evidence, drops, bumped, swept, doubtful, *masks, occupied_at, drop_at, *window
    )


def boundary(
    edge: Mask,
    free: Mask,
    unknown: Mask,
    occupied: Mask,
    given_up: Mask,
    wall_gap: int,
    window: Ends,
) -> Ends | None:
    """Makes `edge` anew within a window, in place: free cells beside unknown ones, by eight
    neighbours, with no obstacle in the square of `wall_gap` cells, and not given up. All (R, C).
    Returns the window of what changed, None for nothing."""
    return _compiled.boundary(edge, free, unknown, occupied, given_up, wall_gap, *window)


def components(mask: Mask, top: int, left: int) -> list[I32]:
    """(r, c) -> the 8-connected sets of cells, each (N, 2) row, col in scan order, of a mask whose
    corner is given; those first whose first block of 2 x 2 cells of the mask comes first."""
    count = int(np.count_nonzero(mask))
    cells, ends = np.empty((count, 2), np.int32), np.empty((1, count), np.int32)
    found = _compiled.components(mask, cells, ends, top, left)
    last = ends[0, :found].tolist()
    return [cells[start:end] for start, end in zip([0, *last[:-1]], last, strict=False)]


def shared(cells: I32, others: I32, reach: int) -> int:
    """How many of some cells (N, 2) have one of the others (M, 2) in the square of so many cells
    around them."""
    return _compiled.shared(np.ascontiguousarray(cells), np.ascontiguousarray(others), reach)


class Rules(NamedTuple):
    """Where a window lies, where the robot is, and what it can pass. Lengths in m."""

    cell_m: float
    x0_m: float  # the grid's corner
    y0_m: float
    first_row: int  # the window's, in the grid
    first_col: int
    x_m: float  # the robot
    y_m: float
    most_m: float  # clearance that is told
    hard_m: float  # that the body needs
    comfort_m: float  # more of it, over which speed rises to all of it
    slowest: float  # relative speed at the least clearance
    squeeze_m: float  # so near to the robot cells of `loose_m` are clear; 0: none
    loose_m: float
    escape_m: float  # so near to it free cells pass
    dead_end_m: float  # and so near even those of a dead end


def survey(
    distance: F32,
    free: Mask,
    driven: NDArray[np.uint8],
    dead_end: Mask,
    terrain: tuple[F32, Mask, F32],
    rules: Rules,
) -> None:
    """Makes `terrain` anew, in place: clearance in m, where the body fits, relative speed; of the
    distance to the nearest obstacle's middle in cells, and the map's masks. All (r, c), of one
    window. What was driven over is as clear as the body needs."""
    _compiled.survey(distance, free, driven, dead_end, *terrain, *rules)
