"""What the experts are told: objects and room types around each frontier, by walking distance."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from runtime.core.geometry import GridFrame
from runtime.core.mapping.grid import MapCopy, NavigationMap
from runtime.core.mapping.keyframes import KeyframeView
from runtime.core.mapping.windows import part_frame
from runtime.core.objects.semantic_map import SemanticMap
from runtime.core.types import (
    F32,
    F64,
    I32,
    Brief,
    Frontier,
    FrontierBrief,
    Mask,
    NearbyObject,
)

_CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
_SQUARE = np.ones((3, 3), np.uint8)


OBJECT_RANGE_M = 3.5  # objects further on foot are not mentioned
OBJECT_CONFIDENCE = 0.6  # less certain ones are not mentioned
ROOM_RANGE_M = 1.5  # around the frontier, where room evidence is averaged
ROOM_WEIGHT_MIN = 1.0  # mean evidence, in views, below which no room type is told
DOORWAY_M = (0.5, 1.4)  # width of a gap that is taken for a doorway
JAMB_M = 0.25  # from both its ends to something occupied
LARGEST_M = 4.0  # from an object's middle to its farthest cell
UNKNOWN_DEPTH_M = 2.0  # how far into the unknown a frontier is credited


def walking_distances(passable: Mask, seeds: Mask, limit: int) -> F32:
    """(r, c) masks -> cells of walking distance from the seeds, octagonal metric, inf beyond
    `limit` steps. One dilation a step: for small neighbourhoods it beats fast marching."""
    reached, wider = seeds.astype(np.uint8), np.zeros(seeds.shape, np.uint8)
    allowed = (passable | seeds).astype(np.uint8)
    # Steps that each cell has been reached for; bytes are added fastest.
    since = np.zeros(seeds.shape, np.uint8 if limit < 255 else np.uint16)
    count, done = cv2.countNonZero(reached), 0
    x, y, w, h = cv2.boundingRect(reached)
    for n in range(1, limit + 1):
        # no step leads further than a cell from what was reached
        near = slice(max(0, y - n), y + h + n), slice(max(0, x - n), x + w + n)
        part = wider[near]
        cv2.dilate(reached[near], _CROSS if n % 2 else _SQUARE, dst=part)
        cv2.bitwise_and(part, allowed[near], dst=part)
        before, count = count, cv2.countNonZero(part)
        if count == before:
            break
        reached, wider, done = wider, reached, n
        since[near] += part
    steps = np.where(since > 0, np.float32(done + 1) - since.astype(np.float32), np.float32(np.inf))
    steps[seeds] = 0.0
    return steps


@dataclass(frozen=True)
class SemanticCopy:
    """What is told of a window of a semantic map as it was at one moment: room evidence (R, rows,
    cols) and the objects that are sure, in the window's own rows and columns."""

    room_names: tuple[str, ...]
    rooms: F32
    things: "Things"

    @classmethod
    def of(
        cls, semantic: SemanticMap, frame: GridFrame, window: tuple[slice, slice]
    ) -> "SemanticCopy":
        """Of the map within a window."""
        rooms = semantic.rooms[:, *window].copy()
        return cls(semantic.room_names, rooms, Things.of(semantic, frame, window))


def compose(
    goal: str,
    stamp_ns: int,
    grid: NavigationMap | MapCopy,
    semantic: SemanticMap | SemanticCopy,
    frontiers: Iterable[Frontier],
    views: Mapping[int, KeyframeView],
) -> Brief:
    """The brief over the reachable frontiers, sorted by id; `views` are their best keyframes."""
    reachable = sorted((f for f in frontiers if math.isfinite(f.distance_m)), key=lambda f: f.id)
    if isinstance(semantic, SemanticMap):
        whole = slice(0, grid.frame.rows), slice(0, grid.frame.cols)
        semantic = SemanticCopy.of(semantic, grid.frame, whole)
    told = [_frontier_brief(f, grid, semantic, views.get(f.id, KeyframeView())) for f in reachable]
    return Brief(goal, stamp_ns, tuple(told))


def _frontier_brief(
    frontier: Frontier,
    grid: NavigationMap | MapCopy,
    semantic: SemanticCopy,
    view: KeyframeView,
) -> FrontierBrief:
    margin_m = max(OBJECT_RANGE_M, UNKNOWN_DEPTH_M) + 0.5
    window, origin = _window(grid.frame, frontier.cells_xy, margin_m)
    seeds = np.zeros((window[0].stop - window[0].start, window[1].stop - window[1].start), bool)
    seeds[tuple((grid.frame.cells(frontier.cells_xy) - origin).T)] = True
    resolution = grid.frame.resolution_m
    steps = walking_distances(grid.free[window], seeds, math.ceil(OBJECT_RANGE_M / resolution))
    walk_m = steps * np.float32(resolution)
    unknown_m2 = _unknown_m2(grid.unknown[window], seeds, resolution)
    rooms = _rooms(semantic, window, walk_m <= ROOM_RANGE_M)
    objects = _objects(semantic.things, origin, walk_m)
    door = doorway(frontier.cells_xy, grid)
    return FrontierBrief(
        frontier.id,
        frontier.distance_m,
        objects,
        rooms,
        view.embedding,
        view.jpeg,
        door,
        round(unknown_m2, 2),
    )


