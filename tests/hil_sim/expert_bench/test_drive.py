"""Drives through a home of three rooms: what is asked about it, and what is true of the answers."""

import math
import pickle
import random
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from hil_sim.expert_bench.bank import CLEAN, BankHome, BankPlan, read_home, write_home
from hil_sim.expert_bench.drive import ORIGIN, Goals, Stop, frozen, misnamed, priced, stops, thinned
from hil_sim.expert_bench.make import home_file, make_bank, tell_again, write_maps
from hil_sim.expert_bench.seeing import BenchDetector
from hil_sim.ground_truth.truth import SceneTruth
from hil_sim.ground_truth.witness import to_scene
from hil_sim.scenes.format import Door, Room, Scene, SceneError, SceneObject, Wall
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.simulation.scene_physics import ScenePhysics
from runtime.core.objects.instances import Evidence
from runtime.core.types import Detections, Pose

pytestmark = pytest.mark.slow  # a home is driven through

PLAN = BankPlan(starts=1, steps=30, moments=2, goals=4)
ROOMS = ("bathroom", "bedroom")


def scene() -> Scene:
    """Rooms of 4 m x 4 m in a row, doors at alternate ends: beds in two, a toilet in the last."""
    corners = [(0.0, 0.0), (12.0, 0.0), (12.0, 4.0), (0.0, 4.0)]
    outer = tuple(
        Wall(a, b, 0.1, "outer") for a, b in zip(corners, corners[1:] + corners[:1], strict=True)
    )
    inner = tuple(Wall((x, 0.0), (x, 4.0), 0.1) for x in (4.0, 8.0))
    rooms = tuple(
        Room(f"r{x}", "bedroom", ((x, 0), (x + 4, 0), (x + 4, 4), (x, 4)), "#b58a5b", "#cc4444")
        for x in (0, 4, 8)
    )
    size = (0.5, 0.5, 0.5)
    things = (
        SceneObject("bed", "bed", "builtin:box", (0.5, 0.5, 0.0), 0.0, size),
        SceneObject("bed2", "bed", "builtin:box", (6.0, 2.0, 0.0), 0.0, size),
        SceneObject("toilet", "toilet", "builtin:box", (11.5, 3.5, 0.0), 0.0, size),
    )
    doors = (Door((4.0, 2.9), (4.0, 3.8), 2.0), Door((8.0, 0.2), (8.0, 1.1), 2.0))
    return Scene("three", (*outer, *inner), doors, rooms, things)


class Grey:
    """A detector that takes every view for the same bedroom."""

    rooms = ROOMS

    def detect(self, rgb: np.ndarray) -> Detections:
        none = np.zeros((0, 4), np.float32)
        nothing = np.zeros(0, np.float32)
        room, scene = np.array([0.2, 0.8], np.float32), np.array([1.0, 0.0], np.float32)
        return Detections(none, nothing, np.zeros(0, np.int32), none, room, scene)


@pytest.fixture(scope="module")
def detector() -> BenchDetector:
    return BenchDetector(Grey(), ("bed", "toilet"), BenchDetector.settings())


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[ScenePhysics, SceneTruth]]:
    cache = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(cache))
        assets = Assets(cache)
        with ScenePhysics(scene(), assets) as world:
            yield world, SceneTruth(world, assets)


def asked(
    home: tuple[ScenePhysics, SceneTruth], detector: BenchDetector, plan: BankPlan = PLAN
) -> tuple[BankHome, list[bytes]]:
    """What the command asks of a home, and the maps behind it."""
    world, truth = home
    goals, left_out = Goals.of(world.scene, truth, plan), Counter[str]()
    moments, kept = [], []
    for number in range(plan.starts):
        for stop in stops("three", number, world, truth.space, detector, plan):
            costs_m = priced(stop, goals, left_out)
            if costs_m:
                moments.append(frozen("three", stop, costs_m, plan, detector.config.navigate))
                kept.append(pickle.dumps(stop))
    return BankHome("three", tuple(moments), dict(left_out), "grey"), kept


@pytest.fixture(scope="module")
def driven(
    home: tuple[ScenePhysics, SceneTruth], detector: BenchDetector
) -> tuple[BankHome, list[bytes]]:
    return asked(home, detector)


@pytest.fixture(scope="module")
def made(driven: tuple[BankHome, list[bytes]]) -> BankHome:
    found, _ = driven
    assert found.moments
    assert found.moments[0].why == "first decision"
    return found


