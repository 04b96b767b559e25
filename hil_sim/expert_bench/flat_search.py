"""Searches on the plan of a home: a disc that sees a fan of it, drives to frontiers by the shortest
way, and is done when the goal is in view. What a frontier is, how much is unknown behind it, how
far it is on foot and how one is elected is the runtime's own, on a coarser grid; there is no camera
and no base."""

import math
import random
from collections.abc import Callable
from dataclasses import dataclass, field

import cv2
import numpy as np

from hil_sim.expert_bench.flat_home import CELL_M, FlatHome
from hil_sim.simulation.protocol import HM3D
from runtime.core.distances.terrain import Terrain
from runtime.core.geometry import GridFrame
from runtime.core.kernels import mapping, marching, walking
from runtime.core.mapping.frontiers import WALL_GAP_CELLS, FrontierMemory, identify
from runtime.core.outlook import WORTH_M2
from runtime.core.types import F32, F64, I32, Decision, Frontier, Mask, Pose
from runtime.core.voting import prior
from runtime.core.voting.brief import UNKNOWN_DEPTH_M

LEAST_WAY_M = 2.0  # from a start to success
STEP_M = 0.5  # between two views
LOOKS = 6  # of the look around at the start
RANGE_M = 5.0
RAYS = 80
BODY_M = 0.17  # of clearance: no more than the truth asks for
MIN_CELLS = 4  # of a frontier: as narrow as the runtime's
SNAP_M = 0.3  # from a frontier to where the body fits
ARRIVED_M = 0.25
ENDS_CELLS = 2  # from where the body stands to true free space
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


@dataclass
class FlatSearch:
    """The state of one. Frames are the plan's cells, in metres. known (H, W): what was in view;
    seen (T,): things that were; arrival (H, W) m on foot from the robot."""

    home: FlatHome
    task: FlatTask
    at: Cell
    heading_rad: float
    known: Mask
    given_up: Mask
    seen: Mask
    frame: GridFrame
    memory: FrontierMemory = field(default_factory=FrontierMemory)
    path_m: float = 0.0
    arrival: F64 = field(default_factory=lambda: np.zeros((0, 0)))
    clear_m: F32 = field(default_factory=lambda: np.zeros((0, 0), np.float32))
    decision: Decision | None = None

    @classmethod
    def begin(cls, home: FlatHome, task: FlatTask) -> "FlatSearch":
        """Of which nothing is known yet."""
        known, given_up = np.zeros((2, *home.free.shape), bool)
        frame = GridFrame(0.0, 0.0, CELL_M, *home.free.shape)
        seen = np.zeros(len(home.things), bool)
        return cls(home, task, task.start, task.heading_rad, known, given_up, seen, frame)

    @property
    def free(self) -> Mask:
        """(H, W) known floor."""
        floor: Mask = self.known & ~self.home.solid
        return floor

    @property
    def pose(self) -> Pose:
        row, col = self.home.middle(self.at) * CELL_M
        return Pose(float(col), float(row), self.heading_rad)

    @property
    def terrain(self) -> Terrain:
        """What is known, as the planner sees it."""
        passable = self.free & (self.clear_m >= BODY_M)
        passable[self.at] = True
        return Terrain(self.frame, self.clear_m, passable, passable.astype(np.float32))


Decide = Callable[[FlatSearch, tuple[Frontier, ...], dict[int, float]], Decision]
"""A search, what it may go to, and the unknown area behind each -> which of them."""


def task_in(home: FlatHome, goal: str, seed: int) -> FlatTask | None:
    """A start from which the goal is not in view and some way off; None where there is none."""
    way, wanted = home.way_m(goal), np.array(home.wanted(goal))
    cells = np.argwhere(home.free & (way >= LEAST_WAY_M) & np.isfinite(way))
    rng = random.Random(f"flat/{home.name}/{goal}/{seed}")
    for _ in range(60 if len(cells) else 0):
        row, col = cells[rng.randrange(len(cells))].tolist()
        heading_rad = math.radians(30 * rng.randrange(12))
        if not home.in_view(home.middle((row, col)), heading_rad, wanted).any():
            return FlatTask(goal, (row, col), heading_rad, float(way[row, col]))
    return None


def drive(home: FlatHome, task: FlatTask, decide: Decide) -> FlatResult:
    """Until the goal is in view, or nothing is left to explore; whence the rest of the way is the
    shortest: how a thing is found that nothing hides any more is not what is compared here."""
    search, wanted, decisions = FlatSearch.begin(home, task), home.wanted(task.goal), 0
    for turn in range(LOOKS):
        _look(search, task.heading_rad + turn * math.tau / LOOKS)
    while decisions < MOST_VIEWS and not search.seen[wanted].any():
        frontiers, unknown_m2 = _frontiers(search)
        if not frontiers:
            break
        decisions += 1
        made = decide(search, frontiers, unknown_m2)
        search.decision = prior.remembering(made, search.decision, search.memory.cells_xy)
        _go(search, next(f for f in frontiers if f.id == search.decision.frontier))
    (row, col), n = search.at, ENDS_CELLS
    way = home.way_m(task.goal)[max(0, row - n) : row + n + 1, max(0, col - n) : col + n + 1]
    left_m = float(way.min())
    return FlatResult(math.isfinite(left_m), search.path_m + left_m, task.shortest_m, decisions)


