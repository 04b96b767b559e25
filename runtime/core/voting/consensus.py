"""From votes to one frontier: by evidence on where the thing is (`prior`), or as the paper has it,
CDM: by the experts' sets, and the closest frontier when they do not agree."""

import math
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal, Protocol

from runtime.core.belief import Ahead
from runtime.core.keys import key
from runtime.core.types import Ballot, Decision, Vote
from runtime.core.voting import comparison_modes, prior

Rank = Literal["nearest", "farthest", "gain"]
ConsensusMode = Literal[
    "strict", "lenient", "prior", "weighted", "best", "majority-3", "majority-5"
]
Fallback = Literal["closest", "geometry", "ahead"]
SAMPLES = {"majority-3": 3, "majority-5": 5}


@dataclass(frozen=True)
class ConsensusConfig:
    """How votes elect a frontier; all of it to compare with."""

    rank: Rank = key(
        "nearest",
        'Which of the chosen set wins; "farthest" is Algorithm 1\'s literal argmax, "gain" the one '
        "that the fallback puts first.",
        research="consensus_rank",
    )  # fmt: skip
    mode: ConsensusMode = key(
        "prior",
        '"prior": all evidence says, with the unknown, where the thing may be, and '
        '`consensus_fallback` goes by that; "strict": two must agree; "lenient": a lone vote '
        'counts; "weighted": evidence against way, by the weights; "best": what one is surest of; '
        '"majority-K": the most frequent of K samples of the first vote.',
        research="consensus_mode",
    )
    fallback: Fallback = key(
        "ahead",
        'What decides when nobody agrees: "ahead" is the order of frontiers that finds soonest in '
        'the mean, "geometry" information gain against distance, "closest" is the paper\'s.',
        research="consensus_fallback",
    )
    weights: tuple[tuple[str, float], ...] = key(
        (),
        'For mode "weighted": [expert, metres of way that a nat of its evidence is worth]; set '
        "`experts_bar` to 0 then, as experts that abstain where nothing is above the bar say "
        "nothing.",
        research="consensus_weights",
    )
    detour_m: float = key(
        math.inf,
        "No vote wins a frontier that is so much farther than the fallback's; 1.0 costs least a "
        "decision with weak models (docs/lab/experts.md), the paper has no bound.",
        "m",
        research="consensus_detour_m",
        within=(0.0, math.inf),
    )
    veto: int = key(
        0, "Frontiers that so many experts vote against are out; 0: none is.",
        research="consensus_veto",
        within=(0, 10),
    )  # fmt: skip
    seed: int = key(
        0,
        "Of the samples that a majority is drawn from.",
        research="consensus_seed",
        within=(0, 4_294_967_295),
    )

    @property
    def counts_sets(self) -> bool:
        """Whether only the experts' sets count, as in the paper, not their probabilities."""
        return self.mode in ("strict", "lenient")

    @property
    def plans(self) -> bool:
        """Whether the order of several frontiers is planned."""
        return self.fallback == "ahead"


class Candidate(Protocol):
    """A frontier, as far as a vote needs to know it."""

    @property
    def id(self) -> int: ...

    @property
    def distance_m(self) -> float: ...


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


@dataclass(frozen=True)
class _Field:
    """What a vote is held over: the reachable frontiers, nearest first (ties: the older)."""

    distance_m: Mapping[int, float]
    order: tuple[int, ...] = ()  # the fallback's; the closest comes after it

    @classmethod
    def of(cls, frontiers: Iterable[Candidate], order: Sequence[int] = ()) -> "_Field | None":
        """None when no frontier can be reached."""
        far = sorted((f.distance_m, f.id) for f in frontiers if f.distance_m < float("inf"))
        return cls({id: distance for distance, id in far}, tuple(order)) if far else None

    @property
    def closest(self) -> int:
        return next(iter(self.distance_m))

    @property
    def fallback(self) -> int:
        return next((i for i in self.order if i in self.distance_m), self.closest)

    def without(self, out: Collection[int]) -> "_Field":
        """Without the frontiers that are vetoed; a veto of all is none."""
        left = {id: d for id, d in self.distance_m.items() if id not in out}
        return replace(self, distance_m=left) if left else self

    def within(self, detour_m: float) -> "_Field":
        """Without the frontiers that no vote can win, since they are too far away."""
        most = self.distance_m[self.fallback] + detour_m
        return replace(self, distance_m={i: d for i, d in self.distance_m.items() if d <= most})

    def bounded(self, votes: Iterable[Vote], cfg: ConsensusConfig) -> "_Field":
        """Those that can win by these votes."""
        return self.without(_vetoed(votes, cfg)).within(cfg.detour_m)

    def ranked(self, ids: Collection[int], rank: str) -> list[int]:
        """The best of `ids` first, as `research.consensus_rank` has it."""
        if rank == "gain":
            places = {id: n for n, id in enumerate(self.order)}
            return sorted(ids, key=lambda i: (places.get(i, len(places)), self.distance_m[i], i))
        sign = -1 if rank == "farthest" else 1
        return sorted(ids, key=lambda i: (sign * self.distance_m[i], i))

    def sets(self, votes: Iterable[Vote]) -> list[frozenset[int]]:
        """Each vote's reachable frontiers, by expert; a vote for none of them is none."""
        by_name = sorted(votes, key=_name)
        inside = (frozenset(i for i in v.frontiers if i in self.distance_m) for v in by_name)
        return [s for s in inside if s]


