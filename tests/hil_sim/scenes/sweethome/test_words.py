"""Names in several languages -> categories and room types."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_sim.scenes.format import CATEGORIES, ROOM_TYPES
from hil_sim.scenes.sweethome.words import ETEKS, WORDS, category_of, is_window, room_type


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
        ("", ["bed", "desk", "chair"], "bedroom", "furniture"),
        ("Room B", ["toilet", "sink"], "bathroom", "furniture"),
        ("Room C", ["vase"], "hallway", "guess"),
    ],
)
def test_a_room_is_known_by_its_name_or_furniture(
    name: str, inside: list[str], kind: str, how: str
) -> None:
    assert room_type(name, inside) == (kind, how)


def test_windows_are_told_from_glass_doors() -> None:
    assert is_window("eTeks#fixedWindow85x123", "Fenêtre fixe")
    assert not is_window("eTeks#frenchWindow85x200", "Porte-fenêtre")
    assert not is_window("eTeks#door", "Door")


def test_the_tables_name_only_what_scenes_know() -> None:
    newer = {"alarm clock", "apple", "baseball bat", "basketball", "bowl", "mug", "spray bottle"}
    assert {*WORDS, *ETEKS.values()} <= {*CATEGORIES} | newer


@given(st.text(max_size=40), st.text(max_size=40))
def test_any_name_gives_a_category_and_a_type(catalog_id: str, name: str) -> None:
    assert category_of(catalog_id, name) in CATEGORIES
    assert room_type(name, [])[0] in ROOM_TYPES
