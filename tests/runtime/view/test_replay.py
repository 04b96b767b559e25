"""A recording as a page goes through it."""

import struct
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from page_audience import PageAudience

from runtime.errors import RecordingError
from runtime.recording.mcap_file import McapFile
from runtime.recording.reader import messages
from runtime.tracing.budgets import read_budgets
from runtime.view.replay import ReplayFeed
from runtime.view.tiles import TilesHeld

DRIVE = Path(__file__).parents[2] / "refs" / "realtime.mcap"


@pytest.fixture
def audience() -> PageAudience:
    return PageAudience()


@pytest.fixture
def feed(audience: PageAudience) -> Iterator[ReplayFeed]:
    feed = ReplayFeed(DRIVE, read_budgets())
    feed.start(audience)
    feed.attend(1, 1)
    yield feed
    feed.close()


def at_s(t_s: float) -> Callable[[dict[str, Any]], bool]:
    """Seconds since 1970, to a millisecond."""
    return lambda told: abs(told["t_s"] - t_s) < 1e-3


def like(**values: Any) -> Callable[[dict[str, Any]], bool]:
    return lambda told: all(told.get(name) == value for name, value in values.items())


def test_a_page_is_told_what_there_is_to_go_through(feed: ReplayFeed, audience: PageAudience):
    span = audience.wait("span", lambda told: True)
    times_ns = [message.log_time_ns for message in messages(DRIVE)]
    assert (span["from_s"], span["to_s"]) == (min(times_ns) / 1e9, max(times_ns) / 1e9)
    assert [one["goal"] for one in span["goals"]] == ["toilet"]
    assert [one["number"] for one in span["decisions"]] == list(range(1, 9))
    assert feed.welcome()["mode"] == "replay"
    assert feed.welcome()["can"] == {"teleop": False, "command": False, "camera": True}
    assert audience.wait("at", lambda told: True)["speed"] == 0.0


def test_a_moment_is_shown_as_it_was(feed: ReplayFeed, audience: PageAudience):
    span = audience.wait("span", lambda told: True)
    when_s = span["to_s"] - 5.0
    feed.steer(1, {"kind": "seek", "t_s": when_s})
    state = audience.wait("state", at_s(when_s))
    assert state["goal"]["text"] == "toilet"
    assert state["goal"]["mode"] == "target"
    before = [d for d in span["decisions"] if d["t_s"] <= when_s]
    decision = audience.wait("decision", like(number=before[-1]["number"]))
    assert decision["votes"]
    assert any("Rule:" in line for line in decision["full"])
    scene = audience.wait("scene", lambda told: len(told["things"]) > 3)
    assert "toilet" in [one["name"] for one in scene["things"] if one["goal"]]
    assert len(scene["path"]) > 10
    assert feed.tiles.since(TilesHeld()) is not None
    assert struct.unpack_from("<BB", audience.pictures[-1]) == (2, 1)


def test_going_back_shows_the_map_that_there_was_then(feed: ReplayFeed, audience: PageAudience):
    span = audience.wait("span", lambda told: True)

    def known(t_s: float) -> int:
        feed.steer(1, {"kind": "seek", "t_s": t_s})
        audience.wait("at", at_s(t_s))
        message, _ = feed.tiles.since(TilesHeld()) or (b"", TilesHeld())
        return len(message)

    early = known(span["decisions"][0]["t_s"])
    late = known(span["to_s"])
    assert early < late
    assert known(span["decisions"][0]["t_s"]) < late
    nothing = struct.Struct("<BBHIfddH").size + len(zlib.compress(b"", 1))
    assert known(span["from_s"]) == nothing
    assert audience.newest["decision"]["number"] == 0
    assert known(span["decisions"][0]["t_s"]) == early
    assert audience.newest["decision"]["number"] == 1


def test_it_plays_as_fast_as_it_is_asked_to_and_stops_at_the_end(
    feed: ReplayFeed, audience: PageAudience
):
    span = audience.wait("span", lambda told: True)
    feed.steer(1, {"kind": "seek", "t_s": span["to_s"] - 4.0})
    feed.steer(1, {"kind": "play", "speed": 8})
    audience.wait("at", lambda told: told["speed"] == 8)
    end = audience.wait("at", lambda told: told["speed"] == 0 and told["t_s"] > span["to_s"] - 1)
    assert audience.wait("state", lambda told: told["goal"] is None)["last"]["result"] == "found"
    assert audience.count["state"] < 100
    assert at_s(span["to_s"])(end)


def test_nothing_is_asked_of_a_recording(feed: ReplayFeed):
    for what in ("goal", "stop", "zones", "why"):
        with pytest.raises(ValueError, match="this is a recording"):
            feed.ask(what, {})
    assert feed.ask("decision", {"number": 2})["number"] == 2
    for number in (0, 11, "2", None):
        with pytest.raises(ValueError, match="there is none"):
            feed.ask("decision", {"number": number})


def test_nonsense_does_not_move_the_playhead_out_of_the_recording(
    feed: ReplayFeed, audience: PageAudience
):
    span = audience.wait("span", lambda told: True)
    for wrong in ({"t_s": -1e18}, {"t_s": "x"}, {}):
        feed.steer(1, {"kind": "seek", **wrong})
        audience.wait("at", at_s(span["from_s"]))
    feed.steer(1, {"kind": "seek", "t_s": 1e305})
    audience.wait("at", at_s(span["to_s"]))
    feed.steer(1, {"kind": "play", "speed": -3})
    feed.steer(1, {"kind": "teleop", "v": 1.0})
    feed.steer(1, {})


def test_a_file_that_is_no_recording_is_told_in_a_line(tmp_path: Path):
    with pytest.raises(RecordingError, match="not a recording"):
        ReplayFeed(Path(__file__), read_budgets())
    McapFile(tmp_path / "empty.mcap", {}).close()
    with pytest.raises(RecordingError, match="nothing was recorded"):
        ReplayFeed(tmp_path / "empty.mcap", read_budgets())


def test_one_that_was_cut_off_is_shown_as_far_as_it_goes(tmp_path: Path, audience: PageAudience):
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(DRIVE.read_bytes()[: DRIVE.stat().st_size // 2])
    feed = ReplayFeed(cut, read_budgets())
    feed.start(audience)
    feed.attend(1, 0)
    span = audience.wait("span", lambda told: True)
    assert span["cut"]
    feed.steer(1, {"kind": "seek", "t_s": span["to_s"]})
    audience.wait("at", at_s(span["to_s"]))
    feed.close()
