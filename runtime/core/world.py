"""`World`: all state of one search. One thread owns it; what leaves it is an immutable snapshot."""

import math
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import NamedTuple

import cv2
import numpy as np

from runtime.core.distances.kept_plan import KeptPlan
from runtime.core.distances.passages import Passages
from runtime.core.distances.planner import Field, descend
from runtime.core.distances.terrain import Terrain, TerrainSurvey
from runtime.core.geometry import Standoff, standoff
from runtime.core.kernels import walking
from runtime.core.mapping.frontiers import Boundary, FrontierMemory
from runtime.core.mapping.grid import NavigationMap
from runtime.core.mapping.keyframes import Keyframe
from runtime.core.mapping.patches import Closer
from runtime.core.mapping.windows import padded, widened
from runtime.core.motion.courses import STILL, Along, Course
from runtime.core.objects.instances import Instance
from runtime.core.objects.semantic_map import SemanticMap
from runtime.core.resorts import Resort
from runtime.core.types import (
    F64,
    Action,
    Brief,
    Decision,
    Frontier,
    Hint,
    Intrinsics,
    Mask,
    Mount,
    Observation,
    Pose,
    SearchState,
    Twist,
)

STEP_M = 0.01  # of the way that is kept: a robot that stands leaves none
CREEPING = "at a creep: the camera could not see the floor here"
MOST_SIDE_M = 120.0  # of a grid: all that is kept by cell is some 260 MB then
FIRST_LOOKS = 12  # turns of the look around at the start: a whole one, where a turn is 30 degrees


@dataclass(frozen=True)
class Snapshot:
    """What a decision is made on."""

    brief: Brief
    frontiers: tuple[Frontier, ...]
    stamp_ns: int
    why: str  # the event that made the decision due


class Mode(StrEnum):
    """What a step is for."""

    LOOK = "look"
    FRONTIER = "frontier"
    TARGET = "target"
    FACE = "face"
    CLOSER = "closer"  # what was not seen finely enough for the goal
    RETURN = "return"
    PLACE = "place"
    LEAVE = "leave"  # a zone that is kept out of
    STOP = "stop"


@dataclass(frozen=True)
class Command:
    """One step of the base, and what it is for. A base of whole steps is told the action. One of
    velocities follows the course: the twist is what it was sent, the action the twist's likeness.
    """

    action: Action
    mode: Mode
    toward_xy: tuple[float, float] | None
    reason: str
    path_xy: F64 = field(default_factory=lambda: np.zeros((0, 2)))  # (N, 2) m, from the robot
    course: Course | None = None
    twist: Twist | None = None
    ended: SearchState | None = None  # of a STOP: what came of it


class AimKind(StrEnum):
    """What the robot may be after."""

    NONE = "none"
    FRONTIER = "frontier"
    TARGET = "target"
    SIDE = "side"  # of a target: to see it from another side
    FACE = "face"  # a target, turning on the spot
    START = "start"  # where the search began
    PLACE = "place"  # that the goal names
    NEAR = "near"  # what the goal was said to be near
    OUT = "out"  # of a zone that is kept out of
    WAY = "way"  # that was open before
    CLOSER = "closer"  # a patch of a surface


class Aim(NamedTuple):
    """What the robot is after: a frontier or an object, by its id."""

    kind: AimKind
    id: int


NO_AIM = Aim(AimKind.NONE, 0)


@dataclass
class Progress:
    """Guards against standing still: how close the robot came to one aim."""

    best_m: float = math.inf  # ever
    run_m: float = math.inf  # since it last turned to this aim
    idle: float = 0.0  # effort since then without coming closer: steps, or seconds of velocities
    returns: int = 0  # how often it turned to this aim again without having come closer than ever
    plan: tuple[Action, ...] = ()  # through a tight place, what is left of it


@dataclass
class Explored:
    """What exploring has come to."""

    given_up: Mask  # (R, C) frontier cells that were looked at in vain
    looked: Mask  # (R, C) cells seen from near
    memory: FrontierMemory = field(default_factory=FrontierMemory)
    boundary: Boundary = field(default_factory=Boundary)
    looks_left: int = 0  # turns of the first look around
    resort: Resort = Resort.NONE
    only_room: str = ""  # the type of room that is searched; "" for all
    passages: Passages = field(default_factory=Passages)
    hint: Hint = field(default_factory=Hint)
    closer: Closer = field(default_factory=Closer)