def _unknown_m2(unknown: Mask, seeds: Mask, resolution_m: float) -> float:
    """Unknown area that could be walked to from a frontier's cells, as far as the walls go."""
    steps = walking_distances(unknown, seeds, math.ceil(UNKNOWN_DEPTH_M / resolution_m))
    return float(np.isfinite(steps[~seeds]).sum()) * resolution_m**2


def worthwhile(brief: Brief, least_m2: float) -> Brief:
    """The brief without frontiers that have next to nothing unknown behind them; as it is when
    there are no others."""
    kept = tuple(f for f in brief.frontiers if f.unknown_m2 >= least_m2)
    return replace(brief, frontiers=kept) if kept else brief


def doorway(cells_xy: F64, grid: NavigationMap | MapCopy) -> bool:
    """Whether cells (N, 2) m span a door's width and have something standing at both ends."""
    middle = cells_xy.mean(axis=0)
    axis = np.linalg.svd(cells_xy - middle, full_matrices=False)[2][0]
    along = (cells_xy - middle) @ axis
    width = float(np.ptp(along)) + grid.frame.resolution_m
    if not DOORWAY_M[0] <= width <= DOORWAY_M[1]:
        return False
    reach = math.ceil(JAMB_M / grid.frame.resolution_m)
    ends = grid.frame.cells(cells_xy[[int(along.argmin()), int(along.argmax())]])
    return all(
        bool(
            grid.occupied[
                max(0, r - reach) : r + reach + 1, max(0, c - reach) : c + reach + 1
            ].any()
        )
        for r, c in ends
    )


@dataclass(frozen=True)
class Things:
    """Certain objects, name and confidence, and the cells under them: (N, 2), those of one object
    from `starts` on."""

    named: tuple[tuple[str, float], ...]
    cells: I32
    starts: NDArray[np.intp]

    @classmethod
    def of(cls, semantic: SemanticMap, frame: GridFrame, window: tuple[slice, slice]) -> "Things":
        """Those that may lie in a window of the map; their cells are counted from its first."""
        ends = np.array([[part.start for part in window], [part.stop for part in window]], np.int32)
        low, high = frame.centres(ends)
        middle, reach_m = (low + high) / 2, float(np.hypot(*(high - low))) / 2 + LARGEST_M
        ids, _ = semantic.places.within((float(middle[0]), float(middle[1])), reach_m)
        near = [semantic.instances[id] for id in ids]
        sure = [i for i in near if i.confidence >= OBJECT_CONFIDENCE]
        inner = part_frame(frame, window)
        cells = [inner.cells(i.cells_xy) for i in sure]
        starts = np.cumsum([0, *(len(c) for c in cells)])[:-1]
        flat = np.concatenate([np.zeros((0, 2), np.int32), *cells])
        return cls(tuple((i.name, i.confidence) for i in sure), flat, starts)


def _objects(things: Things, origin: np.ndarray, walk_m: F32) -> tuple[NearbyObject, ...]:
    """Objects whose footprint can be walked up to; 0.2 m around it counts as touching it."""
    if not things.named:
        return ()
    touch = cv2.erode(walk_m, np.ones((9, 9), np.uint8))  # a minimum filter
    rows, cols = (things.cells - origin).T
    inside = (rows >= 0) & (rows < walk_m.shape[0]) & (cols >= 0) & (cols < walk_m.shape[1])
    away = np.full(len(rows), np.inf, np.float32)
    away[inside] = touch[rows[inside], cols[inside]]
    nearest = np.minimum.reduceat(away, things.starts)
    near = [
        NearbyObject(name, round(confidence, 3), float(distance))
        for (name, confidence), distance in zip(things.named, nearest, strict=True)
        if distance <= OBJECT_RANGE_M
    ]
    return tuple(sorted(near, key=lambda o: (o.distance_m, o.name, o.confidence)))


def _rooms(
    semantic: SemanticCopy, window: tuple[slice, slice], near: Mask
) -> tuple[tuple[str, float], ...]:
    if not semantic.room_names or not near.any():
        return ()
    evidence = semantic.rooms[:, *window][:, near].mean(axis=1).astype(float)
    total = float(evidence.sum())
    if total < ROOM_WEIGHT_MIN:
        return ()
    return tuple(
        (name, round(float(e) / total, 4))
        for name, e in zip(semantic.room_names, evidence, strict=True)
    )


def _window(
    frame: GridFrame, cells_xy: F64, margin_m: float
) -> tuple[tuple[slice, slice], np.ndarray]:
    cells = frame.cells(cells_xy)
    margin = math.ceil(margin_m / frame.resolution_m)
    low = np.maximum(cells.min(axis=0) - margin, 0)
    high = np.minimum(cells.max(axis=0) + margin + 1, frame.shape)
    return (slice(int(low[0]), int(high[0])), slice(int(low[1]), int(high[1]))), low
