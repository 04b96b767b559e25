"""When a battery is too low: not by one word, and not to and fro."""

import pytest

from runtime.robot.battery import LOW_S, RECOVERED_PERCENT, Battery, BatteryConfig

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