@dataclass
class StandingDecision:
    """The decision that stands, and when it was adopted."""

    decision: Decision | None = None
    step: int = -10_000
    elapsed_s: float = 0.0
    evidence: tuple[object, ...] = ()  # what it knew


@dataclass
class BaseState:
    """What the base was told, and what became of it."""

    step: int = 0
    last: Command | None = None
    elapsed_s: float = 0.0  # by the observations' stamps; gaps count as a second at most
    dt_s: float = 0.0  # of that, since the observation before
    held: bool = False  # ever since the observation before, and not by what is in the way
    free_s: float = 0.0  # of `elapsed_s`, in which it was not
    turned_rad: float = 0.0  # yaw since the start, counter-clockwise
    twist: Twist = STILL  # sent last
    asked_mps: float = 0.0  # forward speed asked of the base since the observation before
    blocked_s: float = 0.0  # velocities: how long the base has not moved although asked
    collisions: int = 0
    blind: bool = False  # the last observation had hardly any depth
    visited_xy: list[tuple[float, float]] = field(default_factory=list)

    def been(self, pose: Pose) -> None:
        """Book where it is; what moves by less than STEP_M is no way."""
        here = pose.x_m, pose.y_m
        if not self.visited_xy or math.dist(self.visited_xy[-1], here) >= STEP_M:
            self.visited_xy.append(here)

    def told(self, command: Command) -> Command:
        """Book what the base was told until the next observation."""
        self.last, self.twist = command, command.twist or STILL
        self.asked_mps = self.twist.v_mps
        return command


@dataclass
class Pursuit:
    """What the robot is after, and how it gets on with each aim so far."""

    aim: Aim = NO_AIM
    progress: dict[Aim, Progress] = field(default_factory=dict)


@dataclass(frozen=True)
class NewestImage:
    """The image whose detections came last, and the instances that it calls what is sought."""

    obs: Observation
    mount: Mount
    called: frozenset[int]


