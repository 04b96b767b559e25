"""The language model's scores make sense and do not depend on what was cached."""

import functools
from pathlib import Path

import gguf
import numpy as np
import pytest

from models.errors import ModelFileError
from models.language.scoring import LanguageModel
from models.store import manifest

BATHROOM = "This room contains a sink, a bathtub, and a"
KITCHEN = "This room contains a sink, a stove, and a"


@pytest.fixture(scope="module")
def model() -> LanguageModel:
    return LanguageModel(manifest.fetch("smollm2-135m"), threads=2, context=128)


def test_a_toilet_belongs_to_a_bathtub(model: LanguageModel) -> None:
    toilet, engine = model.score(BATHROOM, [" toilet", " car engine"])
    assert toilet > engine
    assert toilet > model.score(KITCHEN, [" toilet"])[0]


def test_scores_are_log_probabilities(model: LanguageModel) -> None:
    words, longer = model.score(BATHROOM, [" washing", " washing machine"])
    assert longer < words < 0


@pytest.mark.slow
def test_a_score_depends_on_its_text_alone(model: LanguageModel) -> None:
    """To the last bit: whatever was asked before, and in whatever order."""
    asked = [" toilet", " washing machine", " refrigerator"]
    first = model.score(KITCHEN, asked)
    warm = model.score(BATHROOM, asked)
    assert model.score(KITCHEN, asked[::-1]) == first[::-1]
    model.score("Things found together in one room: bed, pillow, nightstand. And a", asked)
    assert model.score(BATHROOM, asked[1:]) == warm[1:]
    model.forget()
    assert model.score(BATHROOM, asked) == warm


def test_another_word_in_a_known_context_needs_no_evaluation(
    model: LanguageModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    model.forget()
    want = model.score(BATHROOM, [" toilet", " bed"])
    model.forget()
    model.score(BATHROOM, [" lamp"])
    model.score(KITCHEN, [" lamp"])

    def evaluated(tokens: list[int]) -> None:
        raise AssertionError("the model was run")

    monkeypatch.setattr(model._llama, "eval", evaluated)
    assert model.score(BATHROOM, [" toilet", " bed"]) == want
    with pytest.raises(AssertionError):
        model.score(BATHROOM, [" washing machine"])  # two tokens


@functools.cache
def table() -> gguf.ReaderTensor:
    """Of all the model's tokens."""
    tensors = gguf.GGUFReader(manifest.fetch("smollm2-135m")).tensors
    return next(t for t in tensors if t.name == "token_embd.weight")


def vectors(ids: list[int]) -> np.ndarray:
    """(n, 576) of these tokens, as the model has them."""
    return gguf.dequantize(table().data[ids], table().tensor_type)


def test_vectors_that_are_words_are_read_as_these_words(
    model: LanguageModel,
) -> None:
    """To the last bit: only where they begin and end is a batch of its own."""
    llama, said = model._llama, "In the hotel bathroom there"
    words, rest = model._tokens(said, first=False), model._tokens(" is a", first=False)
    model.forget()
    llama.n_tokens = 0
    for part in (words, rest):
        llama.eval(part)
    logits = np.array(llama.scores[len(words) + len(rest) - 1], np.float64)
    ids = [model._tokens(w, first=False)[0] for w in (" toilet", " stove")]
    want = logits[ids] - np.log(np.exp(logits - logits.max()).sum()) - logits.max()
    got = model.score(" is a", [" toilet", " stove"], vectors(words))
    assert got == pytest.approx(want, abs=1e-9)
    assert got[0] > got[1]


def test_a_score_of_what_was_seen_does_not_depend_on_what_was_asked_before(
    model: LanguageModel,
) -> None:
    bath, cook = (vectors(model._tokens(w, False)) for w in ("bathroom bathtub", "kitchen stove"))
    asked = [" toilet", " washing machine"]
    model.forget()
    first = model.score(" and a", asked, bath)
    other = model.score(" and a", asked, cook)
    assert first[0] - other[0] > 1.0
    words = model.score(BATHROOM, asked)
    assert model.score(" and a", asked[::-1], bath) == first[::-1]
    model.forget()
    assert model.score(BATHROOM, asked) == words
    assert model.score(" and a", asked[1:], cook) == other[1:]
    assert model.score(BATHROOM, asked[1:]) == words[1:]


def test_what_was_seen_must_be_made_for_this_model(model: LanguageModel) -> None:
    for wrong in (np.zeros((8, 960)), np.zeros((0, 576)), np.zeros(576)):
        with pytest.raises(ModelFileError, match="made for another language model"):
            model.score(" and a", [" bed"], wrong.astype(np.float32))
    with pytest.raises(ModelFileError, match="not finite"):
        model.score(" and a", [" bed"], np.full((8, 576), np.nan, np.float32))
    with pytest.raises(ModelFileError, match="do not fit the context of 128"):
        model.score(" and a", [" bed"], np.zeros((126, 576), np.float32))


def test_what_cannot_be_scored_is_said_in_one_line(model: LanguageModel, tmp_path: Path) -> None:
    with pytest.raises(ModelFileError, match="do not fit the context of 128"):
        model.score("word " * 200, [" toilet"])
    with pytest.raises(ModelFileError, match="continuation to score is empty"):
        model.score(BATHROOM, [""])
    with pytest.raises(ModelFileError, match="no such model file"):
        LanguageModel(tmp_path / "none.gguf")
    (tmp_path / "text.gguf").write_text("not a model")
    with pytest.raises(ModelFileError, match="not a GGUF file"):
        LanguageModel(tmp_path / "text.gguf")


def test_a_truncated_model_is_refused(tmp_path: Path) -> None:
    whole = manifest.fetch("smollm2-135m")
    with whole.open("rb") as stream:
        (tmp_path / "short.gguf").write_bytes(stream.read(1 << 20))
    with pytest.raises(ModelFileError, match="it ends too early") as error:
        LanguageModel(tmp_path / "short.gguf")
    assert "\n" not in str(error.value)
