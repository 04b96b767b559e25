"""Counting what stands in rooms and near what, for the experts."""

import json

import pytest

from hil_sim.importers import standing_counts
from hil_sim.importers.standing_counts import HomeCounts, generated_homes
from hil_sim.scenes.format import ROOM_TYPES, Door, Room, Scene, SceneObject, Wall
from hil_sim.scenes.robothor.metadata import metadata_path
from models.words.counts import PATH

SIZE = (0.5, 0.5, 0.5)


def stands(category: str, x: float, y: float) -> SceneObject:
    return SceneObject(f"{category} at {x}", category, "box", (x, y, 0.0), size_m=SIZE)


def home(*objects: SceneObject) -> Scene:
    """A kitchen of 6 m by 4 m and a bathroom of 3 m by 4 m, a door between them."""
    return Scene(
        "two rooms",
        (Wall((6.0, 0.0), (6.0, 4.0)),),
        (Door((6.0, 1.0), (6.0, 2.0)),),
        (
            Room("kitchen", "kitchen", ((0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0))),
            Room("bathroom", "bathroom", ((6.0, 0.0), (9.0, 0.0), (9.0, 4.0), (6.0, 4.0))),
        ),
        objects,
    )


def test_rooms_things_and_doors_are_counted() -> None:
    one = home(stands("stove", 1, 1), stands("sink", 2, 1), stands("sink", 8, 1))
    counts = generated_homes([one, home()])
    assert counts.rooms == {"kitchen": 2, "bathroom": 2}
    assert counts.things == {"stove": 1, "sink": 2}
    assert counts.holding == {
        ("stove", "kitchen"): 1, ("sink", "kitchen"): 1, ("sink", "bathroom"): 1,
    }  # fmt: skip
    assert counts.doors == {("kitchen", "bathroom"): 2, ("bathroom", "kitchen"): 2}


def test_near_is_within_reach_and_in_the_same_room() -> None:
    counts = generated_homes([home(
        stands("stove", 1, 1), stands("table", 3.9, 1), stands("chair", 5.6, 1),
        stands("toilet", 6.4, 1),
    )])  # fmt: skip
    assert counts.beside == {
        ("stove", "table"): 1, ("table", "stove"): 1, ("table", "chair"): 1, ("chair", "table"): 1,
    }  # fmt: skip


def test_several_of_a_kind_near_count_once() -> None:
    counts = HomeCounts()
    rect = (0.0, 0.0, 1.0, 1.0)
    counts.add_room("kitchen", [("table", rect), ("chair", rect), ("chair", rect)])
    assert counts.beside["table", "chair"] == 1
    assert counts.beside["chair", "chair"] == 2
    assert counts.holding["chair", "kitchen"] == 1


def test_what_no_goal_names_is_not_counted() -> None:
    assert not generated_homes([home(stands("other", 1, 1))]).things


def test_rows_and_columns_are_in_order() -> None:
    counts = generated_homes([home(stands("stove", 1, 1), stands("sink", 2, 1))])
    packed = counts.packed(["sink", "stove"])
    assert packed["beside"] == [[0, 1], [1, 0]]
    assert packed["holding"][0][ROOM_TYPES.index("kitchen")] == 1
    assert packed["rooms"][ROOM_TYPES.index("bathroom")] == 1


@pytest.mark.slow
def test_the_committed_table_is_what_the_public_rooms_say() -> None:
    if not metadata_path().is_file():
        pytest.skip("hil-sim assets pull")
    table = json.loads(PATH.read_text(encoding="utf-8"))
    assert table["counts"]["public"] == standing_counts.public_rooms().packed(table["names"])
