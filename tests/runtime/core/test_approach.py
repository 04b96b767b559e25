"""The way to the target: what is stopped at, and from how many sides it is looked at first."""

from dataclasses import replace

import numpy as np
import pytest
from apartment import MOUNT, TWO_ROOMS, Apartment, looked_from
from open_floor import POSE, RADIUS_M, axes, floor

from runtime import navigate
from runtime.core import approach, progress
from runtime.core.approach import TRIES, approach_target, out_of_reach, settle_for
from runtime.core.distances.planner import look_around
from runtime.core.geometry import wrap_angle
from runtime.core.local_policy import GIVE_UP_AFTER_S
from runtime.core.mapping.fineness import GoalSize
from runtime.core.motion.courses import ControlConfig
from runtime.core.motion.discrete_policy import FORWARD_M, TURN_RAD
from runtime.core.objects.gone import LOOKS
from runtime.core.objects.instances import Evidence, Instance
from runtime.core.objects.verdict import INSPECT_LOG_ODDS, UNSEEN_LOOKS, Reached, from_two_sides
from runtime.core.resorts import Resort
from runtime.core.settings import NavigateConfig
from runtime.core.types import Action, Ballot, Pose, SearchState
from runtime.core.world import Mode, World


def before_a_table() -> tuple[World, Instance]:
    """The robot stands before a table, whose cells were taken for a part of the sofa behind it; and
    the table."""
    grid = floor()
    x, y = axes(grid)
    table, sofa = ((x > low) & (x < low + 0.4) & (np.abs(y) < 0.4) for low in (0.6, 1.7))
    grid.evidence[table | sofa] = 10
    grid.changed()
    before, behind = (np.stack([x[at], y[at]], 1) for at in (table, sofa))
    world = World.begin("sofa", ("sofa", "coffee table"), (), POSE, RADIUS_M, 0)
    world.map, world.seen = grid, look_around(grid, POSE, RADIUS_M)
    both = np.concatenate([before, behind])
    views = [POSE, Pose(1.9, -2.0, 1.5)]
    believed = {"sofa": Evidence(4.0, backing=views, near_m=1.0)}
    target = Instance(1, believed, (1.9, 0.0), 0.4, both, 0.0, 0.8, views=[POSE])
    world.semantic.instances[1], world.newest = target, looked_from(POSE, 1)
    return world, Instance(2, {"coffee table": Evidence(4.0)}, (0.8, 0.0), 0.3, before, 0.0, 0.45)


def test_the_table_before_a_sofa_is_not_stopped_at_for_the_sofa():
    world, table = before_a_table()
    alone = approach_target(world, NavigateConfig())
    assert alone is not None
    assert alone.mode == "stop"  # it believes to be there
    world.semantic.instances[2] = table
    command = approach_target(world, NavigateConfig())
    assert command is not None
    assert command.mode == "target"


@pytest.mark.parametrize("behind", [None, Pose(POSE.x_m - 1.0, POSE.y_m, POSE.yaw_rad)])
def test_a_detector_that_is_behind_is_waited_for_before_the_verdict_but_not_for_ever(behind):
    world, _ = before_a_table()
    cfg = replace(NavigateConfig(), control=ControlConfig(mode="velocity"))
    world.newest, world.body.dt_s = looked_from(behind, 1) if behind else None, 1.0
    waits = 0
    while (command := approach_target(world, cfg)) and command.mode == "face":
        waits += 1
        assert command.reason.startswith("look at sofa")
    assert command is not None
    assert command.mode == "stop"
    assert waits == pytest.approx(GIVE_UP_AFTER_S, abs=1)
    world, _ = before_a_table()
    found = approach_target(world, cfg)
    assert found is not None
    assert found.mode == "stop"


