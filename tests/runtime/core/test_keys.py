"""What a key takes, and what is said of a value that it does not take."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.config import known_keys
from runtime.core.keys import ITEMS, LETTERS, Key


def a_key(unit: str = "", within: tuple[float, float] | None = None) -> Key:
    return Key("table.name", ("table", "name"), 1.0, "What it is.", unit, within)


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        (a_key("m", (0.1, 2.0)), 0.1, ""),
        (a_key("m", (0.1, 2.0)), 2.0, ""),
        (a_key("m", (0.1, 2.0)), 0.0, "is 0.0, must be 0.1 to 2 m"),
        (a_key("m", (0.1, 2.0)), 180, "is 180, must be 0.1 to 2 m; 180 mm are 0.18 m"),
        (a_key("m", (0.1, 2.0)), 1e9, "is 1000000000.0, must be 0.1 to 2 m"),
        (a_key("rad", (-1.6, 1.6)), -30.0,
         "is -30.0, must be -1.6 to 1.6 rad; -30 degrees are -0.524 rad"),
        (a_key("rad/s", (0.05, 6.0)), 57.3,
         "is 57.3, must be 0.05 to 6 rad/s; 57.3 degrees/s are 1 rad/s"),
        (a_key("s", (0.05, 2.0)), 300.0, "is 300.0, must be 0.05 to 2 s; 300 ms are 0.3 s"),
        (a_key("s", (0.05, 2.0)), math.nan, "is nan, must be 0.05 to 2 s"),
        (a_key("Hz", (5.0, 200.0)), 0.01, "is 0.01, must be 5 to 200 Hz"),
        (a_key("", (0.0, math.inf)), math.inf, ""),
        (a_key("m", (0.0, math.inf)), -1.0, "is -1.0, must be 0 m or more"),
        (a_key(), math.inf, "is inf, must be finite"),
        (a_key(), (("o2f", math.nan),), "is nan, must be finite"),
        (a_key(), True, ""),
        (a_key(), "a\nb", "has '\\n' in it, must be printable text"),
        (a_key(), ("fine", "a\0b"), "has '\\x00' in it, must be printable text"),
        (a_key(), "x" * (LETTERS + 1), f"has {LETTERS + 1} letters, must have at most {LETTERS}"),
        (a_key(), ("x",) * (ITEMS + 1), f"has {ITEMS + 1} items, must have at most {ITEMS}"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_value(key: Key, value: object, told: str):
    assert key.wrong(value) == told


@given(value=st.floats() | st.integers(), least=st.floats(-1e6, 1e6), span=st.floats(0, 1e6))
def test_nothing_outside_of_the_bounds_is_taken(value: float, least: float, span: float):
    wrong = a_key("m", (least, least + span)).wrong(value)
    assert (wrong == "") == (least <= value <= least + span)
    assert "\n" not in wrong


def test_every_number_of_the_configuration_has_bounds_that_hold_its_default():
    for key in known_keys().values():
        if isinstance(key.default, int | float) and not isinstance(key.default, bool):
            assert key.within is not None, key.name
        assert key.wrong(key.default) == "", key.name
