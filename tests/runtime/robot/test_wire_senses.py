"""What robots have beside a camera, as others' programs put it on the wire."""

import math
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from other_half import STORE, battery_state, flag, hazards, laser_scan

from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot import wire_senses as senses
from runtime.robot.wire_senses import Hazard, HazardKind

DECODERS = (
    senses.decode_scan,
    senses.decode_range,
    senses.decode_flag,
    senses.decode_hazards,
    senses.decode_battery,
    senses.check_sticks,
)


def test_a_scan_keeps_what_came_back_from_within_its_range():
    ranges = [0.05, 1.5, math.inf, math.nan, -1.0, 13.0, 12.0]
    told = senses.decode_scan(laser_scan(ranges, 7, first_rad=-1.0, step_rad=0.5), "scan")
    assert told.stamp_ns == 7
    assert told.value.ranges_m.tolist() == [0, 1.5, 0, 0, 0, 0, 12]
    assert (told.value.frame, told.value.first_rad, told.value.step_rad) == ("laser", -1.0, 0.5)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"ranges": []}, "with beams"),
        ({"step_rad": 0.0}, "unequal angles"),
        ({"first_rad": math.nan}, "finite"),
        ({"step_rad": 9.0}, "no scan of one turn"),
        ({"near_m": 3.0, "far_m": 2.0}, "no scan of one turn"),
    ],
)
def test_a_scan_that_is_none_is_told_in_a_line(changes: dict, words: str):
    given = {"ranges": [1.0, 2.0, 3.0], "stamp_ns": 1} | changes
    with pytest.raises(SensorError, match=words):
        senses.decode_scan(laser_scan(**given), "scan")


@pytest.mark.parametrize(("below_m", "told_m"), [(0.03, 0.03), (0.4, math.inf), (-math.inf, 0.0)])
def test_what_is_under_a_cliff_sensor(below_m: float, told_m: float):
    payload = senses.encode_range(below_m, 5, 0.4, "cliff_left")
    assert senses.decode_range(payload, "cliff/left").value == pytest.approx(told_m)


def test_a_range_of_later_distributions_ends_in_a_variance():
    payload = senses.encode_range(0.03, 5, 0.4, "front") + b"\0\0\x80\x3f"
    assert senses.decode_range(payload, "cliff/left").value == pytest.approx(0.03)


def test_a_range_that_is_not_a_number_is_refused():
    with pytest.raises(SensorError, match="cliff/left: range is not a number"):
        senses.decode_range(
            senses.encode_range(0.03, 5, 0.4, "f")[:-4] + b"\0\0\xc0\x7f", "cliff/left"
        )


def test_hazards_of_a_create():
    told = [("bump_front_left", 1), ("cliff_side_right", 2), ("base_link", 99)]
    found = senses.decode_hazards(hazards(told, 3), "hazard_detection")
    assert found.stamp_ns == 3
    assert found.value == (
        Hazard(HazardKind.BUMP, "bump_front_left"),
        Hazard(HazardKind.CLIFF, "cliff_side_right"),
    )
    assert senses.decode_hazards(hazards([], 3), "hazard_detection").value == ()


@pytest.mark.parametrize(
    ("share", "told"), [(0.42, 0.42), (42.0, 42.0), (0.0, 0.0), (math.nan, None)]
)
def test_a_battery_is_told_as_it_is_told(share: float, told: float | None):
    found = senses.decode_battery(battery_state(share, 9), "battery_state")
    assert found.stamp_ns == 9
    assert found.value == (None if told is None else pytest.approx(told))


def test_our_battery_is_read_by_others():
    message = STORE.deserialize_cdr(senses.encode_battery(12.5, 10**9), senses.BATTERY_STATE)
    assert message.percentage == pytest.approx(0.125)
    assert math.isnan(message.voltage)


@pytest.mark.parametrize("share", [-0.1, 101.0, math.inf])
def test_a_battery_of_impossible_percentage(share: float):
    with pytest.raises(SensorError, match="publish 0 to 1"):
        senses.decode_battery(battery_state(share, 9), "battery_state")


def test_sticks_may_be_stamped_or_not():
    assert senses.check_sticks(wire.encode_twist(0.1, 0.2), "t") == wire.TWIST
    assert senses.check_sticks(wire.encode_twist_stamped(0.1, 0.2, 5), "t") == wire.TWIST_STAMPED
    with pytest.raises(SensorError, match="not finite"):
        senses.check_sticks(wire.encode_twist(math.nan, 0.0), "t")


def test_a_flag():
    assert senses.decode_flag(flag(True), "bumper")
    assert not senses.decode_flag(flag(False), "bumper")


@given(st.binary(max_size=300), st.sampled_from(DECODERS))
def test_no_bytes_do_worse_than_a_sensor_error(payload: bytes, decode):
    for given_bytes in (payload, b"\0\1\0\0" + payload):
        with suppress(SensorError):
            decode(given_bytes, "topic")


@pytest.mark.parametrize(
    ("name", "degrees"),
    [("front_left", 20), ("cliff_front_right", -20), ("bump_left", 63), ("side_right", -63),
     ("bumper", 0), ("bump_front_center", 0), ("rear", 180), ("cliff_rear_left", 135)],
)  # fmt: skip
def test_where_a_sensor_is_by_its_name(name: str, degrees: float):
    assert np.degrees(senses.bearing_named(name)) == pytest.approx(degrees, abs=1)
