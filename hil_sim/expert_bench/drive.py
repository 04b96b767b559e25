"""Drives through one home. At some moments the map so far becomes questions: one for each goal
that is not on it yet."""

import math
import random
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Self

import numpy as np

from hil_sim.driving.rig import camera_of, open_world
from hil_sim.expert_bench.bank import CLEAN, EQUAL_M, BankHome, BankPlan, Moment
from hil_sim.expert_bench.seeing import BenchDetector
from hil_sim.ground_truth.episodes import HM3D_GOALS, ROBOTHOR_GOALS
from hil_sim.ground_truth.goals import categories_of
from hil_sim.ground_truth.labels import LABELLED
from hil_sim.ground_truth.witness import to_scene
from hil_sim.scenes.format import Scene, SceneError
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.camera import Frame
from hil_sim.simulation.protocol import HM3D
from hil_sim.simulation.robot import Robot, act
from runtime import navigate
from runtime.core.objects.instances import Evidence
from runtime.core.objects.semantic_map import SemanticMap
from runtime.core.types import (
    Action,
    Ballot,
    Brief,
    Decision,
    Detections,
    Frontier,
    Observation,
    Pose,
)
from runtime.core.world import World
from runtime.navigate import NavigateConfig

if TYPE_CHECKING:  # PyBullet prints when it is imported: see open_world
    from hil_sim.ground_truth.freespace import FreeSpace
    from hil_sim.ground_truth.truth import SceneTruth
    from hil_sim.simulation.scene_physics import ScenePhysics

NOTHING = "nothing"
"""What a drive looks for: every goal is asked about, none is driven to."""
ASTRAY_M = 0.5
"""A frontier this far from true free space still counts as lying in it."""
ORIGIN = Pose(0.0, 0.0, 0.0)
Watch = Callable[[Observation, Detections, Pose, Frame], None]


@dataclass(frozen=True)
class Stop:
    """A moment at which the runtime would decide. `start` is where the map's origin truly is."""

    drive: int
    known: World
    why: str
    start: Pose

    @property
    def reachable(self) -> tuple[Frontier, ...]:
        """Sorted by id."""
        found = (f for f in self.known.frontiers if math.isfinite(f.distance_m))
        return tuple(sorted(found, key=lambda f: f.id))

    def told(self, cfg: NavigateConfig) -> Brief:
        """What the experts would be told."""
        return navigate.snapshot(self.known, self.why, cfg).brief


def drive_home(
    name: str, plan: BankPlan, keep: Callable[[Stop], None] = lambda stop: None
) -> BankHome:
    """All questions of one home, and `keep` hears of the maps behind them; SceneError when the
    home cannot be opened."""
    scene, assets, left_out = open_scene(name), Assets(), Counter[str]()
    with open_world(scene, assets, "auto") as world:
        from hil_sim.ground_truth.truth import SceneTruth

        detector, truth = BenchDetector.open(), SceneTruth(world, assets)
        goals = Goals.of(scene, truth, plan)
        moments = []
        for number in range(plan.starts):
            for stop in stops(name, number, world, truth.space, detector, plan):
                costs_m = priced(stop, goals, left_out)
                if costs_m:
                    moments.append(frozen(name, stop, costs_m, plan, detector.config.navigate))
                    keep(stop)
        detector.models.close()
        return BankHome(name, tuple(moments), dict(sorted(left_out.items())), detector.identity())


@dataclass
class Goals:
    """Which goals a home is asked about: those that were not on the map when they were first
    thought of, the benchmarks' before others, in an order drawn by the seed."""

    order: tuple[str, ...]
    most: int
    truth: "SceneTruth"
    taken: set[str] = field(default_factory=set)
    unseen: set[str] = field(default_factory=set)  # from nowhere

    @classmethod
    def of(cls, scene: Scene, truth: "SceneTruth", plan: BankPlan) -> Self:
        rng = random.Random(f"questions/{plan.seed}/goals/{scene.name}")
        here = {obj.category for obj in scene.objects} & set(LABELLED)
        known = {c for goal in (*HM3D_GOALS, *ROBOTHOR_GOALS) for c in categories_of(goal)}
        first, others = sorted(here & known), sorted(here - known)
        rng.shuffle(first)
        rng.shuffle(others)
        return cls((*first, *others), plan.goals, truth)

    def missing(self, mapped: set[str]) -> list[str]:
        """The home's goals that a map with these names lacks. Where a goal is seen from is looked
        for only now: that is slow."""
        found = []
        for goal in self.order:
            if mapped & set(categories_of(goal)) or goal in self.unseen:
                continue
            if goal not in self.taken and len(self.taken) == self.most:
                continue
            try:
                self.truth.success(goal)
            except SceneError:
                self.unseen.add(goal)
                continue
            self.taken.add(goal)
            found.append(goal)
        return found


