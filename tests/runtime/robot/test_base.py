"""An order, and when it is too late to send it."""

from runtime.core.types import Twist
from runtime.robot.base import DriveOrder


def test_an_order_is_late_when_its_time_is_over_and_says_by_how_much():
    order = DriveOrder(Twist(0.3, 0.0), 0, 10.0)
    assert order.late(9.9) == ""
    assert order.late(10.0) == ""
    assert order.late(10.25) == "the order came 0.25 s too late"
    assert not order.searching
