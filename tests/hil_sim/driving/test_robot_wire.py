"""The robot's own way of putting it."""

import pytest

from hil_sim.driving.robot_wire import RobotWire
from runtime.robot.session import TopicsConfig


def test_behind_the_bridge_a_topic_is_its_key():
    wire = RobotWire()
    assert wire.key("odom") == wire.topic("odom") == "odom"
    assert wire.attachment() is None


@pytest.mark.parametrize("topic", ["odom", "cliff/front_left", "rfnav/state", TopicsConfig().color])
def test_natively_it_is_found_in_its_key_again(topic: str):
    wire = RobotWire("rmw_zenoh")
    domain, *_, kind, hashed = wire.key(topic).split("/")
    assert (domain, kind[-1], hashed[:7]) == ("0", "_", "RIHS01_")
    assert wire.topic(wire.key(topic)) == topic
    first, second = wire.attachment(), wire.attachment()
    assert first is not None
    assert second is not None
    assert (first[0], second[0], len(first)) == (1, 2, 33)
