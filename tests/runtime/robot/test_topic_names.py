"""Names on the bus are looked at before anything is opened by them."""

import pytest

from runtime.config import load
from runtime.errors import ConfigError


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ('bus.topics.color=""', 'bus.topics.color: is "", must be one topic, e.g. "camera/color'),
        ('bus.topics.odom="/"', 'bus.topics.odom: is "/", must be one topic, e.g. "odom"'),
        ('bus.topics.odom="odom/*"', 'bus.topics.odom: is "odom/*", must be one topic'),
        ('bus.topics.depth="a//b"', 'bus.topics.depth: "a//b" is no name on the bus'),
        ('bus.topics.pose="a?b"', 'bus.topics.pose: "a?b" is no name on the bus; must be like'),
        ('bus.prefix="a#"', 'bus.topics.color: "a#/camera/color/image_raw" is no name on the bus'),
        ('bus.topics.odom="cmd_vel"', "bus.topics.cmd_vel: cmd_vel is bus.topics.odom too"),
    ],
)
def test_a_name_that_is_none(setting: str, message: str):
    with pytest.raises(ConfigError) as caught:
        load(None, [setting])
    assert message in str(caught.value)


def test_what_a_robot_may_do_without_may_be_empty():
    assert load(None, ['bus.topics.pose=""', 'bus.topics.scan=""']).bus.topics.scan == ""
    assert load(None, ['bus.topics.cliff="cliff/*"']).bus.topics.cliff == "cliff/*"
