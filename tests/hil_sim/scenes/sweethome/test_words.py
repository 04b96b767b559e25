"""Names in several languages -> categories and room types."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_sim.scenes.format import CATEGORIES, ROOM_TYPES
from hil_sim.scenes.sweethome.known_words import (
    ENDINGS,
    ETEKS,
    FAINT,
    FAINT_ROOMS,
    ROOMS,
    SHORT_ENDINGS,
    WORDS,
)
from hil_sim.scenes.sweethome.words import (
    category_of,
    is_outdoors,
    is_window,
    room_type,
    tells,
)


@pytest.mark.parametrize(
    ("catalog_id", "name", "category"),
    [
        ("eTeks#bed140x190", "Lit 140x190", "bed"),
        ("eTeks#toiletUnit", "whatever", "toilet"),
        ("eTeks#staircase", "Escalier", "other"),
        ("Blend Swap CC-0#couch", "", "sofa"),
        ("", "Kleiderschrank", "wardrobe"),
        ("", "Table de chevet", "nightstand"),
        ("", "Coffee table", "coffee table"),
        ("", "Bedside lamp", "lamp"),
        ("", "Table lamp", "lamp"),
        ("", "Lampe de table", "lamp"),
        ("", "TV stand", "cabinet"),
        ("", "Chest of drawers", "dresser"),
        ("", "Kühlschrank", "refrigerator"),
        ("", "Wooden chairs", "chair"),
        ("", "Washbasin with cabinet", "sink"),
        ("", "Baignoire", "bathtub"),
        ("", "Cama doble", "bed"),
        ("user#myFloorLamp", "Xyz", "lamp"),
        ("", "Einzelbett", "bed"),
        ("", "Küchenstühle", "chair"),
        ("", "Waschtisch", "sink"),
        ("", "Spaceship", "other"),
        ("", "Water", "toilet"),
        ("", "Water dispenser", "other"),
        ("", "Water bottle", "other"),
        ("", "Toilet brush", "other"),
        ("", "Toilet paper", "other"),
        ("", "Toilet roll holder", "other"),
        ("", "WC-Bürste", "other"),
        ("", "Brosse WC", "other"),
        ("", "Papier toilette", "other"),
        ("", "Porte-serviettes", "other"),
        ("", "Bath towel", "other"),
        ("", "Sink plunger", "other"),
        ("", "TV remote", "other"),
        ("", "Light switch", "other"),
        ("", "Wall light", "lamp"),
        ("", "Sofa light grey", "sofa"),
        ("", "Door mat", "other"),
        ("", "Wardrobe sliding doors", "wardrobe"),
        ("", "Bed frame", "bed"),
        ("", "Frame", "picture"),
        ("", "Four poster", "bed"),
        ("", "Four encastrable", "stove"),
        ("", "Four à micro-ondes", "microwave"),
        ("", "Turntable", "other"),
        ("", "Portable speaker", "other"),
        ("", "Sofa orange", "sofa"),
        ("", "Woven basket", "other"),
        ("", "Gartenbank", "other"),
        ("", "Bank 3-zits", "sofa"),
        ("", "Dining table set 4 chairs", "table"),
        ("", "2 seat sofa", "sofa"),
        ("", "Night table lamp", "lamp"),
        ("", "Dog bed", "other"),
        ("", "Tête de lit", "other"),
        ("", "Cadre de lit", "bed"),
        ("", "Set of 4 chairs", "chair"),
        ("", "Armoire à miroir", "wardrobe"),
        ("", "Bedside table2", "nightstand"),
        ("", "", "other"),
    ],
)
def test_a_piece_is_known_by_its_id_or_name(catalog_id: str, name: str, category: str) -> None:
    assert category_of(catalog_id, name) == category


@pytest.mark.parametrize(
    ("name", "inside", "kind", "how"),
    [
        ("Küche", [], "kitchen", "name"),
        ("Salle de bain", ["bed"], "bathroom", "name"),
        ("Salle à manger", [], "dining room", "name"),
        ("Bedroom 2", [], "bedroom", "name"),
        ("Schlafzimmer2", [], "bedroom", "name"),
        ("Living / Kitchen", [], "living room", "name"),
        ("Flur", [], "hallway", "name"),
        ("Elternschlafzimmer", [], "bedroom", "name"),
        ("Master", [], "bedroom", "name"),
        ("Master bath", [], "bathroom", "name"),
        ("Master closet", [], "hallway", "name"),
        ("Bath (master)", [], "bathroom", "name"),
        ("Hall bath", [], "bathroom", "name"),
        ("Bed 2 bath", [], "bathroom", "name"),
        ("Kid's bath", [], "bathroom", "name"),
        ("Elternbad", [], "bathroom", "name"),
        ("Bad Eltern", [], "bathroom", "name"),
        ("SDB", [], "bathroom", "name"),
        ("Sala de baño", [], "bathroom", "name"),
        ("Bagno camera", [], "bathroom", "name"),
        ("W/C", [], "bathroom", "name"),
        ("Pool bath", [], "bathroom", "name"),
        ("Bedroom with bath", [], "bedroom", "name"),
        ("Suite parentale", [], "bedroom", "name"),
        ("Suite parentale salle de bain", [], "bathroom", "name"),
        ("Study bedroom", [], "bedroom", "name"),
        ("Chambre bureau", [], "bedroom", "name"),
        ("Wohn- und Esszimmer", [], "dining room", "name"),
        ("Terrasse", ["bed"], "bedroom", "furniture"),
        ("", ["bed", "desk", "chair"], "bedroom", "furniture"),
        ("Room B", ["toilet", "sink"], "bathroom", "furniture"),
        ("Room C", ["vase"], "hallway", "guess"),
    ],
)
def test_a_room_is_known_by_its_name_or_furniture(
    name: str, inside: list[str], kind: str, how: str
) -> None:
    assert room_type(name, inside) == (kind, how)


@pytest.mark.parametrize(
    ("name", "outside"),
    [("Terrasse", True), ("Back garden", True), ("Garden bedroom", False), ("Bedroom", False)],
)
def test_a_room_is_outdoors_only_if_its_name_is_of_that(name: str, outside: bool) -> None:
    assert is_outdoors(name) == outside
    assert tells(name)
    assert not tells("12 m²")


def test_windows_are_told_from_glass_doors() -> None:
    assert is_window("eTeks#fixedWindow85x123", "Fenêtre fixe")
    assert not is_window("eTeks#frenchWindow85x200", "Porte-fenêtre")
    assert not is_window("eTeks#door", "Door")


def test_the_tables_name_only_what_scenes_know() -> None:
    newer = {"alarm clock", "apple", "baseball bat", "basketball", "bowl", "mug", "spray bottle"}
    assert {*WORDS, *ETEKS.values()} <= {*CATEGORIES} | newer
    assert {*ROOMS} == {*ROOM_TYPES}
    named = {word for names in WORDS.values() for word in names.split()}
    assert {*ENDINGS.split(), *FAINT.split()} <= named
    roomy = {word for last, first in ROOMS.values() for word in f"{last} {first}".split()}
    assert {*FAINT_ROOMS.split(), *SHORT_ENDINGS.split()} <= roomy


def test_no_word_has_two_meanings() -> None:
    """A word of two languages would be whichever stands last in the table."""
    for table in (WORDS, {kind: " ".join(both) for kind, both in ROOMS.items()}):
        words = [word for names in table.values() for word in names.split()]
        assert sorted(words) == sorted({*words})


@given(st.text(max_size=40), st.text(max_size=40))
def test_any_name_gives_a_category_and_a_type(catalog_id: str, name: str) -> None:
    assert category_of(catalog_id, name) in CATEGORIES
    assert room_type(name, [])[0] in ROOM_TYPES
