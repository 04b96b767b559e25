"""Which storey of a drawing is taken."""

import pytest
from drawn import room, tag, wall, xml

from hil_sim.scenes.sweethome.drawing import read_drawing
from hil_sim.scenes.sweethome.storey import Storey, pick_storey


def level(name: str, elevation: float) -> str:
    return tag("level", id=name, name=name, elevation=elevation, floorThickness=12, height=250)


def picked(*parts: str, name: str | None = None) -> tuple[Storey, list[str]]:
    notes: list[str] = []
    return pick_storey(read_drawing(xml(*parts), "home"), name, "home", notes), notes


PLINTH = level("Plinth", 0) + wall(0, 0, 600, 0, level="Plinth")
HOME = level("Home", 132) + wall(0, 0, 500, 0, level="Home")
KITCHEN = room("Kitchen", 0, 0, 600, 400, level="Home")


def test_the_storey_with_rooms_is_taken() -> None:
    storey, notes = picked(PLINTH, HOME, KITCHEN)
    assert [r.name for r in storey.rooms] == ["Kitchen"]
    assert "level 'Home' is imported; others are not: Plinth (see --level)" in notes


def test_of_storeys_with_rooms_that_nearest_the_ground() -> None:
    attic = level("Attic", 400) + wall(0, 0, 400, 0, level="Attic")
    storey, _ = picked(attic, PLINTH, HOME, KITCHEN, room("Study", 0, 0, 9, 9, level="Attic"))
    assert [w.level for w in storey.walls] == ["Home"]


@pytest.mark.parametrize("name", ["Garden", "Driveway"])
def test_a_storey_with_only_a_garden_has_no_rooms(name: str) -> None:
    outside = room(name, 0, 0, 2000, 2000, level="Plinth")
    storey, _ = picked(PLINTH, HOME, KITCHEN, outside)
    assert [w.level for w in storey.walls] == ["Home"]


def test_where_no_storey_has_rooms_the_ground_is_taken() -> None:
    storey, _ = picked(HOME, PLINTH)
    assert [w.level for w in storey.walls] == ["Plinth"]


def test_rooms_on_another_level_of_the_same_height_count() -> None:
    beside = level("Rooms", 132) + room("Kitchen", 0, 0, 600, 400, level="Rooms")
    storey, _ = picked(PLINTH, HOME, beside)
    assert ([w.level for w in storey.walls], len(storey.rooms)) == (["Home"], 1)


def test_who_names_a_storey_gets_it() -> None:
    storey, _ = picked(PLINTH, HOME, KITCHEN, name="Plinth")
    assert (len(storey.walls), storey.rooms) == (1, ())
