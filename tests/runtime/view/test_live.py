"""A feed from a service on a real bus: heard while somebody looks, found again when it is back."""

import struct
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from page_audience import PageAudience
from page_server import free_port
from page_service import PageService, told_rooms

from runtime.commands.running import running
from runtime.config import Config, load
from runtime.core.belief import Belief, Expected
from runtime.core.geometry import GridFrame
from runtime.core.mapping.grid import MapCopy
from runtime.errors import BusError
from runtime.robot import wire
from runtime.robot.drawn_messages import Stamp, encode_map
from runtime.robot.session import BusConfig
from runtime.tracing.budgets import read_budgets
from runtime.view import live
from runtime.view.hearing import page_topics
from runtime.view.live import LiveFeed, LiveParts
from runtime.view.tiles import TilesHeld

PATIENCE_S = 15.0
STATE = {
    "runtime": {"state": "searching", "cause": ""}, "pose": [1.0, 2.0, 0.5], "v_mps": 0.2,
    "w_radps": 0.0, "halt": "", "base": {"hand": "", "battery_percent": 50.0}, "mode": "frontier",
    "reason": "drive to frontier 7", "toward_xy": [3.0, 1.0], "frontier": 7,
}  # fmt: skip
STOP = {
    "number": 3, "state": "held", "kind": "contact", "reason": "touched", "ended_s": None,
    "in_words": ["Stop 3"],
}  # fmt: skip


@pytest.fixture
def port() -> int:
    return free_port()


@pytest.fixture
def service(port: int) -> Iterator[PageService]:
    service = PageService(port)
    yield service
    service.close()


@pytest.fixture
def audience() -> PageAudience:
    return PageAudience()


@pytest.fixture
def feed(port: int, audience: PageAudience, monkeypatch: pytest.MonkeyPatch) -> Iterator[LiveFeed]:
    monkeypatch.setattr(live, "LINGER_S", 0.2)
    monkeypatch.setattr(live, "RETRY_S", 0.2)
    config = at_port(port)
    connect = partial(running, config.bus)
    feed = LiveFeed(LiveParts(connect, config, read_budgets(), lambda status: ["a line"]))
    feed.start(audience)
    yield feed
    feed.close()


def at_port(port: int) -> Config:
    bus = BusConfig(mode="client", connect=(f"tcp/127.0.0.1:{port}",))
    return replace(load(None), bus=bus)


def until(what: Callable[[], Any]) -> None:
    by_s = time.monotonic() + PATIENCE_S
    while not what():
        assert time.monotonic() < by_s
        time.sleep(0.02)


def looked_at(feed: LiveFeed, service: PageService) -> None:
    feed.attend(1, 0)
    for topic in page_topics().values():
        until(lambda name=topic.name: service.heard(name))


def test_while_nobody_looks_nothing_is_heard_or_asked(
    feed: LiveFeed, service: PageService, audience: PageAudience
):
    time.sleep(0.5)
    assert service.asked == []
    assert not service.heard("rfnav/state")
    looked_at(feed, service)
    assert service.heard("rfnav/scene")
    assert not service.heard("camera/color/image_raw")
    feed.attend(1, 1)
    until(lambda: service.heard("camera/color/image_raw"))
    feed.attend(1, 0)
    until(lambda: not service.heard("camera/color/image_raw"))
    feed.attend(0, 0)
    until(lambda: not service.heard("rfnav/state"))
    asked = len(service.asked)
    time.sleep(1.5)
    assert len(service.asked) == asked


