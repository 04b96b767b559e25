"""What the service is asked for pages: words of decisions, stops, zones, rooms; on a real bus."""

import struct
import time
import zlib

import numpy as np
import pytest
from live_page import STATE, looked_at, until
from lived_in import lived_in
from page_audience import PageAudience
from page_service import PageService, told_rooms

from runtime.core.geometry import GridFrame
from runtime.core.mapping.grid import MapCopy
from runtime.map_look import room_hue
from runtime.robot.drawn_messages import Stamp, encode_map
from runtime.service.atlas import atlas_of, nothing_told
from runtime.view.live import LiveFeed
from runtime.view.tiles import FREE, NO_ROOM, UNKNOWN, TilesHeld

STOP = {
    "number": 3, "state": "held", "kind": "contact", "reason": "touched", "ended_s": None,
    "in_words": ["Stop 3"],
}  # fmt: skip


def test_a_decision_comes_with_its_words_and_stays_in_the_timeline(
    live_feed: LiveFeed, service: PageService, audience: PageAudience
):
    looked_at(live_feed, service)
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
    kept = live_feed.ask("decision", {"number": 4})
    assert kept["scene"]["goal"] == "mug"
    with pytest.raises(ValueError, match="decision 9"):
        live_feed.ask("decision", {"number": 9})


def test_a_decision_that_comes_late_takes_nothing_from_the_timeline(
    live_feed: LiveFeed, service: PageService, audience: PageAudience
):
    service.answers["status"] = {"now_s": 100.0, "up_s": 90.0}
    looked_at(live_feed, service)
    words = {"id": "a1", "goal": "mug", "in_words": ["Taken: frontier 7."]}
    service.answers["why"] = {"decision": {"number": 5, **words}, "stop": None}
    live_feed.ask("stop", {})  # asks why at once
    audience.wait("decision", lambda d: d["number"] == 5)
    service.answers["why"] = {"decision": None, "stop": None}
    for number in (4, 6, 5):
        service.tell("rfnav/decision", {"id": "a1", "number": number, "votes": [], "frontier": 7})
    line = audience.wait("timeline", lambda t: len(t["decisions"]) == 3)
    assert [one["number"] for one in line["decisions"]] == [4, 5, 6]
    until(lambda: live_feed.ask("decision", {"number": 5}).get("votes") == [])
    assert audience.newest["decision"]["number"] == 6
    service.answers["why"] = {"decision": {"number": 6, **words}, "stop": None}
    status = {"now_s": 100.0, "up_s": 90.0, "goal": "mug", "id": "b2"}
    service.answers["status"] = status  # another, of which none was made
    service.tell("rfnav/feedback", {"id": "b2", "goal": "mug"})
    audience.wait("state", lambda s: s["goal"] is not None and s["goal"]["id"] == "b2")
    for _ in range(2):  # the second time, the first answer was taken
        service.asked.clear()
        live_feed.ask("stop", {})
        until(lambda: ("why", {}) in service.asked)
    assert audience.newest["timeline"]["id"] == "a1"
    service.answers["why"] = {"decision": None, "stop": None}
    service.answers["status"] = {"now_s": 100.0, "up_s": 1.0}  # it was started anew
    audience.wait("timeline", lambda t: t["decisions"] == [])


def test_a_stop_of_the_base_is_told_when_it_begins_and_ends(
    live_feed: LiveFeed, service: PageService, audience: PageAudience
):
    looked_at(live_feed, service)
    service.tell("rfnav/state", STATE)
    service.answers["why"] = {"stop": STOP, "decision": None}
    service.tell("rfnav/state", {**STATE, "runtime": {"state": "held"}, "halt": "touched"})
    told = audience.wait("stop", lambda s: s["number"] == 3)
    assert (told["halt"], told["over"]) == ("contact", False)
    service.answers["why"] = {"stop": {**STOP, "ended_s": 5.0}, "decision": None}
    service.tell("rfnav/state", STATE)
    audience.wait("stop", lambda s: s["over"])


def test_the_map_comes_with_its_rooms(
    live_feed: LiveFeed, service: PageService, audience: PageAudience
):
    rooms = np.full((70, 70), 255)
    rooms[2:5, 2:5] = 1
    service.answers["map"] = told_rooms(rooms, ["kitchen", "hallway"])
    looked_at(live_feed, service)
    service.tell("rfnav/scene", {"goal": "mug"})
    service.publish("rfnav/map", grid(np.ones((70, 70), bool)))
    scene = audience.wait("scene", lambda s: s["rooms"] == ["kitchen", "hallway"])
    assert scene["hues"] == [room_hue("kitchen"), room_hue("hallway")]
    until(lambda: audience.maps >= 2)
    message, _ = live_feed.tiles.since(TilesHeld()) or (b"", TilesHeld())
    assert struct.unpack_from("<H", message, 28)[0] == 4


def test_rooms_and_where_a_thing_is_come_as_the_service_tells_them(
    live_feed: LiveFeed, service: PageService, audience: PageAudience
):
    service.answers["map"] = nothing_told("map", "", "odom")  # no search has seen anything
    looked_at(live_feed, service)
    world, origin_xy = lived_in(), (100.0, -3.0)
    known = atlas_of(world, [("mug", "cup")], "odom", origin_xy)
    copy = world.map.copied(world.map.known_window())
    service.publish("rfnav/map", encode_map(copy, Stamp(1, "odom", origin_xy)))
    until(lambda: audience.maps)
    service.answers["map"] = known.told("map")
    service.answers["where"] = known.told("where", "cup")
    service.tell("rfnav/scene", {"goal": "mug"})
    audience.wait("scene", lambda s: s["rooms"] == ["kitchen", "hall"])
    cells, rooms = planes(live_feed)
    assert set(rooms[cells == FREE]) == {0}
    assert set(rooms[cells == UNKNOWN]) == {NO_ROOM}
    assert live_feed.ask("where", {"name": "cup"})["found"][0]["room"] == "kitchen"


def planes(live_feed: LiveFeed) -> tuple[np.ndarray, np.ndarray]:
    """All cells of the map that a page is sent, and their rooms."""
    message, _ = live_feed.tiles.since(TilesHeld()) or (b"", TilesHeld())
    (count,) = struct.unpack_from("<H", message, 28)
    tiles = np.frombuffer(zlib.decompress(message[30 + 8 * count :]), np.uint8)
    both = tiles.reshape(count, 2, -1)
    return both[:, 0], both[:, 1]


def grid(free: np.ndarray) -> bytes:
    rows, cols = free.shape
    frame = GridFrame(0.0, 0.0, 0.05, rows, cols)
    none = np.zeros_like(free)
    return encode_map(MapCopy(frame, free, none, none), Stamp(1, "odom"))


def test_a_zone_that_was_drawn_is_told_at_once(
    live_feed: LiveFeed, service: PageService, audience: PageAudience
):
    looked_at(live_feed, service)
    audience.wait("zones", lambda z: z["zones"] == [])
    drawn = {"name": "stairs", "polygon": [[0, 0], [1, 0], [1, 1]]}
    service.answers["zones"] = {"accepted": True, "zones": [drawn], "bound": True}
    live_feed.ask("zones", {"add": "stairs", "polygon": drawn["polygon"]})
    began_s = time.monotonic()
    audience.wait("zones", lambda z: z["zones"] == [drawn])
    assert time.monotonic() - began_s < 2.5  # sooner than it is asked else
