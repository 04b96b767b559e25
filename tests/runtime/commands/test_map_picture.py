"""What the service knows of the home, as a picture."""

import numpy as np
import pytest
from lived_in import lived_in

from runtime.commands.map_picture import (
    DRIVEN,
    ELECTED,
    FRONTIER,
    GOAL,
    KEY_PX,
    LARGEST_PX,
    OBSTACLE,
    PLACE,
    ROBOT,
    THING,
    TINTS,
    UNKNOWN,
    ZONE,
    picture,
)
from runtime.core.types import Frontier
from runtime.errors import SensorError
from runtime.service.atlas import atlas_of, nothing_told


@pytest.fixture
def told() -> dict:
    """Of a robot that has driven a metre, in odometry that began elsewhere."""
    world = lived_in()
    world.body.visited_xy = [(-1.0, -0.5), (0.0, -0.5)]
    cells = np.array([[-1.9, 0.1 * n] for n in range(5)])
    other = np.array([[-1.9, -0.9 + 0.1 * n] for n in range(3)])
    world.frontiers = Frontier(3, cells, (-1.9, 0.2), 2.0), Frontier(4, other, (-1.9, -0.8), 2.0)
    atlas = atlas_of(world, (), "odom", (5.0, 0.0))
    return {**atlas.told("map"), "elected": 3, "things": atlas.told("things")["things"]}


def at(told: dict, image: np.ndarray, x: float, y: float) -> tuple[int, int, int]:
    """The pixel of a place, m in odometry's frame."""
    cell_px = image.shape[1] // told["cols"]
    x0, y0 = told["origin_xy"]
    scale = cell_px / told["resolution_m"]
    low = image.shape[0] - KEY_PX
    row, col = low - 1 - int((y - y0) * scale), int((x - x0) * scale)
    return tuple(int(v) for v in image[row, col])


def has(image: np.ndarray, colour: tuple[int, int, int]) -> bool:
    return bool((image[:-KEY_PX] == colour).all(axis=2).any())


def test_each_part_has_its_colour_and_lies_where_it_is(told: dict):
    image = picture(told, told["things"])
    assert image.shape[:2] == (told["rows"] * LARGEST_PX + KEY_PX, told["cols"] * LARGEST_PX)
    assert at(told, image, 5.0 + 2.05, 0.0) == OBSTACLE
    assert at(told, image, 5.0 + 1.0, 0.4) == TINTS[0]
    assert tuple(image[2, 2]) == UNKNOWN
    assert at(told, image, 4.5, -0.5) == DRIVEN
    assert all(has(image, colour) for colour in (ELECTED, FRONTIER, ROBOT, GOAL))


def test_a_thing_that_is_not_sought_has_another_colour(told: dict):
    image = picture({**told, "goal": "sofa"}, told["things"])
    assert has(image, THING)
    assert not has(image, GOAL)


def test_zones_and_places_are_drawn(told: dict):
    zone = {"name": "rug", "polygon": [[4.0, -0.8], [4.6, -0.8], [4.6, -0.2]]}
    image = picture(told, [], [zone], {"dock": [5.5, 0.5, 0.0], "sofa": None})
    assert has(image, ZONE)
    assert has(image, PLACE)
    assert not has(picture(told, []), ZONE)


def test_words_do_not_cover_each_other(told: dict):
    things = [{**told["things"][0], "name": f"box {n}", "id": n} for n in range(40)]
    crowded = picture({**told, "goal": "bed"}, things)
    few = picture({**told, "goal": "bed"}, things[:4])
    assert (crowded == few).mean() > 0.999  # there is room for four round one point


@pytest.mark.parametrize(
    ("changed", "said"),
    [({"rows": 100_000, "cols": 100_000}, "no map to draw"), ({"rows": 7}, "cells in place of")],
)
def test_an_answer_that_is_no_map_is_told(told: dict, changed: dict, said: str):
    with pytest.raises(SensorError, match=said):
        picture({**told, **changed}, [])
    with pytest.raises(SensorError, match="0 x 0"):
        picture(nothing_told("map", "", "odom"), [])