def test_a_state_is_told_with_the_goal_that_it_is_of(
    feed: LiveFeed, service: PageService, audience: PageAudience
):
    looked_at(feed, service)
    service.tell("rfnav/state", {**STATE, "origin_xy": [100.0, 0.0]})
    service.tell("rfnav/feedback", {"id": "a1", "goal": "mug", "state": "searching", "usd": 0.1})
    service.answers["status"] = {"goal": "mug", "id": "a1", "queue": [{"id": "b2", "goal": "cup"}]}
    told = audience.wait("state", lambda s: s["goal"] is not None and bool(s["queue"]))
    assert told["pose"] == [101.0, 2.0, 0.5]
    assert told["target"] == [103.0, 1.0]
    assert (told["goal"]["text"], told["goal"]["usd"]) == ("mug", 0.1)
    assert (told["battery"], told["frontier"]) == (50.0, 7)


def test_a_service_that_is_not_there_is_told_and_found_when_it_comes(
    feed: LiveFeed, port: int, audience: PageAudience
):
    feed.attend(1, 0)
    told = audience.wait("state", lambda s: "nobody listens" in s["why"])
    assert told["link"] == "no service"
    service = PageService(port)
    until(lambda: service.heard("rfnav/state"))
    service.tell("rfnav/state", STATE)
    audience.wait("state", lambda s: s["link"] == "ok")
    service.close()
    audience.wait("state", lambda s: s["link"] == "no service")
    again = PageService(port)
    until(lambda: again.heard("rfnav/state"))
    again.tell("rfnav/state", STATE)
    audience.wait("state", lambda s: s["link"] == "ok")
    again.close()


def test_a_service_that_answers_and_tells_nothing_is_silent(
    feed: LiveFeed, service: PageService, audience: PageAudience
):
    feed.attend(1, 0)
    assert "has not come" in audience.wait("state", lambda s: s["link"] == "silent")["why"]


def test_a_decision_comes_with_its_words_and_stays_in_the_timeline(
    feed: LiveFeed, service: PageService, audience: PageAudience
):
    looked_at(feed, service)
    words = {"number": 4, "goal": "mug", "in_words": ["Decision 4", "Taken: frontier 7."]}
    service.answers["why"] = {"decision": words, "stop": None}
    service.tell("rfnav/scene", {"goal": "mug", "frontiers": [], "things": []})
    audience.wait("scene", lambda s: s["goal"] == "mug")
    vote = {"expert": "o2f", "frontiers": [7], "probabilities": [[7, 0.6]], "rung": "local"}
    report = {
        "number": 4, "frontier": 7, "rule": "all", "votes": [vote], "missing": [],
        "latency_s": {"o2f": 0.3}, "without": {"o2f": 3}, "in_words": "frontier 7",
    }  # fmt: skip
    service.tell("rfnav/decision", report)
    told = audience.wait("decision", lambda d: "votes" in d)
    assert (told["number"], told["full"]) == (4, ["Decision 4", "Taken: frontier 7."])
    assert told["votes"][0]["latency_s"] == 0.3
    assert told["without"] == {"o2f": 3}
    line = audience.wait("timeline", lambda t: bool(t["decisions"]))
    assert line["decisions"][0]["in_words"] == "frontier 7"
    kept = feed.ask("decision", {"number": 4})
    assert kept["scene"]["goal"] == "mug"
    with pytest.raises(ValueError, match="decision 9"):
        feed.ask("decision", {"number": 9})


def test_a_decision_that_comes_late_takes_nothing_from_the_timeline(
    feed: LiveFeed, service: PageService, audience: PageAudience
):
    service.answers["status"] = {"now_s": 100.0, "up_s": 90.0}
    looked_at(feed, service)
    words = {"goal": "mug", "in_words": ["Taken: frontier 7."]}
    service.answers["why"] = {"decision": {"number": 5, **words}, "stop": None}
    service.tell("rfnav/feedback", {"id": "a1", "goal": "mug"})
    feed.ask("stop", {})  # asks why at once
    audience.wait("decision", lambda d: d["number"] == 5)
    service.answers["why"] = {"decision": None, "stop": None}
    for number in (4, 6, 5):
        service.tell("rfnav/decision", {"id": "a1", "number": number, "votes": [], "frontier": 7})
    line = audience.wait("timeline", lambda t: len(t["decisions"]) == 3)
    assert [one["number"] for one in line["decisions"]] == [4, 5, 6]
    until(lambda: feed.ask("decision", {"number": 5}).get("votes") == [])
    assert audience.newest["decision"]["number"] == 6
    service.answers["status"] = {"now_s": 100.0, "up_s": 1.0}  # it was started anew
    audience.wait("timeline", lambda t: t["decisions"] == [])


