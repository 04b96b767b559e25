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
        ('bus.topics.depth="d/image_raw/theora"', "bus.topics.depth: theora is not read; must be"),
        ('bus.topics.color="c/compressedDepth"', 'must be the raw image, or "c/compressed"'),
        ('bus.topics.color="c/ffmpeg"', 'must be the raw image, or "c/compressed"'),
        ('bus.compressed=["deth"]', 'bus.compressed: "deth" is none of "color" and "depth"'),
    ],
)
def test_a_name_that_is_none(setting: str, message: str):
    with pytest.raises(ConfigError) as caught:
        load(None, [setting])
    assert message in str(caught.value)


def test_what_a_robot_may_do_without_may_be_empty():
    assert load(None, ['bus.topics.pose=""', 'bus.topics.scan=""']).bus.topics.scan == ""
    assert load(None, ['bus.topics.cliff="cliff/*"']).bus.topics.cliff == "cliff/*"


@pytest.mark.parametrize(
    ("settings", "packed"),
    [
        ((), (False, False)),
        (("bus.topics.color=c/compressed", "bus.topics.depth=d/compressedDepth"), (True, True)),
        (("bus.topics.depth=d/compressed", "bus.topics.color=compressed"), (False, True)),
        (('bus.compressed=["depth"]',), (False, True)),
        (('bus.compressed=["depth", "color"]',), (True, True)),
    ],
)
def test_what_comes_packed_is_told_by_its_name_or_a_key(settings: tuple, packed: tuple):
    bus = load(None, settings).bus
    assert (bus.is_packed("color"), bus.is_packed("depth")) == packed
