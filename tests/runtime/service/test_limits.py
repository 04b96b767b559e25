"""What a goal may take at most."""

import math

import pytest

from runtime.core.types import SearchState
from runtime.errors import ConfigError
from runtime.service.limits import NO_LIMITS, GoalLimits
from runtime.service.outcomes import FailCause


def test_limits_are_read_and_told_as_far_as_there_are_any():
    assert GoalLimits.read({}) == NO_LIMITS
    limits = GoalLimits.read({"time_s": 60, "distance_m": 2.5, "money_usd": 0})
    assert limits == GoalLimits(60.0, 2.5, 0.0)
    assert limits.told() == {"time_s": 60.0, "distance_m": 2.5, "money_usd": 0.0}
    assert NO_LIMITS.told() == {}


@pytest.mark.parametrize(
    ("value", "told"),
    [
        (None, "limits: must be an object"),
        ([], "limits: must be an object"),
        ({"time": 3}, "limits: unknown; did you mean time_s?"),
        ({"time_s": "3"}, "time_s: must be a number from 0.001 to 86400"),
        ({"time_s": True}, "time_s: must be a number"),
        ({"time_s": 0}, "time_s: must be a number"),
        ({"time_s": 1e9}, "time_s: must be a number"),
        ({"distance_m": math.nan}, "distance_m: must be a number"),
        ({"money_usd": -0.1}, "money_usd: must be a number from 0 to 1e+06"),
        ({"money_usd": None}, "money_usd: must be a number"),
    ],
)
def test_what_is_no_limit_is_refused(value: object, told: str):
    with pytest.raises(ConfigError) as caught:
        GoalLimits.read(value)
    assert told in str(caught.value)


def test_what_comes_first_ends_a_search():
    limits = GoalLimits(time_s=60.0, distance_m=5.0)
    assert limits.passed(59.9, 4.9) is None
    timed = limits.passed(60.0, 4.9)
    assert timed is not None
    assert (timed.state, timed.cause) == (SearchState.TIMED_OUT, None)
    driven = limits.passed(59.9, 5.0)
    assert driven is not None
    assert (driven.state, driven.cause) == (SearchState.FAILED, FailCause.DISTANCE)
    assert NO_LIMITS.passed(1e9, 1e9) is None
