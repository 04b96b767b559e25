"""The memo asks a model once, in one thread; deadlines cut between prompts."""

import threading
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from manual_clock import ManualClock
from taught_layout import ShownModel

from runtime.clock import Deadline, SystemClock
from runtime.core.types import F32
from runtime.core.voting.likelihood_experts import LikelihoodQuestion
from runtime.experts.score_cache import ScoreFile
from runtime.experts.scorer import Scorer, Similarity

PATIENCE_S = 20.0
CLOCK = SystemClock()
NEVER = Deadline.never(CLOCK)


class Counting:
    """Scores by length and remembers who asked what; `gate` stops it before each prompt."""

    def __init__(self, gate: threading.Semaphore | None = None) -> None:
        self.prompts: list[tuple[str, tuple[str, ...]]] = []
        self.threads: set[int] = set()
        self.gate = gate
        self.begun = threading.Semaphore(0)

    def score(self, context: str, continuations: Sequence[str]) -> tuple[float, ...]:
        self.begun.release()
        if self.gate is not None:
            assert self.gate.acquire(timeout=PATIENCE_S)
        self.prompts.append((context, tuple(continuations)))
        self.threads.add(threading.get_ident())
        return tuple(-float(len(context) + len(c)) for c in continuations)


class Broken:
    def __init__(self) -> None:
        self.calls = 0

    def score(self, context: str, continuations: Sequence[str]) -> tuple[float, ...]:
        self.calls += 1
        raise RuntimeError("no memory")


def questions(*pairs: str) -> list[LikelihoodQuestion]:
    return [LikelihoodQuestion(pair.split("|")[0], pair.split("|")[1]) for pair in pairs]


def test_equal_questions_reach_the_model_once_and_contexts_share_a_prompt() -> None:
    model = Counting()
    with Scorer([("m", model)], CLOCK) as scorer:
        asked = questions("a sink|toilet", "a bed|toilet", "a sink|bath", "a sink|toilet")
        first = scorer.answer(asked, NEVER)
        again = scorer.answer(asked, NEVER)
    assert first == again == {q: -float(len(q.context) + len(q.continuation)) for q in asked}
    assert model.prompts == [("a sink", ("toilet", "bath")), ("a bed", ("toilet",))]
    assert model.threads
    assert threading.get_ident() not in model.threads
    assert len(model.threads) == 1


def test_what_each_prompt_took_is_told_and_what_is_known_takes_nothing() -> None:
    took: list[float] = []
    with Scorer([("m", Counting())], SystemClock(), book=took.append) as scorer:
        for _ in range(2):
            scorer.answer(questions("a|x", "a|y", "b|x"), NEVER)
            assert scorer.settle(NEVER)
    assert len(took) == 2  # contexts
    assert all(0.0 <= one_s < 60.0 for one_s in took)


def test_what_was_forgotten_is_scored_anew() -> None:
    model = Counting()
    with Scorer([("m", model)], CLOCK) as scorer:
        before = scorer.answer(questions("a|x"), NEVER)
        scorer.forget()
        assert len(scorer) == 0
        assert scorer.answer(questions("a|x"), NEVER) == before
    assert len(model.prompts) == 2


def test_contexts_that_begin_alike_are_asked_about_in_a_row() -> None:
    """What a model has read it need not read again."""
    long = "Things found together in one room: bed, pillow, nightstand, lamp, rug"
    model = Counting()
    with Scorer([("m", model)], CLOCK) as scorer:
        asked = questions(*(f"{c}|t" for thing in "abc" for c in (thing, f"{long}, {thing}")))
        assert len(scorer.answer(asked, NEVER)) == 6
        assert len(scorer.answer(questions("d|t", f"{long}, d|t"), NEVER)) == 2
    order = [context.removeprefix(long) for context, _ in model.prompts]
    assert order == ["a", ", a", ", b", ", c", "b", "c", "d", ", d"]


def test_the_caller_who_can_be_answered_soonest_comes_first() -> None:
    model = Counting(threading.Semaphore(0))
    with Scorer([("m", model)], CLOCK) as scorer:
        many = questions(*(f"many {n}|t" for n in range(5)))
        callers = [threading.Thread(target=scorer.answer, args=(many, NEVER))]
        callers[0].start()
        assert model.begun.acquire(timeout=PATIENCE_S)  # one of the many is under way
        callers.append(threading.Thread(target=scorer.answer, args=(questions("few|t"), NEVER)))
        callers[1].start()
        with scorer._condition:
            assert scorer._condition.wait_for(lambda: len(scorer._urgent) == 2, PATIENCE_S)
        for _ in range(6):
            model.gate.release()
        for caller in callers:
            caller.join(PATIENCE_S)
    assert [context for context, _ in model.prompts[:3]] == ["many 0", "few", "many 1"]


def test_many_callers_share_one_model_thread() -> None:
    model = Counting()
    with Scorer([("m", model)], CLOCK) as scorer:
        asked = questions(*(f"c{i}|t" for i in range(20)))
        got: list[dict[LikelihoodQuestion, float]] = []
        callers = [
            threading.Thread(target=lambda: got.append(scorer.answer(asked, NEVER)))
            for _ in range(4)
        ]
        for caller in callers:
            caller.start()
        for caller in callers:
            caller.join(PATIENCE_S)
    assert len(got) == 4
    assert all(len(answer) == 20 for answer in got)
    assert len(model.threads) == 1
    assert len(model.prompts) == 20


