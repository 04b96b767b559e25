"""A door that is closed during a search, and opened again, or not."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from apartment import MOUNT, NO_DETECTIONS, Apartment

from runtime import navigate
from runtime.core.distances.passages import Passages, TriedWay
from runtime.core.progress import advance
from runtime.core.resorts import Resort
from runtime.core.trying_again import LOOKS, WATCH_S, WAYS, look_again
from runtime.core.types import Action, Ballot, Decision, Pose, SearchState
from runtime.core.world import Command, Mode, World

TWO_ROOMS = """
########################
#          #           #
#          #           #
#          #           #
#          #           #
#          #           #
#                      #
#                      #
#                      #
#                      #
#          #           #
#          #           #
#          #           #
#          #           #
########################
"""
DOORWAY = slice(62, 113), slice(142, 146)
STEP_NS = 500_000_000
CFG = navigate.NavigateConfig()
LOOKED = 12  # steps of the first look around, after which the door is closed


def searched(opened: int, most: int = 300) -> Iterator[tuple[World, Command]]:
    """Step by step; the door is opened with that one."""
    home = Apartment.of(TWO_ROOMS, Pose(1.2, 1.8, 0.0))
    home.things = {"toilet": (5.4, 0.6, 0.2)}
    world = World.begin("toilet", ("toilet",), (), home.pose, 0.18)
    for step in range(most):
        home.heights[DOORWAY] = 2.5 if LOOKED <= step < opened else 0.0
        obs = replace(home.observe(), stamp_ns=(step + 1) * STEP_NS)
        seen = home.detect(("toilet",), obs) if step > LOOKED else NO_DETECTIONS
        navigate.perceive(world, obs, seen, MOUNT, CFG)
        why = navigate.due(world, CFG)
        if why:
            near = sorted((f.distance_m, f.id) for f in world.frontiers if f.distance_m < 99)
            first = near[0][1] if near else None
            decided = Decision(first, "nearest", (), first, Ballot(), obs.stamp_ns, why)
            navigate.adopt(world, decided)
        command = navigate.steer(world, navigate.act(world, CFG), CFG)
        yield world, command
        if command.action is Action.STOP:
            return
        home.apply(command.action)


def test_what_is_missed_over_a_closed_way_that_is_watched_is_still_told():
    """Something low is put into the doorway when the robot has seen the toilet and sets out."""
    home = Apartment.of(TWO_ROOMS, Pose(1.2, 1.8, 0.0))
    home.things = {"toilet": (5.0, 1.8, 0.2)}
    world = World.begin("toilet", ("toilet",), (), home.pose, 0.18, 0)
    commands: list[Command] = []
    while len(commands) < 300 and (not commands or commands[-1].action is not Action.STOP):
        seen = home.detect(("toilet",), home.observe()) if not world.sought else NO_DETECTIONS
        home.heights[DOORWAY] = 0.3 if world.sought else 0.0
        obs = replace(home.observe(), stamp_ns=(len(commands) + 1) * STEP_NS)
        navigate.perceive(world, obs, seen, MOUNT, CFG)
        if why := navigate.due(world, CFG):
            decided = Decision(None, "nearest", (), None, Ballot(), obs.stamp_ns, why)
            navigate.adopt(world, decided)
        commands.append(navigate.steer(world, navigate.act(world, CFG), CFG))
        home.apply(commands[-1].action)
    (toilet,) = world.semantic.instances.values()
    assert any("is open again" in command.reason for command in commands)
    assert toilet.confidence_of("toilet") < 0.5
    assert commands[-1].ended is SearchState.UNREACHABLE
    assert commands[-1].reason.endswith("and no way leads there")


def until(words: str) -> World:
    """The world, when a step's reason has these words, behind a door that stays closed."""
    return next(world for world, command in searched(opened=999) if words in command.reason)


def test_it_is_found_after_the_door_has_been_opened():
    steps = list(searched(opened=50))
    commands = [command for _, command in steps]
    watched = [c for c in commands if c.reason.startswith("look whether the way at (3.0, 1.8)")]
    assert len(watched) > 10
    assert all(command.mode is Mode.FACE for command in watched)
    assert commands[-1].ended is SearchState.FOUND
    assert "could not be reached" not in commands[-1].reason