@dataclass
class World:
    """All state of one search: what is known of the home, and what the robot does in it."""

    goal: str
    map: NavigationMap
    semantic: SemanticMap
    pose: Pose
    explored: Explored
    stamp_ns: int = 0
    lens: tuple[Intrinsics, Mount] | None = None  # of the last observation
    newest: NewestImage | None = None
    keyframes: list[Keyframe] = field(default_factory=list)
    seen: tuple[Terrain, Field] | None = None  # the planner's view; distance from the robot
    survey: TerrainSurvey = field(default_factory=TerrainSurvey, repr=False)  # behind that view
    plan: KeptPlan = field(default_factory=KeptPlan, repr=False)  # to the aim
    frontiers: tuple[Frontier, ...] = ()
    standing: StandingDecision = field(default_factory=StandingDecision)
    body: BaseState = field(default_factory=BaseState)
    pursuit: Pursuit = field(default_factory=Pursuit)
    sought: set[int] = field(default_factory=set)  # believed to be the goal, with a way there
    held_up: dict[int, list[Pose]] = field(default_factory=dict)
    """Believed to be the goal, and the way there was lost; from where it was come no nearer to."""
    halted: dict[int, Pose] = field(default_factory=dict)
    """Come no nearer to, but near enough to be judged from there."""
    doubted: dict[int, tuple[float, Pose]] = field(default_factory=dict)
    """Looked at from near and not believed to be the goal: what spoke for it then, log-odds, and
    from where it was looked at from nearest."""

    @classmethod
    def begin(
        cls,
        goal: str,
        names: tuple[str, ...],
        room_names: tuple[str, ...],
        pose: Pose,
        radius_m: float,
        looks: int | None = None,
    ) -> "World":
        """Of which nothing is known but that the robot stands in it. `looks`: the first turns."""
        grid = NavigationMap.around(pose, radius_m)
        semantic = SemanticMap.empty(names, room_names, grid.frame)
        given_up, looked = np.zeros(grid.frame.shape, bool), np.zeros(grid.frame.shape, bool)
        looks_left = FIRST_LOOKS if looks is None else looks
        return cls(goal, grid, semantic, pose, Explored(given_up, looked, looks_left=looks_left))

    @classmethod
    def begin_from(cls, before: "World", goal: str, names: tuple[str, ...]) -> "World":
        """A world for a new goal that has another's map, objects and track, of the same odometry
        frame: nothing is given up or decided yet, and there is no first look around."""
        known = before.explored
        given_up, looked = np.zeros_like(known.given_up), np.zeros_like(known.looked)
        return cls(
            goal,
            before.map,
            replace(before.semantic, names=names),
            before.pose,
            Explored(given_up, looked, known.memory, closer=known.closer.afresh()),
            before.stamp_ns,
            keyframes=before.keyframes,
            body=BaseState(visited_xy=before.body.visited_xy),
        )

    @property
    def terrain(self) -> Terrain:
        """The planner's view of the map; there is one after the first observation."""
        assert self.seen is not None
        return self.seen[0]

    @property
    def reach(self) -> Field:
        """Geodesic distance from the robot; there is one after the first observation."""
        assert self.seen is not None
        return self.seen[1]

    def standoff(self, thing: Instance) -> Standoff:
        """How far away a thing is in the image, by its height."""
        return standoff(*self.lens, thing.low_m, thing.high_m) if self.lens else Standoff()

    def may_reach(self, pose: Pose, margin_m: float) -> bool:
        """Whether the grid could be grown so that a pose keeps `margin_m` to each side."""
        f = self.map.frame
        width_m, height_m = f.cols * f.resolution_m, f.rows * f.resolution_m
        return all(
            at + margin_m - low <= MOST_SIDE_M and low + side - at + margin_m <= MOST_SIDE_M
            for at, low, side in ((pose.x_m, f.x0_m, width_m), (pose.y_m, f.y0_m, height_m))
        )

    def grow(self, margin_m: float, xy: F64 | None = None) -> None:
        """Keep the grid larger than what the camera can see from here, or about another point."""
        padding = self.map.grow(self.pose.xy if xy is None else xy, margin_m)
        if padding:
            self.semantic.grow(padding)
            explored = self.explored
            explored.given_up = padded(explored.given_up, padding)
            explored.looked = padded(explored.looked, padding)

    def give_up(self, cells_xy: F64, near_m: float = math.inf) -> None:
        """Never ask for these frontier cells again (those within `near_m` of the robot)."""
        gap = np.hypot(cells_xy[:, 0] - self.pose.x_m, cells_xy[:, 1] - self.pose.y_m)
        cells = self.map.frame.cells(cells_xy[gap <= near_m])
        if not len(cells):
            return
        (top, left), (bottom, right) = cells.min(axis=0).tolist(), cells.max(axis=0).tolist()
        held = slice(top, bottom + 1), slice(left, right + 1)
        window = widened(held, 2, self.map.frame)
        mask = np.zeros(self.explored.given_up[window].shape, np.uint8)
        mask[cells[:, 0] - window[0].start, cells[:, 1] - window[1].start] = 1
        self.explored.given_up[window] |= cv2.dilate(mask, np.ones((5, 5), np.uint8)).view(bool)
        self.map.touched(window)

    def frontier(self, id: int | None) -> Frontier | None:
        """The frontier of that id, if it is there."""
        return next((f for f in self.frontiers if f.id == id), None)


def with_distances(world: World, cells_by_id: dict[int, F64], snap_m: float = 0.3) -> None:
    """Turn identified cells into frontiers: goal point and walking distance from the robot."""
    if not cells_by_id:
        world.frontiers = ()
        return
    reach, frame = world.reach, world.reach.frame
    every = frame.cells(np.concatenate(list(cells_by_id.values())))
    ends = np.cumsum([len(cells) for cells in cells_by_id.values()], dtype=np.int32)
    # The body may not fit onto any of a frontier's cells: it stands close by. What lies before the
    # first cell of the map is none.
    snap, first = round(snap_m / frame.resolution_m), (-frame.first_row, -frame.first_col)
    places, away = walking.nearest(reach.arrival_m, every, ends, snap, first)
    goals, distances_m = frame.centres(places).tolist(), away.tolist()
    world.frontiers = tuple(
        Frontier(id, cells_xy, (x, y), distance_m)
        for (id, cells_xy), (x, y), distance_m in zip(
            cells_by_id.items(), goals, distances_m, strict=True
        )
    )


def toward(field: Field, pose: Pose, command: Command) -> Command:
    """The command with the path that the field leads along; it says so where that begins over floor
    that was never in view."""
    path_xy, course = descend(field, (pose.x_m, pose.y_m)), command.course
    if isinstance(course, Along) and course.footing and course.footing.begins_blind(path_xy):
        command = replace(command, reason=f"{command.reason}, {CREEPING}")
    return replace(command, path_xy=path_xy)
