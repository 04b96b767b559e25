"""In which order to look behind several frontiers, so that what is sought is found soonest in the
mean: the minimum latency problem, each place weighed by how likely the thing is there. Going to the
best one alone forgets what is passed by, and has to be come back for."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from runtime.core.belief import Ahead, SeenSurface
from runtime.core.distances.terrain import Terrain
from runtime.core.kernels import marching
from runtime.core.types import F64, I32, Decision, Frontier, Pose
from runtime.core.voting import information_gain

MOST = 8  # frontiers whose orders are all compared: 2^8 sets of them
MARCHED = 12  # frontiers that ways are measured from, the best without a vote
STEADY = 0.15  # more way in the mean that is taken into the bargain to go on where one was going


def looked_ahead(
    frontiers: Sequence[Frontier],
    unknown_m2: Mapping[int, float],
    terrain: Terrain,
    pose: Pose,
    standing: Decision | None,
    plans: bool,
    patches: tuple[SeenSurface, ...] = (),
) -> Ahead | None:
    """Of frontiers, those that unknown area is told of, as a decision without a vote ranks them;
    where it `plans`, with the ways between them. None where there are none."""
    current = standing.frontier if standing and not plans else None
    mass = information_gain.masses(frontiers, unknown_m2, current, terrain, pose)
    best = information_gain.by_worth(frontiers, mass)
    if not best:
        return None
    ahead = ahead_of(best, unknown_m2, mass, standing, patches)
    return with_ways(ahead, terrain) if plans else ahead


def ahead_of(
    best: Sequence[Frontier],
    unknown_m2: Mapping[int, float],
    mass: Mapping[int, float],
    standing: Decision | None,
    patches: tuple[SeenSurface, ...] = (),
) -> Ahead:
    """Frontiers, the best first, as they are without a vote and without ways between them.
    `standing`: the decision before."""
    return Ahead(
        tuple(f.id for f in best),
        tuple((float(f.goal_xy[0]), float(f.goal_xy[1])) for f in best),
        tuple(unknown_m2[f.id] for f in best),
        np.array([mass[f.id] for f in best]),
        np.array([f.distance_m for f in best]),
        standing=standing.frontier if standing else None,
        before=standing.said if standing else {},
        patches=patches,
    )


def with_ways(ahead: Ahead, terrain: Terrain) -> Ahead:
    """The MARCHED first, with the ways between them on the terrain. One that is not known there
    leads by where the robot is."""
    n, first_m = min(MARCHED, len(ahead.ids)), ahead.first_m[:MARCHED]
    between_m = _ways_m(ahead.at_xy[:n], terrain)
    between_m = np.minimum(np.minimum(between_m, between_m.T), first_m[:, None] + first_m)
    np.fill_diagonal(between_m, 0.0)
    return replace(
        ahead,
        ids=ahead.ids[:n],
        at_xy=ahead.at_xy[:n],
        unknown_m2=ahead.unknown_m2[:n],
        mass=ahead.mass[:n],
        first_m=first_m,
        between_m=between_m,
    )


def _ways_m(points_xy: Sequence[tuple[float, float]], terrain: Terrain) -> F64:
    """(N, N) m on foot from each point to each; inf where the terrain has no way."""
    frame = terrain.frame
    cells = frame.cells(np.array(points_xy))
    inside = ((cells >= 0) & (cells < frame.shape)).all(axis=1)
    rows, cols = cells[inside].T
    found = np.full((len(cells), len(cells)), np.inf)
    for n in np.flatnonzero(inside).tolist():
        arrival = np.full(frame.shape, np.inf)
        arrival[tuple(cells[n])] = 0.0
        marching.march(arrival, terrain.traversable, frame.resolution_m)
        found[n, inside] = arrival[rows, cols]
    return found


def ordered(ahead: Ahead, nats: Mapping[int, float]) -> tuple[int, ...]:
    """Ids in the order of least expected way, the evidence of each, nats, multiplying its mass.
    What is beyond the MOST best comes last. Where the ways between them are not known, the most for
    the way there comes first: without evidence they are in that order."""
    if not ahead.planned and not nats:
        return ahead.ids
    evidence = np.array([nats.get(id, 0.0) for id in ahead.ids])
    mass = ahead.mass * np.exp(evidence - evidence.max(initial=0.0))
    worth = mass * np.exp(-information_gain.DISCOUNT_PER_M * ahead.first_m)
    ranked = np.lexsort((np.array(ahead.ids), ahead.first_m, -worth))
    if not ahead.planned:
        return tuple(ahead.ids[n] for n in ranked.tolist())
    kept = ahead.ids.index(ahead.standing) if ahead.standing in ahead.ids else None
    if kept is not None and kept in ranked[MOST:]:
        ranked = np.concatenate([[kept], ranked[ranked != kept]])
    best, rest = ranked[:MOST], ranked[MOST:]
    ways_m = ahead.first_m[best], ahead.between_m[np.ix_(best, best)]
    keep = None if kept is None else best.tolist().index(kept)
    tour = soonest(mass[best], *ways_m, keep)
    return tuple(ahead.ids[n] for n in (*best[list(tour)].tolist(), *rest.tolist()))


def soonest(mass: F64, first_m: F64, between_m: F64, keep: int | None = None) -> tuple[int, ...]:
    """The order of n <= MOST places in which the way to the thing is least in the mean. `mass` (n,)
    how likely it is at each, up to a factor; ways, m: `first_m` (n,) from here, `between_m` (n, n)
    from row to column. Exact, by dynamic programming over the sets of places that are left; of
    equal orders the one whose places come first. `keep` stays the first of them unless another
    saves a good part of the way, STEADY."""
    n = len(mass)
    if n == 0:
        return ()
    bits = 1 << np.arange(n)
    left = _sums(mass)  # (2^n,) what is still to be found, by set that is still to be visited
    cost = np.zeros((1 << n, n))  # onward from a place, by that set
    then = np.zeros((1 << n, n), np.int32)
    for sets in _by_size(n):
        after = sets[:, None] & ~bits
        onward = np.where(after == sets[:, None], np.inf, cost[after, np.arange(n)])
        # All that is left waits while the next way is driven: (sets, from, to).
        total = between_m * left[sets][:, None, None] + onward[:, None, :]
        then[sets] = total.argmin(axis=2)
        cost[sets] = total.min(axis=2)
    rest = (1 << n) - 1
    total_m = first_m * left[rest] + cost[rest & ~bits, np.arange(n)]
    at = int(total_m.argmin())
    if keep is not None and total_m[keep] <= (1.0 + STEADY) * total_m[at]:
        at = keep
    order = [at]
    while rest := rest & ~(1 << at):
        at = int(then[rest, at])
        order.append(at)
    return tuple(order)


@lru_cache(maxsize=MOST + 1)
def _by_size(n: int) -> tuple[I32, ...]:
    """The sets of n places but the empty one, as bits, the smaller ones first."""
    sets = np.arange(1, 1 << n, dtype=np.int32)
    sizes = np.array([each.bit_count() for each in sets.tolist()])
    return tuple(sets[sizes == size] for size in range(1, n + 1))


def _sums(mass: F64) -> F64:
    """(n,) -> (2^n,) by set, as bits."""
    sums = np.zeros(1)
    for each in mass:
        sums = np.concatenate([sums, sums + each])
    return sums
