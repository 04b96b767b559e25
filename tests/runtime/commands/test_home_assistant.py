"""What a robot is to Home Assistant."""

import json

import pytest

from runtime.commands.home_assistant import GOAL_CHARS, Topics, Wished, vacuum_state, wish
from runtime.errors import ConfigError, SensorError

ROSIE = Topics("rosie")
STATUS = {
    "runtime": {"state": "searching", "cause": ""}, "goal": "mug", "id": "a1", "paused": "",
    "does": "drive to frontier 7", "decisions": 3, "queue": [{"id": "b2"}], "refuses": "",
    "base": {"battery_percent": 79.6},
    "last": {"result": "found", "sentence": '"bed" was found at (1.0, 2.0)', "at_xy": [1.0, 2.0],
             "goal": "bed", "id": "9f", "elapsed_s": 50.0, "driven_m": 9.0, "usd": 0.0},
}  # fmt: skip


def test_it_is_discovered_as_a_vacuum_cleaner_with_a_goal_and_what_it_found():
    told = {topic: json.loads(text) for topic, text in ROSIE.discoveries().items()}
    assert set(told) == {
        f"homeassistant/{kind}/rfnav_rosie/{name}/config"
        for kind, name in (
            ("vacuum", "robot"), ("text", "goal"), ("sensor", "last"), ("sensor", "battery"),
        )
    }  # fmt: skip
    assert len({entity["unique_id"] for entity in told.values()}) == 4
    assert {entity["availability_topic"] for entity in told.values()} == {
        "rfnav/rosie/availability"
    }
    heard = {value for entity in told.values() for key, value in entity.items()
             if key.endswith("command_topic")}  # fmt: skip
    assert heard | {"homeassistant/status"} == set(ROSIE.heard)
    said = {value for entity in told.values() for key, value in entity.items()
            if key in ("state_topic", "json_attributes_topic", "availability_topic")}  # fmt: skip
    assert said == set(ROSIE.states(STATUS, "", "mug", ""))


def test_how_it_stands_is_told():
    told = ROSIE.states(STATUS, "", "cup", "cup: known as cup")
    assert json.loads(told["rfnav/rosie/state"]) == {"state": "cleaning"}
    about = json.loads(told["rfnav/rosie/attributes"])
    assert (about["goal"], about["does"], about["waiting"]) == ("mug", "drive to frontier 7", 1)
    assert about["said"] == "cup: known as cup"
    assert told["rfnav/rosie/goal"] == "cup"
    assert told["rfnav/rosie/battery"] == "80"
    assert told["rfnav/rosie/last"] == '"bed" was found at (1.0, 2.0)'
    assert json.loads(told["rfnav/rosie/last/attributes"])["at_xy"] == [1.0, 2.0]


def test_what_is_not_known_is_none_and_a_long_sentence_is_cut():
    told = ROSIE.states({"last": {"sentence": "x" * 400}}, "", "", "")
    assert told["rfnav/rosie/battery"] == "None"
    assert len(told["rfnav/rosie/last"]) == 255
    assert ROSIE.states({}, "", "", "")["rfnav/rosie/last"] == "nothing yet"


@pytest.mark.parametrize(
    ("status", "state"),
    [
        ({"runtime": {"state": "ready"}}, "idle"),
        ({"runtime": {"state": "held"}, "goal": "mug"}, "cleaning"),
        ({"runtime": {"state": "paused"}, "goal": "mug", "paused": "rfnav/pause"}, "paused"),
        ({"runtime": {"state": "stopped"}, "goal": "mug"}, "error"),
        ({"runtime": {"state": "fault"}}, "error"),
        ({"runtime": {"state": "searching"}, "goal": "go to dock", "id": "home"}, "returning"),
        ({"runtime": {"state": "searching"}, "goal": "mug", "mode": "return"}, "returning"),
        ({}, "idle"),
    ],
)
def test_it_is_in_one_of_a_vacuum_cleaners_states(status: dict, state: str):
    assert vacuum_state(status, "home") == state


@pytest.mark.parametrize(
    ("topic", "payload", "asked"),
    [
        ("command", b"start", Wished("start")),
        ("command", b"pause", Wished("pause")),
        ("command", b"stop", Wished("stop")),
        ("command", b"return_to_base", Wished("return")),
        ("goal/set", b" a  red mug ", Wished("kept", "a red mug")),
        ("send", b'{"command": "find", "goal": "bed"}', Wished("found", "bed")),
        ("send", b"find coffee table", Wished("found", "coffee table")),
    ],
)
def test_what_is_wished_is_read(topic: str, payload: bytes, asked: Wished):
    assert wish(ROSIE, ROSIE.of(topic), payload) == asked


def test_home_assistant_that_begins_anew_is_told_again():
    assert wish(ROSIE, "homeassistant/status", b"online") == Wished("again")
    assert wish(ROSIE, "homeassistant/status", b"offline") == Wished("nothing")


@pytest.mark.parametrize(
    ("topic", "payload", "said"),
    [
        ("command", b"clean_spot", "know start, pause, stop, return_to_base"),
        ("command", b"\x1b[2J", "' \\[2J'"),
        ("command", b"\xff\xfe", "is no text"),
        ("command", b"s" * 2000, "2000 bytes: at most 1024"),
        ("goal/set", b"", "1 to 80 printable"),
        ("goal/set", b"m" * (GOAL_CHARS + 1), "1 to 80 printable"),
        ("goal/set", b"a\x00b", "1 to 80 printable"),
        ("send", b"drive 1.0", "send"),
        ("send", b'{"command": "find"}', "send"),
        ("send", b'{"command": "find", "goal": 3}', "send"),
        ("send", b"{" * 300, "nested deeper"),
        ("send", b"{no", "not JSON"),
    ],
)
def test_nonsense_is_refused_in_a_line(topic: str, payload: bytes, said: str):
    with pytest.raises(SensorError, match=said) as error:
        wish(ROSIE, ROSIE.of(topic), payload)
    assert str(error.value).isprintable()


@pytest.mark.parametrize("name", ["", "a/b", "+", "#", "x" * 41])
def test_a_name_that_is_part_of_no_topic_is_refused(name: str):
    with pytest.raises(ConfigError, match="--id"):
        Topics(name)
    with pytest.raises(ConfigError, match="--discovery"):
        Topics("rosie", "home assistant")
