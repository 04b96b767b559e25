"""Large models' style, shown with a small one: held to a grammar, bounded in tokens and time."""

import json
import math
from collections.abc import Iterator
from pathlib import Path

import pytest
from llama_cpp import Llama

from models.errors import ModelFileError, OverdueError
from models.language.reasoning import ReasoningModel
from models.store import manifest

pytestmark = pytest.mark.slow  # a language model answers

GRAMMAR = r"""
root ::= "{\"reason\": " text ", \"frontiers\": [" ( "2" | "5" ) "]}"
text ::= "\"" [a-zA-Z ,.]{1,60} "\""
"""
WHERE = [{"role": "user", "content": "Frontier 2: a bed. Frontier 5: a sink. Where is the toilet?"}]
LONG = [{"role": "user", "content": "chair, table, lamp and " * 250 + "Which one?"}]


@pytest.fixture(scope="module")
def model() -> Iterator[ReasoningModel]:
    model = ReasoningModel(manifest.fetch("smollm2-135m"), threads=1, context=2048)
    yield model
    model.close()


def test_an_answer_is_held_to_its_grammar(model: ReasoningModel) -> None:
    answer = json.loads(model.reply(WHERE, GRAMMAR, max_tokens=120))
    assert answer["frontiers"] in ([2], [5])
    assert answer["reason"]


def test_an_answer_is_bounded_in_tokens(model: ReasoningModel) -> None:
    said = model.reply(WHERE, GRAMMAR, max_tokens=4)
    assert 0 < len(model._llama.tokenize(said.encode(), add_bos=False)) <= 5


@pytest.mark.slow
def test_the_time_bounds_a_prompt_that_is_being_read(model: ReasoningModel) -> None:
    """And what is left of it in the cache does not change the next answer."""
    before = model.reply(WHERE, GRAMMAR, max_tokens=60)
    with pytest.raises(OverdueError, match=r"no answer in 0\.05 s"):
        model.reply(LONG, GRAMMAR, max_tokens=60, seconds=0.05)
    assert model._llama.n_tokens == 0  # far from having read it
    assert model.reply(WHERE, GRAMMAR, max_tokens=60) == before


def test_the_time_bounds_an_answer_that_is_being_given(
    model: ReasoningModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The alarm rings at the third token."""
    sampled, sample = [], Llama.sample

    def counted(llama: Llama, *arguments: object, **named: object) -> int:
        sampled.append(1)
        if len(sampled) == 3:
            model._alarm._ring()
        return int(sample(llama, *arguments, **named))  # type: ignore[arg-type]

    monkeypatch.setattr(Llama, "sample", counted)
    with pytest.raises(OverdueError):
        model.reply(WHERE, GRAMMAR, max_tokens=60, seconds=math.inf)
    assert len(sampled) <= 4


def test_what_cannot_be_asked_is_said_in_one_line(model: ReasoningModel, tmp_path: Path) -> None:
    with pytest.raises(ModelFileError, match="exceed context window") as error:
        model.reply([{"role": "user", "content": "word " * 5000}], GRAMMAR, max_tokens=10)
    assert "\n" not in str(error.value)
    with pytest.raises(ModelFileError, match="no such model file"):
        ReasoningModel(tmp_path / "none.gguf")
