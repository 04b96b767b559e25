"""Which meaning a word has among the classes, on a dictionary of a few words."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from runtime.core.word_senses import meaning

CLASSES = (("lamp", "light"), ("cup", "tumbler"), ("alarm clock",), ("watch",))


@dataclass(frozen=True)
class Entry:
    id: int
    names: tuple[str, ...]
    gloss: str = ""
    broader: tuple[int, ...] = ()
    narrower: tuple[int, ...] = ()
    common: bool = True


ENTRIES = (
    Entry(0, ("lamp", "light"), "shines"),
    Entry(1, ("igniter", "light"), "burns"),
    Entry(2, ("cup",), narrower=(3,)),
    Entry(3, ("beaker",), "to drink from", broader=(2,)),
    Entry(4, ("beaker",), "for chemists"),
    Entry(5, ("timepiece",), narrower=(6, 7)),
    Entry(6, ("alarm clock",), broader=(5,)),
    Entry(7, ("watch",), broader=(5,)),
    Entry(8, ("andiron", "dog"), common=False),
    Entry(9, ("mug shot",), "of a face"),
    Entry(10, ("mug shot",), "to drink at once", broader=(2,)),
    Entry(11, ("quaff",), "to drink at once", broader=(2,)),
)
LIKE = {
    "shines": 0, "burns": 3, "drink": 1, "chemists": 3, "lamp": 0, "cup": 1, "tumbler": 1,
    "beaker": 1,
}  # fmt: skip


def senses(word: str) -> Sequence[Entry]:
    return [e for e in ENTRIES if word in e.names]


def embed(texts: Sequence[str]) -> np.ndarray:
    """A text has the axis of the last word in it that has one."""
    rows = np.full((len(texts), 5), 0.01, np.float32)
    for row, text in zip(rows, texts, strict=True):
        axes = [axis for word, axis in LIKE.items() if word in text]
        row[axes[0] if axes else 4] = 1.0
    return rows


def test_the_meaning_that_is_most_like_a_class_is_meant():
    found = meaning("beaker", CLASSES, senses, embed)
    assert found is not None
    assert (found.same, found.broader) == ((), (CLASSES[1],))


def test_of_several_meanings_none_makes_it_a_kind_of_what_the_word_is_not_like():
    for word, broader in (("mug shot", ()), ("quaff", (CLASSES[1],))):
        found = meaning(word, CLASSES, senses, embed)
        assert found is not None
        assert found.broader == broader


def test_another_meaning_of_a_classs_name_is_not_the_class():
    found = meaning("igniter", CLASSES, senses, embed)
    assert found is not None
    assert (found.same, found.broader, found.narrower) == ((), (), ())


def test_a_general_word_has_the_classes_that_are_its_kinds():
    found = meaning("timepiece", CLASSES, senses, embed)
    assert found is not None
    assert found.narrower == (("alarm clock",), ("watch",))


def test_what_a_word_seldom_means_lends_it_no_names():
    found = meaning("dog", CLASSES, senses, embed)
    assert found is not None
    assert found.names == ()


def test_words_that_the_dictionary_does_not_have():
    assert meaning("qwertyuiop", CLASSES, senses, embed) is None
    assert meaning("lamp", (), senses, embed) is None
