"""What the service knows of the home, as a picture."""

import numpy as np
import pytest
from lived_in import lived_in

from runtime.commands.map_picture import picture
from runtime.commands.map_sheet import KEY, KEY_PX, LARGEST_PX, Sheet, bgr
from runtime.core.types import Frontier
from runtime.errors import SensorError
from runtime.map_look import room_tint
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
    assert at(told, image, 5.0 + 2.05, 0.0) == KEY["obstacle"]
    assert at(told, image, 5.0 + 1.0, 0.4) == bgr(room_tint("kitchen"))
    assert tuple(image[2, 2]) == KEY["unknown"]
    assert at(told, image, 4.5, -0.5) == KEY["driven"]
    assert all(has(image, KEY[name]) for name in ("taken", "frontier", "robot", "sought"))


def test_a_thing_that_is_not_sought_has_another_colour(told: dict):
    image = picture({**told, "goal": "sofa"}, told["things"])
    assert has(image, KEY["thing"])
    assert not has(image, KEY["sought"])


def test_zones_and_places_are_drawn(told: dict):
    zone = {"name": "rug", "polygon": [[4.0, -0.8], [4.6, -0.8], [4.6, -0.2]]}
    image = picture(told, [], [zone], {"dock": [5.5, 0.5, 0.0], "sofa": None})
    assert has(image, KEY["zone"])
    assert has(image, KEY["place"])
    assert not has(picture(told, []), KEY["zone"])


def test_words_do_not_cover_each_other_and_nothing_is_without_a_name(
    told: dict, monkeypatch: pytest.MonkeyPatch
):
    boxes: list[object] = []
    monkeypatch.setattr(Sheet, "box", lambda sheet, *what: boxes.append(what))
    things = [{**told["things"][0], "name": f"box {n}", "id": n} for n in range(40)]
    crowded = picture({**told, "goal": "bed"}, things)
    named = len(boxes)
    assert 4 < named < 40  # so many names have room round one point
    few = picture({**told, "goal": "bed"}, things[:named])
    assert (crowded == few).all()


def test_what_is_not_sure_is_not_drawn(told: dict):
    thing = {**told["things"][0], "confidence": 0.3}
    assert not has(picture({**told, "goal": "sofa"}, [thing]), KEY["thing"])
    assert has(picture({**told, "goal": thing["name"]}, [thing]), KEY["sought"])


def test_ids_of_frontiers_stand_on_a_dot_of_theirs(told: dict, monkeypatch: pytest.MonkeyPatch):
    sheets: list[Sheet] = []
    real = Sheet.finished
    monkeypatch.setattr(Sheet, "finished", lambda sheet: (sheets.append(sheet), real(sheet))[1])
    picture(told, [])
    (sheet,) = sheets
    for frontier in told["frontiers"]:
        (label,) = [label for label in sheet.labels if label.text == str(frontier["id"])]
        left, top, right, bottom = label.box
        dots = [sheet.at(xy) for xy in frontier["cells_xy"]]
        assert any(left <= x <= right and top <= y <= bottom for x, y in dots)


def test_the_name_of_a_room_keeps_off_other_words(told: dict, monkeypatch: pytest.MonkeyPatch):
    sheets: list[Sheet] = []
    real = Sheet.finished
    monkeypatch.setattr(Sheet, "finished", lambda sheet: (sheets.append(sheet), real(sheet))[1])
    picture(told, told["things"])
    words = {label.text: label.box for label in sheets[0].labels}
    x0, y0, x1, y1 = words.pop("kitchen")
    assert all(x1 < a or c < x0 or y1 < b or d < y0 for a, b, c, d in words.values())


@pytest.mark.parametrize(
    ("changed", "said"),
    [({"rows": 100_000, "cols": 100_000}, "no map to draw"), ({"rows": 7}, "cells in place of")],
)
def test_an_answer_that_is_no_map_is_told(told: dict, changed: dict, said: str):
    with pytest.raises(SensorError, match=said):
        picture({**told, **changed}, [])
    with pytest.raises(SensorError, match="0 x 0"):
        picture(nothing_told("map", "", "odom"), [])
