"""What the official episodes and the furniture say about where a layout's walls are.

A layout's five scenes share their walls. Where a path runs is no wall; where furniture stands is
none; a painting hangs on one; and two places of a path that lie nearer to each other than the path
between them have something in between: furniture of that scene, or a wall.
"""

import gzip
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.robothor.footprints import footprint
from hil_sim.scenes.robothor.metadata import MetadataError, Thing, apartment

OUTER = (1.01, -4.9, 9.79, -1.01)
"""The apartment between its walls' inner faces: x0, y0, x1, y1."""
CELL_M = 0.01
HALF_WALL_M = 0.0125
"""Half the wall's thickness: paintings on both sides of one are 2.5 cm apart."""
SHRINK_M = 0.06
"""Furniture's boxes are larger than furniture; walls may cut this much off their sides."""
SOLID = 2
"""In how many of the scenes furniture must stand in a place for it to be no wall: boxes err."""
BODY_M = 0.23
"""A straight way this near furniture may be barred by it: the body's radius and the box's error."""
DETOUR_M = 0.06
LONGEST = 12_000
"""Chords looked at; the rest are left out evenly."""

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Path2 = Floats
"""A path on the plan, (N, 2) metres in the scene frame."""


@dataclass(frozen=True)
class Plane:
    """A wall's middle plane behind something hung on it. `axis` 0: the wall runs along x at
    y = `at`; 1: along y at x = `at`; the hung object spans `low` to `high` along it."""

    axis: int
    at: float
    low: float
    high: float


@dataclass(frozen=True)
class WallEvidence:
    """Of one layout. Grids have cells of 1 cm from OUTER's lower left corner, row along y.

    `clear_m` (H, W): metres to the nearest path. `solid` (H, W): furniture of any scene stands
    there. `chords` (N, 4): x0, y0, x1, y1 of straight ways that something other than furniture
    bars. `paths`: all of them.
    """

    clear_m: Floats
    solid: Bools
    chords: Floats
    planes: tuple[Plane, ...]
    paths: tuple[Path2, ...]


def read_paths(path: Path) -> tuple[Path2, ...]:
    """The shortest paths of a file of official episodes, of two points or more."""
    return tuple(line for row in read_rows(path) if len(line := _line(row, path)) > 1)


def read_rows(path: Path) -> list[dict[str, Any]]:
    """The episodes of a RoboTHOR 2021 file as they stand; MetadataError names a bad file."""
    try:
        with gzip.open(path, "rt", encoding="utf-8") as file:
            rows = json.load(file)
    except (OSError, EOFError, ValueError) as error:
        raise MetadataError(f"{path}: not a gzipped JSON file of episodes: {error}") from None
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise MetadataError(f"{path}: must hold a list of episodes")
    return rows


def _line(row: dict[str, Any], path: Path) -> Path2:
    try:
        points = [(float(point["x"]), float(point["z"])) for point in row["shortest_path"]]
    except (KeyError, TypeError, ValueError):
        raise MetadataError(
            f"{path}: episode {row.get('id')}: shortest_path: must list points with x and z"
        ) from None
    return np.array(points, float).reshape(-1, 2)


