"""Votes as what they are for a search: evidence on where the unknown holds the thing. It multiplies
what unknown areas say, and the best is elected by both."""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from typing import Final

from runtime.core.belief import Ahead, Belief, Evidence, Taken, believed
from runtime.core.types import Ballot, Decision, Missing, Vote
from runtime.core.voting import search_order
from runtime.core.voting.taken import by_whom, said_of, taken

LEAST = 1e-9  # what says anything
PULL = 1.0  # nats of one expert at most, either way of its mean
WEIGHTS: Final[Mapping[str, float]] = {"r2f": 2.0}  # of a nat of one's; of the others 1
NAMED = 1.0  # nats of a frontier that is named by an expert that tells no numbers
LONE = 0.6  # of what an expert alone says of a frontier, beyond what any other backs
NEWEST = 0.4  # of an expert's evidence for a frontier, what it says now against what it said
Electable = Callable[[Sequence[Vote]], Collection[int]]
"""Votes -> the frontiers that may win by them, one or more, the nearest first."""


def heard(ballot: Ballot, ahead: Ahead) -> Evidence:
    """By expert that has any evidence, whether or not it recommends anything: nats by frontier, the
    difference to the mean of those it knows of, weighed and cut to PULL; 0 of others.
    What it said of the same frontier before goes on counting, less and less: what is said at random
    cancels out over time, what is known stays."""
    return {
        expert: {
            id: NEWEST * x + (1 - NEWEST) * before[id] if id in before else x
            for id, x in nats.items()
        }
        for expert, nats in _said(ballot, ahead).items()
        for before in [ahead.before.get(expert, {})]
    }


def remembering(decision: Decision, before: Decision | None, living: Collection[int]) -> Decision:
    """The decision with what was said up to the one `before` of frontiers that it was not made on:
    nobody was asked about them. Of frontiers that are not among the `living` nothing is kept."""
    earlier = before.said if before else {}
    said = {
        expert: {
            id: nats
            for id, nats in {**earlier.get(expert, {}), **decision.said.get(expert, {})}.items()
            if id in living
        }
        for expert in sorted({*earlier, *decision.said})
    }
    return replace(decision, said=said)


def counted(ballot: Ballot, ahead: Ahead, evidence: Evidence) -> Evidence:
    """Of what was `heard`, what counts: all that an expert says who says what it said before, and
    nothing of one who says the contrary (their cosine over the frontiers that were there)."""
    found: dict[str, Mapping[int, float]] = {}
    for expert, now in _said(ballot, ahead).items():
        before = ahead.before.get(expert, {})
        shared = [(x, before[id]) for id, x in now.items() if id in before]
        size = math.sqrt(math.fsum(x * x for x, _ in shared) * math.fsum(y * y for _, y in shared))
        trust = max(0.0, math.fsum(x * y for x, y in shared) / size) if size > LEAST else 1.0
        found[expert] = {id: trust * x for id, x in evidence[expert].items()}
    return found


def _said(ballot: Ballot, ahead: Ahead) -> Evidence:
    """What each says now, and nothing of who was heard before and is not now."""
    now = spoken(ballot, ahead.ids)
    experts = sorted({e for e, nats in now.items() if nats} | set(ahead.before))
    return {e: _apart(now.get(e, {}), ahead.ids, WEIGHTS.get(e, 1.0)) for e in experts}


def spoken(ballot: Ballot, ids: Collection[int]) -> dict[str, dict[int, float]]:
    """Nats as each expert tells them now, by the frontiers that it tells any of."""
    every: tuple[Vote | Missing, ...] = (*ballot.votes, *ballot.missing)
    return {each.expert: dict(each.nats) or _named(each, ids) for each in every}


def _named(outcome: Vote | Missing, ids: Collection[int]) -> dict[int, float]:
    if isinstance(outcome, Missing):
        return {}
    return {id: NAMED * (id in outcome.frontiers) for id in ids}


def _apart(nats: Mapping[int, float], ids: Collection[int], weight: float) -> dict[int, float]:
    """Scores of views have no level of their own: one that is not known is no less than those."""
    known = [nats[id] for id in sorted(ids) if id in nats]
    mean = math.fsum(known) / max(1, len(known))
    return {id: max(-PULL, min(PULL, weight * (nats.get(id, mean) - mean))) for id in sorted(ids)}


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
    ballot: Ballot,
    ahead: Ahead,
    closest: int,
    stamp_ns: int,
    why: str,
    silent: str,
    electable: Electable | None = None,
) -> Decision:
    """The first by what the unknown and all experts say: of a planned order, where the ways between
    frontiers are known. `silent`: the rule where nobody says anything. `electable`: all are where
    it is not given."""
    evidence = heard(ballot, ahead)
    counts = counted(ballot, ahead, evidence)

    def order_without(left_out: str = "") -> tuple[int, ...]:
        order = _ordered(ahead, {e: nats for e, nats in counts.items() if e != left_out})
        if electable is None:
            return order
        may = electable([vote for vote in ballot.votes if vote.expert != left_out])
        first = [*(id for id in order if id in may), *may][0]
        return first, *(id for id in order if id != first)

    order = order_without()
    without = tuple((left_out, order_without(left_out)[0]) for left_out in counts)
    rule, chosen = ("prior", order[:1]) if evidence else (silent, ())
    return Decision(
        order[0],
        rule,
        chosen,
        closest,
        ballot,
        stamp_ns,
        why,
        without,
        order=order if ahead.planned else (),
        belief=belief(ahead, counts, spoken(ballot, ahead.ids)),
        said=evidence,
    )


def belief(ahead: Ahead, evidence: Evidence, now: Evidence | None = None) -> Belief:
    """Where the thing may be. `now`: what each expert says now; None: all of the evidence."""
    said = {id: by_whom(said_of(id, evidence, now)) for id in ahead.ids}
    return believed(ahead, pooled(evidence, ahead.ids), said)


def taken_for(decision: Decision, way_m: float, ahead: Ahead | None) -> Taken:
    """What its frontier was taken for; `way_m` to it on foot, `ahead` as it was elected by."""
    if ahead is None or decision.frontier is None:
        return taken(decision, way_m, None, ())
    counts = counted(decision.ballot, ahead, decision.said)
    now = spoken(decision.ballot, ahead.ids)
    return taken(decision, way_m, ahead, said_of(decision.frontier, counts, now))


def _ordered(ahead: Ahead, evidence: Evidence) -> tuple[int, ...]:
    return search_order.ordered(ahead, pooled(evidence, ahead.ids))
