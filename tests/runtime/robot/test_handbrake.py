"""A stop stays until a hand releases it."""

from runtime.robot.handbrake import Handbrake


def reason(brake: Handbrake) -> str:
    halt = brake.halt()
    return f"{halt.kind}: {halt.reason}" if halt else ""


def test_a_stop_stays_until_it_is_released():
    brake = Handbrake()
    assert reason(brake) == ""
    brake.stop("rfnav/stop")
    assert reason(brake) == "stop: stopped by rfnav/stop: ask rfnav/release to go on"
    assert brake.release() == ""
    assert reason(brake) == ""


def test_letting_go_of_a_button_releases_nothing_and_a_pressed_one_cannot_be_released():
    brake = Handbrake()
    brake.button("stop", True)
    assert brake.release() == "stop is still pressed"
    brake.button("stop", False)
    assert reason(brake).startswith("stop: stopped by stop")
    assert brake.release() == ""
    assert reason(brake) == ""


def test_a_cancel_holds_the_base_as_long_as_it_waits():
    brake = Handbrake()
    brake.cancel(True)
    brake.cancel(True)
    brake.cancel(False)
    assert reason(brake) == "cancel: a cancel waits to be answered"
    brake.cancel(False)
    assert reason(brake) == ""
