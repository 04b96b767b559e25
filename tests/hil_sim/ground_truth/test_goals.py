"""What a goal's words mean in the scenes' categories."""

import pytest

from hil_sim.ground_truth.goals import category_word


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("toilet", "toilet"),
        ("the red mug on the table", "mug"),
        ("please find my couch, not the chair", "couch"),
        ("a mug and a chair", "a mug and a chair"),
        ("asdf", "asdf"),
        ("", ""),
    ],
)
def test_a_person_s_words_are_judged_by_the_one_category_in_them(text: str, word: str) -> None:
    assert category_word(text) == word
