"""What a hand on the sticks does with a robot."""

from dataclasses import replace

from hil_sim.simulation.hand import TURNS_S, by_hand
from hil_sim.simulation.robot import Robot
from runtime.core.types import Pose, Twist

HERE = Robot(Pose(0.0, 0.0, 0.0))


def test_it_turns_away_then_drives_ahead_and_round_what_it_touches():
    assert by_hand(HERE, 0.0, 0.3).v_mps == 0.0
    assert by_hand(HERE, 0.0, 0.3).w_radps > 0
    assert by_hand(HERE, TURNS_S, 0.3) == Twist(0.3, 0.0)
    touching = replace(HERE, touched_xy=(0.2, 0.0))
    assert by_hand(touching, TURNS_S, 0.3).v_mps == 0.0
