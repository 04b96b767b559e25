"""SLE by what a detector's backbone saw of the views toward frontiers: its questions to a language
model that is shown them, and its vote. No model here.

A view stands before the context in place of words. Its score is centred as those of words are: on
other words after the same view, and on the same word after no view.
"""

from collections.abc import Iterable, Mapping
from statistics import fmean

from runtime.core.types import Brief, Missing, Vote
from runtime.core.voting.likelihood_experts import (
    REFERENCES,
    VIEW,
    ExpertConfig,
    LikelihoodQuestion,
    vote_where_known,
)

SIGHT_REFERENCES = tuple(word for word in REFERENCES if word != "sofa")
"""One token each: a view is read once for all of them."""


def vote_sights(brief: Brief, nats: Mapping[int, float], cfg: ExpertConfig) -> Vote | Missing:
    """SLE by what was taught of views: `nats` by frontier that was seen; of others nothing is
    known."""
    return vote_where_known("sle", brief, {i: (value, VIEW) for i, value in nats.items()}, cfg)


def sight_questions(context: str, goal: str, seen: Iterable[str]) -> tuple[LikelihoodQuestion, ...]:
    """Everything to be scored before `sight_evidence` can be computed. `seen`: digests of views,
    of which one is of none."""
    words = dict.fromkeys((*SIGHT_REFERENCES, goal))
    return tuple(LikelihoodQuestion(context, " " + word, one) for one in seen for word in words)


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
            known[one] = answers[LikelihoodQuestion(context, " " + goal, one)] - fmean(
                answers[LikelihoodQuestion(context, " " + word, one)] for word in SIGHT_REFERENCES
            )
        except KeyError:
            continue
    return {one: known[one] - known[blank] for one in seen if blank in known and one in known}
