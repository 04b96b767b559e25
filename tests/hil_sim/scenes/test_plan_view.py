"""A plan from above: names can be read, and stand where they belong."""

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest
from matplotlib.path import Path as Outline

from hil_sim.scenes.format import Scene
from hil_sim.scenes.furniture.boxes import box_of
from hil_sim.scenes.open import open_scene
from hil_sim.scenes.plan_view import NAMED_M, PIXELS_PER_M, plan_bounds, plan_image

Written = list[tuple[str, tuple[float, float]]]


@pytest.fixture
def written(monkeypatch: pytest.MonkeyPatch) -> Written:
    """Each word, and where its middle is, px."""
    words: Written = []
    real = cv2.putText

    def put(image: np.ndarray, text: str, at: tuple[int, int], font: int, scale: float,
            *how: Any) -> Any:  # fmt: skip
        (wide, high), _ = cv2.getTextSize(text, font, scale, 1)
        words.append((text, (at[0] + wide / 2, at[1] - high / 2)))
        return real(image, text, at, font, scale, *how)

    monkeypatch.setattr(cv2, "putText", put)
    return words


def in_m(scene: Scene, at: tuple[float, float]) -> tuple[float, float]:
    low, high = plan_bounds(scene)
    top = int((high[1] - low[1]) * PIXELS_PER_M)
    return low[0] + at[0] / PIXELS_PER_M, low[1] + (top - at[1]) / PIXELS_PER_M


@pytest.mark.parametrize("name", ["cedar", "maple", "val-4"])
def test_the_name_of_a_room_stands_in_it_and_on_no_thing(name: str, written: Written) -> None:
    scene = open_scene(name)
    plan_image(scene)
    rooms = {room.name: Outline(room.polygon) for room in scene.rooms}
    named = {word: in_m(scene, at) for word, at in written if word in rooms}
    assert named.keys() == rooms.keys()
    things = [Outline(box_of(obj).corners()) for obj in scene.objects]
    for word, middle in named.items():
        assert rooms[word].contains_point(middle), word
        assert not any(thing.contains_point(middle) for thing in things), word


def test_small_things_have_no_name(written: Written) -> None:
    scene = open_scene("cedar")
    one = scene.objects[0]
    alone = replace(scene, objects=(replace(one, size_m=(NAMED_M - 0.1, 0.2, 0.3)),))
    plan_image(alone)
    rooms = {room.name for room in scene.rooms}
    assert {word for word, _ in written} == rooms
    plan_image(replace(scene, objects=(replace(one, size_m=(NAMED_M + 0.1, 0.2, 0.3)),)))
    assert {word for word, _ in written} - rooms == {one.category}
