"""Types by topic."""

import pytest

from runtime.robot import wire
from runtime.robot.heard_topics import heard_topics
from runtime.robot.session import BusConfig, TopicsConfig


@pytest.mark.parametrize(
    ("topics", "stream", "kind"),
    [
        (TopicsConfig(), "color", wire.IMAGE),
        (TopicsConfig(color="image/compressed"), "color", wire.COMPRESSED_IMAGE),
        (TopicsConfig(), "odom", wire.ODOMETRY),
        (TopicsConfig(pose="slam"), "odom", wire.POSE_STAMPED),
    ],
)
def test_the_type_goes_by_how_the_topic_is_configured(topics: TopicsConfig, stream: str, kind: str):
    assert heard_topics(BusConfig(topics=topics))[stream].kind == kind


@pytest.mark.parametrize("stream", ["color", "depth"])
def test_what_is_compressed_without_its_name_saying_so_is_configured(stream: str):
    assert heard_topics(BusConfig(compressed=(stream,)))[stream].kind == wire.COMPRESSED_IMAGE


def test_what_has_no_topic_is_not_listened_to():
    heard = heard_topics(BusConfig(topics=TopicsConfig(scan="", stop="")))
    assert "scan" not in heard
    assert "stop" not in heard
    assert heard["teleop"].kinds == (wire.TWIST, wire.TWIST_STAMPED)
