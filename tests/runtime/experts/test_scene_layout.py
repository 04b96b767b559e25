"""SLE by a network that was taught views: what it is shown, what is kept, when it has no word."""

import threading
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from manual_clock import ManualClock
from sighted import sight
from taught_layout import ShownModel, TaughtLayout

from runtime.clock import Deadline, SystemClock
from runtime.core.types import F32, Absence, Brief, FrontierBrief, Missing, Sight, Vote
from runtime.core.voting.likelihood_experts import ExpertConfig
from runtime.core.voting.sight_experts import SIGHT_REFERENCES
from runtime.experts import scene_layout
from runtime.experts.scene_layout import SceneLayoutExperts
from runtime.experts.scorer import Scorer

CFG = ExpertConfig()
NEVER = Deadline.never(SystemClock())


def brief(*sights: Sight | None, goal: str = "toilet") -> Brief:
    told = (FrontierBrief(i, 1.0, (), (), sight=s) for i, s in enumerate(sights, 1))
    return Brief(goal, 0, tuple(told))


def row(text: str) -> F32:
    assert text == "toilet"
    return np.ones(1, np.float32)


@pytest.fixture
def model() -> ShownModel:
    return ShownModel()


@pytest.fixture
def experts(model: ShownModel) -> Iterator[SceneLayoutExperts]:
    with Scorer([("small", model)], SystemClock()) as scorer:
        yield SceneLayoutExperts(TaughtLayout(), row, scorer)


def chosen(outcome: Vote | Missing) -> tuple[int, ...]:
    assert isinstance(outcome, Vote), outcome
    return outcome.frontiers


def looks(experts: SceneLayoutExperts) -> list[tuple[float, ...]]:
    assert isinstance(experts.layout, TaughtLayout)
    return experts.layout.ways


THREE = brief(sight(0.25, mark=1), sight(0.5, mark=4), sight(0.75, mark=1))


def test_the_view_with_the_better_prospect_is_recommended(experts: SceneLayoutExperts) -> None:
    for ask in (experts.head(CFG), experts.language(CFG)):
        assert chosen(ask(THREE, NEVER)) == (2,)


def test_a_view_is_looked_at_once_whatever_is_looked_for(experts: SceneLayoutExperts) -> None:
    experts.head(CFG)(THREE, NEVER)
    assert len(looks(experts)) == 3
    experts.language(CFG)(replace(THREE, goal="lamp"), NEVER)
    later = brief(*(replace(f.sight, column=f.sight.column + 0.004, range_m=2.05)
                    for f in THREE.frontiers if f.sight is not None))  # fmt: skip
    experts.head(CFG)(later, NEVER)
    assert len(looks(experts)) == 3
    assert looks(experts)[1] == pytest.approx((0.5, 2.0 / 5.0))
    experts.head(CFG)(brief(sight(0.6, mark=4), sight(0.5, 3.0, mark=4)), NEVER)
    assert len(looks(experts)) == 5


def test_what_is_kept_of_views_is_bounded(
    experts: SceneLayoutExperts, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scene_layout, "VIEWS_KEPT", 2)
    for _ in range(2):
        experts.head(CFG)(THREE, NEVER)
    assert len(looks(experts)) == 6
    assert len(experts._views) == 2


def test_the_language_model_reads_each_view_once_and_no_view_once(
    experts: SceneLayoutExperts, model: ShownModel
) -> None:
    for _ in range(2):
        experts.language(CFG)(THREE, NEVER)
    assert sorted(model.shown) == [0.0, 1.0, 4.0]  # two views are alike


def test_a_frontier_that_was_never_seen_counts_as_unknown(experts: SceneLayoutExperts) -> None:
    outcome = experts.head(CFG)(brief(None, sight(0.5, mark=4), None), NEVER)
    assert chosen(outcome) == (2,)
    assert isinstance(outcome, Vote)
    assert len(outcome.probabilities) == 3


@pytest.mark.parametrize("by", ["head", "language"])
def test_without_a_view_it_has_no_word(experts: SceneLayoutExperts, by: str) -> None:
    ask = getattr(experts, by)(CFG)
    unseen = Missing("sle", Absence.NO_IMAGES, "no view of a frontier yet")
    assert ask(brief(None, None), NEVER) == unseen
    one_colour = replace(sight(0.5), features=np.full((3, 2, 4), 2.5, np.float16))
    broken = replace(sight(0.5), features=np.full((3, 2, 4), np.nan, np.float16))
    blank = Missing("sle", Absence.NO_IMAGES, "of 2 views none shows anything")
    assert ask(brief(one_colour, broken), NEVER) == blank
    assert ask(brief(sight(0.5)), NEVER) == Missing("sle", Absence.NO_EVIDENCE)  # no choice
    assert looks(experts) == []


def test_evidence_that_is_none_is_refused(experts: SceneLayoutExperts) -> None:
    experts.row = lambda text: np.full(1, np.inf, np.float32)
    with pytest.raises(ValueError, match="not finite"):
        experts.head(CFG)(THREE, NEVER)


def test_without_its_language_model_it_says_so() -> None:
    mute = SceneLayoutExperts(TaughtLayout(), row, mute="another language model")
    assert mute.ready(NEVER)
    told = Missing("sle", Absence.NO_MODEL, "another language model")
    assert mute.language(CFG)(THREE, NEVER) == told
    assert chosen(mute.head(CFG)(THREE, NEVER)) == (2,)


def test_a_language_model_that_is_too_slow_is_late() -> None:
    clock, gate = ManualClock(), threading.Semaphore(0)
    begun = threading.Semaphore(0)

    class Slow(ShownModel):
        def score(self, *asked: object, **shown: np.ndarray) -> list[float]:
            begun.release()
            assert gate.acquire(timeout=20.0)
            return super().score(*asked, **shown)  # type: ignore[arg-type]

    got: list[Vote | Missing] = []
    with Scorer([("small", Slow())], clock) as scorer:
        experts = SceneLayoutExperts(TaughtLayout(), row, scorer)
        by = Deadline.after(1.0, clock)
        asker = threading.Thread(target=lambda: got.append(experts.language(CFG)(THREE, by)))
        asker.start()
        assert begun.acquire(timeout=20.0)
        clock.advance(10.0)
        asker.join(20.0)
        assert not experts.ready(Deadline.after(1.0, clock))
        gate.release(9)
    assert got == [Missing("sle", Absence.LATE, "0 of 2 views answered")]
    assert len(SIGHT_REFERENCES) == 7
