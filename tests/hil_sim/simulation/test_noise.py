"""Noise by name, and the same random numbers for the same seed."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_sim.simulation.noise import NONE, USUAL, Noise, generator, parse_noise
from runtime.errors import ConfigError


def test_values_usual_values_and_lists() -> None:
    assert parse_noise(["depth=0.003", "edges"]) == Noise(depth=0.003, edges=USUAL.edges)
    assert parse_noise(["depth=0.003,edges"]) == Noise(depth=0.003, edges=USUAL.edges)
    assert parse_noise(["all", "drift=0"]) == Noise(**{**vars(USUAL), "drift": 0.0})
    assert parse_noise(["camera=kinect-v1", "flying=0.5"]) == Noise(flying=0.5, camera="kinect-v1")
    assert parse_noise(["none"], USUAL) == parse_noise([]) == NONE


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("dept=1", r"^noise dept: unknown; known: depth, edges, .*; e.g. depth=0.003$"),
        ("depth=lots", r"^noise depth: 'lots': must be a number from 0 to 10$"),
        ("edges=1.5", r"^noise edges: '1.5': must be a number from 0 to 1$"),
        ("slip=-1", r"^noise slip: '-1': must be"),
        ("drift=nan", r"^noise drift: 'nan': must be"),
        ("", r"^noise : unknown"),
        ("flying", r"^noise flying: '': must be a number from 0 to 1$"),
        ("camera", r"^noise camera: no name: known: kinect-v1, realsense-d435, azure-kinect$"),
        ("camera=d435", r"^noise camera: d435: known: kinect-v1, "),
    ],
)
def test_what_is_wrong_is_said_in_one_line(text: str, says: str) -> None:
    with pytest.raises(ConfigError, match=says):
        parse_noise([text])


@given(st.text(max_size=30))
def test_nothing_but_a_config_error_leaves_the_parser(text: str) -> None:
    try:
        found = parse_noise([text])
    except ConfigError:
        return
    assert isinstance(found, Noise)


def test_streams_are_apart_and_repeat() -> None:
    first = generator(1, "e", 3, "camera").random(4).tolist()
    assert generator(1, "e", 3, "camera").random(4).tolist() == first
    others = [(2, "e", 3, "camera"), (1, "f", 3, "camera"), (1, "e", 4, "camera"), (1, "e", 3, "b")]
    for other in others:
        assert generator(*other).random(4).tolist() != first
