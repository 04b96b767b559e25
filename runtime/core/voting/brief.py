"""What the experts are told: objects and room types around each frontier, by walking distance."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from runtime.core.geometry import GridFrame
from runtime.core.kernels import walking
from runtime.core.mapping.grid import MapCopy, NavigationMap
from runtime.core.mapping.keyframes import KeyframeView
from runtime.core.mapping.windows import Window, part_frame
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

OBJECT_RANGE_M = 3.5  # objects further on foot are not mentioned
TOUCH_CELLS = 4  # around an object: to walk there is to have walked up to it
ROOM_RANGE_M = 1.5  # around the frontier, where room evidence is averaged
ROOM_WEIGHT_MIN = 1.0  # mean evidence, in views, below which no room type is told
DOORWAY_M = (0.5, 1.4)  # width of a gap that is taken for a doorway
JAMB_M = 0.25  # from both its ends to something occupied
LARGEST_M = 4.0  # from an object's middle to its farthest cell
UNKNOWN_DEPTH_M = 2.0  # how far into the unknown a frontier is credited


def walking_distances(passable: Mask, seeds: Mask, limit: int) -> F32:
    """(r, c) masks -> cells of walking distance from the seeds, octagonal metric, inf beyond
    `limit` steps."""
    return walking.walk(passable, seeds, limit)[0]


@dataclass(frozen=True)
class SemanticCopy:
    """What is told of a window of a semantic map as it was at one moment: mean room evidence round
    each frontier, by its id, and the objects that are sure, in the window's own rows and columns.
    """

    room_names: tuple[str, ...]
    rooms: Mapping[int, F32]  # (R,) each
    things: "Things"

    @classmethod
    def of(
        cls,
        semantic: SemanticMap,
        grid: NavigationMap | MapCopy,
        frontiers: Iterable[Frontier],
        window: Window | None = None,
    ) -> "SemanticCopy":
        """Of a map within a window, the whole one if none is given, which holds the frontiers."""
        frame, cells_xy = grid.frame, {f.id: f.cells_xy for f in frontiers}
        window = window or (slice(0, frame.rows), slice(0, frame.cols))
        rooms: dict[int, F32] = {}
        if cells_xy and semantic.room_names:
            every = frame.cells(np.concatenate(list(cells_xy.values())))
            ends = np.cumsum([len(each) for each in cells_xy.values()], dtype=np.int32)
            steps = math.floor(ROOM_RANGE_M / frame.resolution_m + 1e-6)
            means = walking.means(semantic.rooms, grid.free, every, ends, steps)
            rooms = dict(zip(cells_xy, means, strict=True))
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
        semantic = SemanticCopy.of(semantic, grid, reachable)
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
    rooms = _rooms(semantic, frontier.id)
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
        view.sight,
        view.in_image,
    )


def _unknown_m2(unknown: Mask, seeds: Mask, resolution_m: float) -> float:
    """Unknown area that could be walked to from a frontier's cells, as far as the walls go."""
    _, reached = walking.walk(unknown, seeds, math.ceil(UNKNOWN_DEPTH_M / resolution_m))
    return float(reached - np.count_nonzero(seeds)) * resolution_m**2


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
    """Certain objects: name and confidence, and the centres (N, 2) m of the cells under each, which
    nobody changes; `frame` is of the window whose cells they are told in."""

    named: tuple[tuple[str, float], ...]
    cells_xy: tuple[F64, ...]
    frame: GridFrame

    @classmethod
    def of(cls, semantic: SemanticMap, frame: GridFrame, window: Window) -> "Things":
        """Those that may lie in a window of the map."""
        corners = np.array([[part.start for part in window], [part.stop for part in window]])
        low, high = frame.centres(corners.astype(np.int32))
        middle, reach_m = (low + high) / 2, float(np.hypot(*(high - low))) / 2 + LARGEST_M
        ids, _ = semantic.places.within((float(middle[0]), float(middle[1])), reach_m)
        named, cells_xy = [], []
        for id in ids:
            if semantic.catalogue.is_sure(id):
                one = semantic.instances[id]
                named.append((one.name, one.confidence))
                cells_xy.append(one.cells_xy)
        return cls(tuple(named), tuple(cells_xy), part_frame(frame, window))

    @cached_property
    def cells(self) -> I32:
        """(N, 2) row, col of all of them."""
        return self.frame.cells(np.concatenate(self.cells_xy))

    @cached_property
    def starts(self) -> I32:
        """(M,) where the cells of each begin."""
        lengths = [len(cells) for cells in self.cells_xy]
        return np.cumsum([0, *lengths[:-1]], dtype=np.int32)


def _objects(things: Things, origin: I32, walk_m: F32) -> tuple[NearbyObject, ...]:
    """Objects whose footprint can be walked up to."""
    if not things.named:
        return ()
    nearest = walking.reach_things(walk_m, things.cells - origin, things.starts, TOUCH_CELLS)
    near = []
    for thing in np.flatnonzero(nearest <= OBJECT_RANGE_M).tolist():
        name, confidence = things.named[thing]
        near.append(NearbyObject(name, round(confidence, 3), float(nearest[thing])))
    return tuple(sorted(near, key=lambda o: (o.distance_m, o.name, o.confidence)))


def _rooms(semantic: SemanticCopy, frontier: int) -> tuple[tuple[str, float], ...]:
    if not semantic.room_names:
        return ()
    evidence = semantic.rooms[frontier].astype(float)
    total = float(evidence.sum())
    if total < ROOM_WEIGHT_MIN:
        return ()
    return tuple(
        (name, round(float(e) / total, 4))
        for name, e in zip(semantic.room_names, evidence, strict=True)
    )


def _window(frame: GridFrame, cells_xy: F64, margin_m: float) -> tuple[Window, I32]:
    """The window of the grid that holds cells (N, 2) m and a margin, and its first cell."""
    cells = frame.cells(cells_xy)
    margin = math.ceil(margin_m / frame.resolution_m)
    low = np.maximum(cells.min(axis=0) - margin, 0)
    high = np.minimum(cells.max(axis=0) + margin + 1, frame.shape)
    corner: I32 = low.astype(np.int32)
    return (slice(int(low[0]), int(high[0])), slice(int(low[1]), int(high[1]))), corner
