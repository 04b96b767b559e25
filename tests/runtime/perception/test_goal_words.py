"""From a person's words to the detector's classes."""

from collections.abc import Sequence

import numpy as np
import pytest

from runtime.errors import ConfigError
from runtime.perception.goal_words import Words, check, understand

CLASSES = (("sofa", "couch"), ("toilet",), ("plant", "potted plant"))
AXES = {"sofa": 0, "couch": 0, "toilet": 1, "plant": 2, "potted plant": 2, "settee": 0}


def embed(texts: Sequence[str]) -> np.ndarray:
    """Words of one meaning share an axis; unknown words have one of their own."""
    rows = np.zeros((len(texts), 8), np.float32)
    for row, text in zip(rows, texts, strict=True):
        row[AXES.get(text, 7)] = 1.0
    return rows


def test_a_class_or_its_other_name_is_known():
    assert understand("Toilet", Words(CLASSES), embed).name == "toilet"
    assert understand("potted plant", Words(CLASSES), embed).name == "plant"
    assert understand("couch", Words(CLASSES), embed).classes == CLASSES


def test_what_people_also_call_a_class_is_looked_for_as_it():
    also = {"toilet": ("loo", "water closet")}
    for text in ("loo", "The Loo", "my water-closet", "loos"):
        goal = understand(text, Words(CLASSES, also=also), embed)
        assert goal.name == "toilet"
        assert goal.classes == CLASSES  # the detector is asked for nothing more
        assert "another word for toilet" in goal.how
    assert understand("a", Words(CLASSES, also=also), embed).name == "a"


def test_who_asks_for_a_lamp_is_served_by_any():
    classes = (("lamp", "light"), ("desk lamp", "table lamp"), ("sofa",))
    kinds = {"lamp": ("desk lamp",)}
    goal = understand("light", Words(classes, kinds=kinds), embed)
    assert goal.name == "lamp"
    assert goal.classes == (("lamp", "light", "desk lamp", "table lamp"), *classes[1:])
    assert "of its kind: desk lamp" in goal.how
    assert understand("table lamp", Words(classes, kinds=kinds), embed).classes == classes


def test_of_names_alike_enough_one_of_its_kind_wins():
    classes = (("laundry basket",), ("trash can", "hamper"), ("shoe",))
    like = {"laundry basket": 0.67, "trash can": 0.64, "hamper": 0.64, "shoe": 0.0}

    def near(texts: Sequence[str]) -> np.ndarray:
        return np.array([(like.get(t, 1.0), 0.0) for t in texts], np.float32)

    # With what its kind is worth, "hamper" is nearest, but not near enough by itself.
    assert understand("odd hamper", Words(classes), near).name == "laundry basket"


def test_a_synonym_joins_the_class_it_means():
    goal = understand("settee", Words(CLASSES), embed)
    assert goal.name == "sofa"
    assert ("sofa", "couch", "settee") in goal.classes
    assert len(goal.classes) == len(CLASSES)
    assert "taken for sofa" in goal.how


def test_anything_else_becomes_a_class_of_its_own():
    goal = understand("Red  umbrella", Words(CLASSES), embed)
    assert goal.name == "red umbrella"
    assert goal.classes == (*CLASSES, ("red umbrella",))


@pytest.mark.parametrize("text", ["", "   ", "\n", "x" * 81, "toi\x00let"])
def test_what_cannot_be_looked_for_is_refused_in_one_line(text: str):
    with pytest.raises(ConfigError, match="goal: ") as caught:
        check(text)
    assert "\n" not in str(caught.value)
