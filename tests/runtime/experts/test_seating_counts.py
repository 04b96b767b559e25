"""Where the table of counts sits on the ladders of O2F and R2F."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack

import pytest

from runtime.clock import Deadline, SystemClock
from runtime.core.types import Brief, FrontierBrief, NearbyObject, Vote
from runtime.core.voting.counts import Count, CountTable
from runtime.core.voting.likelihood_experts import ExpertConfig, WordEvidence
from runtime.experts.counts import CountExperts
from runtime.experts.likelihood import LikelihoodExperts
from runtime.experts.panel import Expert
from runtime.experts.scorer import Scorer
from runtime.experts.seating import Seating

ROOMS = ("bathroom", "bedroom")
TABLE = CountTable.of([
    Count(
        rooms={"bathroom": 90, "bedroom": 90},
        holding={"toilet": {"bathroom": 90, "bedroom": 0}, "lamp": {"bathroom": 9, "bedroom": 90}},
        things={"toilet": 90, "sink": 90, "lamp": 90},
        beside={"toilet": {"sink": 90}, "sink": {"toilet": 90}, "lamp": {}},
        doors={"bathroom": {"bedroom": 1}, "bedroom": {"bathroom": 1}},
    )
])  # fmt: skip


def brief(goal: str) -> Brief:
    sink, lamp = NearbyObject("sink", 0.9, 0.2), NearbyObject("lamp", 0.9, 0.2)
    return Brief(
        goal,
        7,
        (
            FrontierBrief(1, 1.0, (sink,), (("bathroom", 1.0),), unknown_m2=1.0),
            FrontierBrief(2, 2.0, (lamp,), (("bedroom", 1.0),), unknown_m2=1.0),
        ),
    )


class Says:
    """A scorer that finds every goal likely after one word, a little or very; or it fails."""

    def __init__(self, word: str, nats: float = 1.0, broken: bool = False) -> None:
        self.word, self.nats, self.broken = word, nats, broken

    def score(self, context: str, continuations: Sequence[str]) -> tuple[float, ...]:
        if self.broken:
            raise RuntimeError("no memory")
        likely = self.word in context
        return tuple(
            -5.0 + self.nats * (likely and c in (" toilet", " unicorn")) for c in continuations
        )


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


def seated(stack: ExitStack, model: Says) -> Seating:
    """The text encoder and the model prefer the lamp, counts the sink."""

    def scored(name: str, by: Says) -> LikelihoodExperts:
        return LikelihoodExperts(stack.enter_context(Scorer([(name, by)], SystemClock())), ROOMS)

    counts = CountExperts(TABLE, lambda name: {})
    seats = Seating("small", lambda brief: {}, scored("embedding", Says("lamp", 4.0)), counts)
    seats.by_likelihood = scored("small", model)
    return seats


def asked(seats: Seating, words: WordEvidence, goal: str = "toilet") -> tuple[tuple[int, ...], str]:
    cfg = ExpertConfig(words=words, bar=1.2)
    table: dict[str, Expert] = seats.experts(("o2f", "r2f", "sle"), cfg)
    outcome = table["o2f"](brief(goal), Deadline.never(SystemClock()))
    assert isinstance(outcome, Vote), outcome
    return outcome.frontiers, outcome.rung


def test_counts_answer_in_place_of_a_language_model_that_fails(stack: ExitStack) -> None:
    seats = seated(stack, Says("lamp", broken=True))
    assert asked(seats, "language") == ((1,), "counts")
    assert seats.rung() == "counts alone"
    assert not seats.by_embedding.used


def test_while_it_answers_counts_are_not_asked(stack: ExitStack) -> None:
    seats = seated(stack, Says("lamp", 4.0))
    assert asked(seats, "language") == ((2,), "local")
    assert seats.rung() == "small"


def test_counts_come_first_where_they_are_to(stack: ExitStack) -> None:
    seats = seated(stack, Says("lamp", 4.0))
    assert asked(seats, "counts") == ((1,), "counts")
    assert seats.health()["rungs"] == {"o2f": "counts"}
    assert seats.rung() == "counts", "which nobody fell back on"


def test_what_was_never_counted_is_for_the_rungs_below(stack: ExitStack) -> None:
    assert asked(seated(stack, Says("lamp", 4.0)), "counts", "unicorn") == ((2,), "local")
    broken = seated(stack, Says("lamp", broken=True))
    assert asked(broken, "counts", "unicorn") == ((2,), "embedding")


@pytest.mark.parametrize(("nats", "frontier"), [(0.5, 1), (9.0, 2)])
def test_both_are_weighed_together(stack: ExitStack, nats: float, frontier: int) -> None:
    seats = seated(stack, Says("lamp", nats))
    assert asked(seats, "both") == ((frontier,), "local+counts")
    assert seats.rung() == "small"


def test_of_both_counts_are_left_when_the_model_fails(stack: ExitStack) -> None:
    assert asked(seated(stack, Says("lamp", broken=True)), "both") == ((1,), "counts")
