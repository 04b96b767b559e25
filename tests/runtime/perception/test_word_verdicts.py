"""What the runtime makes of people's words, with the real dictionary and text encoder."""

import pytest
from click.testing import CliRunner

from models.evaluation.truth import read_words
from models.words.text_encoder import TextEncoder
from models.words.vocabulary import load_vocabulary
from runtime.perception.models_command import models_command
from runtime.perception.word_verdicts import by_default, word_verdicts

pytestmark = pytest.mark.slow  # hundreds of names are embedded


@pytest.mark.parametrize(
    ("word", "name", "how"),
    [
        ("settee", "sofa", "a kind of sofa"),
        ("telly", "television", "another word for television"),
        ("loo", "toilet", "another word for toilet"),
        ("recliner", "armchair", "a kind of armchair"),
        ("my chairs", "chair", "known as chair"),
        ("knives", "knife", "another word for knife"),
        ("beaker", "cup", "a kind of cup"),
        ("night stand", "nightstand", "known as nightstand"),
        ("umbrella", "umbrella", "a class of its own"),
        ("igniter", "igniter", "a class of its own"),
        ("safe", "safe", "a class of its own"),
        ("runner", "rug", "a kind of rug"),
        ("laundry hamper", "laundry basket", "taken for laundry basket"),
        ("toy box", "box", "taken for box"),
        ("money plant", "plant", "a kind of plant"),
        ("towel rail", "towel rail", "a class of its own"),
        ("salad", "salad", "a class of its own"),
    ],
)
def test_a_goal_is_looked_for_as_what_it_means(
    encoder: TextEncoder, word: str, name: str, how: str
) -> None:
    goal = by_default(encoder, listed=False)(word)
    assert goal.name == name
    assert how in goal.how


def test_a_name_that_is_refused_is_no_mistake_of_the_list(encoder: TextEncoder) -> None:
    rows = word_verdicts(read_words(), by_default(encoder), {"bed": ["qwertyuiop", "twin bed"]})
    assert [row.verdict for row in rows] == ["refused", "its own"]
    assert "no thing that is known" in rows[0].how


@pytest.mark.parametrize(
    ("word", "name"),
    [("the loo", "toilet"), ("water boilers", "kettle"), ("Bed-side lamp", "desk lamp")],
)
def test_listed_names_need_no_dictionary(encoder: TextEncoder, word: str, name: str) -> None:
    assert by_default(encoder, senses=False)(word).name == name
    assert by_default(encoder, senses=False, listed=False)(word).name != name


@pytest.mark.parametrize(
    ("word", "kind"),
    [
        ("bin", "trash can"),
        ("cushion", "pillow"),
        ("timepiece", "clock"),
        ("monitor", "computer monitor"),
        ("monitor", "television"),
    ],
)
def test_a_goal_that_is_more_than_a_class_keeps_its_kinds(
    encoder: TextEncoder, word: str, kind: str
) -> None:
    understood = by_default(encoder, listed=False)
    assert understood(word).name == word
    assert kind in understood(word).names


@pytest.mark.slow
def test_the_dictionary_helps_and_bare_classes_stay_what_they_are(encoder: TextEncoder) -> None:
    words = read_words()
    own = {}
    for with_senses in (False, True):
        understood = by_default(encoder, tuple(words.trained.values()), with_senses)
        own[with_senses] = {
            told.word
            for told in word_verdicts(words, understood, words.unseen)
            if told.verdict == "its own"
        }
    assert len(own[True]) > len(own[False])
    classes = load_vocabulary().objects
    understood = by_default(encoder)
    assert [understood(names[0]).name for names in classes] == [names[0] for names in classes]


@pytest.mark.slow
def test_the_command_tells_where_each_name_ends() -> None:
    done = CliRunner().invoke(models_command, ["words", "--asked"], catch_exceptions=False)
    lines, asked = done.output.splitlines(), sum(map(len, read_words().asked.values()))
    own = [line for line in lines if line.startswith("its own  ")]
    assert f"{len(own):4} of {asked}: its own" in lines
    assert len(own) > asked / 2
