"""CDM: from the experts' sets to one frontier, and the closest frontier when they do not agree."""

import random
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations

from runtime.core.types import Ballot, Decision, Frontier, Vote


@dataclass(frozen=True)
class ConsensusConfig:
    """[consensus]"""

    rank: str = "nearest"  # within the chosen set; "farthest" is Algorithm 1's literal argmax
    mode: str = "strict"
    """"strict": two must agree. "lenient": a lone vote counts. To compare with: "best" takes what
    one is surest of, "majority-K" the most frequent of K samples of the first vote."""
    fallback: str = "closest"  # when nobody agrees; "geometry" goes by information gain
    seed: int = 0  # of the samples


MODES = ("strict", "lenient", "best", "majority-3", "majority-5")


def agree(sets: Sequence[frozenset[int]], lenient: bool = False) -> tuple[str, frozenset[int]]:
    """The consensus set of n experts' sets and the rule that gave it: "all" (their intersection),
    "pairs" (the union of pairwise intersections), "lone" (only when lenient and one voted), or
    "closest" with the empty set. One set alone is no agreement. (Paper, Algorithm 1.)"""
    if len(sets) >= 2:
        everyone = frozenset.intersection(*sets)
        if everyone:
            return "all", everyone
        pairs = frozenset[int]().union(*(a & b for a, b in combinations(sets, 2)))
        if pairs:
            return "pairs", pairs
    elif len(sets) == 1 and lenient:
        return "lone", sets[0]
    return "closest", frozenset()


def elect(
    ballot: Ballot,
    frontiers: Iterable[Frontier],
    cfg: ConsensusConfig,
    stamp_ns: int = 0,
    why: str = "",
    order: Sequence[int] = (),
) -> Decision:
    """Decide a ballot among the reachable frontiers. Ties in distance go to the older frontier.
    `order` ranks frontiers for the fallback; without it the closest is the fallback."""
    reachable = sorted(
        (f for f in frontiers if f.distance_m < float("inf")), key=lambda f: (f.distance_m, f.id)
    )
    if not reachable:
        return Decision(None, "none", (), None, ballot, stamp_ns, why)
    known = frozenset(f.id for f in reachable)
    sets = [s for v in sorted(ballot.votes, key=_name) if (s := frozenset(v.frontiers) & known)]
    if cfg.mode in ("strict", "lenient"):
        rule, chosen = agree(sets, cfg.mode == "lenient")
    else:
        rule, chosen = _single(ballot, reachable, cfg, stamp_ns)
    closest = reachable[0].id
    ranked = [f.id for f in reachable if f.id in chosen]
    if ranked and cfg.rank == "farthest":
        top = max(f.distance_m for f in reachable if f.id in chosen)
        ranked = [f.id for f in reachable if f.id in chosen and f.distance_m == top]
    alive = {f.id for f in reachable}
    fallback = next((i for i in order if i in alive), closest)
    if not ranked and order:
        rule = cfg.fallback
    winner = ranked[0] if ranked else fallback
    return Decision(winner, rule, tuple(sorted(chosen)), closest, ballot, stamp_ns, why)


def successor(decision: Decision, frontiers: Iterable[Frontier]) -> int | None:
    """The elected frontier if it still exists and can be reached, else the nearest of the chosen
    set that does, else the closest of all; None when there is none."""
    alive = {f.id: f.distance_m for f in frontiers if f.distance_m < float("inf")}
    if decision.frontier in alive:
        return decision.frontier
    candidates = [i for i in decision.chosen if i in alive] or sorted(alive)
    return min(candidates, key=lambda i: (alive[i], i), default=None)


def _single(
    ballot: Ballot, reachable: Sequence[Frontier], cfg: ConsensusConfig, stamp_ns: int
) -> tuple[str, frozenset[int]]:
    """The modes that follow one expert: its surest frontier, or the most frequent of samples of its
    probabilities. `reachable` is sorted by distance: ties go to the nearest."""
    if not ballot.votes:
        return "closest", frozenset()
    vote = min(ballot.votes, key=_name)
    p = dict(vote.probabilities)
    ids = [f.id for f in reachable if p.get(f.id, 0.0) > 0]
    if not ids:
        return "closest", frozenset()
    if cfg.mode == "best":
        return "best", frozenset([max(ids, key=lambda i: p[i])])
    k = int(cfg.mode.removeprefix("majority-"))
    rng = random.Random(f"{cfg.seed}/{stamp_ns}")
    drawn = Counter(rng.choices(ids, [p[i] for i in ids], k=k))
    return "majority", frozenset([max(ids, key=lambda i: drawn[i])])


def _name(vote: Vote) -> str:
    return vote.expert