def test_what_is_hidden_where_it_is_faced_is_gone_to_where_it_may_be_seen(
    monkeypatch: pytest.MonkeyPatch,
):
    world, _ = before_a_table()
    world.newest = looked_from(POSE)
    sofa, why = world.semantic.instances[1], "approach sofa 1 (p 0.98) from where it may be seen"
    monkeypatch.setattr(progress, "hidden", lambda *_: True)
    at: list[Pose] = []
    while (command := approach_target(world, NavigateConfig())) and command.mode is not Mode.STOP:
        assert command.mode is Mode.FACE or command.reason == why
        at.append(world.pose)
        turn = {Action.TURN_LEFT: 1, Action.TURN_RIGHT: -1}.get(command.action, 0)
        yaw_rad, step_m = world.pose.yaw_rad, 0.0 if turn else FORWARD_M
        x_m, y_m = world.pose.xy + step_m * np.array([np.cos(yaw_rad), np.sin(yaw_rad)])
        world.pose = Pose(float(x_m), float(y_m), wrap_angle(yaw_rad + turn * TURN_RAD))
        world.newest, world.body.last = looked_from(world.pose), command
        world.seen = look_around(world.map, world.pose, RADIUS_M)
        assert len(at) < 60
    assert command is not None
    assert command.ended is SearchState.FOUND  # none of the places showed it
    assert sofa.unseen[0] == POSE
    assert len(sofa.unseen) == UNSEEN_LOOKS
    assert len({(pose.x_m, pose.y_m) for pose in at}) > 2


def test_what_is_come_no_nearer_to_is_judged_from_there_if_that_is_near_enough(
    monkeypatch: pytest.MonkeyPatch,
):
    there, asked = approach._toward, []

    def toward(world: World, candidate: approach._Candidate, cfg: NavigateConfig):
        asked.append(candidate)
        return there(world, candidate, cfg) if world.halted else (Reached.HELD_UP, None)

    monkeypatch.setattr(approach, "_toward", toward)
    world, _ = before_a_table()
    found = approach_target(world, NavigateConfig())
    assert found is not None
    assert found.ended is SearchState.FOUND
    assert (len(asked), world.halted) == (2, {1: POSE})
    away = Pose(-1.5, 0.0, 0.0)
    world, _ = before_a_table()
    world.pose, world.seen = away, look_around(world.map, away, RADIUS_M)
    assert approach_target(world, NavigateConfig()) is None
    assert not world.halted
    assert list(world.held_up) == [1]


