"""A stop stays until a hand releases it."""

import json
from types import SimpleNamespace
from typing import Any, Literal

from other_half import flag

from runtime.robot.dialects.choice import spoken
from runtime.robot.dialects.type_hashes import type_hash
from runtime.robot.handbrake import Handbrake, serve_handbrake
from runtime.robot.ros_node import RosNode
from runtime.robot.session import BusConfig, TopicsConfig
from runtime.robot.wire_senses import BOOL


def reason(brake: Handbrake) -> str:
    halt = brake.halt()
    return f"{halt.kind}: {halt.reason}" if halt else ""


def test_a_stop_stays_until_it_is_released():
    brake = Handbrake()
    assert reason(brake) == ""
    brake.stop("rfnav/stop")
    assert reason(brake) == "stop: stopped by rfnav/stop: ask rfnav/release to go on"
    assert brake.release() == ""
    assert reason(brake) == ""


def test_letting_go_of_a_button_releases_nothing_and_a_pressed_one_cannot_be_released():
    brake = Handbrake()
    brake.button("stop", True)
    assert brake.release() == "stop is still pressed"
    brake.button("stop", False)
    assert reason(brake).startswith("stop: stopped by stop")
    assert brake.release() == ""
    assert reason(brake) == ""


def test_a_cancel_holds_the_base_as_long_as_it_waits():
    brake = Handbrake()
    brake.cancel(True)
    brake.cancel(True)
    brake.cancel(False)
    assert reason(brake) == "cancel: a cancel waits to be answered"
    brake.cancel(False)
    assert reason(brake) == ""


def test_who_stopped_it_first_is_said_and_of_pressed_buttons_one():
    brake = Handbrake()
    brake.stop("rfnav/stop")
    brake.stop("somebody else")
    brake.button("stop", True)
    assert reason(brake) == "stop: stopped by rfnav/stop: ask rfnav/release to go on"
    brake.button("another", True)
    assert brake.release() == "another is still pressed"
    brake.button("another", False)
    assert brake.release() == "stop is still pressed"
    brake.button("stop", False)
    assert reason(brake) == "stop: stopped by rfnav/stop: ask rfnav/release to go on"


def test_the_button_that_was_pressed_first_is_said():
    brake = Handbrake()
    brake.button("left", True)
    brake.button("right", True)
    assert reason(brake).startswith("stop: stopped by left:")


# -- on the bus ------------------------------------------------------------------------------------


class Session:
    """What is declared on one, by key."""

    def __init__(self) -> None:
        self.served: dict[str, Any] = {}

    def zid(self) -> str:
        return "f00"

    def liveliness(self) -> Any:
        return SimpleNamespace(declare_token=lambda token: None)

    def declare_queryable(self, key: str, serve: Any) -> str:
        self.served[key] = serve
        return f"queryable {key}"

    def declare_subscriber(self, key: str, take: Any) -> str:
        self.served[key] = take
        return f"subscriber {key}"


class Query:
    """One that keeps what it is answered."""

    def __init__(self) -> None:
        self.answers: list[tuple[str, Any]] = []
        self.dropped = False

    def reply(self, key: str, said: str) -> None:
        self.answers.append((key, json.loads(said)))

    def drop(self) -> None:
        self.dropped = True


class Served:
    """A handbrake on a bus whose robot is called r1."""

    def __init__(
        self,
        topics: TopicsConfig = TopicsConfig(),  # noqa: B008 -- a value
        dialect: Literal["ros2dds", "rmw_zenoh"] = "ros2dds",
    ) -> None:
        self.session, self.brake, self.urgent = Session(), Handbrake(), []
        config = BusConfig(prefix="r1", topics=topics, dialect=dialect)
        hurry = lambda: self.urgent.append(reason(self.brake))  # noqa: E731
        node = RosNode(self.session, spoken(config))
        self.declared = serve_handbrake(self.session, node, config, self.brake, hurry)

    def ask(self, key: str) -> list[tuple[str, Any]]:
        query = Query()
        self.session.served[key](query)
        assert query.dropped
        return query.answers

    def press(self, payload: bytes, key: str = "r1/stop") -> None:
        taken = SimpleNamespace(to_bytes=lambda: payload)
        (hear,) = (take for where, take in self.session.served.items() if "r1/stop" in where)
        hear(SimpleNamespace(key_expr=key, payload=taken))


def test_a_stop_holds_the_base_before_it_is_answered_and_a_release_is_answered_too():
    bus = Served()
    assert bus.ask("r1/rfnav/stop") == [("r1/rfnav/stop", {"stopped": True})]
    held = "stop: stopped by rfnav/stop: ask rfnav/release to go on"
    assert (reason(bus.brake), bus.urgent) == (held, [held])
    assert bus.ask("r1/rfnav/release") == [("r1/rfnav/release", {"released": True})]
    assert reason(bus.brake) == ""
    assert len(bus.urgent) == 1


def test_a_button_stops_and_while_it_is_pressed_nothing_is_released():
    bus = Served()
    bus.press(flag(False))
    assert (reason(bus.brake), bus.urgent) == ("", [])
    bus.press(flag(True))
    assert reason(bus.brake) == "stop: stopped by r1/stop: ask rfnav/release to go on"
    assert bus.urgent == [reason(bus.brake)]
    why = "r1/stop is still pressed"
    assert bus.ask("r1/rfnav/release") == [("r1/rfnav/release", {"released": False, "error": why})]
    bus.press(flag(False))
    assert bus.ask("r1/rfnav/release")[0][1] == {"released": True}
    assert len(bus.urgent) == 1


def test_what_cannot_be_read_on_the_button_s_topic_is_a_stop():
    bus = Served()
    bus.press(b"\x00")
    assert reason(bus.brake).startswith("stop: stopped by r1/stop")
    assert len(bus.urgent) == 1


def test_a_message_of_another_type_on_the_button_s_topic_is_a_stop_of_the_same_button():
    bus = Served(dialect="rmw_zenoh")
    key = "0/r1/stop/std_msgs::msg::dds_::{}_/{}"
    bus.press(flag(False), key.format("Empty", "RIHS01_0"))
    assert reason(bus.brake).startswith("stop: stopped by r1/stop")
    assert len(bus.urgent) == 1
    why = "r1/stop is still pressed"
    assert bus.ask("r1/rfnav/release")[0][1] == {"released": False, "error": why}
    bus.press(flag(False), key.format("Bool", type_hash(BOOL, "jazzy")))
    assert bus.ask("r1/rfnav/release")[0][1] == {"released": True}


def test_what_was_declared_is_handed_back_and_without_a_topic_there_is_no_button():
    asked = ["queryable r1/rfnav/stop", "queryable r1/rfnav/release"]
    bus, bare = Served(), Served(TopicsConfig(stop=""))
    assert bus.declared == bare.declared == asked
    assert set(bus.session.served) - set(bare.session.served) == {"r1/stop"}
