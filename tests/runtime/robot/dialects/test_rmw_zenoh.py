"""Keys, attachments and tokens as rmw_zenoh_cpp makes them."""

import itertools

import pytest
from zenoh.ext import Int64, z_serialize

from runtime.errors import SensorError
from runtime.robot import wire, wire_senses
from runtime.robot.action_types import CANCEL
from runtime.robot.dialects.dialect import Qos, Role, RosService, RosTopic
from runtime.robot.dialects.rmw_zenoh import RmwZenoh

TWIST = "geometry_msgs::msg::dds_::Twist_"
HASH = "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"
CMD_VEL = RosTopic("cmd_vel", wire.TWIST)
JAZZY, HUMBLE = RmwZenoh("", 0, "jazzy"), RmwZenoh("robot1", 7, "humble")


def test_the_type_and_its_hash_are_in_the_key():
    assert JAZZY.publishes_on(CMD_VEL) == f"0/cmd_vel/{TWIST}/{HASH}"
    assert HUMBLE.publishes_on(CMD_VEL) == f"7/robot1/cmd_vel/{TWIST}/TypeHashNotSupported"
    cancel = RosService("fibonacci/_action/cancel_goal", CANCEL)
    assert HUMBLE.serves_on(cancel) == (
        "7/robot1/fibonacci/_action/cancel_goal/action_msgs::srv::dds_::CancelGoal_/"
        "TypeHashNotSupported"
    )


def test_whatever_comes_on_a_topic_is_heard():
    assert JAZZY.listens_on(CMD_VEL) == "0/cmd_vel/*/*"
    assert JAZZY.name_of(f"0/cmd_vel/{TWIST}/{HASH}", CMD_VEL) == "cmd_vel"
    cliffs = RosTopic("cliff/*", wire_senses.RANGE)
    assert HUMBLE.listens_on(cliffs) == "7/robot1/cliff/*/*/*"
    key = "7/robot1/cliff/left/sensor_msgs::msg::dds_::Range_/TypeHashNotSupported"
    assert HUMBLE.name_of(key, cliffs) == "robot1/cliff/left"


@pytest.mark.parametrize(
    ("dialect", "kind", "hashed", "said"),
    [
        (JAZZY, TWIST, "TypeHashNotSupported", 'set bus.distro = "humble"'),
        (HUMBLE, TWIST, HASH, 'set bus.distro = "jazzy"'),
        (JAZZY, TWIST, "RIHS01_00", "another than that of jazzy"),
        (
            JAZZY,
            "geometry_msgs::msg::dds_::TwistStamped_",
            "RIHS01_5f",
            "comes as geometry_msgs/msg/TwistStamped, where geometry_msgs/msg/Twist is read",
        ),
    ],
)
def test_another_type_is_told_of_with_what_to_do(
    dialect: RmwZenoh, kind: str, hashed: str, said: str
):
    with pytest.raises(SensorError) as told:
        dialect.name_of(f"0/cmd_vel/{kind}/{hashed}", CMD_VEL)
    assert str(told.value).startswith("cmd_vel: comes ")
    assert said in str(told.value)
    assert "\n" not in str(told.value)


def test_a_topic_of_two_types_is_read_as_either():
    sticks = RosTopic("cmd_vel_teleop", wire.TWIST, other_kind=wire.TWIST_STAMPED)
    for kind in sticks.kinds:
        key = JAZZY.publishes_on(RosTopic("cmd_vel_teleop", kind))
        assert JAZZY.name_of(key, sticks) == "cmd_vel_teleop"


def test_an_attachment_is_what_zenohs_own_serialization_makes():
    gid = bytes(range(16))
    ours = JAZZY.attachment(5, 1_700_000_000_000_000_000, gid)
    theirs = z_serialize((Int64(5), Int64(1_700_000_000_000_000_000), gid))
    assert ours == theirs.to_bytes()
    assert len(ours or b"") == 33


def test_a_reply_goes_to_who_asked_by_its_number():
    asked = JAZZY.attachment(9, 100, bytes(range(16)))
    assert JAZZY.reply_attachment(asked, 200) == JAZZY.attachment(9, 200, bytes(range(16)))
    assert JAZZY.reply_attachment(b"short", 200) is None
    assert JAZZY.reply_attachment(None, 200) is None


def test_tokens_say_who_and_what_and_how():
    numbers = itertools.count(1)
    assert JAZZY.node_tokens("ab12") == ("@ros2_lv/0/ab12/0/0/NN/%/%/rfnav",)
    assert JAZZY.tokens("ab12", numbers, Role.PUBLISHER, CMD_VEL) == (
        f"@ros2_lv/0/ab12/0/1/MP/%/%/rfnav/%cmd_vel/{TWIST}/{HASH}/::,10:,:,:,,",
    )
    best_effort = RosTopic("camera/odom", wire.TWIST, Qos(reliable=False, depth=5))
    assert HUMBLE.tokens("ab12", numbers, Role.SUBSCRIPTION, best_effort) == (
        f"@ros2_lv/7/ab12/0/2/MS/%/%robot1/rfnav/%robot1%camera%odom/{TWIST}/"
        "TypeHashNotSupported/2::,5:,:,:,,",
    )
    latched = RosTopic("map", wire.TWIST, Qos(latched=True, depth=1))
    (token,) = JAZZY.tokens("ab12", numbers, Role.PUBLISHER, latched)
    assert token.endswith("/:1:,1:,:,:,,")
    (token,) = HUMBLE.tokens("ab12", numbers, Role.SERVICE, RosService("a/b", CANCEL))
    assert "/0/4/SS/%/%robot1/rfnav/%robot1%a%b/action_msgs::srv::dds_::CancelGoal_/" in token


def test_each_type_of_a_topic_is_an_endpoint_and_a_wildcard_is_none():
    sticks = RosTopic("sticks", wire.TWIST, other_kind=wire.TWIST_STAMPED)
    first, second = JAZZY.tokens("z", itertools.count(3), Role.SUBSCRIPTION, sticks)
    assert "/0/3/MS/" in first
    assert "/0/4/MS/" in second
    assert "TwistStamped_" in second
    cliffs = RosTopic("cliff/*", wire_senses.RANGE)
    assert JAZZY.tokens("z", itertools.count(1), Role.SUBSCRIPTION, cliffs) == ()
