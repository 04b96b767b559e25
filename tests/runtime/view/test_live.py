"""A feed from a service on a real bus: heard while somebody looks, found again when it is back."""

import struct
import time

import numpy as np
import pytest
from live_page import STATE, Dozing, looked_at, until
from page_audience import PageAudience
from page_service import PageService, told_rooms

from runtime.core.belief import Belief, Expected
from runtime.errors import BusError
from runtime.robot import wire
from runtime.view.live import LiveFeed


def test_while_nobody_looks_nothing_is_heard_or_asked(
    live_feed: LiveFeed, service: PageService, dozing: Dozing
):
    until(lambda: dozing.who == {"view _link", "view _read"})
    assert service.asked == []
    assert not service.heard("rfnav/state")
    looked_at(live_feed, service)
    assert service.heard("rfnav/scene")
    assert not service.heard("camera/color/image_raw")
    live_feed.attend(1, 1)
    until(lambda: service.heard("camera/color/image_raw"))
    live_feed.attend(1, 0)
    until(lambda: not service.heard("camera/color/image_raw"))
    live_feed.attend(0, 0)
    until(lambda: dozing.who == {"view _link", "view _read"})
    assert service.asked  # while somebody looked
    until(lambda: not service.heard("rfnav/state"))


def test_a_state_is_told_with_the_goal_that_it_is_of(
    live_feed: LiveFeed, service: PageService, audience: PageAudience
):
    looked_at(live_feed, service)
    service.tell("rfnav/state", {**STATE, "origin_xy": [100.0, 0.0]})
    service.tell("rfnav/feedback", {"id": "a1", "goal": "mug", "state": "searching", "usd": 0.1})
    service.answers["status"] = {"goal": "mug", "id": "a1", "queue": [{"id": "b2", "goal": "cup"}]}
    told = audience.wait("state", lambda s: s["goal"] is not None and bool(s["queue"]))
    assert told["pose"] == [101.0, 2.0, 0.5]
    assert told["target"] == [103.0, 1.0]
    assert (told["goal"]["text"], told["goal"]["usd"]) == ("mug", 0.1)
    assert (told["battery"], told["frontier"]) == (50.0, 7)


def test_a_service_that_is_not_there_is_told_and_found_when_it_comes(
    live_feed: LiveFeed, bus_port: int, audience: PageAudience
):
    live_feed.attend(1, 0)
    told = audience.wait("state", lambda s: "nobody listens" in s["why"])
    assert told["link"] == "no service"
    service = PageService(bus_port)
    until(lambda: service.heard("rfnav/state"))
    service.tell("rfnav/state", STATE)
    audience.wait("state", lambda s: s["link"] == "ok")
    service.close()
    audience.wait("state", lambda s: s["link"] == "no service")
    again = PageService(bus_port)
    until(lambda: again.heard("rfnav/state"))
    again.tell("rfnav/state", STATE)
    audience.wait("state", lambda s: s["link"] == "ok")
    again.close()


def test_a_service_that_answers_and_tells_nothing_is_silent(
    live_feed: LiveFeed, service: PageService, audience: PageAudience
):
    live_feed.attend(1, 0)
    assert "has not come" in audience.wait("state", lambda s: s["link"] == "silent")["why"]


def test_where_the_thing_may_be_is_told_as_the_decision_that_stands_has_it(
    live_feed: LiveFeed, service: PageService, audience: PageAudience
):
    looked_at(live_feed, service)
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


def test_images_are_made_small_and_not_more_often_than_pages_want(
    live_feed: LiveFeed, service: PageService, audience: PageAudience
):
    live_feed.attend(1, 1)
    topic = "camera/color/image_raw"
    until(lambda: service.heard(topic))
    began_s = time.monotonic()
    while time.monotonic() - began_s < 1.5:
        service.publish(topic, wire.encode_color(np.zeros((600, 800, 3), np.uint8), 5))
        time.sleep(0.02)
    assert 3 <= len(audience.pictures) <= 9
    assert struct.unpack_from("<BBHHQ", audience.pictures[0]) == (2, 1, 640, 480, 5)


def test_what_is_asked_goes_to_the_service_and_no_more_than_a_page_may(
    live_feed: LiveFeed, service: PageService
):
    looked_at(live_feed, service)
    assert live_feed.ask("goal", {"goal": "mug"})["id"] == "5f3a09c1"
    assert ("goal", {"goal": "mug"}) in service.asked
    with pytest.raises(ValueError, match="settings"):
        live_feed.ask("goal", {"goal": "mug", "settings": {}})
    service.answers.pop("goal")
    with pytest.raises(BusError, match="nobody answers"):
        live_feed.ask("goal", {"goal": "mug"})


def test_while_models_load_no_goal_is_asked_for(
    live_feed: LiveFeed, service: PageService, audience: PageAudience
):
    looked_at(live_feed, service)
    service.tell("rfnav/state", {**STATE, "runtime": {"state": "starting", "cause": ""}})
    audience.wait("state", lambda s: s["runtime"]["state"] == "starting")
    with pytest.raises(BusError, match="its models still load"):
        live_feed.ask("goal", {"goal": "mug"})
    assert "goal" not in [kind for kind, _ in service.asked]
    assert live_feed.ask("stop", {}) == {"stopped": True}


def test_a_stop_goes_through_though_nobody_looks(live_feed: LiveFeed, service: PageService):
    assert live_feed.ask("stop", {}) == {"stopped": True}
    assert [kind for kind, _ in service.asked] == ["stop"]


def test_hands_drive_until_the_page_is_gone(
    live_feed: LiveFeed, service: PageService, audience: PageAudience
):
    looked_at(live_feed, service)
    service.tell("rfnav/state", STATE)
    audience.wait("state", lambda s: s["link"] == "ok")
    until(lambda: live_feed.steer(1, {"kind": "teleop", "v": 1.0, "w": 0.0}) or service.teleop)
    assert service.teleop[0] == (0.4, 0.0)
    live_feed.gone(1)
    until(lambda: service.teleop[-1] == (0.0, 0.0))


def test_nobody_drives_a_robot_that_does_not_tell_whether_it_is_stopped(
    live_feed: LiveFeed, service: PageService
):
    looked_at(live_feed, service)
    until(lambda: live_feed._teleop is not None)
    live_feed.steer(1, {"kind": "teleop", "v": 1.0, "w": 0.0})
    assert live_feed._sticks.who is None
    live_feed.close()
    assert service.teleop == []


def test_nonsense_on_the_bus_is_left_out(
    live_feed: LiveFeed, service: PageService, audience: PageAudience
):
    looked_at(live_feed, service)
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


def test_a_page_is_told_what_this_robot_is_like(live_feed: LiveFeed):
    told = live_feed.welcome()
    assert told["can"] == {"teleop": True, "command": True, "camera": True}
    assert told["robot"] == {"radius_m": 0.18}
    assert (told["max_v_mps"], told["max_w_radps"]) == (0.4, 1.0)
    assert told["budgets"]["tick"]["p99_ms"] > 0
