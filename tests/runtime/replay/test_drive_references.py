"""The main regression test of both loops: two recorded drives, made by `scripts/references`, come
out again to the last bit. Where a change of the loop is meant to change what it does, they are
recorded anew, in a commit of their own."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner
from places import ROOT, TESTS

from runtime.__main__ import cli
from runtime.recording.reader import Recorded, messages
from runtime.recording.schemas import JSON_SCHEMAS
from runtime.robot import wire

LOOPS = ("lockstep", "realtime")
SIZE_MB = 9.0  # of both together
LAYOUT = ROOT / "deploy/foxglove/rf-nav.json"


def recording(loop: str) -> Path:
    return TESTS / "refs" / f"{loop}.mcap"


@pytest.mark.parametrize("loop", LOOPS)
def test_a_recorded_drive_comes_out_again(loop: str):
    done = CliRunner().invoke(cli, ["replay", str(recording(loop)), "--diff"])
    expected = recording(loop).with_suffix(".txt").read_text(encoding="utf-8")
    assert done.output == expected
    assert done.exit_code == 0
    assert "ended by found" in expected


def test_they_are_small():
    assert sum(recording(loop).stat().st_size for loop in LOOPS) <= SIZE_MB * 1e6


@pytest.fixture(scope="module")
def recorded() -> dict[str, list[Recorded]]:
    found: dict[str, list[Recorded]] = {}
    for message in messages(recording("realtime")):
        found.setdefault(message.topic, []).append(message)
    return found


def test_what_is_ours_is_as_its_schema_says(recorded: dict[str, list[Recorded]]):

    ours = [m for found in recorded.values() for m in found if m.schema in JSON_SCHEMAS]
    assert {m.schema for m in ours} >= {f"rfnav.{n}" for n in ("Tick", "Ballot", "Decision")}
    judges = {name: jsonschema.Draft202012Validator(JSON_SCHEMAS[name]) for name in JSON_SCHEMAS}
    for message in ours:
        judges[message.schema].validate(json.loads(message.payload))


def test_every_topic_and_field_of_the_layout_is_in_a_recording(
    recorded: dict[str, list[Recorded]],
):
    layout = json.loads(LAYOUT.read_text(encoding="utf-8"))
    named = set(_named(layout["configById"]))
    assert len(named) > 12
    for path in sorted(named):
        topic = max((t for t in recorded if f"{path}.".startswith(f"{t}.")), default="", key=len)
        assert topic, f"{path}: no such topic"
        fields = path.removeprefix(topic).split(".")[1:]
        assert any(_there(_value(m), fields) for m in recorded[topic]), f"{path}: no such field"
    panels = set(_panels(layout["layout"]))
    tabs = {t["layout"] for t in layout["configById"]["Tab!words"]["tabs"]}
    assert panels | tabs == set(layout["configById"])


def _named(config: Any) -> Iterator[str]:
    """What in a layout is a topic, or a path into one."""
    if isinstance(config, dict):
        for key, value in config.items():
            if key.startswith("/"):
                yield key
            yield from _named(value)
    elif isinstance(config, list):
        for value in config:
            yield from _named(value)
    elif isinstance(config, str) and config.startswith("/"):
        yield config


def _panels(layout: Any) -> Iterator[str]:
    if isinstance(layout, str):
        yield layout
    else:
        yield from _panels(layout["first"])
        yield from _panels(layout["second"])


def _value(message: Recorded) -> Any:
    if message.schema in JSON_SCHEMAS:
        return json.loads(message.payload)
    return wire.STORE.deserialize_cdr(message.payload, message.schema)


def _there(value: Any, fields: list[str]) -> bool:
    """Whether the path leads to something that can be shown."""
    for name in fields:
        value = value.get(name) if isinstance(value, dict) else getattr(value, name, None)
    return isinstance(value, bool | int | float | str | np.ndarray | dict) or bool(fields == [])
