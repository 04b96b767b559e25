"""What a search leaves that later ones may know, in another odometry frame, too: the map, the
objects, the views. It is taken into a world where that has not seen for itself; what is remembered
of a cell one look overrules, but for what was bumped into, and a remembered object is looked at
again."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from runtime.core.geometry import GridFrame, placed, seen_from
from runtime.core.mapping.drops import DROP_AT
from runtime.core.mapping.grid import MISS, OCCUPIED_AT, MapCopy, NavigationMap
from runtime.core.mapping.keyframes import KEYFRAMES_KEPT, Keyframe
from runtime.core.mapping.laser_layer import HELD_AT
from runtime.core.mapping.windows import Window, part_frame
from runtime.core.objects.instances import ASSOCIATE_M, Evidence, Instance
from runtime.core.objects.semantic_map import SemanticMap
from runtime.core.types import F32, F64, Pose
from runtime.core.world import World

LAYERS: Final = {
    "evidence": np.int16, "swept": np.bool_, "backed": np.bool_, "driven": np.uint8,
    "drops": np.uint8, "bumped": np.bool_, "doubtful": np.bool_, "laser": np.int8,
}  # fmt: skip
"""By name the cells of a map that are remembered."""
MARGIN: Final = 4  # cells
OBJECTS_KEPT: Final = 2000  # the surest
VIEWS_KEPT: Final = 32  # of each, the latest


@dataclass(frozen=True)
class Keepsake:
    """layers: (R, C) each, of LAYERS. rooms: (K, R, C). `on`: where its frame's origin is in the
    frame that places and zones are told in, which is the same over all restarts. `looks`: whose
    embeddings these are; others say nothing beside them."""

    frame: GridFrame
    layers: dict[str, NDArray[Any]]
    room_names: tuple[str, ...]
    rooms: F32
    instances: tuple[Instance, ...]
    keyframes: tuple[Keyframe, ...]
    on: Pose
    looks: str

    @property
    def map(self) -> MapCopy:
        """As it was seen, to be matched with what is seen now."""
        layer = self.layers
        stands = (layer["evidence"] >= OCCUPIED_AT) | (layer["laser"] >= HELD_AT)
        stands = stands | layer["bumped"].astype(bool) | (layer["drops"] >= DROP_AT)
        free = ((layer["evidence"] < 0) | layer["swept"].astype(bool)) & ~stands
        return MapCopy(self.frame, stands, free, ~(stands | free))


def keepsake_of(world: World, on: Pose, looks: str) -> Keepsake:
    """A copy of what is to be remembered, which nobody changes any more."""
    grid, semantic = world.map, world.semantic
    window = grid.known_window(MARGIN)
    f = part_frame(grid.frame, window)
    r = f.resolution_m
    frame = GridFrame(f.x0_m + f.first_col * r, f.y0_m + f.first_row * r, r, *f.shape)
    things = sorted(semantic.instances.values(), key=lambda i: -i.log_odds)[:OBJECTS_KEPT]
    return Keepsake(
        frame,
        {name: _layer(grid, name, window) for name in LAYERS},
        semantic.room_names,
        semantic.rooms[:, *window].copy(),
        tuple(_bare(thing) for thing in sorted(things, key=lambda i: i.id)),
        tuple(k.bare() for k in world.keyframes),
        on,
        looks,
    )


def _layer(grid: NavigationMap, name: str, window: Window) -> NDArray[Any]:
    if name != "laser":
        cells: NDArray[Any] = getattr(grid, name)[window].copy()
        return cells
    return grid.laser.evidence[window].copy() if grid.laser.evidence.size else np.zeros(
        (window[0].stop - window[0].start, window[1].stop - window[1].start), np.int8
    )  # fmt: skip


def _bare(thing: Instance) -> Instance:
    """What it is and where, and from where it was seen last; what those views said for a name or
    against it is a search's own affair."""
    gone = max(0, len(thing.views) - VIEWS_KEPT)
    evidence = {
        name: Evidence(known.odds, rejections=known.rejections, since=max(0, known.since - gone))
        for name, known in thing.evidence.items()
    }
    views, cells_xy = thing.views[gone:], thing.cells_xy.copy()
    return replace(thing, evidence=evidence, views=views, looks=[], unseen=[], cells_xy=cells_xy)


def turned_onto(known: Keepsake, at: Pose, frame: GridFrame) -> Keepsake:
    """The same in the frame in which its own origin is `at`, on the lattice of another grid's
    cells: slow, and nobody's world is touched."""
    lattice = _covering(known, at, frame)
    rows, cols = np.indices(lattice.shape)
    centres = lattice.centres(np.stack([rows, cols], axis=-1).astype(np.int32))
    cells = known.frame.cells(_moved(centres, at, back=True))
    inside = ((cells >= 0) & (cells < known.frame.shape)).all(axis=-1)
    cells[~inside] = 0
    take = cells[..., 0], cells[..., 1]
    return Keepsake(
        lattice,
        {name: np.where(inside, cells[take], cells.dtype.type(0))
         for name, cells in known.layers.items()},
        known.room_names,
        np.asarray(np.where(inside, known.rooms[:, *take], 0), np.float32),
        tuple(_thing_at(thing, at, lattice) for thing in known.instances),
        tuple(replace(k, pose=placed(at, k.pose)) for k in known.keyframes),
        placed(known.on, seen_from(at, Pose(0.0, 0.0, 0.0))),
        known.looks,
    )  # fmt: skip


