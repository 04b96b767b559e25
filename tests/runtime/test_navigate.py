"""The whole loop over a flat-land apartment: perceive, decide, act until it stops."""

import math
from dataclasses import replace

import numpy as np
import pytest
from apartment import MOUNT, TWO_ROOMS, Apartment

from runtime import navigate
from runtime.core.objects import standpoints
from runtime.core.progress import hidden_from_here
from runtime.core.types import Action, Ballot, Brief, Decision, Pose, Vote
from runtime.core.voting.brief import OBJECT_RANGE_M, compose, walking_distances
from runtime.core.world import Command, World

NAMES = ("toilet", "sofa", "bed")
ROOMS = ("bathroom", "bedroom")
CFG = navigate.NavigateConfig()


class Silent:
    """A panel on which nobody votes."""

    def ask(self, brief: Brief, by: None) -> Ballot:
        return Ballot()


class Stubborn:
    """Two experts that always want the farthest frontier."""

    def ask(self, brief: Brief, by: None) -> Ballot:
        far = max(brief.frontiers, key=lambda f: f.distance_m).id
        return Ballot(tuple(Vote(name, (far,), ((far, 1.0),), "far") for name in ("a", "b")))


def search(
    home: Apartment, goal: str, panel=None, limit: int = 350, cfg=CFG
) -> tuple[World, list[Command], list[Decision]]:
    world, commands, decisions = None, [], []
    panel = panel or Silent()
    for _ in range(limit):
        obs = home.observe()
        if world is None:
            world = World.begin(goal, NAMES, ROOMS, obs.pose, 0.18)
        navigate.perceive(world, obs, home.detect(NAMES, obs), MOUNT, cfg)
        why = navigate.due(world, cfg)
        if why:
            decision = navigate.decide(navigate.snapshot(world, why, cfg), panel, None, cfg)
            navigate.adopt(world, decision)
            decisions.append(decision)
        commands.append(navigate.steer(world, navigate.act(world, cfg), cfg))
        if commands[-1].action is Action.STOP:
            break
        home.apply(commands[-1].action)
    assert world is not None
    return world, commands, decisions


def home(x: float = 1.0, y: float = 3.2, yaw: float = 0.0) -> Apartment:
    return Apartment.of(TWO_ROOMS, Pose(x, y, yaw))


@pytest.mark.parametrize("yaw", [0.0, 2.0])
def test_the_target_is_found_faced_and_stopped_at(yaw: float):
    there = home(yaw=yaw)
    there.things = {"toilet": (7.4, 2.2, 0.3)}
    world, commands, decisions = search(there, "toilet")
    assert [c.mode for c in commands[:12]] == ["look"] * 12
    assert commands[-1].mode == "stop"
    assert commands[-1].reason.startswith("found toilet")
    assert math.hypot(there.pose.x_m - 7.4, there.pose.y_m - 2.2) < 1.3
    ((x_m, y_m),) = [thing.xy for thing in world.semantic.called("toilet")]
    bearing = math.atan2(y_m - there.pose.y_m, x_m - there.pose.x_m)
    assert abs(math.remainder(bearing - there.pose.yaw_rad, math.tau)) < math.radians(16)
    assert there.collisions == 0
    assert all(d.rule == "ahead" for d in decisions)


@pytest.mark.slow
def test_without_the_target_everything_is_explored_and_it_says_so():
    there = home(8.0, 3.0)
    world, commands, _ = search(there, "toilet")
    assert commands[-1].action is Action.STOP
    assert commands[-1].reason == "no toilet found and nothing left to explore"
    assert min(x for x, _ in world.body.visited_xy) < 4.0  # through the door into the other room
    assert world.map.free.sum() * 0.0025 > 30.0


def test_a_vote_sends_the_robot_elsewhere_than_the_closest():
    _, near, _ = search(home(), "toilet", Silent(), limit=16)
    world, far, decisions = search(home(), "toilet", Stubborn(), limit=16)
    assert decisions[0].rule == "prior"
    assert decisions[0].frontier != decisions[0].closest
    assert far[12].toward_xy != near[12].toward_xy
    assert world.standing.decision is not None


@pytest.mark.slow
def test_the_same_run_twice_is_the_same():
    runs = [search(home(), "toilet", limit=40) for _ in range(2)]
    assert [(c.action, c.reason) for c in runs[0][1]] == [(c.action, c.reason) for c in runs[1][1]]
    assert (runs[0][0].map.evidence == runs[1][0].map.evidence).all()


