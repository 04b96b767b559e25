"""Votes as what they are for a search: evidence on where the unknown holds the thing. It multiplies
what unknown areas say, and the best is elected by both."""

import math
from collections.abc import Collection, Mapping, Sequence

from runtime.core.belief import Ahead, Belief, Evidence, believed
from runtime.core.types import Ballot, Decision, Missing, Vote
from runtime.core.voting import search_order

PULL = 2.0  # nats of one expert at most, either way of its mean
NAMED = 1.0  # nats of a frontier that is named by an expert that tells no numbers
LONE = 0.3  # of what an expert alone says of a frontier, beyond what any other backs
NEWEST = 0.4  # of an expert's evidence for a frontier, what it says now against what it said


def heard(ballot: Ballot, ahead: Ahead) -> Evidence:
    """By expert that has any evidence, whether or not it recommends anything: nats by frontier, the
    difference to their mean, cut to PULL. Who knows nothing of a frontier has 0 for it. What it
    said of the same frontier before goes on counting, less and less: what is said at random cancels
    out over time, what is known stays."""
    every: tuple[Vote | Missing, ...] = (*ballot.votes, *ballot.missing)
    now = {each.expert: dict(each.nats) or _named(each) for each in every}
    found: dict[str, Mapping[int, float]] = {}
    for expert in sorted({e for e, nats in now.items() if nats} | set(ahead.before)):
        nats, before = _apart(now.get(expert, {}), ahead.ids), ahead.before.get(expert, {})
        found[expert] = {
            id: NEWEST * x + (1 - NEWEST) * before[id] if id in before else x
            for id, x in nats.items()
        }
    return found


def _named(outcome: Vote | Missing) -> dict[int, float]:
    return dict.fromkeys(outcome.frontiers, NAMED) if isinstance(outcome, Vote) else {}


def _apart(nats: Mapping[int, float], ids: Collection[int]) -> dict[int, float]:
    known = {id: nats.get(id, 0.0) for id in sorted(ids)}
    mean = math.fsum(known.values()) / max(1, len(known))
    return {id: max(-PULL, min(PULL, x - mean)) for id, x in known.items()}


def pooled(evidence: Evidence, ids: Collection[int]) -> dict[int, float]:
    """Nats of all experts together, by frontier: what two or more say counts, and of what one alone
    says, for or against, the part LONE."""
    found = {}
    for id in sorted(ids):
        said = [nats.get(id, 0.0) for nats in evidence.values()]
        spoken_for = sorted((x for x in said if x > 0), reverse=True)
        against = sorted((-x for x in said if x < 0), reverse=True)
        found[id] = _supported(spoken_for) - _supported(against)
    return found


def _supported(nats: Sequence[float]) -> float:
    """Of nats in one direction, the strongest first: of the strongest no more counts in full than
    the next one backs."""
    if not nats:
        return 0.0
    backed = nats[1] if len(nats) > 1 else 0.0
    return backed + LONE * (nats[0] - backed) + math.fsum(nats[1:])


def elect(
    ballot: Ballot, ahead: Ahead, closest: int, stamp_ns: int, why: str, silent: str
) -> Decision:
    """The first by what the unknown and all experts say: of a planned order, where the ways between
    frontiers are known. `silent`: the rule where nobody says anything."""
    evidence = heard(ballot, ahead)
    order = _ordered(ahead, evidence)
    without = tuple(
        (left_out, _ordered(ahead, {e: nats for e, nats in evidence.items() if e != left_out})[0])
        for left_out in evidence
    )
    rule, chosen = ("prior", order[:1]) if evidence else (silent, ())
    planned = order if ahead.planned else ()
    told = ballot, stamp_ns, why, without, planned, belief(ahead, evidence), evidence
    return Decision(order[0], rule, chosen, closest, *told)


def belief(ahead: Ahead, evidence: Evidence) -> Belief:
    """Where the thing may be."""
    return believed(ahead, pooled(evidence, ahead.ids), said=", ".join(evidence))


def _ordered(ahead: Ahead, evidence: Evidence) -> tuple[int, ...]:
    return search_order.ordered(ahead, pooled(evidence, ahead.ids))
