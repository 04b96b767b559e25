"""`rfnav understand`."""

import json
from pathlib import Path

from click.testing import CliRunner, Result

from runtime.perception.understand_command import understand_command


def asked(*arguments: str) -> Result:
    return CliRunner().invoke(understand_command, arguments, catch_exceptions=False)


def test_it_says_what_is_looked_for_and_why() -> None:
    done = asked("the red mug on the kitchen table")
    assert done.exit_code == 0
    assert "looked for is mug, known as mug" in done.output
    assert "first near a table, in a kitchen, where that is mapped; not used: red" in done.output


def test_what_is_refused_says_what_could_be_asked_instead() -> None:
    done = asked("kitchen")
    assert done.exit_code == 1
    assert done.output == "goal: 'kitchen' is a place; name a thing in it, e.g. refrigerator\n"


def test_it_goes_by_the_robots_own_words(tmp_path: Path) -> None:
    own = tmp_path / "words.toml"
    own.write_text('objects = [["flux capacitor"]]\nrooms = ["garage"]\n')
    refused = asked("flux capacitor")
    assert refused.exit_code == 1
    assert "models.vocabulary" in refused.output
    done = asked("flux capacitor", "--set", f"models.vocabulary={str(own)!r}")
    assert done.exit_code == 0
    assert "known as flux capacitor" in done.output


def test_as_json() -> None:
    told = json.loads(asked("keys on the desk, please", "--json").output)
    assert told["name"] == "keys"
    assert told["own_class"] is True
    assert told["first"] == {"near": ["desk"], "rooms": []}
    assert told["not_used"]["near"] == []
    refused = asked("my wife", "--json")
    assert refused.exit_code == 1
    assert "a person" in json.loads(refused.output)["refused"]
