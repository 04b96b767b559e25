"""One table of colours for the page and for pictures."""

import itertools
import re

import numpy as np
import pytest
from places import ROOT

from runtime.map_look import (
    COLOURS,
    LIGHTNESS,
    ROOM_HUES_DEG,
    SATURATION,
    STRENGTH,
    dots_from_middle,
    rgb,
    room_hue,
    room_tint,
)


@pytest.fixture
def bright() -> dict[str, str]:
    """The page's bright theme: `--map-` by name."""
    style = (ROOT / "runtime/view/page/look.css").read_text(encoding="utf-8")
    theme = style.split(":root {")[1].split("}")[0]
    return dict(re.findall(r"--map-([a-z-]+): ([^;]+);", theme))


def test_the_page_has_the_colours_of_the_table(bright: dict[str, str]):
    assert {name: bright[name] for name in COLOURS} == COLOURS
    assert bright["tint"] == f"{STRENGTH:.2f}"
    assert bright["tint-saturation"] == f"{100 * SATURATION:.0f}%"
    assert bright["tint-light"] == f"{100 * LIGHTNESS:.0f}%"


def test_types_of_room_can_be_told_apart():
    tints = [np.array(room_tint(name)) for name in ROOM_HUES_DEG]
    assert min(np.abs(a - b).max() for a, b in itertools.combinations(tints, 2)) >= 10
    assert all(tint.min() > 200 for tint in tints)  # what lies on them can be read


def test_a_type_that_is_not_in_the_table_has_a_colour_of_its_own():
    assert room_hue("sauna") == room_hue("sauna") != room_hue("garage")
    assert room_tint("sauna") != room_tint("garage")


def test_colours_are_read_as_numbers():
    assert rgb("goal") == (0x1A, 0x7F, 0x37)


def test_a_frontier_begins_at_the_dot_that_is_nearest_to_its_middle():
    bow = [[0.0, 0.0], [0.5, 1.0], [1.0, 1.2], [1.5, 1.0], [2.0, 0.0]]
    dots = dots_from_middle(bow)
    assert dots[0].tolist() == [1.0, 1.2] or dots[0].tolist() == [0.5, 1.0]
    assert sorted(dots.tolist()) == bow
    assert dots_from_middle([]).shape == (0, 2)