def elect(
    ballot: Ballot,
    frontiers: Iterable[Candidate],
    cfg: ConsensusConfig,
    stamp_ns: int = 0,
    why: str = "",
    order: Sequence[int] = (),
    ahead: Ahead | None = None,
) -> Decision:
    """Decide a ballot among the reachable frontiers. Ties in distance go to the older frontier.
    `order` ranks frontiers for the fallback; without it the closest is the fallback. `ahead`: what
    a belief is made of, and an order where one is planned."""
    field = _Field.of(frontiers, order)
    if field is None:
        return Decision(None, "none", (), None, ballot, stamp_ns, why)
    elected = _elected(ballot, field, cfg, stamp_ns, why, order, ahead)
    assert elected.frontier is not None  # of a field, which is never empty
    way_m = field.distance_m[elected.frontier]
    return replace(elected, taken=prior.taken_for(elected, way_m, ahead))


def _elected(
    ballot: Ballot,
    field: _Field,
    cfg: ConsensusConfig,
    stamp_ns: int,
    why: str,
    order: Sequence[int],
    ahead: Ahead | None,
) -> Decision:
    if cfg.mode == "prior" and ahead is not None:
        return _by_evidence(ballot, field, ahead, cfg, stamp_ns, why)
    winner, rule, chosen = _outcome(ballot.votes, field, cfg, stamp_ns)
    if not chosen and order:
        rule = cfg.fallback
    without = tuple(
        (left_out, _outcome(others, field, cfg, stamp_ns)[0])
        for left_out in sorted(v.expert for v in ballot.votes)
        for others in [[v for v in ballot.votes if v.expert != left_out]]
    )
    standing = tuple(sorted(chosen))
    told = Decision(winner, rule, standing, field.closest, ballot, stamp_ns, why, without)
    if ahead is None:
        return told
    said = prior.heard(ballot, ahead)
    now = prior.spoken(ballot, ahead.ids)
    belief = prior.belief(ahead, prior.counted(ballot, ahead, said), now)
    planned = (winner, *(id for id in order if id != winner)) if cfg.plans else ()
    return replace(told, order=planned, belief=belief, said=said)


def _by_evidence(
    ballot: Ballot, field: _Field, ahead: Ahead, cfg: ConsensusConfig, stamp_ns: int, why: str
) -> Decision:
    """Mode "prior": within the same bounds as sets. Where those leave one frontier there is nothing
    for evidence to decide, and the rule is told as of sets."""

    def electable(votes: Sequence[Vote]) -> Collection[int]:
        return field.bounded(votes, cfg).distance_m

    closest, silent = field.closest, cfg.fallback
    told = prior.elect(ballot, ahead, closest, stamp_ns, why, silent, electable)
    left = field.bounded(ballot.votes, cfg)
    if len(left.distance_m) > 1:
        return told
    rule, chosen = agree(left.sets(ballot.votes))
    voted = {vote.expert for vote in ballot.votes}
    without = tuple(each for each in told.without if each[0] in voted)
    return replace(told, rule=rule if chosen else silent, chosen=tuple(chosen), without=without)


def _outcome(
    votes: Sequence[Vote], field: _Field, cfg: ConsensusConfig, stamp_ns: int
) -> tuple[int, str, frozenset[int]]:
    """The elected frontier, the rule, the chosen set."""
    field = field.bounded(votes, cfg)
    far = field.distance_m
    if cfg.counts_sets:
        rule, chosen = agree(field.sets(votes), cfg.mode == "lenient")
    elif cfg.mode == "weighted":
        rule, chosen = comparison_modes.weighted(votes, far, dict(cfg.weights))
    elif cfg.mode == "prior":
        rule, chosen = comparison_modes.NOBODY  # nothing to plan with
    elif cfg.mode == "best":
        rule, chosen = comparison_modes.surest(votes, far)
    else:
        seed = f"{cfg.seed}/{stamp_ns}"
        rule, chosen = comparison_modes.majority(votes, far, SAMPLES[cfg.mode], seed)
    ranked = field.ranked(chosen, cfg.rank)
    return ranked[0] if ranked else field.fallback, rule, chosen


