"""Searches on the plan of a home: a disc that sees a fan of it, drives to frontiers by the shortest
way, and is done when the goal is in view. What a frontier is, how much is unknown behind it and how
far it is on foot are the runtime's own kernels, at a coarser grid; there is no camera and no base.
Thousands of searches take minutes."""

import math
import random
from collections.abc import Callable
from dataclasses import dataclass, field

import cv2
import numpy as np

from hil_sim.expert_bench.flat_home import CELL_M, FlatHome
from hil_sim.simulation.protocol import HM3D
from runtime.core.kernels import mapping, marching, walking
from runtime.core.mapping.frontiers import WALL_GAP_CELLS
from runtime.core.types import F64, I32, Mask

LEAST_WAY_M = 2.0  # from a start to success
STEP_M = 0.5  # between two views
RANGE_M = 5.0
RAYS = 80
BODY_M = 0.17  # of clearance: no more than the truth asks for
MIN_CELLS = 4  # of a frontier: as narrow as the runtime's
SNAP_M = 0.3  # from a frontier to where the body fits
ARRIVED_M = 0.25
SAME_M = 0.7  # a frontier so near to the one that was driven to goes on from it
BEHIND_M = 2.0  # how far into the unknown a frontier is credited
MOST_VIEWS = 400
Cell = tuple[int, int]


@dataclass(frozen=True)
class FlatTask:
    """Where a search begins, and the shortest way from there to success, m."""

    goal: str
    start: Cell
    heading_rad: float
    shortest_m: float


@dataclass(frozen=True)
class FlatResult:
    """How one ended: ways in metres."""

    found: bool
    path_m: float
    shortest_m: float
    decisions: int

    @property
    def spl(self) -> float:
        """Success weighted by path length."""
        return self.found * self.shortest_m / max(self.shortest_m, self.path_m)


@dataclass(frozen=True)
class FlatFrontier:
    """Its cells (N, 2), where the robot would stand, how far that is on foot, how much is unknown
    behind it; `kept`: it is the one that was driven to."""

    cells: I32
    goal: Cell
    distance_m: float
    unknown_m2: float
    kept: bool


@dataclass
class FlatSearch:
    """The state of one. known (H, W): what was in view; arrival (H, W) m on foot from the robot;
    seen: things, by index, that were in view."""

    home: FlatHome
    task: FlatTask
    known: Mask
    at: Cell
    heading_rad: float
    given_up: Mask
    seen: Mask
    path_m: float = 0.0
    passable: Mask = field(default_factory=lambda: np.zeros((0, 0), bool))
    arrival: F64 = field(default_factory=lambda: np.zeros((0, 0)))
    target: Cell | None = None

    @property
    def unknown(self) -> Mask:
        return ~self.known

    def ways_m(self, frontiers: list[FlatFrontier]) -> F64:
        """(N, N) on foot between frontiers, over what is known."""
        goals = np.array([f.goal for f in frontiers])
        found = np.zeros((len(goals), len(goals)))
        for n, goal in enumerate(goals):
            arrival = np.full(self.known.shape, np.inf)
            arrival[tuple(goal)] = 0.0
            marching.march(arrival, self.passable, CELL_M)
            found[n] = arrival[tuple(goals.T)]
        return np.asarray(np.minimum(found, found.T), np.float64)


Choose = Callable[[FlatSearch, list[FlatFrontier]], int]
"""Which of the frontiers is gone to."""


def task_in(home: FlatHome, goal: str, seed: int) -> FlatTask | None:
    """A start from which the goal is not in view and some way off; None where there is none."""
    way = home.way_m(goal)
    cells = np.argwhere(home.free & (way >= LEAST_WAY_M) & np.isfinite(way))
    rng = random.Random(f"flat/{home.name}/{goal}/{seed}")
    for _ in range(60 if len(cells) else 0):
        row, col = cells[rng.randrange(len(cells))].tolist()
        heading = math.radians(30 * rng.randrange(12))
        wanted = np.array(home.wanted(goal))
        if not home.in_view(home.middle((row, col)), heading, wanted).any():
            return FlatTask(goal, (row, col), heading, float(way[row, col]))
    return None


def drive(home: FlatHome, task: FlatTask, choose: Choose) -> FlatResult:
    """Until the goal is in view, or nothing is left to explore; whence the rest of the way is the
    shortest: how a thing is found that nothing hides any more is not what is compared here."""
    shape = home.free.shape
    search = FlatSearch(
        home, task, np.zeros(shape, bool), task.start, task.heading_rad,
        np.zeros(shape, bool), np.zeros(len(home.things), bool),
    )  # fmt: skip
    way, wanted = home.way_m(task.goal), home.wanted(task.goal)
    for turn in range(6):
        _look(search, task.heading_rad + math.radians(60 * turn))
    decisions = 0
    for _ in range(MOST_VIEWS):
        if search.seen[wanted].any():
            break
        frontiers = _frontiers(search)
        if not frontiers:
            break
        decisions += 1
        chosen = frontiers[choose(search, frontiers)] if len(frontiers) > 1 else frontiers[0]
        _go(search, chosen)
    (row, col), n = search.at, 2  # the body may stand where it only just fits
    left_m = float(way[max(0, row - n) : row + n + 1, max(0, col - n) : col + n + 1].min())
    return FlatResult(math.isfinite(left_m), search.path_m + left_m, task.shortest_m, decisions)


