"""When a battery is too low: not by one word, and not to and fro."""

import pytest

from runtime.robot.battery import (
    LOW_S,
    RECOVERED_PERCENT,
    UNSURE_S,
    Battery,
    BatteryConfig,
    Charge,
)

LOW = BatteryConfig(low_percent=20.0)


def test_it_is_low_when_it_stays_so():
    battery = Battery(LOW)
    assert battery.runs_low(12.0, 0.0) == ""
    assert battery.runs_low(12.0, LOW_S - 0.1) == ""
    why = battery.runs_low(12.0, LOW_S)
    assert why == "battery: 12 % is left, battery.low_percent is 20"


def test_one_word_between_others_is_none():
    battery = Battery(LOW)
    for second in range(20):
        assert battery.runs_low(0.0 if second % 3 == 0 else 50.0, float(second)) == ""


def test_what_is_low_is_low_until_it_has_recovered():
    battery = Battery(LOW)
    battery.runs_low(19.0, 0.0)
    assert battery.runs_low(19.0, LOW_S)
    assert battery.runs_low(20.0 + RECOVERED_PERCENT - 1, LOW_S + 1)
    assert battery.refuses(20.0 + RECOVERED_PERCENT - 1)
    assert battery.runs_low(20.0 + RECOVERED_PERCENT, LOW_S + 2) == ""
    assert battery.refuses(20.0 + RECOVERED_PERCENT - 1) == ""


def test_a_search_is_refused_at_once():
    assert Battery(LOW).refuses(19.9)
    assert Battery(LOW).refuses(20.0) == ""


@pytest.mark.parametrize("battery", [Battery(LOW), Battery(BatteryConfig(low_percent=0.0))])
def test_what_nobody_knows_or_asks_for_is_not_low(battery: Battery):
    percent = None if battery.refuses(0.0) else 0.0
    for second in range(20):
        assert battery.runs_low(percent, float(second)) == ""
    assert battery.refuses(percent) == ""


def test_a_driver_that_begins_with_0_is_believed_when_it_stays_so_or_says_something_else():
    charge = Charge()
    assert charge.percent(0.0) is None
    charge.tell(0.0, 10.0)
    assert charge.percent(10.0 + UNSURE_S - 0.1) is None
    charge.tell(64.0, 11.0)
    assert charge.percent(11.0) == 64.0
    charge.tell(0.0, 12.0)  # it was read before: that is no beginning
    assert charge.percent(12.0) == 0.0


@pytest.mark.parametrize("told", [(), (0.0, 0.0), (None, 0.0)])
def test_a_battery_that_is_empty_is_known_to_be_however_it_is_told(told):
    charge = Charge()
    charge.tell(0.0, 10.0)
    for n, percent in enumerate(told, 1):
        charge.tell(percent, 10.0 + n)
    assert charge.percent(10.0 + UNSURE_S) == 0.0


def test_what_was_told_long_ago_is_not_told_any_more():
    charge = Charge()
    charge.tell(50.0, 10.0)
    assert charge.percent(40.0, worth_s=30.0) == 50.0
    assert charge.percent(40.1, worth_s=30.0) is None