def agreed(ballot: Ballot, cfg: ConsensusConfig) -> bool:
    """Whether the experts agree: if not, others may be appealed to. Where evidence decides, whoever
    leans any way has a say, and two must name one frontier all the same to agree. Votes are taken
    to be for reachable frontiers, as a brief lists no others; how far those are is not asked
    (`detour_m`)."""
    if cfg.counts_sets or cfg.mode == "prior":
        out = _vetoed(ballot.votes, cfg)
        sets = [rest for v in ballot.votes if (rest := frozenset(v.frontiers) - out)]
        return bool(agree(sets, cfg.mode == "lenient")[1])
    if cfg.mode == "weighted":
        return any(v.expert in dict(cfg.weights) for v in ballot.votes)
    return any(p > 0 for v in sorted(ballot.votes, key=_name)[:1] for _, p in v.probabilities)


def decides(ballot: Ballot, cfg: ConsensusConfig) -> bool:
    """Whether the experts' word decides: if not, the fallback does."""
    if cfg.mode == "prior":
        return bool(ballot.votes) or any(absent.nats for absent in ballot.missing)
    return agreed(ballot, cfg)


def settled(
    votes: Sequence[Vote],
    pending: Collection[str],
    frontiers: Iterable[Candidate],
    cfg: ConsensusConfig,
    order: Sequence[int] = (),
) -> bool:
    """True iff no possible votes of the `pending` experts (by name; each may name any non-empty
    set of frontiers, or abstain) can change the frontier that `votes` elect. Exact, but where
    numbers count beside the sets ("prior", "weighted", a veto): there everyone is waited for."""
    field = _Field.of(frontiers, order)
    if not pending or field is None:
        return True
    field = field.within(cfg.detour_m)
    if len(field.distance_m) == 1:
        return True
    if cfg.veto or cfg.mode in ("prior", "weighted"):
        return False
    if cfg.counts_sets:
        return _stands(field.sets(votes), len(pending), field, cfg)
    return any(v.expert < min(pending) for v in votes)  # the first by name decides


def _stands(sets: Sequence[frozenset[int]], left: int, field: _Field, cfg: ConsensusConfig) -> bool:
    """`settled` for two frontiers or more, and `left` votes, one or more, that are out.

    Let c(f) count the sets with f. With two or more sets and an agreement on a, a new vote can keep
    "all" (then any frontier of the intersection may win: there must be no other), or break it; then
    every frontier wins that two name and that ranks before all others that two name: the votes that
    are out lift f to c(f) + left. So a stands iff it is the only one of the intersection, if there
    is one, and none that ranks before it can be lifted to two. Without an agreement among two or
    more, one new vote can always make one. With fewer than two sets, two votes that are out can
    elect anything; one can elect any frontier of the lone set, or leave things to the fallback.
    """
    if len(sets) < 2:
        if left > 1 or not sets:
            return left == 1 and not sets and cfg.mode == "strict"
        return sets[0] == {field.fallback}
    rule, chosen = agree(sets)
    if not chosen or (rule == "all" and len(chosen) > 1):
        return False
    named = Counter(i for s in sets for i in s)
    winner = field.ranked(chosen, cfg.rank)[0]
    everyone = field.ranked(list(field.distance_m), cfg.rank)
    return all(named[i] + left < 2 for i in everyone[: everyone.index(winner)])


def successor(
    decision: Decision, frontiers: Iterable[Candidate], rank: str = "nearest"
) -> int | None:
    """The decision on a newer map: the elected frontier if it still exists and can be reached, else
    the next of the chosen set (by `rank`, at today's distances) or of the planned order, else the
    closest of all; None when there is none. The ballot is not counted again: it was about another
    map."""
    field = _Field.of(frontiers, decision.order)
    if field is None:
        return None
    if decision.frontier in field.distance_m:
        return decision.frontier
    heirs = field.ranked([i for i in decision.chosen if i in field.distance_m], rank)
    return heirs[0] if heirs else field.fallback


def _vetoed(votes: Iterable[Vote], cfg: ConsensusConfig) -> frozenset[int]:
    against = Counter(i for v in votes for i in set(v.against))
    return frozenset(i for i, n in against.items() if 0 < cfg.veto <= n)


def _name(vote: Vote) -> str:
    return vote.expert
