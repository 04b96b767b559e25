"""A person's words, taken apart."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.core.goal_phrase import Phrase, in_turn, parse
from runtime.core.small_words import BACK, FRONT, NOT, PLACING, SAYING

THINGS = {
    "mug", "cup", "chair", "sofa", "table", "kitchen table", "keys", "plant", "tv",
    "bottle of wine", "red apple", "small table", "shoes",
}  # fmt: skip
ROOMS = {"kitchen", "living room", "bedroom"}


class Few:
    """Few things and rooms."""

    def thing(self, phrase: str) -> bool:
        return phrase in THINGS

    def room(self, phrase: str) -> bool:
        return phrase in ROOMS


def read(text: str) -> Phrase:
    return parse(text, Few())


@pytest.mark.parametrize(
    ("text", "phrase"),
    [
        ("mug", Phrase(("mug",))),
        ("the MUG!", Phrase(("mug",))),
        ("red apple", Phrase(("red apple",))),
        ("a little table", Phrase(("small table",))),
        ("big red mug", Phrase(("mug",), traits=("big", "red"))),
        ("a black and white mug", Phrase(("mug",), traits=("black", "white"))),
        ("my wife's two keys", Phrase(("keys",), traits=("wife's", "two"))),
        ("a pair of shoes", Phrase(("shoes",))),
        ("a cup of tea", Phrase(("cup",), other=("of tea",))),
        ("a bottle of wine on the table", Phrase(("bottle of wine",), near=("table",))),
        ("kitchen mug", Phrase(("mug",), rooms=("kitchen",))),
        ("mug, kitchen", Phrase(("mug",), rooms=("kitchen",))),
        (
            "the red mug on the kitchen table",
            Phrase(("mug",), near=("table",), rooms=("kitchen",), traits=("red",)),
        ),
        ("mug that I left on the table", Phrase(("mug",), near=("table",))),
        ("keys lying under the sofa", Phrase(("keys",), near=("sofa",))),
        (
            "mug on the table, next to the tv, in the living room",
            Phrase(("mug",), near=("table", "tv"), rooms=("living room",)),
        ),
        ("mug between the sofa and the table", Phrase(("mug",), near=("sofa", "table"))),
        ("mug on the table or the sofa", Phrase(("mug",), near=("table", "sofa"))),
        ("mug on the table and a chair", Phrase(("mug", "chair"), near=("table",))),
        ("a mug with a handle", Phrase(("mug",), other=("with a handle",))),
        ("mug, not the cup", Phrase(("mug",), unlike=("cup",))),
        ("not the cup but the mug", Phrase(("mug",), unlike=("cup",))),
        ("mug, not a cup, on the table", Phrase(("mug",), near=("table",), unlike=("cup",))),
        ("a mug instead of a cup", Phrase(("mug",), unlike=("cup",))),
        ("a mug and a chair", Phrase(("mug", "chair"))),
        ("sofa/chair, or a mug", Phrase(("sofa", "chair", "mug"))),
        ("where is my mug, please?", Phrase(("mug",))),
        ("Could you please find me the mug? Thanks!", Phrase(("mug",))),
        ("go to the kitchen and find a mug", Phrase(("mug",), rooms=("kitchen",))),
        ("no, the mug", Phrase(("mug",))),
        ("kitchen", Phrase(("kitchen",))),
        ("xyzzy plugh", Phrase(("xyzzy plugh",))),
        ("!!!", Phrase(refusal="names no thing")),
        ("please", Phrase(refusal="names no thing")),
        ("the red one", Phrase(refusal="names no thing")),
        ("on the table", Phrase(refusal="names no thing but a place (the table)")),
        ("not the sofa", Phrase(refusal="says what is not looked for (not the sofa)")),
        ("anything but a mug", Phrase(refusal="says what is not looked for (anything but a mug)")),
    ],
)
def test_what_is_looked_for_is_told_from_what_is_said_of_it(text: str, phrase: Phrase) -> None:
    assert read(text) == phrase


def test_a_thing_of_several_words_is_left_whole_whatever_they_are() -> None:
    class Odd(Few):
        def thing(self, phrase: str) -> bool:
            return phrase == "find not on and the"

    assert parse("find not on and the", Odd()) == Phrase(("find not on and the",))


def test_hints_say_what_each_is() -> None:
    hints = read("the red mug on the kitchen table with a handle, not a cup").hints
    assert hints == ("red", "near: table", "room: kitchen", "not: cup", "with a handle")


SMALL = sorted({" ".join(p) for p in (*FRONT, *BACK, *NOT, *PLACING, *SAYING)})
WORD = st.sampled_from(
    [*SMALL, *sorted(THINGS), *sorted(ROOMS), "and", "or", ",", "of", "the", "red", "two", "x's"]
)


@given(st.one_of(st.text(max_size=80), st.lists(WORD, max_size=16).map(" ".join)))
def test_whatever_is_said_is_taken_apart_into_no_more_than_was_said(text: str) -> None:
    calls = 0

    class Counting(Few):
        def thing(self, phrase: str) -> bool:
            nonlocal calls
            calls += 1
            return super().thing(phrase)

    phrase = parse(text, Counting())
    assert bool(phrase.things) != bool(phrase.refusal)
    assert all(thing and thing == thing.strip() for thing in phrase.things)
    assert len(phrase.things) + len(phrase.hints) <= len(text) + 1
    assert calls <= 4 * (len(text) + 2) ** 2
    assert "\n" not in phrase.refusal
    assert parse(text, Few()) == phrase


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("find a mug, then a chair", ("find a mug", "a chair")),
        ("a mug and then a chair; after that the sofa.", ("a mug", "a chair", "the sofa")),
        ("erst eine Tasse, dann ein Stuhl", ("erst eine Tasse", "ein Stuhl")),
        ("una taza, LUEGO una silla", ("una taza", "una silla")),
        ("then a mug", ("a mug",)),
        ("a mug and a chair", ("a mug and a chair",)),
        ("the authentic mug", ("the authentic mug",)),
        ("Dan's mug", ("Dan's mug",)),
        ("then", ("then",)),
        ("", ("",)),
    ],
)
def test_what_is_to_be_done_next_is_told_apart(text: str, parts: tuple[str, ...]):
    assert in_turn(text) == parts
