"""What is published, how urgently, and what becomes of an answer that was lost. Over the wire:
test_bus.py."""

import pytest
import zenoh
from other_half import stamped_twist

from runtime.core.types import Action, Twist
from runtime.errors import BusError
from runtime.robot import wire
from runtime.robot.dialects.choice import spoken
from runtime.robot.dialects.dialect import Qos, RosTopic
from runtime.robot.publications import Publications, _topic, cmd_vel_topic
from runtime.robot.ros_node import RosNode
from runtime.robot.session import BusConfig, TopicsConfig
from runtime.robot.streams import WireMessage


class Publisher:
    """What a session hands out."""

    def __init__(self, key: str, how: dict) -> None:
        self.key, self.how = key, how
        self.put_payloads: list[bytes] = []
        self.broken = False

    def put(self, payload: bytes, attachment: None) -> None:
        if self.broken:
            raise zenoh.ZError("session closed")
        self.put_payloads.append(payload)


class Session:
    """One that nobody else is on."""

    def __init__(self) -> None:
        self.publishers: dict[str, Publisher] = {}

    def zid(self) -> str:
        return "f00"

    def declare_publisher(self, key: str, **how) -> Publisher:
        name = f"last {key}" if key in self.publishers else key
        assert name not in self.publishers
        self.publishers[name] = Publisher(key, how)
        return self.publishers[name]


CONFIG = BusConfig(prefix="r1", topics=TopicsConfig(cmd_vel="base/cmd_vel"))
URGENT, ORDINARY = zenoh.Priority.INTERACTIVE_HIGH, zenoh.Priority.DATA
BLOCK, DROP = zenoh.CongestionControl.BLOCK, zenoh.CongestionControl.DROP


def made(lockstep: bool = False, config: BusConfig = CONFIG):
    session, told = Session(), []
    record = lambda kind, value: told.append((kind, value))  # noqa: E731
    node = RosNode(session, spoken(config))
    return Publications(node, config, lockstep, record), session.publishers, told


def said(publisher: Publisher) -> list:
    return [wire.decode_json(payload, publisher.key) for payload in publisher.put_payloads]


def test_commands_go_before_reports_and_the_last_velocity_alone_is_waited_for():
    _, publishers, _ = made()
    assert {key: (p.how["congestion_control"], p.how["priority"]) for key, p in
            publishers.items()} == {
        "r1/rfnav/action": (DROP, URGENT),
        "r1/base/cmd_vel": (DROP, URGENT),
        "last r1/base/cmd_vel": (BLOCK, URGENT),
        "r1/rfnav/state": (DROP, ORDINARY),
        "r1/rfnav/decision": (DROP, ORDINARY),
        "r1/rfnav/feedback": (DROP, ORDINARY),
    }  # fmt: skip
    assert all(p.how["express"] is True for p in publishers.values())


def test_in_lockstep_what_was_published_first_arrives_first():
    _, publishers, _ = made(lockstep=True)
    hows = [(p.how["congestion_control"], p.how["priority"]) for p in publishers.values()]
    assert hows == [(BLOCK, ORDINARY)] * 5


def test_a_velocity_is_what_the_base_reads_and_what_is_recorded():
    publications, publishers, told = made()
    publications.twist(Twist(0.25, -0.5), 7)
    (payload,) = publishers["r1/base/cmd_vel"].put_payloads
    assert wire.decode_twist(payload, "cmd_vel") == (0.25, -0.5)
    assert told == [("wire", WireMessage("base/cmd_vel", wire.TWIST, payload))]


def test_a_velocity_after_which_none_follows_is_sent_by_who_waits_for_the_wire():
    publications, publishers, told = made()
    publications.twist(Twist(), 7, last=True)
    assert publishers["r1/base/cmd_vel"].put_payloads == []
    (payload,) = publishers["last r1/base/cmd_vel"].put_payloads
    assert wire.decode_twist(payload, "cmd_vel") == (0.0, 0.0)
    assert told == [("wire", WireMessage("base/cmd_vel", wire.TWIST, payload))]


def test_a_stamped_velocity_has_the_stamp_and_the_frame():
    config = BusConfig(cmd_vel_type="TwistStamped", cmd_vel_frame="base_footprint")
    publications, publishers, told = made(config=config)
    publications.twist(Twist(0.25, -0.5), 3_000_000_007)
    (payload,) = publishers["cmd_vel"].put_payloads
    assert stamped_twist(payload) == (3_000_000_007, 0.25, -0.5)
    message = wire.decode(payload, wire.TWIST_STAMPED, "cmd_vel")
    assert message.header.frame_id == "base_footprint"
    assert told == [("wire", WireMessage("cmd_vel", wire.TWIST_STAMPED, payload))]


def test_an_action_and_the_velocity_that_goes_with_it():
    publications, publishers, _ = made()
    publications.action(5, Action.MOVE_FORWARD, None)
    publications.action(6, Action.TURN_LEFT, Twist(0.0, 0.5))
    assert said(publishers["r1/rfnav/action"]) == [
        {"stamp_ns": 5, "action": Action.MOVE_FORWARD.value},
        {"stamp_ns": 6, "action": Action.TURN_LEFT.value, "v_mps": 0.0, "w_radps": 0.5},
    ]


def test_an_answer_that_was_lost_is_given_again_and_only_that_one():
    publications, publishers, _ = made()
    answers = publishers["r1/rfnav/action"]
    publications.answer_again(5)
    assert answers.put_payloads == []
    publications.action(5, Action.MOVE_FORWARD, None)
    publications.answer_again(4)
    assert len(answers.put_payloads) == 1
    publications.answer_again(5)
    assert answers.put_payloads[1:] == answers.put_payloads[:1]
    publications.forget_answer()
    publications.answer_again(5)
    assert len(answers.put_payloads) == 2


def test_a_report_is_json_and_a_wire_that_broke_is_an_error_that_says_where():
    publications, publishers, _ = made()
    publications.report("state", {"state": "found", "at": (1.0, 2.0)})
    assert said(publishers["r1/rfnav/state"]) == [{"state": "found", "at": [1.0, 2.0]}]
    publishers["r1/rfnav/state"].broken = True
    with pytest.raises(BusError, match=r"^rfnav/state: cannot be published: session closed$"):
        publications.report("state", {})


def test_nothing_is_recorded_where_nobody_asked_for_it():
    session = Session()
    node = RosNode(session, spoken(CONFIG))
    Publications(node, CONFIG, False).twist(Twist(0.1, 0.0), 0)
    assert len(session.publishers["r1/base/cmd_vel"].put_payloads) == 1


def test_of_velocities_a_base_keeps_the_newest_alone_and_reports_are_text():
    assert cmd_vel_topic(CONFIG) == RosTopic("base/cmd_vel", wire.TWIST, Qos(depth=1))
    stamped = BusConfig(cmd_vel_type="TwistStamped")
    assert cmd_vel_topic(stamped) == RosTopic("cmd_vel", wire.TWIST_STAMPED, Qos(depth=1))
    assert _topic("cmd_vel", CONFIG) == cmd_vel_topic(CONFIG)
    assert _topic("state", CONFIG) == RosTopic("rfnav/state", wire.STRING)