def test_a_goal_is_asked_about_while_it_is_not_on_the_map(made: BankHome) -> None:
    for moment in made.moments:
        told = {o.name for f in moment.briefs[CLEAN].frontiers for o in f.objects}
        assert not told & set(moment.costs_m)
    assert {goal for m in made.moments for goal in m.costs_m} <= {"toilet", "bed"}


def test_a_cost_is_no_less_than_the_way_to_the_frontier(made: BankHome) -> None:
    for moment in made.moments:
        told = {f.id: f.distance_m for f in moment.briefs[CLEAN].frontiers}
        assert set(told) <= set(moment.ids)
        assert len(moment.ids) == len(moment.goal_xy) >= 2
        assert sorted(told) == sorted(moment.order)
        for costs_m in moment.costs_m.values():
            assert max(costs_m) - min(costs_m) >= 0.5
            costs = zip(moment.ids, costs_m, strict=True)
            assert all(cost >= told.get(id, 0.0) for id, cost in costs)


def test_costs_agree_with_the_truth_at_the_frontiers(
    home: tuple[ScenePhysics, SceneTruth], detector: BenchDetector
) -> None:
    world, truth = home
    goals = Goals.of(world.scene, truth, PLAN)
    stop = next(stops("three", 0, world, truth.space, detector, PLAN))
    costs = priced(stop, goals, Counter())
    assert costs
    place = to_scene(stop.start, ORIGIN)
    for goal, costs_m in costs.items():
        for frontier, cost in zip(stop.reachable, costs_m, strict=True):
            onward_m = truth.distance_m(goal, Pose(*place(*frontier.goal_xy), 0.0))
            if math.isfinite(onward_m):
                assert cost == pytest.approx(frontier.distance_m + onward_m, abs=0.02)


def test_the_same_plan_asks_the_same(
    made: BankHome, home: tuple[ScenePhysics, SceneTruth], detector: BenchDetector, tmp_path: Path
) -> None:
    again, _ = asked(home, detector)
    write_home(tmp_path / "a", made)
    write_home(tmp_path / "b", again)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    other, _ = asked(home, detector, replace(PLAN, seed=1))
    assert other != made


def test_what_experts_are_told_can_be_composed_again(
    driven: tuple[BankHome, list[bytes]], tmp_path: Path
) -> None:
    home, kept = driven
    make_bank(tmp_path, [], PLAN, 1)
    blank = tuple(replace(m, order=(), why="") for m in home.moments)
    write_home(home_file(tmp_path, "three"), replace(home, moments=blank))
    write_maps(tmp_path, "three", kept)
    assert tell_again(tmp_path, PLAN) == 1
    assert read_home(home_file(tmp_path, "three")).moments == home.moments


def test_all_conditions_tell_of_the_same_frontiers(made: BankHome) -> None:
    for moment in made.moments:
        assert set(moment.briefs) == {CLEAN, "wrong labels", "missing objects"}
        clean = moment.briefs[CLEAN].frontiers
        for brief in moment.briefs.values():
            assert brief.goal == ""
            assert [(f.id, f.distance_m, f.rooms) for f in brief.frontiers] == [
                (f.id, f.distance_m, f.rooms) for f in clean
            ]


def test_objects_are_misnamed_and_left_out_as_often_as_said(
    home: tuple[ScenePhysics, SceneTruth], detector: BenchDetector
) -> None:
    world, truth = home
    stop: Stop = next(stops("three", 0, world, truth.space, detector, PLAN))
    (first, *_) = stop.known.semantic.instances.values()
    many = {n: replace(first, id=n, evidence={"bed": Evidence(2.0)}) for n in range(500)}
    semantic = replace(stop.known.semantic, instances=many)
    wrong = misnamed(semantic, 0.2, random.Random(1)).instances
    assert 70 < sum(i.name != "bed" for i in wrong.values()) < 130
    assert all(i.log_odds == 2.0 for i in wrong.values())
    assert 320 < len(thinned(semantic, 0.3, random.Random(1)).instances) < 380
    assert all(i.name == "bed" for i in many.values())  # the map itself is left as it is


def test_a_goal_that_is_seen_from_nowhere_is_not_asked_about() -> None:
    def success(goal: str) -> None:
        looked.append(goal)
        if goal == "toilet":
            raise SceneError("from nowhere")

    looked: list[str] = []
    goals = Goals(("toilet", "bed", "sofa", "sink"), 2, SimpleNamespace(success=success))
    assert goals.missing({"bed"}) == ["sofa", "sink"]
    assert goals.missing(set()) == ["sofa", "sink"]  # two at most: bed comes too late
    assert looked == ["toilet", "sofa", "sink", "sofa", "sink"]