def _go(search: FlatSearch, frontier: FlatFrontier) -> None:
    """A step toward a frontier, and a look; on arrival a look at it, which has to show what is
    behind it, or it is given up."""
    search.target = frontier.goal
    back = marching.descend(search.arrival, frontier.goal, 10_000)
    along = search.arrival[tuple(back.T)]
    ahead = np.flatnonzero(along <= STEP_M + 1e-9)
    at = back[ahead[0]] if len(ahead) else back[-1]
    before = search.at
    search.at = int(at[0]), int(at[1])
    search.path_m += float(search.arrival[search.at])
    middle = frontier.cells.mean(axis=0)
    arrived = frontier.distance_m - float(search.arrival[search.at]) <= ARRIVED_M
    (down, right) = middle - search.at if arrived else np.subtract(search.at, before)
    if down or right:
        search.heading_rad = math.atan2(down, right)
    known = int(np.count_nonzero(search.known))
    _look(search, search.heading_rad)
    if arrived and np.count_nonzero(search.known) - known < MIN_CELLS:
        mask = np.zeros(search.known.shape, np.uint8)
        mask[tuple(frontier.cells.T)] = 1
        search.given_up |= cv2.dilate(mask, np.ones((3, 3), np.uint8)).view(bool)


def _look(search: FlatSearch, heading_rad: float) -> None:
    home, here = search.home, search.home.middle(search.at)
    outline, hits = home.rays(here, heading_rad, HM3D.hfov_rad, RANGE_M, RAYS)
    patch = np.zeros(search.known.shape, np.uint8)
    points = np.round((outline - 0.5) * 16).astype(np.int32)
    cv2.fillPoly(patch, [points], 1, shift=4)
    search.known |= patch.view(bool)
    search.known[hits[:, 0], hits[:, 1]] = True
    search.known[search.at] = True
    left = np.flatnonzero(~search.seen)
    search.seen[left[home.in_view(here, heading_rad, left)]] = True


def _frontiers(search: FlatSearch) -> list[FlatFrontier]:
    """Those that can be reached, with what is behind them."""
    home, known = search.home, search.known
    occupied, unknown = known & home.solid, ~known
    free = known & ~home.solid
    clear = cv2.distanceTransform((~occupied).view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5)
    search.passable = free & (clear * CELL_M >= BODY_M)
    search.passable[search.at] = True
    search.arrival = np.full(known.shape, np.inf)
    search.arrival[search.at] = 0.0
    marching.march(search.arrival, search.passable, CELL_M)
    edge = np.zeros(known.shape, bool)
    whole = 0, known.shape[0], 0, known.shape[1]
    mapping.boundary(edge, free, unknown, occupied, search.given_up, WALL_GAP_CELLS, whole)
    parts = [c for c in mapping.components(edge, 0, 0) if len(c) >= MIN_CELLS]
    if not parts:
        return []
    ends = np.cumsum([len(c) for c in parts], dtype=np.int32)
    snap = round(SNAP_M / CELL_M)
    places, away = walking.nearest(search.arrival, np.concatenate(parts), ends, snap, (0, 0))
    found = []
    for cells, place, far in zip(parts, places.tolist(), away.tolist(), strict=True):
        if math.isfinite(far):
            goal = place[0], place[1]
            area = behind_m2(unknown, cells, BEHIND_M)
            found.append(FlatFrontier(cells, goal, far, area, False))
    if search.target is not None and found:
        near = [math.dist(f.goal, search.target) * CELL_M for f in found]
        n = int(np.argmin(near))
        if near[n] <= SAME_M:
            f = found[n]
            found[n] = FlatFrontier(f.cells, f.goal, f.distance_m, f.unknown_m2, True)
    worth = [f for f in found if f.unknown_m2 >= 0.1]
    return worth or found


def behind_m2(unknown: Mask, cells: I32, depth_m: float) -> float:
    """Unknown area that could be walked to from these cells."""
    reach = math.ceil(depth_m / CELL_M)
    low = np.maximum(cells.min(axis=0) - reach - 1, 0)
    high = np.minimum(cells.max(axis=0) + reach + 2, unknown.shape)
    window = slice(int(low[0]), int(high[0])), slice(int(low[1]), int(high[1]))
    seeds = np.zeros((high[0] - low[0], high[1] - low[1]), bool)
    seeds[tuple((cells - low).T)] = True
    _, reached = walking.walk(unknown[window], seeds, reach)
    return float(reached - len(cells)) * CELL_M**2