def _covering(known: Keepsake, at: Pose, frame: GridFrame) -> GridFrame:
    """The cells of a grid's lattice that hold all of it."""
    f, r = known.frame, frame.resolution_m
    wide, high = f.cols * f.resolution_m, f.rows * f.resolution_m
    corners = np.array([[0, 0], [wide, 0], [0, high], [wide, high]])
    xy = _moved(corners + np.array([f.x0_m, f.y0_m]), at)
    low = np.floor((xy.min(axis=0) - (frame.x0_m, frame.y0_m)) / r)
    top = np.ceil((xy.max(axis=0) - (frame.x0_m, frame.y0_m)) / r)
    cols, rows = (top - low).astype(int).tolist()
    x0_m, y0_m = (low * r + (frame.x0_m, frame.y0_m)).tolist()
    return GridFrame(x0_m, y0_m, r, rows, cols)


def _moved(xy: F64, at: Pose, back: bool = False) -> F64:
    """(..., 2) m in the frame whose origin is `at` -> outside of it, or `back`."""
    c, s = math.cos(at.yaw_rad), math.sin(at.yaw_rad)
    if back:
        return np.asarray((xy - at.xy) @ np.array([[c, -s], [s, c]]), np.float64)
    return np.asarray(xy @ np.array([[c, s], [-s, c]]) + at.xy, np.float64)


def _thing_at(thing: Instance, at: Pose, frame: GridFrame) -> Instance:
    x_m, y_m = _moved(np.array(thing.xy), at).tolist()
    cells = np.unique(frame.cells(_moved(thing.cells_xy, at)), axis=0)
    evidence = {name: replace(known) for name, known in thing.evidence.items()}
    views = [placed(at, view) for view in thing.views]
    at_cells = frame.centres(cells)
    return replace(thing, xy=(x_m, y_m), cells_xy=at_cells, evidence=evidence, views=views)


def take_in(world: World, known: Keepsake) -> tuple[Instance, ...]:
    """Have a world know what is remembered, `turned_onto` its frame, as far as a map may reach;
    returns the objects that it did not know, for `meet_again`."""
    frame, r = known.frame, known.frame.resolution_m
    high, wide = frame.rows * r, frame.cols * r
    for x, y in ((0.0, 0.0), (wide, 0.0), (0.0, high), (wide, high)):
        corner = Pose(frame.x0_m + x, frame.y0_m + y, 0.0)
        if world.may_reach(corner, MARGIN * r):
            world.grow(MARGIN * r, corner.xy)
    window, part = _shared(world.map.frame, frame)
    if window[0].start < window[0].stop and window[1].start < window[1].stop:
        _take_cells(world, known, window, part)
    near = world.semantic.places
    new = [
        thing for thing in known.instances
        if not any(
            thing.name in world.semantic.instances[id].evidence
            for _, id in near.near(thing.xy, thing.cells_xy, ASSOCIATE_M)
        )
    ]  # fmt: skip
    world.keyframes = [*known.keyframes, *world.keyframes][-KEYFRAMES_KEPT:]
    return tuple(new)


def meet_again(semantic: SemanticMap, things: Sequence[Instance]) -> tuple[Instance, ...]:
    """Have them on the map, each under an id of its own."""
    met = []
    for thing in things:
        met.append(replace(thing, id=semantic.next_id))
        semantic.instances[semantic.next_id] = met[-1]
        semantic.next_id += 1
    return tuple(met)


def _shared(outer: GridFrame, frame: GridFrame) -> tuple[Window, Window]:
    """The window of a grid that another one of its lattice covers, and where in that it is."""
    r = outer.resolution_m
    top, left = round((frame.y0_m - outer.y0_m) / r), round((frame.x0_m - outer.x0_m) / r)
    row, col = max(0, top), max(0, left)
    last_row, last_col = min(outer.rows, top + frame.rows), min(outer.cols, left + frame.cols)
    window = slice(row, max(row, last_row)), slice(col, max(col, last_col))
    part = (
        slice(row - top, window[0].stop - top),
        slice(col - left, window[1].stop - left),
    )
    return window, part


def _take_cells(world: World, known: Keepsake, window: Window, part: Window) -> None:
    """What is unknown becomes as it was; never surer than that one look says otherwise."""
    grid, layer = world.map, {name: cells[part] for name, cells in known.layers.items()}
    unknown = grid.unknown[window].copy()
    evidence = np.clip(layer["evidence"].astype(np.int16), -MISS, OCCUPIED_AT)
    _fill(grid.evidence, window, unknown, evidence)
    _fill(grid.drops, window, unknown, np.minimum(layer["drops"].astype(np.uint8), DROP_AT))
    for name in ("swept", "backed", "driven", "bumped", "doubtful"):
        _fill(getattr(grid, name), window, unknown, layer[name])
    laser = np.minimum(layer["laser"].astype(np.int8), HELD_AT)
    if grid.laser.evidence.size:
        _fill(grid.laser.evidence, window, unknown, laser)
    elif laser.any():
        _fill(
            grid.evidence, window, unknown & (laser >= HELD_AT), np.full_like(evidence, OCCUPIED_AT)
        )
    grid.changed(window)
    grid.touched(window)
    for n, name in enumerate(known.room_names):
        if name in world.semantic.room_names:
            mine = world.semantic.rooms[world.semantic.room_names.index(name)][window]
            mine[unknown] = known.rooms[n][part][unknown]


def _fill(
    cells: NDArray[Any], window: Window, where: NDArray[np.bool_], values: NDArray[Any]
) -> None:
    cells[window][where] = values[where]


def forget_looks(known: Keepsake) -> Keepsake:
    """The same without embeddings, for whom those of its views say nothing."""
    none: F32 = np.zeros(0, np.float32)
    things = tuple(replace(thing, embedding_sum=none) for thing in known.instances)
    return replace(known, instances=things, keyframes=())