def test_what_is_judged_from_where_it_was_come_no_nearer_to_is_looked_at_from_nowhere_else(
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.setattr(progress, "hidden", lambda *_: True)
    world, _ = before_a_table()
    sofa = world.semantic.instances[1]
    world.newest, world.halted = looked_from(POSE), {1: POSE}
    found = approach_target(world, NavigateConfig())
    assert found is not None
    assert found.ended is SearchState.FOUND
    assert not sofa.unseen
    world, _ = before_a_table()
    world.halted, sofa = {1: POSE}, world.semantic.instances[1]
    sofa.evidence["sofa"] = Evidence(1.0, backing=[POSE], near_m=1.0)
    sofa.looks.extend([POSE, POSE])
    assert approach_target(world, NavigateConfig()) is None  # rejected, and with it the place
    assert not world.halted


def test_an_image_from_elsewhere_does_not_tell_that_it_is_hidden_from_here():
    world, _ = before_a_table()
    world.newest = looked_from(Pose(-1.0, 0.0, 0.0))
    looking = approach_target(world, NavigateConfig())
    assert looking is not None
    assert looking.reason.startswith("look at sofa")


def test_what_is_believed_and_cannot_be_stood_before_is_out_of_reach():
    world, table = before_a_table()
    sofa = replace(
        world.semantic.instances[1], xy=(2.3, 0.0), cells_xy=table.cells_xy + np.array([1.5, 0.0])
    )
    world.semantic.instances = {1: sofa}
    x, _ = axes(world.map)
    world.map.evidence[(x > 0.4) & (x < 0.6)] = 10  # a wall, through which it was seen
    world.map.changed()
    world.seen = look_around(world.map, POSE, RADIUS_M)
    assert approach_target(world, NavigateConfig()) is None
    assert out_of_reach(world) is sofa
    sofa.seen_through = LOOKS
    assert out_of_reach(world) is None
    sofa.seen_through = 0
    sofa.evidence["sofa"].backing.clear()  # nothing of this search speaks for it
    assert out_of_reach(world) is None


def test_what_was_given_up_on_the_way_is_out_of_reach_until_it_was_stood_before(
    monkeypatch: pytest.MonkeyPatch,
):
    world, _ = before_a_table()
    sofa = world.semantic.instances[1]
    reached = Reached.HELD_UP
    monkeypatch.setattr(approach, "_toward", lambda *_: (reached, None))
    for odds in (4.0, 1.0):  # the second time, seen anew, it would not be believed
        sofa.evidence["sofa"] = Evidence(odds, backing=[POSE, Pose(1.9, -2.0, 1.5)], near_m=1.0)
        sofa.looks.extend([POSE, POSE])
        assert approach_target(world, NavigateConfig()) is None
        assert sofa.confidence_of("sofa") < 0.5  # given up
        assert out_of_reach(world) is sofa
    reached = Reached.FACED
    sofa.evidence["sofa"] = Evidence(1.0, backing=[POSE], near_m=1.0)
    sofa.looks.extend([POSE, POSE])
    assert approach_target(world, NavigateConfig()) is None
    assert out_of_reach(world) is None


CFG = NavigateConfig()
ROUND, STRAIGHT = (1.9, 2.8), (-0.3, 0.3)  # in y, the ways through a wall


def before_a_wall(*ways: tuple[float, float]) -> tuple[World, Instance]:
    """The robot stands before a wall, and surely saw a vase behind the way that leads straight on,
    between two cupboards; the other way leads to behind it. And the vase."""
    world = World.begin("vase", ("vase",), (), POSE, RADIUS_M, 0)
    grid = world.map = floor()
    x, y = axes(grid)
    vase = (np.abs(x - 2.2) < 0.1) & (np.abs(y) < 0.1)
    cells = np.stack([x[vase], y[vase]], 1)
    seen = {"vase": Evidence(2.3, backing=[POSE, Pose(0.5, 0.1, 0.0)], near_m=1.6)}
    thing = Instance(1, seen, (2.2, 0.0), 0.4, cells, 0.0, 0.8, views=[POSE])
    world.semantic.instances[1], world.newest = thing, looked_from(POSE, 1)
    open_to(world, *ways)
    return world, thing


def open_to(world: World, *ways: tuple[float, float]) -> None:
    """The wall is seen to have these, and no other."""
    grid = world.map
    x, y = axes(grid)
    open_at = np.zeros(x.shape, bool)
    for low, high in ways:
        open_at |= (y > low) & (y < high)
    wall = (x > 0.5) & (x < 0.6) & ~open_at
    cupboards = (x > 0.5) & (x < 2.1) & (np.abs(y) > 0.3) & (np.abs(y) < 1.7)
    vase = (np.abs(x - 2.2) < 0.1) & (np.abs(y) < 0.1)
    grid.evidence[(np.abs(x) < 3.0) & (np.abs(y) < 3.0)] = -10
    grid.evidence[wall | cupboards | vase] = 10
    grid.changed()
    world.seen = look_around(grid, world.pose, RADIUS_M)


def test_what_the_way_was_lost_to_is_gone_to_from_another_side():
    world, _ = before_a_wall(STRAIGHT, ROUND)
    straight = approach_target(world, CFG)
    assert straight is not None
    assert straight.path_xy[-1, 0] < 2.2
    open_to(world, ROUND)
    assert approach_target(world, CFG) is None
    round_it = approach_target(world, CFG)
    assert round_it is not None
    assert round_it.reason == "inspect vase 1 (p 0.91)"
    assert round_it.path_xy[-1, 0] > 2.2


def test_what_was_never_to_be_had_from_where_it_was_seen_is_not_gone_to_from_behind():
    world, vase = before_a_wall(ROUND)
    for least in (None, -3.0):
        assert approach_target(world, CFG, least) is None
    assert out_of_reach(world) is vase


def test_a_sure_sighting_that_the_way_was_lost_to_is_told_however_often_it_was_missed_since():
    world, vase = before_a_wall(STRAIGHT)
    approach_target(world, CFG)
    open_to(world)
    approach_target(world, CFG)
    vase.evidence["vase"].odds = -5.0
    told = navigate._nothing_left(world)
    assert told.ended is SearchState.UNREACHABLE
    assert told.reason == "vase 1 was seen at (2.2, 0.0), and no way leads there"
    vase.seen_through = LOOKS
    assert navigate._nothing_left(world).ended is SearchState.NOT_FOUND


def test_what_the_way_was_lost_to_is_tried_again_at_last_so_often(monkeypatch: pytest.MonkeyPatch):
    world, vase = before_a_wall(STRAIGHT)
    approach_target(world, CFG)
    open_to(world)
    approach_target(world, CFG)
    vase.evidence["vase"].odds = -5.0
    assert approach_target(world, CFG, -3.0) is None
    open_to(world, STRAIGHT)
    assert approach_target(world, CFG) is None  # there is more to do than to look at that
    again = approach_target(world, CFG, -3.0)
    assert again is not None
    assert again.reason == "inspect vase 1 (p 0.01)"
    monkeypatch.setattr(approach, "_toward", lambda *_: (Reached.HELD_UP, None))
    for ways, tries in (((STRAIGHT,), 1), ((STRAIGHT, ROUND), TRIES)):  # not twice from one side
        open_to(world, *ways)
        assert approach_target(world, CFG, -3.0) is None
        assert len(world.held_up[1]) == tries
    assert out_of_reach(world) is vase


def test_what_was_doubted_on_an_open_way_is_not_told_as_out_of_reach():
    world, vase = before_a_wall(STRAIGHT)
    approach_target(world, CFG)
    vase.evidence["vase"].odds = -0.5
    assert approach_target(world, CFG) is None
    open_to(world)
    assert approach_target(world, CFG, -3.0) is None
    assert navigate._nothing_left(world).ended is SearchState.NOT_FOUND


def test_what_a_surer_thing_in_its_place_outdoes_is_gone_to_at_the_very_last():
    world, _ = before_a_table()
    sofa = world.semantic.instances[1]
    bed = replace(sofa, id=2, evidence={"bed": Evidence(7.0)})
    world.semantic.instances[2] = bed
    assert approach_target(world, NavigateConfig()) is None
    world.explored.resort = Resort.AFAR
    assert approach_target(world, NavigateConfig(), -1.0) is None
    assert out_of_reach(world) is sofa
    world.explored.resort = Resort.FAINT
    command = approach_target(world, NavigateConfig(), -3.0)
    assert command is not None
    assert command.ended is SearchState.FOUND


def test_what_was_likest_is_settled_for_where_it_was_looked_at_from_nearest():
    world, _ = before_a_table()
    sofa, nearer = world.semantic.instances[1], Pose(POSE.x_m + 0.1, POSE.y_m, POSE.yaw_rad)
    sofa.looks += [Pose(-0.2, 0.1, 0.0), nearer]
    sofa.evidence["sofa"] = Evidence(INSPECT_LOG_ODDS + 0.05, backing=[POSE], near_m=1.0)
    assert approach_target(world, NavigateConfig()) is None  # not believed after a second look
    assert world.doubted == {1: (INSPECT_LOG_ODDS + 0.05, nearer)}
    world.doubted[2] = 9.0, POSE  # joined to another since
    world.pose = Pose(-0.6, 0.8, 0.0)
    world.seen = look_around(world.map, world.pose, RADIUS_M)
    back = settle_for(world, NavigateConfig())
    assert back is not None
    assert (back.mode, back.ended) == ("target", None)
    world.pose, world.newest = nearer, looked_from(nearer, 1)
    world.seen = look_around(world.map, world.pose, RADIUS_M)
    there = settle_for(world, NavigateConfig())
    assert there is not None
    assert there.ended is SearchState.FOUND
    assert there.reason == "found sofa 1 (p 0.70), the likest of all that was seen"


def test_what_was_stood_before_and_faded_at_the_next_look_may_be_settled_for():
    """It is never rejected: it is no candidate any more."""
    world, _ = before_a_table()
    sofa = world.semantic.instances[1]
    sofa.evidence["sofa"] = Evidence(2.0, backing=[POSE], near_m=1.0)
    world.newest = None
    looking = approach_target(world, NavigateConfig())
    assert looking is not None
    assert looking.mode is Mode.FACE
    sofa.evidence["sofa"].odds = -1.0
    assert approach_target(world, NavigateConfig()) is None
    world.newest = looked_from(POSE, 1)
    there = settle_for(world, NavigateConfig())
    assert there is not None
    assert "(p 0.88)" in there.reason


def test_a_search_without_anything_left_settles_for_what_was_likest(
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.setattr(navigate, "look_again", lambda *_, **__: None)  # no way was closed
    world, _ = before_a_table()
    world.explored.resort = Resort.FAINT
    world.semantic.instances[1].evidence["sofa"] = Evidence(-9.0)
    assert navigate._finish(world, CFG).ended is SearchState.NOT_FOUND
    world.doubted[1] = 1.0, POSE
    assert navigate._finish(world, CFG).ended is SearchState.FOUND


def test_what_was_taken_for_a_part_of_a_small_goal_is_not_stood_before():
    world, _ = before_a_table()
    assert approach._stands(world, world.semantic.instances[1])[world.terrain.frame.cell(*POSE.xy)]
    world.explored.closer.wanted = GoalSize(reaches_m=0.3)  # the table before it is no part of it
    stands = approach._stands(world, world.semantic.instances[1])
    assert not stands[world.terrain.frame.cell(*POSE.xy)]


def test_nothing_is_settled_for_that_little_spoke_for_or_that_is_gone():
    world, _ = before_a_table()
    sofa = world.semantic.instances[1]
    sofa.looks += [POSE, POSE]
    sofa.evidence["sofa"] = Evidence(INSPECT_LOG_ODDS - 0.05, backing=[POSE], near_m=1.0)
    assert approach_target(world, NavigateConfig(), 0.0) is None
    assert settle_for(world, NavigateConfig()) is None
    world.doubted[1] = 1.0, POSE
    sofa.seen_through = LOOKS
    assert settle_for(world, NavigateConfig()) is None


class Silent:
    def ask(self, brief: object, by: None) -> Ballot:
        return Ballot()


def drive(score: float, steps: int = 200) -> tuple[World, list[navigate.Command]]:
    """The robot begins right before a thing that is reported with a constant score while it is in
    view, though never from any other side than the one it is in."""
    home, cfg = Apartment.of(TWO_ROOMS, Pose(6.4, 2.2, 0.0)), navigate.NavigateConfig()
    home.things = {"toilet": (7.4, 2.2, 0.3)}
    world, commands = None, []
    for _ in range(steps):
        obs = home.observe()
        if world is None:
            world = World.begin("toilet", ("toilet",), (), obs.pose, 0.18)
        navigate.perceive(world, obs, home.detect(("toilet",), obs, score), MOUNT, cfg)
        why = navigate.due(world, cfg)
        if why:
            snap = navigate.snapshot(world, why, cfg)
            navigate.adopt(world, navigate.decide(snap, Silent(), None, cfg))
        commands.append(navigate.steer(world, navigate.act(world, cfg), cfg))
        if commands[-1].action is Action.STOP:
            break
        home.apply(commands[-1].action)
    assert world is not None
    return world, commands


def test_a_target_it_begins_before_is_looked_at_from_another_side_first():
    world, commands = drive(0.8)
    assert commands[-1].reason.startswith("found toilet")
    assert any("from another side" in c.reason for c in commands)
    (toilet,) = (i for i in world.semantic.instances.values() if i.log_odds > 1)
    assert from_two_sides(toilet, "toilet")
