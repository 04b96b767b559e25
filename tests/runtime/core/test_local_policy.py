"""What differs between a base of whole steps and one of velocities."""

import math
from dataclasses import replace

import pytest
from open_floor import POSE

from runtime.core.local_policy import as_sent, local_policy
from runtime.core.motion.courses import STILL, Spin
from runtime.core.settings import NavigateConfig
from runtime.core.types import Action, Pose, Twist
from runtime.core.world import Command, Mode, World

AHEAD = Command(Action.MOVE_FORWARD, Mode.FRONTIER, (1.0, 0.0), "", course=Spin(0.1))


@pytest.mark.parametrize(
    ("sent", "action"),
    [
        (Twist(0.2, 0.4), Action.MOVE_FORWARD),
        (Twist(0.0, 0.4), Action.TURN_LEFT),
        (Twist(0.0, -0.4), Action.TURN_RIGHT),
        (STILL, Action.MOVE_FORWARD),  # a base that is held is about to do what it cannot yet
    ],
)
def test_a_command_is_booked_as_it_was_sent(sent: Twist, action: Action) -> None:
    command = as_sent(AHEAD, sent)
    assert (command.twist, command.action) == (sent, action)
    assert command.course == AHEAD.course


def test_a_stop_stands_whatever_was_sent_last() -> None:
    stop = Command(Action.STOP, Mode.STOP, None, "found")
    assert as_sent(stop, Twist(0.3, 0.0)).twist == STILL
    assert as_sent(stop, Twist(0.3, 0.0)).action is Action.STOP


class Ahead:
    """A field of a place half a step away, that a step to +x leads nearer to and others do not."""

    def at(self, x_m: float, y_m: float) -> float:
        return 0.12 - 0.2 * x_m


def test_who_has_arrived_goes_on_being_there_while_it_turns_to_face_what_is_there() -> None:
    world = World.begin("sofa", ("sofa",), (), POSE, 0.18, 0)
    steps, facing = local_policy(NavigateConfig()), Command(Action.TURN_LEFT, Mode.FACE, None, "")
    assert not steps.arrived(world, Ahead())
    world.pose = Pose(0.0, 0.0, math.pi)
    assert steps.arrived(world, Ahead())
    world.pose, world.body.last = POSE, facing
    assert steps.arrived(world, Ahead())
    world.body.last = replace(facing, mode=Mode.TARGET)
    assert not steps.arrived(world, Ahead())
    world.pose, world.body.last = Pose(-0.2, 0.0, 0.0), facing  # it is farther than was thought
    assert not steps.arrived(world, Ahead())