def test_where_the_thing_may_be_is_told_as_the_decision_that_stands_has_it(
    feed: LiveFeed, service: PageService, audience: PageAudience
):
    looked_at(feed, service)
    behind = Expected("frontier", 7, (3.0, 1.0), 0.75, "3.0 m² unknown behind it")
    told = {**STATE, "origin_xy": [100.0, 0.0], "belief": Belief((behind,), 0.25).told()}
    service.tell("rfnav/state", told)
    audience.wait("state", lambda s: s["pose"] == [101.0, 2.0, 0.5])
    service.tell("rfnav/scene", {"goal": "mug"})
    scene = audience.wait("scene", lambda s: s["goal"] == "mug")
    assert scene["belief"] == [vars(behind) | {"xy": [103.0, 1.0]}]
    service.tell("rfnav/state", {**STATE, "belief": None})  # the search has ended
    audience.wait("state", lambda s: s["pose"] == [1.0, 2.0, 0.5])
    service.tell("rfnav/scene", {"goal": "bed"})
    assert audience.wait("scene", lambda s: s["goal"] == "bed")["belief"] == []


def test_a_stop_of_the_base_is_told_when_it_begins_and_ends(
    feed: LiveFeed, service: PageService, audience: PageAudience
):
    looked_at(feed, service)
    service.tell("rfnav/state", STATE)
    service.answers["why"] = {"stop": STOP, "decision": None}
    service.tell("rfnav/state", {**STATE, "runtime": {"state": "held"}, "halt": "touched"})
    told = audience.wait("stop", lambda s: s["number"] == 3)
    assert (told["halt"], told["over"]) == ("contact", False)
    service.answers["why"] = {"stop": {**STOP, "ended_s": 5.0}, "decision": None}
    service.tell("rfnav/state", STATE)
    audience.wait("stop", lambda s: s["over"])


def test_the_map_comes_with_its_rooms(feed: LiveFeed, service: PageService, audience: PageAudience):
    rooms = np.full((70, 70), 255)
    rooms[2:5, 2:5] = 1
    service.answers["map"] = told_rooms(rooms, ["kitchen", "hallway"])
    looked_at(feed, service)
    service.tell("rfnav/scene", {"goal": "mug"})
    service.publish("rfnav/map", grid(np.ones((70, 70), bool)))
    audience.wait("scene", lambda s: s["rooms"] == ["kitchen", "hallway"])
    until(lambda: audience.maps >= 2)
    message, _ = feed.tiles.since(TilesHeld()) or (b"", TilesHeld())
    assert struct.unpack_from("<H", message, 28)[0] == 4


def grid(free: np.ndarray) -> bytes:
    rows, cols = free.shape
    frame = GridFrame(0.0, 0.0, 0.05, rows, cols)
    none = np.zeros_like(free)
    return encode_map(MapCopy(frame, free, none, none), Stamp(1, "odom"))


def test_images_are_made_small_and_not_more_often_than_pages_want(
    feed: LiveFeed, service: PageService, audience: PageAudience
):
    feed.attend(1, 1)
    topic = "camera/color/image_raw"
    until(lambda: service.heard(topic))
    began_s = time.monotonic()
    while time.monotonic() - began_s < 1.5:
        service.publish(topic, wire.encode_color(np.zeros((600, 800, 3), np.uint8), 5))
        time.sleep(0.02)
    assert 3 <= len(audience.pictures) <= 9
    assert struct.unpack_from("<BBHHQ", audience.pictures[0]) == (2, 1, 640, 480, 5)


