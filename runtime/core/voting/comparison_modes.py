"""Ways to elect that the consensus is compared with: evidence weighed against way, or one expert's
word. Each gives its rule's name and the set that it chose, "closest" and none where nobody was
heard."""

import math
import random
from collections import Counter
from collections.abc import Collection, Iterable, Mapping

from runtime.core.types import Vote

PULL = 2.0  # nats of one expert at most, either way
NOBODY: tuple[str, frozenset[int]] = ("closest", frozenset())


def weighted(
    votes: Iterable[Vote], distance_m: Mapping[int, float], weights: Mapping[str, float]
) -> tuple[str, frozenset[int]]:
    """The least way, where each expert's evidence for a frontier shortens the way to it and
    evidence against lengthens it, by so many metres a nat. Nothing but weights that were measured
    makes this sound."""
    heard, cost_m = False, dict(distance_m)
    for vote in sorted(votes, key=lambda v: v.expert):
        weight = weights.get(vote.expert, 0.0)
        for id, nats in evidence(vote, cost_m).items():
            cost_m[id] -= weight * nats
            heard = heard or weight > 0
    if not heard:
        return NOBODY
    return "weighted", frozenset([min(cost_m, key=lambda i: (cost_m[i], i))])


def evidence(vote: Vote, among: Collection[int]) -> dict[int, float]:
    """log p of the frontiers that a vote has a probability for, less their mean, nats; bounded, so
    that no expert can outweigh everything."""
    p = {id: share for id, share in vote.probabilities if id in among}
    if not p:
        return {}
    nats = {id: math.log(max(share, 1e-6)) for id, share in p.items()}
    mean = sum(nats.values()) / len(nats)
    return {id: max(-PULL, min(PULL, x - mean)) for id, x in nats.items()}


def surest(votes: Collection[Vote], distance_m: Mapping[int, float]) -> tuple[str, frozenset[int]]:
    """What the first expert by name is surest of; of equals the nearest. `distance_m` is ordered,
    nearest first."""
    p = _heard(votes, distance_m)
    return ("best", frozenset([max(p, key=lambda i: p[i])])) if p else NOBODY


def majority(
    votes: Collection[Vote], distance_m: Mapping[int, float], samples: int, seed: str
) -> tuple[str, frozenset[int]]:
    """The most frequent of so many samples of the first expert's probabilities; of equals the
    nearest."""
    p = _heard(votes, distance_m)
    if not p:
        return NOBODY
    drawn = Counter(random.Random(seed).choices(list(p), list(p.values()), k=samples))
    return "majority", frozenset([max(p, key=lambda i: drawn[i])])


def _heard(votes: Collection[Vote], distance_m: Mapping[int, float]) -> dict[int, float]:
    """The first expert's probabilities of reachable frontiers, nearest first."""
    if not votes:
        return {}
    p = dict(min(votes, key=lambda v: v.expert).probabilities)
    return {i: p[i] for i in distance_m if p.get(i, 0.0) > 0}