def test_a_deadline_leaves_a_partial_answer_and_ends_the_work() -> None:
    clock, gate = ManualClock(), threading.Semaphore(0)
    model = Counting(gate)
    with Scorer([("m", model)], clock) as scorer:
        got: list[dict[LikelihoodQuestion, float]] = []
        asked = questions("a|t", "b|t", "c|t", "d|t")
        by = Deadline.after(2.0, clock)
        caller = threading.Thread(target=lambda: got.append(scorer.answer(asked, by)))
        caller.start()
        gate.release()  # one prompt passes
        assert model.begun.acquire(timeout=PATIENCE_S)
        assert model.begun.acquire(timeout=PATIENCE_S)
        clock.advance(2.0)
        caller.join(PATIENCE_S)
        assert list(got[0]) == asked[:1]
        gate.release()  # the prompt under way ends, the abandoned rest is not begun
        assert scorer.settle(Deadline.never(clock))
        assert [context for context, _ in model.prompts] == ["a", "b"]
        assert len(scorer) == 2  # what was finished too late still serves the next decision
        for _ in range(8):
            gate.release()
        assert len(scorer.answer(asked, Deadline.never(clock))) == 4


def test_warming_happens_behind_those_who_wait() -> None:
    gate = threading.Semaphore(0)
    model = Counting(gate)
    with Scorer([("m", model)], CLOCK) as scorer:
        scorer.warm(questions("w1|t", "w2|t", "w3|t", "w1|t"))
        assert model.begun.acquire(timeout=PATIENCE_S)  # w1 is under way
        caller = threading.Thread(target=lambda: scorer.answer(questions("now|t"), NEVER))
        caller.start()
        with scorer._condition:
            assert scorer._condition.wait_for(lambda: bool(scorer._urgent), PATIENCE_S)
        for _ in range(8):
            gate.release()
        caller.join(PATIENCE_S)
        assert scorer.settle(NEVER)
    assert [context for context, _ in model.prompts] == ["w1", "now", "w2", "w3"]


def test_a_broken_model_is_left_for_the_rung_below_without_mixing_scales() -> None:
    class BreaksLater(Counting):
        def score(self, context: str, continuations: Sequence[str]) -> tuple[float, ...]:
            if context == "b":
                raise RuntimeError("no memory")
            return super().score(context, continuations)

    below = Counting()
    with Scorer([("llm", BreaksLater()), ("text", below)], CLOCK) as scorer:
        asked = questions("a|t", "b|t")
        assert len(scorer.answer(asked[:1], NEVER)) == 1
        assert scorer.rung == "llm"
        assert set(scorer.answer(asked, NEVER)) == set(asked)
        assert scorer.rung == "text"
        assert scorer.errors == ["llm: no memory"]
        assert sorted(context for context, _ in below.prompts) == ["a", "b"]


def test_the_last_rungs_failure_reaches_the_caller_and_the_thread_lives() -> None:
    broken = Broken()
    with Scorer([("m", broken)], CLOCK) as scorer:
        for _ in range(2):
            with pytest.raises(RuntimeError, match="no memory"):
                scorer.answer(questions("a|t"), NEVER)
        scorer.warm(questions("b|t"))
        assert scorer.settle(NEVER)
        assert broken.calls == 3


def test_a_model_that_returns_too_few_scores_is_a_failure() -> None:
    class Short:
        def score(self, context: str, continuations: Sequence[str]) -> tuple[float, ...]:
            return ()

    with (
        Scorer([("m", Short())], CLOCK) as scorer,
        pytest.raises(ValueError, match="0 scores for 1 continuations"),
    ):
        scorer.answer(questions("a|t"), NEVER)


def test_similarity_ranks_like_the_cosine() -> None:
    class Letters:
        def embed(self, texts: list[str]) -> F32:
            rows = np.array([[text.count(c) + 1e-3 for c in "abc"] for text in texts])
            unit: F32 = (rows / np.linalg.norm(rows, axis=1, keepdims=True)).astype(np.float32)
            return unit

    near, far = Similarity(Letters()).score("aab", [" aa", " cc"])
    assert near > far + 5


def test_what_is_shown_stands_before_its_own_questions_and_is_kept_in_memory_alone(
    tmp_path: Path,
) -> None:
    model, file = ShownModel(), ScoreFile(tmp_path / "scores.sqlite", "m")
    shown = {name: np.full((2, 4), mark, np.float32) for name, mark in (("a", 1), ("b", 2))}
    asked = [LikelihoodQuestion("is a", w, s) for s in ("a", "b") for w in (" toilet", " lamp")]
    with Scorer([("m", model)], CLOCK, file) as scorer:
        first = scorer.answer(asked, NEVER, shown)
        assert scorer.answer(asked, NEVER, shown) == first
    assert [first[q] for q in asked] == [-8.0, -1.0, -7.0, -1.0]
    assert model.shown == [1.0, 2.0]
    assert ScoreFile(tmp_path / "scores.sqlite", "m").load() == {}


def test_a_model_that_cannot_be_shown_anything_fails_as_others_do() -> None:
    question = LikelihoodQuestion("is a", " toilet", "a")
    with (
        Scorer([("m", Counting())], CLOCK) as scorer,
        pytest.raises(TypeError, match="seen"),
    ):
        scorer.answer([question], NEVER, {"a": np.zeros((2, 4), np.float32)})
