"""Candidates for the goal: which objects are worth going to, in which order, and how much of what
was seen is theirs."""

import math
from collections.abc import Callable, Container, Sequence
from dataclasses import replace

from runtime.core.distances.planner import Field
from runtime.core.objects.instances import (
    RIVAL,
    Instance,
    at_one_height,
    same_thing,
    shares,
)
from runtime.core.objects.semantic_map import SemanticMap
from runtime.core.objects.standpoints import REACH_M
from runtime.core.objects.verdict import INSPECT_LOG_ODDS

KEEP_LOG_ODDS = 0.0  # enough to go on for, once on the way
DETOUR_M = 10.0  # what going to something else costs
KEEP_M = 1.0  # by so much must another be better to be gone to instead
RIVAL_SHARE = 0.5  # of the smaller footprint, shared with what is more surely another
APART_CONFIDENCE = 0.9  # from which on something else keeps its cells to itself,
APART_SIZE = 1.2  # unless it is so much larger than the target
SAID_M = 3.0  # of way, that a thing is worth more which is where the goal was said to be
BESIDE_M = 1.5  # between the middles of two things that may share a place
UNDECIDED_SHARE = 0.8  # of all that a thing may be; a name with less is not settled
DOUBT_WORTH_M = 10.0  # way to what is undecided, times how likely it is the goal


def ranked(
    semantic: SemanticMap, goal: str, away: Callable[[Instance], float],
    least: float | None = None, standing: int | None = None, owed: Container[int] = (),
    outdone: bool = False,
) -> list[Instance]:  # fmt: skip
    """The instances worth going to, first the one that costs least to go to and, as likely as it is
    none, to come back from. `away` says how far one is, m. `least` lowers the evidence asked for
    when there is nothing else to do; `standing` is the instance that the robot is on its way to,
    for which less will do: one view that misses it does not turn the robot round. What is rather
    something else, but undecided, is worth a short way, and with `least` any. What is `owed` is
    worth one whatever has been seen since. `outdone`: what is in one place with a surer thing of
    another name, too."""
    bar = INSPECT_LOG_ODDS if least is None else least

    def worth(i: Instance) -> bool:
        if i.name == goal:
            return True
        near = least is not None or i.id == standing or away(i) <= _likely(i, goal) * DOUBT_WORTH_M
        return near and shares(i)[i.name] < UNDECIDED_SHARE

    def speaks(i: Instance) -> bool:
        enough = min(bar, KEEP_LOG_ODDS) if i.id == standing else bar
        return i.odds_of(goal) >= enough and bool(i.views_as(goal)) and worth(i)

    candidates = [
        i
        for i in semantic.called(goal)
        if (i.id in owed or speaks(i)) and (outdone or not _outdone(i, goal, semantic))
    ]

    def cost_m(i: Instance) -> tuple[float, float, int]:
        detour_m = (1.0 - _likely(i, goal)) * DETOUR_M
        kept_m = KEEP_M if i.id == standing else 0.0
        return away(i) + detour_m - kept_m, -i.odds_of(goal), i.id

    return sorted(candidates, key=cost_m)


def said_places(semantic: SemanticMap, names: Sequence[str]) -> list[tuple[float, float]]:
    """Where things of these names surely are, m: the goal was said to be near one."""
    called = (thing for name in names for thing in semantic.called(name) if thing.name == name)
    return [thing.xy for thing in called if semantic.catalogue.is_sure(thing.id)]


def as_said_m(reach: Field, places: Sequence[tuple[float, float]], instance: Instance) -> float:
    """`on_foot_m`, less for what is where it was said to be."""
    near = any(math.dist(instance.xy, place) <= BESIDE_M for place in places)
    return on_foot_m(reach, instance) - (SAID_M if near else 0.0)


def on_foot_m(reach: Field, instance: Instance) -> float:
    """How far the robot has to go to come within REACH_M of it, m; inf when no way is known."""
    frame, n = reach.frame, math.ceil(REACH_M / reach.frame.resolution_m)
    row, col = frame.cell(*instance.xy)
    rows, cols = (slice(max(0, at - n), max(0, at + n + 1)) for at in (row, col))
    around = reach.arrival_m[rows, cols]
    return float(around.min(initial=math.inf))


def _likely(instance: Instance, goal: str) -> float:
    """How likely it is the goal; of one that is rather something else its share."""
    if instance.name == goal:
        return instance.confidence_of(goal)
    return instance.confidence * shares(instance)[goal]


def _outdone(instance: Instance, goal: str, semantic: SemanticMap) -> bool:
    """Whether another in the same place is more surely something else."""
    rivals = [
        other
        for other in _beside(instance, semantic)
        if other.name != goal
        and other.log_odds > instance.log_odds
        and same_thing(instance, other, RIVAL)
    ]
    mine = _places(instance) if rivals else frozenset()
    for other in rivals:
        theirs = _places(other)
        if len(mine & theirs) >= RIVAL_SHARE * min(len(mine), len(theirs)):
            return True
    return False


def apart(instance: Instance, semantic: SemanticMap) -> Instance:
    """The instance without the cells of what surely is something else at the same height, and not
    larger: the coffee table in a sofa's box. The instance itself where nothing would be left."""
    largest = APART_SIZE * len(instance.cells_xy)
    theirs: set[tuple[float, float]] = set()
    for other in _beside(instance, semantic):
        if (
            other.name != instance.name
            and other.confidence >= APART_CONFIDENCE
            and len(other.cells_xy) <= largest
            and at_one_height(instance, other)
        ):
            theirs |= _places(other)
    own = [cell not in theirs for cell in map(tuple, instance.cells_xy.round(3).tolist())]
    if all(own) or not any(own):
        return instance
    return replace(instance, cells_xy=instance.cells_xy[own])


def _beside(instance: Instance, semantic: SemanticMap) -> list[Instance]:
    """What may share its place."""
    ids, _ = semantic.places.within(instance.xy, BESIDE_M)
    near = (semantic.instances[id] for id in ids)
    return [i for i in near if math.dist(i.xy, instance.xy) <= BESIDE_M]


def _places(instance: Instance) -> frozenset[tuple[float, float]]:
    """The cells under it, as values that compare."""
    return frozenset(map(tuple, instance.cells_xy.round(3).tolist()))
