"""What is told of the models: those that are tried are stand-ins, on a clock that a test moves."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from apartment import TWO_ROOMS, Apartment
from fake_models import FakeModels, broken, farthest
from manual_clock import ManualClock

from runtime.clock import Deadline
from runtime.config import Config
from runtime.core.types import Absence, Ballot, Missing, Pose, Vote
from runtime.core.voting.likelihood_experts import things_near
from runtime.doctor.diagnosis import Diagnosis, Grade
from runtime.doctor.models import LOOKS, PATIENCE, ModelsTried, judge_models, try_models
from runtime.errors import ModelError
from runtime.experts.trial_question import TRIAL
from runtime.perception.counted import counted_in_homes
from runtime.tracing.budgets import read_budgets

BUDGETS = read_budgets()
VOTE = Vote("o2f", (1,), ((1, 1.0),), "")
WELL = ModelsTried(
    "", 3.0, [0.1] * 8, (0.2, 0.3), Ballot((VOTE,), latency_s={"o2f": 0.5}), 1.9, True
)


def found(tried: ModelsTried) -> dict[str, Diagnosis]:
    return {one.about: one for one in judge_models(tried, BUDGETS)}


def test_models_that_are_fast_enough():
    told = found(WELL)
    assert {one.grade for one in told.values()} == {Grade.OK}
    assert told["detector"].told.startswith("a look takes 100 ms (a camera's image); its budget is")
    assert told["experts"].told == "a first vote: o2f in 0.50 s"


def test_models_that_cannot_be_used_are_bad():
    told = found(ModelsTried("models.detectors: x: no such file"))
    assert told["models"].grade is Grade.BAD
    assert "rfnav models pull" in told["models"].remedy


@pytest.mark.parametrize(
    ("change", "about", "words"),
    [
        ({"load_s": 60.0}, "models", "60.0 s"),
        ({"looks_s": [0.3]}, "detector", "over 400 ms counts as an overrun"),
        ({"looks_s": [0.6]}, "detector", "the runtime sheds experts, then rests for 1 to 3"),
        ({"prompts_s": (0.9, 1.1)}, "language model", "1000 ms"),
        ({"ballot": Ballot(missing=(Missing("sle", Absence.LATE),))}, "experts", "sle: late"),
        ({"within_s": 0.4}, "experts", "o2f in 0.50 s; what takes over 0.4 s does not count"),
    ],
)
def test_what_is_over_its_budget_is_warned_of(change: dict, about: str, words: str):
    told = found(replace(WELL, **change))
    assert told[about].grade is Grade.WARNING
    assert words in told[about].told
    assert told[about].remedy


def test_without_experts_and_without_an_image():
    told = found(replace(WELL, ballot=None, seen=False, prompts_s=()))
    assert told["experts"].grade is Grade.OK
    assert "noise of 640x480" in told["detector"].told
    assert "language model" not in told


class Slow(FakeModels):
    """A look takes 200 ms of the clock, the first a second."""

    def __init__(self, clock: ManualClock, **experts: object) -> None:
        super().__init__(Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, 0.0)), **experts)
        self.clock, self.shown = clock, list[tuple[int, ...]]()
        self.book: Callable[[float], None] | None = None
        self.waited_s: list[float] = []

    def detect(self, rgb: np.ndarray, window: object = None):
        self.clock.advance(0.2 if self.shown else 1.0)
        self.shown.append(rgb.shape)
        return super().detect(rgb)

    def settle(self, by: Deadline) -> bool:
        """What is scored in the background takes 3 s: six prompts."""
        self.waited_s.append(by.left_s())
        self.clock.advance(3.0)
        if self.book is not None:
            for _ in range(6):
                self.book(0.5)
        return True


@contextmanager
def loaded(models: Slow) -> Iterator[Slow]:
    models.clock.advance(4.0)
    yield models
    models.panel.close()


def loader(models: Slow) -> Callable:
    return lambda config, book: loaded(models)


def test_they_are_loaded_look_and_vote():
    clock = ManualClock()
    models = Slow(clock, o2f=farthest, r2f=broken)
    given: list[Config] = []

    def load(config: Config, book: Callable[[float], None]):
        given.append(config)
        return loaded(models)

    tried = try_models(load, Config(), clock, np.zeros((48, 64, 3), np.uint8))
    assert given == [Config()]
    assert tried.load_s == pytest.approx(4.0)
    assert tried.looks_s == pytest.approx([0.2] * LOOKS)
    assert models.shown == [(48, 64, 3)] * (LOOKS + 1)
    assert tried.ballot is not None
    assert [vote.expert for vote in tried.ballot.votes] == ["o2f"]
    told = found(tried)["experts"].told
    assert told.startswith("a first vote: o2f in 0.")
    assert "r2f: error: the model fell over" in told
    assert try_models(loader(Slow(clock)), Config(), clock, None).seen is False


@pytest.mark.parametrize("words", ["counts", "language", "both"])
def test_votes_are_by_the_evidence_that_is_configured_and_prompts_are_timed_apart(words: str):
    clock, config = ManualClock(), Config()
    config = replace(config, experts=replace(config.experts, words=words))
    models, accepted = Slow(clock, o2f=farthest), list[Config]()

    def accept(goal: str, config: Config):
        accepted.append(config)
        return Slow.accept(models, goal, config)

    def load(config: Config, book: Callable[[float], None]):
        models.book = book
        return loaded(models)

    models.accept = accept
    tried = try_models(load, config, clock, None)
    assert [one.experts.words for one in accepted] == [words]
    assert tried.prompts_s == (0.5,) * 6
    assert models.waited_s == [pytest.approx(PATIENCE * config.panel.votes_s)]
    told = found(tried)
    assert told["language model"].told.startswith("a prompt takes 500 ms")
    assert told["experts"].grade is Grade.OK  # prompts that nobody waited for make no vote late


def test_all_that_the_trial_names_was_counted_so_that_no_text_is_embedded_for_that_vote():
    counted = counted_in_homes().rates
    assert {TRIAL.goal, *things_near(TRIAL)} <= set(counted)


def test_prompts_are_not_waited_for_where_nobody_votes():
    config = replace(Config(), panel=replace(Config().panel, experts=()))
    models = Slow(ManualClock())
    assert try_models(loader(models), config, models.clock, None).ballot is None
    assert not models.waited_s


def test_one_that_cannot_be_loaded_is_told_and_nothing_else():
    def fail(config: Config, book: object) -> None:
        raise ModelError("minilm is missing; run `rfnav models pull minilm`")

    tried = try_models(fail, Config(), ManualClock(), None)
    assert tried.error.startswith("minilm is missing")
