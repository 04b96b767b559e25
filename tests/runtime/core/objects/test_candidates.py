"""Which of the things of the goal's name is gone to, and which is something else."""

import math
from dataclasses import replace

import numpy as np
import pytest
from open_floor import SPOT, at, bed, open_floor

from runtime.core.distances.planner import look_around
from runtime.core.objects.candidates import (
    BESIDE_M,
    KEEP_LOG_ODDS,
    SAID_M,
    apart,
    as_said_m,
    on_foot_m,
    ranked,
    said_places,
)
from runtime.core.objects.instances import Evidence, Instance
from runtime.core.objects.semantic_map import SemanticMap
from runtime.core.objects.standpoints import REACH_M
from runtime.core.objects.verdict import INSPECT_LOG_ODDS


def near(instance: Instance) -> float:
    """All are as near."""
    return 1.0


@pytest.mark.parametrize(
    ("odds", "away_m", "standing", "chosen"),
    [
        ((4.3, 2.3), (4.0, 1.0), None, 2),  # both are likely: the nearer
        ((4.3, 0.8), (2.0, 1.0), None, 1),  # a doubtful one is not worth its metre
        ((4.3, 2.3), (2.2, 1.0), 1, 1),  # no turning back for half a metre
        ((4.3, 2.3), (math.inf, 6.0), None, 2),  # to the other there is no way
        ((2.0, 2.0), (1.0, 1.0), None, 1),
    ],
)
def test_the_target_costs_least_to_go_to_and_to_come_back_from(
    odds: tuple[float, float], away_m: tuple[float, float], standing: int | None, chosen: int
):
    semantic = SemanticMap.empty(("bed",), (), open_floor()[0].frame)
    for id, value in enumerate(odds, 1):
        semantic.instances[id] = replace(bed(at(0, 1), odds=value), id=id)
    away = dict(enumerate(away_m, 1))
    found = ranked(semantic, "bed", lambda i: away[i.id], None, standing)
    assert [i.id for i in found] == [chosen, 3 - chosen]


def test_a_view_that_misses_it_does_not_turn_the_robot_round():
    semantic = SemanticMap.empty(("bed",), (), open_floor()[0].frame)
    doubtful = (KEEP_LOG_ODDS + INSPECT_LOG_ODDS) / 2
    semantic.instances[1] = bed(at(0, 1), odds=doubtful)
    assert ranked(semantic, "bed", near) == []
    assert ranked(semantic, "bed", near, None, 2) == []
    assert ranked(semantic, "bed", near, None, 1) == [semantic.instances[1]]
    semantic.instances[1] = bed(at(0, 1), odds=KEEP_LOG_ODDS - 0.1)
    assert ranked(semantic, "bed", near, None, 1) == []


def test_how_far_it_is_on_foot_is_to_where_it_is_within_reach():
    grid, pose = open_floor()
    _, reach = look_around(grid, pose, 0.18)
    there = bed(at(0, 1))
    assert on_foot_m(reach, there) == pytest.approx(max(0, 2.0 - REACH_M), abs=0.6)
    there.xy = (400.0, -400.0)
    assert on_foot_m(reach, there) == math.inf


def test_what_is_more_surely_something_else_is_no_candidate():
    thing = bed(at(0, 1), at(2, 1))
    semantic = SemanticMap.empty(("bed", "sofa"), (), open_floor()[0].frame)
    semantic.instances[1] = thing
    assert ranked(semantic, "bed", near) == [thing]
    thing.evidence_of("sofa").odds = thing.odds_of("bed") + 2.0
    semantic.learnt((thing,))
    assert ranked(semantic, "bed", near) == []
    assert ranked(semantic, "sofa", near) == [thing]


@pytest.mark.parametrize(
    ("ahead", "away_m", "least", "standing", "gone_to"),
    [
        (0.5, 1.0, None, None, True),  # rather a sofa, and 1 m to see
        (0.5, 6.0, None, None, False),
        (0.5, 6.0, None, 1, True),  # on the way already
        (0.5, 6.0, INSPECT_LOG_ODDS, None, True),  # nothing else is left
        (2.0, 1.0, None, None, False),  # a sofa
        (2.0, 1.0, INSPECT_LOG_ODDS, 1, False),
    ],
)
def test_what_is_undecided_is_worth_a_short_way(
    ahead: float, away_m: float, least: float | None, standing: int | None, gone_to: bool
):
    thing = bed(at(0, 1), odds=1.0)
    thing.evidence_of("sofa").odds = 1.0 + ahead
    semantic = SemanticMap.empty(("bed", "sofa"), (), open_floor()[0].frame)
    semantic.instances[1] = thing
    found = ranked(semantic, "bed", lambda _: away_m, least, standing)
    assert found == ([thing] if gone_to else [])


def cells(x_m: tuple[float, float], y_m: tuple[float, float]) -> np.ndarray:
    x, y = np.meshgrid(np.arange(*x_m, 0.05) + 0.025, np.arange(*y_m, 0.05) + 0.025)
    return np.stack([x.ravel(), y.ravel()], 1)


