"""Which dialect a configuration has."""

from runtime.robot import wire
from runtime.robot.dialects.choice import spoken
from runtime.robot.dialects.dialect import RosTopic
from runtime.robot.session import BusConfig

TOPIC = RosTopic("odom", wire.ODOMETRY)


def test_the_bridge_is_the_default_and_the_other_is_chosen_with_domain_and_distribution():
    assert spoken(BusConfig(prefix="/r/")).publishes_on(TOPIC) == "r/odom"
    native = BusConfig(dialect="rmw_zenoh", distro="humble", domain=3, prefix="/r/")
    assert spoken(native).publishes_on(TOPIC) == (
        "3/r/odom/nav_msgs::msg::dds_::Odometry_/TypeHashNotSupported"
    )
    assert spoken(native, "guard").node_tokens("z") == ("@ros2_lv/3/z/0/0/NN/%/%r/guard",)
