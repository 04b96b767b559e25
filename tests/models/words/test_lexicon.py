"""The words of goals beside the names of what is looked for."""

from pathlib import Path

import pytest

from models.errors import ModelFileError
from models.words.lexicon import folded, lexicon, read_lexicon
from models.words.senses import Senses
from models.words.vocabulary import load_vocabulary


def test_every_translation_is_a_thing_that_is_known() -> None:
    known = {names[0] for names in load_vocabulary().objects} | lexicon().things
    assert set(lexicon().translations.values()) <= known
    assert len(lexicon().translations) > 300


def test_no_translation_is_another_thing_in_english() -> None:
    vocabulary = load_vocabulary()
    owner = {n: names[0] for names in vocabulary.objects for n in names}
    owner |= {n: name for name, also in vocabulary.also.items() for n in also}
    for word, thing in lexicon().translations.items():
        assert owner.get(word, thing) == thing, word


def test_a_place_has_a_thing_to_ask_for_in_it() -> None:
    known = {names[0] for names in load_vocabulary().objects}
    assert set(lexicon().places.values()) <= known
    assert set(load_vocabulary().rooms) <= set(lexicon().places)


def test_people_animals_and_vague_words_are_no_names_of_things() -> None:
    names = {n for c in load_vocabulary().objects for n in c}
    others = lexicon().people | lexicon().animals | lexicon().vague | set(lexicon().places)
    assert not others & names
    assert Senses()("cat")  # a whip; who says cat does not mean that
    assert "cat" in lexicon().animals


def test_accents_are_folded_away() -> None:
    assert folded("Kühlschrank") == "kuhlschrank"
    assert folded("CANAPÉ") == "canape"
    assert folded("Straße") == "strasse"


@pytest.mark.parametrize("text", ["", "[places]\n", "x = [", "[places]\nbed = 3\n[living]\n"])
def test_another_file_is_told_in_one_line(tmp_path: Path, text: str) -> None:
    path = tmp_path / "words.toml"
    path.write_text(text)
    with pytest.raises(ModelFileError, match=r"no words of goals.*reinstall") as caught:
        read_lexicon(path)
    assert "\n" not in str(caught.value)