def _go(search: FlatSearch, frontier: Frontier) -> None:
    """A step toward a frontier, and a look; on arrival a look at it, which has to show what is
    behind it, or it is given up."""
    goal = search.frame.cell(*frontier.goal_xy)
    back = marching.descend(search.arrival, goal, 10_000)
    near = np.flatnonzero(search.arrival[tuple(back.T)] <= STEP_M + 1e-9)
    row, col = back[near[0] if len(near) else -1].tolist()
    before, search.at = search.at, (row, col)
    driven_m = float(search.arrival[search.at])
    search.path_m += driven_m
    cells = search.frame.cells(frontier.cells_xy)
    arrived = frontier.distance_m - driven_m <= ARRIVED_M
    down, right = (cells.mean(axis=0) if arrived else search.at) - np.array(
        search.at if arrived else before
    )
    if down or right:
        search.heading_rad = math.atan2(down, right)
    known = int(np.count_nonzero(search.known))
    _look(search, search.heading_rad)
    if arrived and np.count_nonzero(search.known) - known < MIN_CELLS:
        mask = np.zeros(search.known.shape, np.uint8)
        mask[tuple(cells.T)] = 1
        search.given_up |= cv2.dilate(mask, np.ones((3, 3), np.uint8)).view(bool)


def _look(search: FlatSearch, heading_rad: float) -> None:
    """What a view shows: floor and what stands on it, and the ends of what hides."""
    home, here = search.home, search.home.middle(search.at)
    outline, ends = home.rays(here, heading_rad, HM3D.hfov_rad, RANGE_M, RAYS)
    patch = np.zeros(search.known.shape, np.uint8)
    cv2.fillPoly(patch, [np.round((outline - 0.5) * 16).astype(np.int32)], 1, shift=4)
    search.known |= patch.view(bool)
    search.known[ends[:, 0], ends[:, 1]] = True
    search.known[search.at] = True
    left = np.flatnonzero(~search.seen)
    search.seen[left[home.in_view(here, heading_rad, left)]] = True


def _frontiers(search: FlatSearch) -> tuple[tuple[Frontier, ...], dict[int, float]]:
    """Those that can be reached and have something behind them, and how much."""
    known, solid = search.known, search.home.solid
    occupied, unknown = known & solid, ~known
    bare = (~occupied).view(np.uint8)
    search.clear_m = cv2.distanceTransform(bare, cv2.DIST_L2, cv2.DIST_MASK_5) * CELL_M
    search.arrival = np.full(known.shape, np.inf)
    search.arrival[search.at] = 0.0
    marching.march(search.arrival, search.terrain.traversable, CELL_M)
    edge, whole = np.zeros(known.shape, bool), (0, known.shape[0], 0, known.shape[1])
    mapping.boundary(edge, search.free, unknown, occupied, search.given_up, WALL_GAP_CELLS, whole)
    parts = [cells for cells in mapping.components(edge, 0, 0) if len(cells) >= MIN_CELLS]
    named = identify(search.memory, [search.frame.centres(cells) for cells in parts], search.frame)
    found, unknown_m2 = [], {}
    for id, cells_xy in named.items():
        cells = search.frame.cells(cells_xy)
        snap = round(SNAP_M / CELL_M)
        ends = np.array([len(cells)], np.int32)
        place, away = walking.nearest(search.arrival, cells, ends, snap, (0, 0))
        if math.isfinite(away[0]):
            x, y = search.frame.centres(place)[0].tolist()
            found.append(Frontier(id, cells_xy, (x, y), float(away[0])))
            unknown_m2[id] = behind_m2(unknown, cells)
    worth = {id: area for id, area in unknown_m2.items() if area >= WORTH_M2} or unknown_m2
    return tuple(f for f in found if f.id in worth), worth


def behind_m2(unknown: Mask, cells: I32) -> float:
    """Unknown area that could be walked to from these cells, (N, 2)."""
    reach = math.ceil(UNKNOWN_DEPTH_M / CELL_M)
    low = np.maximum(cells.min(axis=0) - reach - 1, 0)
    high = np.minimum(cells.max(axis=0) + reach + 2, unknown.shape)
    seeds = np.zeros(high - low, bool)
    seeds[tuple((cells - low).T)] = True
    _, reached = walking.walk(unknown[low[0] : high[0], low[1] : high[1]], seeds, reach)
    return float(reached - len(cells)) * CELL_M**2
