"""Who drives while the search does not."""

from runtime.loops.led import Led, led_by
from runtime.robot.base import BaseCondition

HELD = "not armed"


def test_a_hand_comes_before_what_holds_the_base_and_that_before_a_pause():
    assert led_by(BaseCondition(), "") is None
    paused = led_by(BaseCondition(), "rfnav/pause")
    assert paused == Led("paused", "rfnav/pause", "pause", "paused by rfnav/pause")
    assert led_by(BaseCondition(HELD), "rfnav/pause") == Led("held", HELD, "wait", f"base: {HELD}")
    hand = led_by(BaseCondition(HELD, "sticks"), "rfnav/pause")
    assert hand == Led("hand", "sticks", "hand", "a hand has the sticks: sticks")