def gather(layout: str, files: Sequence[Path]) -> WallEvidence:
    """Read the evidence of a layout from the episode files of its scenes."""
    height, width = (round((OUTER[i + 2] - OUTER[i]) / CELL_M) for i in (1, 0))
    crossed, solid = np.zeros((height, width), np.uint8), np.zeros((height, width), np.uint8)
    chords: list[Floats] = []
    paths: list[Path2] = []
    planes: list[Plane] = []
    for file in files:
        things = apartment(file.name.removesuffix(".json.gz"))
        mine = read_paths(file)
        paths += mine
        cv2.polylines(crossed, [to_cells(path) for path in mine], False, 1, shift=_SHIFT)
        filled = np.zeros_like(solid)
        _fill(filled, things, SHRINK_M)
        solid += filled
        chords.append(_barred(mine, things, (height, width)))
        planes += [plane for thing in things if (plane := hung_plane(thing)) is not None]
    clear = cv2.distanceTransform(1 - crossed, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * CELL_M
    every = np.concatenate(chords) if chords else np.empty((0, 4))
    step = max(1, math.ceil(len(every) / LONGEST))
    return WallEvidence(
        np.asarray(clear, float), solid >= SOLID, every[::step], tuple(planes), tuple(paths)
    )


_SHIFT = 6


def to_cells(xy: Floats) -> NDArray[np.int32]:
    """(N, 2) metres -> OpenCV's fixed-point coordinates of the grid."""
    cells = (xy - OUTER[:2]) / CELL_M - 0.5
    return np.asarray(np.round(cells * (1 << _SHIFT)), np.int32)


def _fill(grid: NDArray[np.uint8], things: Sequence[Thing], shrink_m: float) -> None:
    for thing in things:
        if thing.type == "Painting":
            continue
        box = footprint(thing)
        w, d = box.width / 2 - shrink_m, box.depth / 2 - shrink_m
        if min(w, d) <= 0:
            continue
        c, s = math.cos(box.yaw_rad), math.sin(box.yaw_rad)
        local = np.array([[-w, -d], [w, -d], [w, d], [-w, d]])
        corners = local @ np.array([[c, s], [-s, c]]) + (box.x, box.y)
        cv2.fillConvexPoly(grid, to_cells(corners), 1, shift=_SHIFT)


def hung_plane(thing: Thing) -> Plane | None:
    """The plane behind a painting; None for one on the outer walls or at an odd angle."""
    if thing.type != "Painting":
        return None
    along_x, along_y, _ = thing.size_m
    axis = 0 if along_x > along_y else 1
    across = 1 - axis
    turn = math.radians(thing.turn_deg[1])
    ahead = (math.sin(turn), math.cos(turn))[across]
    if abs(ahead) < 0.95:
        return None
    at = thing.low_m[across] - HALF_WALL_M if ahead > 0 else thing.high_m[across] + HALF_WALL_M
    if min(at - OUTER[across], OUTER[across + 2] - at) < 0.15:
        return None
    return Plane(axis, at, thing.low_m[axis], thing.high_m[axis])


def _barred(paths: Sequence[Path2], things: Sequence[Thing], shape: tuple[int, int]) -> Floats:
    """(N, 4) straight ways between vertices of a path that are shorter than the path and that no
    furniture of the scene explains."""
    solid = np.zeros(shape, np.uint8)
    _fill(solid, things, 0.0)
    away = cv2.distanceTransform(1 - solid, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * CELL_M
    chords = np.concatenate([np.empty((0, 4)), *(_shortcuts(path) for path in paths)])
    chords = np.unique(np.round(chords, 2), axis=0)
    steps = np.linspace(0.0, 1.0, 60)[:, None]
    x = chords[:, 0] + (chords[:, 2] - chords[:, 0]) * steps
    y = chords[:, 1] + (chords[:, 3] - chords[:, 1]) * steps
    cols = np.clip(((x - OUTER[0]) / CELL_M).astype(int), 0, shape[1] - 1)
    rows = np.clip(((y - OUTER[1]) / CELL_M).astype(int), 0, shape[0] - 1)
    free: Bools = away[rows, cols].min(axis=0) > BODY_M
    barred: Floats = np.asarray(chords[free], float)
    return barred


def _shortcuts(path: Path2) -> Floats:
    """(N, 4) pairs of vertices that lie nearer to each other than the path between them."""
    run = np.r_[0.0, np.cumsum(np.hypot(*np.diff(path, axis=0).T))]
    i, j = np.triu_indices(len(path), 2)
    straight = np.hypot(*(path[j] - path[i]).T)
    keep = run[j] - run[i] - straight > DETOUR_M
    pairs: Floats = np.hstack([path[i], path[j]])[keep]
    return pairs
