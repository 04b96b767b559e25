"""The way to the target: what is stopped at, and from how many sides it is looked at first."""

from dataclasses import replace

import numpy as np
import pytest
from apartment import MOUNT, TWO_ROOMS, Apartment
from open_floor import POSE, RADIUS_M, axes, floor

from runtime import navigate
from runtime.core import approach
from runtime.core.approach import approach_target, out_of_reach
from runtime.core.distances.planner import look_around
from runtime.core.local_policy import GIVE_UP_AFTER_S
from runtime.core.motion.courses import ControlConfig
from runtime.core.objects.gone import LOOKS
from runtime.core.objects.instances import Evidence, Instance
from runtime.core.objects.verdict import Reached, from_two_sides
from runtime.core.settings import NavigateConfig
from runtime.core.types import Action, Ballot, Pose
from runtime.core.world import World


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
    world.semantic.instances[1], world.looked_from = target, POSE
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
    world.looked_from, world.body.dt_s = behind, 1.0
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