@pytest.mark.parametrize(
    ("confidence", "high_m", "size_m", "kept"),
    [
        (4.0, (0.0, 0.5), 0.6, "its own"),
        (1.0, (0.0, 0.5), 0.6, "all"),  # not sure enough
        (4.0, (0.9, 1.3), 0.6, "all"),  # on top of it
        (4.0, (0.0, 0.5), 1.6, "all"),  # what is larger may have the target under or in it
    ],
)
def test_what_surely_is_something_else_keeps_its_cells(
    confidence: float, high_m: tuple[float, float], size_m: float, kept: str
):
    """A sofa with a table before it that was taken for a part of it."""
    both = np.concatenate([cells((0.0, 0.6), (0.0, 1.5)), cells((0.8, 1.4), (0.4, 1.0))])
    sofa = Instance(1, {"sofa": Evidence(4.0)}, (0.6, 0.7), 0.4, both, 0.0, 0.8)
    place = cells((0.8, 0.8 + size_m), (0.4, 0.4 + size_m))
    table = Instance(2, {"coffee table": Evidence(confidence)}, (1.1, 0.7), 0.3, place, *high_m)
    semantic = SemanticMap.empty(("sofa", "coffee table"), (), open_floor()[0].frame)
    semantic.instances = {1: sofa, 2: table}
    found = apart(sofa, semantic)
    assert len(found.cells_xy) == (12 * 30 if kept == "its own" else len(both))
    assert (found.cells_xy[:, 0] < 0.6).all() == (kept == "its own")
    assert len(sofa.cells_xy) == len(both)
    sofa.cells_xy = place[:10]
    assert apart(sofa, semantic) is sofa  # nothing would be left of it


def rival(
    name: str, cosine: float | None, low_m: float, high_m: float, wide_m: float = 0.0
) -> SemanticMap:
    """A chair's map with a surer thing in the same place, that looks so like it."""
    spot = np.array([[2.025, 0.025], [2.075, 0.025], [2.025, 0.075]])
    chair = Instance(
        1, {"chair": Evidence(3.0)}, SPOT, 0.4, spot, 0.0, 0.9, views=[at(0, 1), at(2, 1)]
    )
    wider = np.concatenate([spot, spot + np.array([wide_m, 0.0])])
    other = Instance(2, {name: Evidence(8.0)}, SPOT, 0.4, wider, low_m, high_m, views=[at(0, 1)])
    if cosine is not None:
        chair.embedding_sum = np.array([1.0, 0.0], np.float32)
        other.embedding_sum = np.array([cosine, math.sqrt(1 - cosine**2)], np.float32)
    semantic = SemanticMap.empty(("chair", name), (), open_floor()[0].frame)
    semantic.instances |= {1: chair, 2: other}
    return semantic


@pytest.mark.parametrize(
    ("name", "cosine", "low_m", "high_m", "chosen"),
    [
        ("armchair", 0.9, 0.0, 0.8, False),  # one thing, once called another name
        ("desk", 0.5, 0.1, 0.9, True),  # the chair stands at it
        ("picture", 0.9, 1.2, 2.0, True),  # hangs above it
        ("armchair", None, 0.0, 0.8, False),  # nothing is known of how they look
    ],
)
def test_a_surer_thing_in_its_place_outdoes_it_if_it_may_be_the_same(
    name: str, cosine: float | None, low_m: float, high_m: float, chosen: bool
):
    semantic = rival(name, cosine, low_m, high_m)
    found = ranked(semantic, "chair", near)
    assert found == ([semantic.instances[1]] if chosen else [])


def test_when_nothing_else_is_left_what_a_surer_thing_outdoes_is_looked_at_too():
    semantic = rival("armchair", 0.9, 0.0, 0.8)
    assert ranked(semantic, "chair", near, INSPECT_LOG_ODDS) == []
    found = ranked(semantic, "chair", near, INSPECT_LOG_ODDS, outdone=True)
    assert found == [semantic.instances[1]]


def test_without_embeddings_a_much_larger_thing_does_not_outdo_it():
    semantic = rival("desk", None, 0.0, 0.9, wide_m=1.0)
    assert ranked(semantic, "chair", near) == [semantic.instances[1]]


def test_what_is_where_it_was_said_to_be_is_worth_more_of_a_way():
    semantic = SemanticMap.empty(("bed", "table"), (), open_floor()[0].frame)
    unsure, other, sure = (replace(bed(at(0, 1)), id=id) for id in (1, 2, 3))
    unsure.evidence, sure.evidence = {"table": Evidence(0.1)}, {"table": Evidence(4.0)}
    semantic.instances = {thing.id: thing for thing in (unsure, other, sure)}
    assert said_places(semantic, ("lamp",)) == []
    assert said_places(semantic, ("table", "lamp")) == [SPOT]
    grid, pose = open_floor()
    _, reach = look_around(grid, pose, 0.18)
    way_m = on_foot_m(reach, other)
    assert as_said_m(reach, [], other) == way_m
    assert as_said_m(reach, [SPOT], other) == way_m - SAID_M
    assert as_said_m(reach, [(SPOT[0], SPOT[1] + BESIDE_M + 0.1)], other) == way_m