def test_what_is_beyond_a_door_that_stays_closed_is_named():
    steps = list(searched(opened=999))
    world, last = steps[-1]
    assert last.ended is SearchState.NOT_FOUND
    assert last.reason.endswith("; what is beyond (3.0, 1.8) could not be reached any more")
    (way,) = world.explored.passages.still_closed
    assert way.looks == LOOKS
    assert len(steps) < 200


def test_what_is_tried_at_last_comes_before_the_second_look():
    reasons = [command.reason for _, command in searched(opened=999)]
    first = reasons.index(Resort.RETRY.reason)
    looks = [n for n, reason in enumerate(reasons) if "is open again" in reason]
    assert looks[0] < first < reasons.index(Resort.FAINT.reason) < looks[-1]


def test_a_way_that_was_opened_has_all_that_it_leads_to_explored():
    world = until(Resort.FAINT.reason)
    assert world.explored.resort is Resort.FAINT
    world.map.evidence[world.map.evidence > 0] = 0  # all is open
    world.map.changed()
    navigate.with_frontiers(world, CFG)
    assert look_again(world, CFG) is None
    assert world.explored.resort is Resort.NONE


@pytest.mark.parametrize(("next_id", "asked"), [(WAYS, True), (WAYS + 1, False)])
def test_a_map_that_flickers_is_not_followed_for_ever(next_id: int, asked: bool):
    world = until("is open again")
    world.explored.passages.tried.clear()
    world.explored.passages.next_id = next_id
    assert (look_again(world, CFG) is not None) is asked


def test_a_way_that_comes_no_nearer_is_left_alone():
    world = until("is open again")
    world.pose = Pose(0.5, 0.5, 0.0)
    navigate.with_frontiers(world, CFG)
    (way,) = world.explored.passages.tried
    way.since_s = None
    said = []
    while not way.looks and len(said) < 99:
        said.append(look_again(world, CFG))
    assert said[-1] is None
    assert said[0] is not None
    assert said[0].mode is Mode.FRONTIER
    assert said[0].reason == "go and look whether the way at (3.0, 1.8) is open again"


def test_a_way_that_the_base_could_not_be_turned_to_was_not_looked_at():
    world = until("is open again")
    (way,) = world.explored.passages.tried
    cfg = replace(CFG, control=replace(CFG.control, mode="velocity"))
    for held, looks in ((True, 0), (False, 1)):
        world.body.held = held
        for _ in range(round(WATCH_S)):
            obs = Apartment.of(TWO_ROOMS, world.pose).observe()
            advance(world, replace(obs, stamp_ns=world.stamp_ns + 10**9), cfg)
            look_again(world, cfg)
        assert way.looks == looks


def test_a_way_that_is_open_by_now_is_not_told_as_closed():
    world, _ = list(searched(opened=50))[-1]
    (way,) = world.explored.passages.tried
    assert way.looks
    assert world.explored.passages.still_closed == []


def test_of_two_ways_the_less_looked_at_comes_first(monkeypatch: pytest.MonkeyPatch):
    world = until("is open again")
    passages = world.explored.passages
    (way,) = passages.closed(world.terrain, world.reach, world.map.zones.barred(world.map.frame))
    other = replace(way, xy=(9.0, 9.0))
    monkeypatch.setattr(Passages, "closed", lambda *_: [way, other])
    passages.tried = [TriedWay(1, way.xy, looks=1), TriedWay(2, other.xy)]
    for looks, at in ((1, "(9.0, 9.0)"), (0, "(3.0, 1.8)")):
        passages.tried[0].looks = looks
        command = look_again(world, CFG)
        assert command is not None
        assert at in command.reason
        for tried in passages.tried:
            tried.since_s = None


def test_only_what_was_looked_at_again_stays_closed():
    passages = Passages([TriedWay(1, (0.0, 0.0)), TriedWay(2, (1.0, 1.0), looks=1)])
    assert [way.id for way in passages.still_closed] == [2]
    assert np.isneginf(passages.tried[0].last_s)
