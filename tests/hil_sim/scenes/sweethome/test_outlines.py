"""Where rooms are, and the texts that say what they are."""

from drawn import ROOMS, WALLS, room, text, wall, xml

from hil_sim.scenes.sweethome.drawing import read_drawing
from hil_sim.scenes.sweethome.outlines import Outline, outlines
from hil_sim.scenes.sweethome.plan import straight
from hil_sim.scenes.sweethome.storey import pick_storey

UNNAMED = room("", 5, 5, 395, 395) + room(" ", 405, 5, 795, 395)


def found(*parts: str) -> tuple[list[Outline], list[str]]:
    notes: list[str] = []
    storey = pick_storey(read_drawing(xml(*parts), "home"), None, "home", notes)
    walls = [side.wall for drawn in storey.walls for side in straight(drawn)]
    return outlines(storey, walls, notes), notes


def test_the_first_text_that_tells_names_an_unnamed_room() -> None:
    texts = (text("3.90 m", 200, 100), text("Master\nbath", 200, 200), text("WC", 200, 300))
    (left, right), _ = found(WALLS, UNNAMED, *texts)
    assert (left.name, left.texts) == ("Master bath", ("Master bath", "WC"))
    assert (right.name, right.texts) == ("", ())


def test_a_name_that_tells_is_believed_and_another_kept() -> None:
    (left, right), _ = found(
        WALLS, room("Kitchen", 5, 5, 395, 395), room("B 12", 405, 5, 795, 395),
        text("Bedroom", 200, 200), text("Bedroom", 600, 200),
    )  # fmt: skip
    assert (left.name, left.texts) == ("Kitchen", ())
    assert (right.name, right.texts) == ("B 12", ("Bedroom",))


def test_a_text_is_the_smallest_room_s_that_it_stands_in() -> None:
    whole = room("", 5, 5, 795, 395)
    (around, small), _ = found(WALLS, whole, room("", 405, 5, 795, 395), text("Bath", 600, 200))
    assert (around.texts, small.texts) == ((), ("Bath",))


def test_texts_name_rooms_that_were_made_from_the_walls() -> None:
    made, _ = found(WALLS, text("Bedroom", 600, 200), text("Kitchen", 200, 200))
    assert sorted(outline.name for outline in made) == ["Bedroom", "Kitchen"]


def test_a_text_on_another_level_or_outside_says_nothing() -> None:
    rooms, _ = found(WALLS, UNNAMED, text("Kitchen", 200, 200, level="up"), text("Bath", 200, 500))
    assert [outline.name for outline in rooms] == ["Kitchen", ""]  # no levels are drawn
    levels = "".join(f'<level id="{i}" name="{i}" elevation="{z}" height="250"/>' for i, z in
                     (("down", 0), ("up", 260)))  # fmt: skip
    here = (WALLS + UNNAMED).replace("<wall ", '<wall level="down" ').replace(
        "<room ", '<room level="down" ')  # fmt: skip
    rooms, _ = found(levels, here, text("Kitchen", 200, 200, level="up"))
    assert [outline.name for outline in rooms] == ["", ""]


def test_what_a_text_calls_a_terrace_is_left_out() -> None:
    rooms, notes = found(WALLS, ROOMS, room("", 0, 405, 795, 700), text("Terrace", 400, 500))
    assert [outline.name for outline in rooms] == ["Kitchen", "Bedroom"]
    assert (
        "room[2] (unnamed): left out: the text 'Terrace' in it says that it lies outdoors" in notes
    )
    rooms, _ = found(WALLS, UNNAMED, text("Balcony", 200, 100), text("Kitchen", 200, 200))
    assert rooms[0].texts == ("Kitchen", "Balcony")  # a kitchen with a balcony


def test_a_terrace_s_text_leaves_the_room_around_all_walls() -> None:
    (whole,), _ = found(wall(0, 0, 500, 0), wall(0, 0, 0, 400), text("Terrace", 100, 100))
    assert (whole.texts, whole.room) == ((), None)
