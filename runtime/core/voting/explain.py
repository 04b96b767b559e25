"""A decision in one line that a person can read: what, by whose word, and what else it could be."""

from collections.abc import Callable

from runtime.core.types import Decision, Vote
from runtime.core.voting import consensus
from runtime.core.voting.names import listed

REASON_MAX = 100  # characters of one expert's reason
THEN_MAX = 5  # frontiers of the order that are told


def in_words(decision: Decision) -> str:
    """ "frontier 7, on which o2f and r2f agree (o2f: sink, towel (0.61); ...); the closest is 3;
    without r2f: 3"."""
    if decision.frontier is None:
        return "no frontier can be reached"
    parts = [f"frontier {decision.frontier}, {_why(decision, decision.frontier)}"]
    if len(decision.order) > 1:
        parts.append(f"then {', '.join(str(i) for i in decision.order[1:THEN_MAX])}")
    if decision.closest != decision.frontier:
        parts.append(f"the closest is {decision.closest}")
    others = [f"without {e}: {i}" for e, i in decision.without if i != decision.frontier]
    return "; ".join(parts + others)


def _why(decision: Decision, elected: int) -> str:
    votes = decision.ballot.votes
    if decision.rule == "prior":
        what = "where it is found soonest" if decision.order else "the most to find for the way"
        names = [one.expert for one in decision.taken.said] if decision.taken else []
        return f"{what} by {_whose(names)}{_said(decision)}"
    backers = [v for v in votes if elected in v.frontiers] or list(votes)
    if decision.chosen:
        said = "; ".join(f"{v.expert}: {_reason(v, elected)}" for v in backers)
        names = [v.expert for v in backers]
        verb = {
            "lone": "for which {0} alone speaks",
            "weighted": "the least way by the weighed evidence of {0}",
            "best": "of which {0} is surest",
            "majority": "most frequent of the samples of {0}",
        }.get(decision.rule, "on which {0} agree")
        return verb.format(listed(names)) + f" ({said})"
    what = {
        "closest": "the closest",
        "ahead": "from where the unknown is looked through soonest",
    }.get(decision.rule, f"by {decision.rule}")
    absent = "; ".join(f"{m.expert}: {m.cause}" for m in decision.ballot.missing)
    return f"{what}, as {no_agreement(decision)}" + (f" ({absent})" if absent else "")


def _whose(names: list[str]) -> str:
    return f"the unknown and the word of {listed(names)}" if names else "the unknown alone"


def _said(decision: Decision) -> str:
    """ " (o2f: sink, towel (0.61))": of those who name the elected frontier."""
    elected = decision.frontier
    backers = [v for v in decision.ballot.votes if elected is not None and elected in v.frontiers]
    said = "; ".join(f"{v.expert}: {_reason(v, elected)}" for v in backers if elected is not None)
    return f" ({said})" if said else ""


def no_agreement(decision: Decision, called: Callable[[str], str] = str) -> str:
    """Why nobody's word decided; `called`: the name of an expert, for a person."""
    names = [called(vote.expert) for vote in decision.ballot.votes]
    if not names:
        return "no expert votes" if decision.ballot.missing else "nobody was asked"
    if len(names) == 1:
        return f"{names[0]} votes alone"
    if consensus.agree([frozenset(v.frontiers) for v in decision.ballot.votes])[1]:
        return f"what {listed(names)} agree on is too far away or voted against"
    return f"{listed(names)} do not agree"


def _reason(vote: Vote, frontier: int) -> str:
    text = vote.reason_for(frontier)
    return text if len(text) <= REASON_MAX else text[: REASON_MAX - 1] + "…"