def test_an_invisible_obstacle_does_not_trap_the_robot():
    there = home(2.0, 3.0)
    row, col = int(3.0 / 0.02), int(2.5 / 0.02)
    there.heights[row - 12 : row + 12, col : col + 4] = 0.05  # too low for the camera's floor test
    world, _, _ = search(there, "toilet", limit=60)
    x, y = world.body.visited_xy[-1]
    assert math.hypot(x - 2.0, y - 3.0) > 1.0
    assert there.collisions - world.body.collisions in (
        0,
        1,
    )  # the last step's is not perceived yet


def test_what_is_sought_and_near_and_not_in_the_newest_image_is_known_as_hidden():
    there = home(6.4, 2.2, 0.0)
    there.things = {"toilet": (7.4, 2.2, 0.3)}
    obs = there.observe()
    world = World.begin("toilet", NAMES, ROOMS, obs.pose, 0.18)
    navigate.perceive(world, obs, there.detect(NAMES, obs), MOUNT, CFG)
    (toilet,) = world.semantic.called("toilet")
    assert world.newest is not None
    assert world.newest.called == {toilet.id}
    assert not hidden_from_here(world, toilet)
    there.pose = Pose(6.4, 2.2, 1.5)
    obs = there.observe()
    navigate.perceive(world, obs, there.detect(NAMES, obs), MOUNT, CFG)
    assert not world.newest.called
    assert world.newest.obs is obs
    assert hidden_from_here(world, toilet)
    world.pose = Pose(6.4, 2.2, 0.0)  # it has turned back since
    assert not hidden_from_here(world, toilet)


def test_a_target_with_nowhere_to_stand_does_not_hide_the_next(monkeypatch: pytest.MonkeyPatch):
    there = home()
    there.things = {"toilet": (4.0, 2.2, 0.3)}
    world, commands, _ = search(there, "toilet", limit=13)
    (near,) = world.semantic.instances.values()
    assert commands[-1].toward_xy == near.xy
    far = replace(
        near,
        id=99,
        evidence={"toilet": replace(near.evidence["toilet"], odds=0.9)},
        xy=(2.4, 2.2),
        cells_xy=near.cells_xy - np.array([1.6, 0]),
    )
    world.semantic.instances[far.id] = far
    stands = standpoints.standpoints
    monkeypatch.setattr(standpoints, "standpoints", lambda *a: stands(*a) & (a[3] is not near))
    assert navigate.act(world, CFG).toward_xy == far.xy


@pytest.mark.slow
def test_a_single_false_sighting_is_inspected_and_rejected():
    there = home()
    there.things = {"toilet": (4.0, 2.2, 0.3)}
    seen = []

    def once(names, obs):
        found = Apartment.detect(there, names, obs)
        if len(found.scores) and not seen:
            seen.append(1)
            return found
        there_now, there.things = there.things, {}
        nothing = Apartment.detect(there, names, obs)
        there.things = there_now
        return nothing

    there.detect = once  # type: ignore[method-assign]
    _, commands, _ = search(there, "toilet", limit=90)
    assert seen
    assert not any(c.reason.startswith("found") for c in commands)
    assert any(c.reason.startswith("inspect") for c in commands)


def test_the_brief_tells_objects_by_walking_distance_not_through_walls():
    there = home(4.0, 3.0)
    there.things = {"bed": (7.2, 4.2, 0.3)}
    world, _, _ = search(there, "toilet", limit=40)
    told = compose("toilet", 0, world.map, world.semantic, world.frontiers, {})
    assert [f.id for f in told.frontiers] == sorted(f.id for f in told.frontiers)
    for frontier in told.frontiers:
        assert all(o.distance_m <= OBJECT_RANGE_M for o in frontier.objects)


def test_walking_distance_goes_around_walls():
    free = np.ones((21, 41), bool)
    free[:18, 20] = False
    seeds = np.zeros_like(free)
    seeds[2, 10] = True
    steps = walking_distances(free, seeds, 80)
    assert steps[2, 10] == 0
    assert steps[2, 0] == 10
    assert steps[2, 30] > 30  # down to the gap and up again
    assert np.isinf(walking_distances(free, seeds, 5)[2, 30])
