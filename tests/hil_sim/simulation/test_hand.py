"""What a hand on the sticks does with a robot."""

from dataclasses import replace

from hil_sim.simulation.faults import parse_faults
from hil_sim.simulation.hand import SPEAKS_S, TURNS_S, Sticks, by_hand
from hil_sim.simulation.robot import Robot
from runtime.core.types import Pose, Twist

HERE = Robot(Pose(0.0, 0.0, 0.0))


def test_it_turns_away_then_drives_ahead_and_round_what_it_touches():
    assert by_hand(HERE, 0.0, 0.3).v_mps == 0.0
    assert by_hand(HERE, 0.0, 0.3).w_radps > 0
    assert by_hand(HERE, TURNS_S, 0.3) == Twist(0.3, 0.0)
    touching = replace(HERE, touched_xy=(0.2, 0.0))
    assert by_hand(touching, TURNS_S, 0.3).v_mps == 0.0


def test_sticks_are_taken_and_let_go():
    (hand,), sticks = parse_faults(["hand:size=0.3"]), Sticks()
    assert sticks.twist(hand, HERE, 5.0) == by_hand(HERE, 0.0, 0.3)
    assert sticks.twist(hand, HERE, 5.0 + TURNS_S) == Twist(0.3, 0.0)
    assert sticks.twist(None, HERE, 8.0) is None
    assert sticks.twist(hand, HERE, 9.0) == by_hand(HERE, 0.0, 0.3)


def test_sticks_speak_every_so_often():
    sticks = Sticks()
    assert sticks.speak(5.0)
    assert not sticks.speak(5.0 + SPEAKS_S / 2)
    assert sticks.speak(5.0 + 1.5 * SPEAKS_S)
