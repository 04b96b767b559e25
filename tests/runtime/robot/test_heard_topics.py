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


def test_what_has_no_topic_is_not_listened_to():
    heard = heard_topics(BusConfig(topics=TopicsConfig(scan="", stop="")))
    assert "scan" not in heard
    assert "stop" not in heard
    assert heard["teleop"].kinds == (wire.TWIST, wire.TWIST_STAMPED)
