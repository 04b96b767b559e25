"""Plain keys."""

import pytest

from runtime.robot import wire
from runtime.robot.dialects.dialect import Role, RosService, RosTopic
from runtime.robot.dialects.ros2dds import Ros2dds


@pytest.mark.parametrize(
    ("prefix", "key"), [("", "camera/odom"), ("/robot1/", "robot1/camera/odom")]
)
def test_a_topic_is_its_name(prefix: str, key: str):
    dialect, topic = Ros2dds(prefix), RosTopic("/camera/odom", wire.ODOMETRY)
    assert dialect.publishes_on(topic) == dialect.listens_on(topic) == key
    assert dialect.name_of(key, topic) == key
    assert dialect.serves_on(RosService("camera/odom", "a/srv/B")) == key


def test_nothing_goes_along():
    dialect = Ros2dds("")
    assert dialect.attachment(1, 2, bytes(16)) is None
    assert dialect.reply_attachment(b"rqh" + bytes(17), 2) is None
    assert dialect.node_tokens("z") == ()
    assert dialect.tokens("z", iter([1]), Role.PUBLISHER, RosTopic("a", wire.TWIST)) == ()
