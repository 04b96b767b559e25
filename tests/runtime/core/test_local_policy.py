"""What differs between a base of whole steps and one of velocities."""

import pytest

from runtime.core.local_policy import as_sent
from runtime.core.motion.courses import STILL, Spin
from runtime.core.types import Action, Twist
from runtime.core.world import Command, Mode

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
