"""SLE by what a detector's backbone saw of the views toward frontiers: its questions to a language
model that is shown them, and its vote. No model here.

A view stands before the context in place of words. Its score is centred as those of words are: on
other words after the same view, and on the same word after no view.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from statistics import fmean
from typing import Final

from runtime.core.types import Absence, Brief, Missing, Vote
from runtime.core.voting.likelihood_experts import (
    REFERENCES,
    UNKNOWN_WEIGHT,
    VIEW,
    ExpertConfig,
    LikelihoodQuestion,
    vote_where_known,
)

SIGHT_REFERENCES = tuple(word for word in REFERENCES if word != "sofa")
"""One token each: a view is read once for all of them."""
HEAD, LANGUAGE = "head", "language"
"""Rungs: of the network alone, of the language model that is shown what it makes of a view."""
HEAD_UNKNOWN_WEIGHT: Final = 0.25
"""Of the unknown area behind a frontier, where the evidence was taught how much lies beyond: what
it knows already must not count twice."""
TOLD: Final = 2
"""Frontiers that are named where none is preferred."""


def vote_sights(
    brief: Brief, nats: Mapping[int, float], cfg: ExpertConfig, rung: str
) -> Vote | Missing:
    """SLE on a rung that was taught views: `nats` by frontier that was seen; of others nothing is
    known. Where it prefers none, what it saw all the same is told."""
    told = {i: (value, VIEW) for i, value in nats.items()}
    weight = unknown_weight(rung)
    outcome = vote_where_known("sle", brief, told, cfg, weight)
    if isinstance(outcome, Vote) or outcome.why is not Absence.NO_PREFERENCE:
        return outcome
    every = vote_where_known("sle", brief, told, replace(cfg, bar=0.0), weight)
    return replace(outcome, detail=_likeliest(every, nats, cfg.bar))


def _likeliest(every: Vote | Missing, seen: Collection[int], bar: float) -> str:
    """Of a vote for all: "likeliest are 7 (0.312) and 3 (0.280, never looked at); it votes from
    0.375 on, 1.5 times an equal share"."""
    assert isinstance(every, Vote)  # for whom all are above the bar
    ranked = sorted(every.probabilities, key=lambda each: (-each[1], each[0]))
    each = [f"{i} ({p:.3f}{'' if i in seen else ', never looked at'})" for i, p in ranked[:TOLD]]
    return (
        f"likeliest are {' and '.join(each)}; it votes from {bar / len(ranked):.3f} on, "
        f"{bar:g} times an equal share"
    )


def unknown_weight(rung: str) -> float:
    """Exponent of the unknown area behind a frontier in the prior of SLE on a rung."""
    return HEAD_UNKNOWN_WEIGHT if rung == HEAD else UNKNOWN_WEIGHT


def sight_questions(context: str, goal: str, seen: Iterable[str]) -> tuple[LikelihoodQuestion, ...]:
    """Everything to be scored before `sight_evidence` can be computed. `seen`: digests of views,
    of which one is of none."""
    words = dict.fromkeys((*SIGHT_REFERENCES, goal))
    return tuple(LikelihoodQuestion(context, " " + word, one) for one in seen for word in words)


def preferences(words: Sequence[float], references: Sequence[float]) -> list[float]:
    """Log likelihoods after one view, of words and of the references -> how much likelier each word
    is than these, nats."""
    middle = fmean(references)
    return [nats - middle for nats in words]


def sight_evidence(
    context: str,
    goal: str,
    seen: Iterable[str],
    blank: str,
    answers: Mapping[LikelihoodQuestion, float],
) -> dict[str, float]:
    """How much more likely the goal becomes by each view than by none, nats, by digest; only for
    those whose questions are all answered, and for none before those of no view, `blank`, are."""
    known: dict[str, float] = {}
    for one in (blank, *seen):
        try:
            goals, others = (
                [answers[LikelihoodQuestion(context, " " + word, one)] for word in words]
                for words in ((goal,), SIGHT_REFERENCES)
            )
        except KeyError:
            continue
        (known[one],) = preferences(goals, others)
    return {one: known[one] - known[blank] for one in seen if blank in known and one in known}
