"""Evidence about views against the way on, by hand."""

import math

import numpy as np
import pytest

from hil_sim.expert_bench.scene_ways import PRIOR, WayFigures, judge_ways, with_prior
from hil_sim.expert_bench.view_questions import SightRows, ViewQuestions, WaysOn
from hil_sim.ground_truth.labels import LABELLED

BED = np.array([LABELLED.index("bed")])
NATS = [2.0, 1.0, 0.0]


def judged(
    evidence: list[float], onward_m: list[float], areas: list[float], asked: bool = True,
    judge: str = "sees",
) -> dict[str, WayFigures]:  # fmt: skip
    """Of three frontiers a moment, in homes of their own."""
    rows, count = len(evidence), len(LABELLED)
    none = np.zeros((0, 0))
    home = tuple(str(n // 3) for n in range(rows))
    sights = SightRows(none, none, none, none, none, none, home)
    every, ways_m = np.full((rows, count), asked), np.full((rows, count), np.inf)
    ways_m[:, BED[0]] = onward_m
    nats = np.zeros((rows, count))
    nats[:, BED[0]] = evidence
    ways = WaysOn(np.arange(rows) // 3, ways_m, np.array(areas), none)
    return judge_ways(ViewQuestions(sights, every, every), ways, {judge: nats}, BED, 0)


def test_who_knows_the_way() -> None:
    found = judged(NATS * 2, [1.0, 2.0, 3.0] * 2, [1.0] * 6)["sees"]
    assert (found.own.mean, found.voted.mean, found.own.n) == (1.0, 1.0, 2)
    mixed = judged(NATS * 2, [1.0, 2.0, 3.0, 3.0, 2.0, 1.0], [1.0] * 6)["sees"]
    assert (mixed.own.mean, mixed.own.low, mixed.own.high) == (0.0, -1.0, 1.0)


def test_the_prior_is_weighed_as_in_a_vote() -> None:
    found = judged(NATS, [3.0, 2.0, 1.0], [1.0, 100.0, 10000.0])
    assert found["sees"].own.mean == -1.0
    assert found["sees"].voted.mean == 1.0  # ten times the weight each, against a nat
    assert found[PRIOR].voted.mean == 1.0
    assert math.isnan(found[PRIOR].own.mean)


@pytest.mark.parametrize(
    ("judge", "step", "voted"),
    [
        ("language", 20.0, -1.0),
        ("language", 40.0, 1.0),
        ("head", 400.0, -1.0),
        ("head", 1600.0, 1.0),
    ],
)
def test_the_network_counts_the_prior_half(judge: str, step: float, voted: float) -> None:
    """Each frontier has so many times the area of the one before it, against a nat over the
    temperature, 0.6: they are even at 28 times with the square root, at 786 with the fourth."""
    areas = [10.0, 10.0 * step, 10.0 * step**2]
    assert judged(NATS, [3.0, 2.0, 1.0], areas, judge=judge)[judge].voted.mean == voted
    weighed = with_prior(judge, np.array([[0.6]]), np.array([[3.0]]))
    assert weighed.item() == pytest.approx(2.5 if judge == "head" else 4.0)


def test_two_frontiers_are_no_order() -> None:
    assert judged(NATS, [1.0, 2.0, math.inf], [1.0] * 3) == {}
    assert judged(NATS, [1.0, 2.0, 3.0], [1.0] * 3, asked=False) == {}


def test_who_says_the_same_of_all_knows_nothing() -> None:
    found = judged([0.5] * 3, [1.0, 2.0, 3.0], [1.0] * 3)["sees"]
    assert found.own.n == 0
    assert math.isnan(found.own.mean)
    assert math.isnan(found.voted.mean)
