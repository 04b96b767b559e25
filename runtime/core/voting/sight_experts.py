"""SLE by what a detector's backbone saw of the views toward frontiers: its questions to a language
model that is shown them, and its vote. No model here.

A view stands before the context in place of words. Its score is centred as those of words are: on
other words after the same view, and on the same word after no view.
"""

from collections.abc import Iterable, Mapping, Sequence
from statistics import fmean
from typing import Final

from runtime.core.types import Brief, Missing, Vote
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


def vote_sights(
    brief: Brief, nats: Mapping[int, float], cfg: ExpertConfig, rung: str
) -> Vote | Missing:
    """SLE on a rung that was taught views: `nats` by frontier that was seen; of others nothing is
    known."""
    told = {i: (value, VIEW) for i, value in nats.items()}
    return vote_where_known("sle", brief, told, cfg, unknown_weight(rung))


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