def test_what_is_asked_goes_to_the_service_and_no_more_than_a_page_may(
    feed: LiveFeed, service: PageService
):
    looked_at(feed, service)
    assert feed.ask("goal", {"goal": "mug"})["id"] == "5f3a09c1"
    assert ("goal", {"goal": "mug"}) in service.asked
    with pytest.raises(ValueError, match="settings"):
        feed.ask("goal", {"goal": "mug", "settings": {}})
    service.answers.pop("goal")
    with pytest.raises(BusError, match="nobody answers"):
        feed.ask("goal", {"goal": "mug"})


def test_a_stop_goes_through_though_nobody_looks(feed: LiveFeed, service: PageService):
    assert feed.ask("stop", {}) == {"stopped": True}
    assert [kind for kind, _ in service.asked] == ["stop"]


def test_a_zone_that_was_drawn_is_told_at_once(
    feed: LiveFeed, service: PageService, audience: PageAudience
):
    looked_at(feed, service)
    audience.wait("zones", lambda z: z["zones"] == [])
    drawn = {"name": "stairs", "polygon": [[0, 0], [1, 0], [1, 1]]}
    service.answers["zones"] = {"accepted": True, "zones": [drawn], "bound": True}
    feed.ask("zones", {"add": "stairs", "polygon": drawn["polygon"]})
    began_s = time.monotonic()
    audience.wait("zones", lambda z: z["zones"] == [drawn])
    assert time.monotonic() - began_s < 2.5  # sooner than it is asked else


def test_hands_drive_until_the_page_is_gone(
    feed: LiveFeed, service: PageService, audience: PageAudience
):
    looked_at(feed, service)
    service.tell("rfnav/state", STATE)
    audience.wait("state", lambda s: s["link"] == "ok")
    until(lambda: feed.steer(1, {"kind": "teleop", "v": 1.0, "w": 0.0}) or service.teleop)
    assert service.teleop[0] == (0.4, 0.0)
    feed.gone(1)
    until(lambda: service.teleop[-1] == (0.0, 0.0))


def test_nobody_drives_a_robot_that_does_not_tell_whether_it_is_stopped(
    feed: LiveFeed, service: PageService
):
    looked_at(feed, service)
    for _ in range(5):
        feed.steer(1, {"kind": "teleop", "v": 1.0, "w": 0.0})
        time.sleep(0.1)
    assert service.teleop == []


def test_nonsense_on_the_bus_is_left_out(
    feed: LiveFeed, service: PageService, audience: PageAudience
):
    looked_at(feed, service)
    service.answers["zones"] = {"zones": 7}
    service.answers["places"] = {"places": []}
    service.answers["map"] = told_rooms(np.zeros((2, 2)), ["kitchen"]) | {"rooms": "AAAA"}
    service.answers["why"] = {"stop": {"number": None}, "decision": []}
    for topic in ("rfnav/state", "rfnav/scene", "rfnav/decision", "rfnav/map", "rfnav/detections"):
        service.publish(topic, b"\x00\x01\x00\x00nonsense")
        service.publish(topic, wire.encode_json({"pose": "x", "votes": 3, "number": "x"}))
    service.tell("rfnav/state", {**STATE, "toward_xy": "there", "runtime": 7, "base": []})
    service.answers["status"] = {"stages": {"tick": 3}, "streams": {"odom": []}, "queue": 5}
    time.sleep(1.0)
    service.answers["status"] = {"goal": None}
    service.tell("rfnav/state", STATE)
    audience.wait("state", lambda s: s["pose"] == [1.0, 2.0, 0.5])


def test_a_page_is_told_what_this_robot_is_like(feed: LiveFeed):
    told = feed.welcome()
    assert told["can"] == {"teleop": True, "command": True, "camera": True}
    assert told["robot"] == {"radius_m": 0.18}
    assert (told["max_v_mps"], told["max_w_radps"]) == (0.4, 1.0)
    assert told["budgets"]["tick"]["p99_ms"] > 0