def stops(
    home: str,
    number: int,
    world: "ScenePhysics",
    space: "FreeSpace",
    detector: BenchDetector,
    plan: BankPlan,
    watch: Watch = lambda obs, seen, at, frame: None,
) -> Iterator[Stop]:
    """One drive: to the closest frontier or to a random one, as the seed has it. Yields where
    there is a choice, some steps apart. `watch` sees every frame, and where it was truly taken."""
    rng = random.Random(f"questions/{plan.seed}/{home}/{number}")
    start, cfg = start_in(space, rng), detector.config.navigate
    robot, camera, known, asked, last = Robot(start), camera_of(HM3D), None, 0, -plan.apart
    for step in range(plan.steps):
        at = robot.pose
        frame = world.render(at.x_m, at.y_m, at.yaw_rad, camera)
        stamp_ns, odometry = round((step + 1) * HM3D.observe_s * 1e9), robot.odometry(start)
        depth_m = HM3D.sensed(frame.depth_m)
        obs = Observation(stamp_ns, frame.rgb, depth_m, odometry, HM3D.intrinsics)
        if known is None:
            known = World.begin(NOTHING, detector.names, detector.models.rooms, odometry,
                                cfg.robot.radius_m)  # fmt: skip
        seen = detector.see(world.scene, at, frame)
        watch(obs, seen, at, frame)
        navigate.perceive(known, obs, seen, detector.config.camera, cfg)
        why = navigate.due(known, cfg)
        if why:
            choice = sum(math.isfinite(f.distance_m) for f in known.frontiers) >= 2
            if choice and step - last >= plan.apart and asked < plan.moments:
                asked, last = asked + 1, step
                yield Stop(number, known, why, start)
            _decide(known, why, rng, plan.wander, detector)
        command = navigate.steer(known, navigate.act(known, cfg), cfg)
        if command.action is Action.STOP or asked == plan.moments:
            return
        robot = act(robot, command.action, world, HM3D)


def start_in(space: "FreeSpace", rng: random.Random) -> Pose:
    """A free place, facing one of twelve ways."""
    cells = np.argwhere(space.free)
    row, col = cells[rng.randrange(len(cells))]
    x, y = space.points(np.array([[row, col]]))[0]
    return Pose(float(x), float(y), rng.randrange(-180, 180, 30) * math.pi / 180)


def _decide(
    known: World, why: str, rng: random.Random, wander: float, detector: BenchDetector
) -> None:
    """Adopt the closest frontier or a random one; one that is driven to is kept while it lasts."""
    near = sorted((f.distance_m, f.id) for f in known.frontiers if math.isfinite(f.distance_m))
    ids = [id for _, id in near]
    before = known.standing.decision
    standing = before.frontier if before else None
    closest = ids[0] if ids else None
    if standing not in ids:
        standing = rng.choice(ids) if ids and rng.random() < wander else closest
    made = Decision(standing, "drawn", (), closest, Ballot(), known.stamp_ns, why)
    navigate.adopt(known, made)


def frozen(
    home: str,
    stop: Stop,
    costs_m: Mapping[str, tuple[float, ...]],
    plan: BankPlan,
    cfg: NavigateConfig,
) -> Moment:
    """What the experts would be told, with the map as it is and with its objects perturbed."""
    known = stop.known
    snap = navigate.snapshot(known, stop.why, cfg)
    rng = random.Random(f"questions/{plan.seed}/perturbed/{home}/{stop.drive}/{known.body.step}")
    maps = {
        "wrong labels": misnamed(known.semantic, plan.wrong, rng),
        "missing objects": thinned(known.semantic, plan.missing, rng),
    }
    briefs = {CLEAN: replace(snap.brief, goal="")}
    for name, semantic in maps.items():
        told = navigate.snapshot(replace(known, semantic=semantic), stop.why, cfg).brief
        briefs[name] = replace(told, goal="")
    places = {f.id: f.goal_xy for f in stop.reachable}
    ids, goal_xy, step = tuple(places), tuple(places.values()), known.body.step
    return Moment(home, stop.drive, step, stop.why, briefs, snap.brief.order, ids, goal_xy, costs_m)


def misnamed(semantic: SemanticMap, share: float, rng: random.Random) -> SemanticMap:
    """Some objects go by another's name."""
    changed = {}
    for id, instance in sorted(semantic.instances.items()):
        wrong, name = rng.random() < share, rng.choice(LABELLED)
        changed[id] = (
            replace(instance, evidence={name: Evidence(instance.log_odds)}) if wrong else instance
        )
    return replace(semantic, instances=changed)


def thinned(semantic: SemanticMap, share: float, rng: random.Random) -> SemanticMap:
    """Some objects were never seen."""
    kept = {i: o for i, o in sorted(semantic.instances.items()) if rng.random() >= share}
    return replace(semantic, instances=kept)


def priced(stop: Stop, goals: Goals, left_out: Counter[str]) -> Mapping[str, tuple[float, ...]]:
    """By goal, cost(f) of the reachable frontiers, sorted by id: metres on the map to the frontier,
    and on from there by the true free space. Goals that make no question are counted."""
    reachable = stop.reachable
    in_scene, truth = to_scene(stop.start, ORIGIN), goals.truth
    places = [_free_near(truth.space, in_scene(*f.goal_xy)) for f in reachable]
    mapped = {instance.name for instance in stop.known.semantic.instances.values()}
    found = {}
    for goal in goals.missing(mapped):
        onward_m = truth.field(goal)
        costs_m = tuple(
            round(f.distance_m + gap_m + float(onward_m[cell]), 3)
            for f, (cell, gap_m) in zip(reachable, places, strict=True)
        )
        if not all(math.isfinite(cost) for cost in costs_m):
            left_out["cut off"] += 1
        elif max(costs_m) - min(costs_m) < EQUAL_M:
            left_out["all the same"] += 1
        else:
            found[goal] = costs_m
    return found


def _free_near(space: "FreeSpace", xy: tuple[float, float]) -> tuple[tuple[int, int], float]:
    """The free cell under a point, else the nearest within reach, and how far that is; inf when
    there is none."""
    cell = space.cell(*xy)
    if cell is not None and space.free[cell]:
        return cell, 0.0
    near = space.nearest_free(*xy, ASTRAY_M)
    cell = space.cell(*near) if near is not None else None
    return (
        (cell, math.dist(near, xy)) if near is not None and cell is not None else ((0, 0), math.inf)
    )
