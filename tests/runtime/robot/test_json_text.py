"""JSON from outside is bounded before it is parsed."""

import json
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.errors import SensorError
from runtime.robot.json_text import DEPTH, MESSAGE_BYTES, parse_json

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**60), 2**60) | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=4), inner),
    max_leaves=12,
)


@given(st.dictionaries(st.text(max_size=8), VALUES, max_size=4))
def test_an_object_comes_back(value: dict):
    assert parse_json(json.dumps(value), "goal") == value
    assert parse_json(json.dumps(value, ensure_ascii=False).encode(), "goal") == value


@given(st.binary(max_size=60))
def test_bytes_raise_nothing_but_sensor_errors(text: bytes):
    with suppress(SensorError):
        parse_json(text, "goal")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (b'{"goal":"bed","episode":' + b"[" * 900 + b"]" * 900 + b"}", "nested deeper than 32"),
        (b'{"a":' * 100_000 + b"1" + b"}" * 100_000, "at most 262144"),
        (b'{"a":' * 40_000, "nested deeper than 32"),
        (b'{"a":' + b"9" * 5000 + b"}", "a whole number of 5000 digits"),
        (b'{"a":1e999}', "1e999 is no finite number"),
        (b'{"a":NaN}', "NaN is no finite number"),
        (b'{"a":-Infinity}', "-Infinity is no finite number"),
        ('{"goal":"bed"}'.encode("utf-16"), "not JSON"),
        (b"[]", "JSON list: send a JSON object"),
        (b"null", "JSON NoneType: send a JSON object"),
        (b"", "not JSON"),
        (b'"' + b"\\" * 1000, "not JSON"),
    ],
)
def test_what_is_refused_says_why_in_a_line(text: bytes, told: str):
    with pytest.raises(SensorError) as caught:
        parse_json(text, "goal")
    assert str(caught.value).startswith("goal: ")
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 200


def test_as_deep_and_as_large_as_is_taken():
    deep = b'{"a":' * DEPTH + b"1" + b"}" * DEPTH
    assert parse_json(deep, "goal")
    brackets = json.dumps({"goal": "[{" * 1000 + '\\"[['})  # in a text they are letters
    assert parse_json(brackets, "goal")["goal"].startswith("[{")
    large = b'{"a":"' + b"x" * (MESSAGE_BYTES - 8) + b'"}'
    assert len(parse_json(large, "goal")["a"]) == MESSAGE_BYTES - 8
    with pytest.raises(SensorError, match=r"262145 bytes of JSON"):
        parse_json(large + b" ", "goal")
