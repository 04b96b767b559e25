"""What the newest depth image leaves of a command."""

import math

from hypothesis import given
from hypothesis import strategies as st

from runtime.core.motion.caution import FREE, Caution
from runtime.core.motion.safety import HaltKind
from runtime.core.types import Twist

speeds = st.floats(-2.0, 2.0)
limits = st.floats(0.0, 2.0) | st.just(math.inf)


@given(speeds, speeds)
def test_where_nothing_limits_a_command_is_left_as_it_is(v, w):
    twist = Twist(v, w)
    assert FREE.allowed(twist) is twist


@given(speeds, speeds, limits, limits)
def test_a_command_is_never_faster_for_it_nor_turned_round(v, w, most_mps, most_radps):
    allowed = Caution(HaltKind.OBSTACLE, "", most_mps, most_radps).allowed(Twist(v, w))
    assert allowed.v_mps <= most_mps
    assert allowed.v_mps == v or 0 <= allowed.v_mps < v
    assert abs(allowed.w_radps) <= most_radps
    assert abs(allowed.w_radps) <= abs(w)
    assert allowed.w_radps * w >= 0


def test_what_stands_ahead_lets_the_base_turn_and_go_back():
    ahead = Caution(HaltKind.OBSTACLE, "a leg", most_mps=0.0)
    assert ahead.allowed(Twist(0.3, 0.5)) == Twist(0.0, 0.5)
    assert ahead.allowed(Twist(-0.1, 0.0)) == Twist(-0.1, 0.0)


def test_just_as_much_as_is_allowed_is_the_command_itself():
    twist = Twist(0.3, -0.5)
    assert Caution(None, "", 0.3, 0.5).allowed(twist) is twist
    assert Caution(None, "", 0.2, 0.5).allowed(twist) == Twist(0.2, -0.5)
    assert Caution(None, "", 0.3, 0.4).allowed(twist) == Twist(0.3, -0.4)
    assert Caution(None, "", 0.3, 0.4).allowed(Twist(0.3, 0.5)) == Twist(0.3, 0.4)
