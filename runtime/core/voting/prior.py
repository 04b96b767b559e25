"""Votes as what they are for a search: evidence on where the unknown holds the thing. It multiplies
what unknown areas say, and the order of frontiers is planned over both."""

import math
from collections.abc import Collection, Mapping

from runtime.core.belief import Ahead, Belief, believed
from runtime.core.types import Ballot, Decision, Missing, Vote
from runtime.core.voting import search_order

PULL = 2.0  # nats of one expert at most, either way of its mean
NAMED = 1.0  # nats of a frontier that is named by an expert that tells no numbers


def heard(ballot: Ballot) -> dict[str, Mapping[int, float]]:
    """By expert that has any evidence, whether or not it recommends anything: nats by frontier."""
    every: tuple[Vote | Missing, ...] = (*ballot.votes, *ballot.missing)
    told = {each.expert: dict(each.nats) or _named(each) for each in every}
    return {expert: told[expert] for expert in sorted(told) if told[expert]}


def _named(outcome: Vote | Missing) -> dict[int, float]:
    return dict.fromkeys(outcome.frontiers, NAMED) if isinstance(outcome, Vote) else {}


def pooled(evidence: Mapping[str, Mapping[int, float]], ids: Collection[int]) -> dict[int, float]:
    """Nats of all experts together, by frontier. Of each the difference to its own mean counts, cut
    to PULL; who knows nothing of a frontier has 0 for it. Where experts contradict each other, what
    is left of their sum is taken as many times less as they cancel out."""
    total = {id: [0.0, 0.0] for id in sorted(ids)}  # for and against
    for expert in sorted(evidence):
        known = {id: evidence[expert].get(id, 0.0) for id in total}
        mean = math.fsum(known.values()) / len(known) if known else 0.0
        for id, nats in known.items():
            apart = max(-PULL, min(PULL, nats - mean))
            total[id][apart < 0] += apart
    return {id: _agreed(*both) for id, both in total.items()}


def _agreed(speaks_for: float, against: float) -> float:
    """Of nats for and against, 0 or more and 0 or less."""
    said = speaks_for - against
    return (speaks_for + against) * abs(speaks_for + against) / said if said else 0.0


def elect(ballot: Ballot, ahead: Ahead, closest: int, stamp_ns: int, why: str) -> Decision:
    """The first of the order that is planned over what the unknown and all experts say."""
    evidence = heard(ballot)
    order = _planned(ahead, evidence)
    without = tuple(
        (left_out, _planned(ahead, {e: nats for e, nats in evidence.items() if e != left_out})[0])
        for left_out in evidence
    )
    rule, chosen = ("prior", order[:1]) if evidence else ("ahead", ())
    likely = belief(ahead, evidence)
    return Decision(
        order[0], rule, chosen, closest, ballot, stamp_ns, why, without, order, likely
    )  # fmt: skip


def belief(ahead: Ahead, evidence: Mapping[str, Mapping[int, float]]) -> Belief:
    """Where the thing may be."""
    return believed(ahead, pooled(evidence, ahead.ids), said=", ".join(evidence))


def _planned(ahead: Ahead, evidence: Mapping[str, Mapping[int, float]]) -> tuple[int, ...]:
    return search_order.ordered(ahead, pooled(evidence, ahead.ids))
