"""Instances: what is one thing and what is two, what it is called, how large it is."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy_things import thing_of

from runtime.core.geometry import GridFrame
from runtime.core.objects.depth_segments import Sighting
from runtime.core.objects.instances import (
    CUT_WEIGHT,
    LOG_ODDS_MAX,
    MAX_STEP,
    MISS_STEP,
    REPEAT_WEIGHT,
    Instance,
    called,
    first_view,
    fuse,
    logit,
    reject,
    shares,
    size_m,
    uncalled,
)
from runtime.core.objects.verdict import confirmed, supported
from runtime.core.types import Pose

FRAME = GridFrame(-10.0, -10.0, 0.05, 400, 400)
HERE = Pose(0.0, 0.0, 0.0)


def unit(*values: float) -> np.ndarray:
    row = np.array(values, np.float32)
    return row / np.linalg.norm(row)


LEATHER, WOOD = unit(1.0, 0.1, 0.0), unit(0.0, 0.1, 1.0)


def box(
    name: str,
    x: float,
    y: float,
    embedding: np.ndarray = LEATHER,
    side_m: float = 0.6,
    z: tuple[float, float] = (0.1, 0.9),
    score: float = 0.8,
) -> Sighting:
    """A sighting of the surface of a box."""
    grid = np.linspace(-side_m / 2, side_m / 2, 8)
    points = np.array([(x + u, y + v, h) for u in grid for v in grid for h in np.linspace(*z, 5)])
    return Sighting(name, score, embedding, thing_of(math.hypot(x, y), points, FRAME))


def seen(*sightings: tuple[Sighting, Pose]) -> dict[int, Instance]:
    instances: dict[int, Instance] = {}
    for n, (sighting, pose) in enumerate(sightings):
        look(instances, n + 1, sighting, pose)
    return instances


def look(instances: dict[int, Instance], id: int, sighting: Sighting, pose: Pose) -> Instance:
    """What one image with one sighting does."""
    instance = fuse(instances, first_view(id, sighting), FRAME, sighting, pose)
    called(instance, sighting, pose)
    uncalled(instance, (sighting.name,), pose, cut=sighting.cut)
    return instance


def around(x: float, y: float, angle_rad: float, range_m: float = 2.0) -> Pose:
    """A pose that looks at the point from a direction."""
    px, py = x + range_m * math.cos(angle_rad), y + range_m * math.sin(angle_rad)
    return Pose(px, py, math.atan2(y - py, x - px))


def test_one_thing_called_by_two_names_is_one_and_its_name_the_best_supported():
    names = ["armchair", "chair", "chair", "chair"]
    views = [(box(n, 2, 0), around(2, 0, 0.6 * k + math.pi / 2)) for k, n in enumerate(names)]
    (thing,) = seen(*views).values()
    assert set(thing.evidence) == {"armchair", "chair"}
    assert thing.name == "chair"
    called = shares(thing)
    assert sum(called.values()) == pytest.approx(1.0)
    assert called["chair"] > 0.9
    assert thing.confidence == thing.confidence_of("chair") > thing.confidence_of("armchair")
    assert thing.confidence_of("sofa") == 0.0


@pytest.mark.parametrize(
    "other",
    [
        box("table", 2.0, 0.0, WOOD),  # looks different
        box("chair", 3.2, 0.0),  # stands elsewhere
        box("chair", 2.0, 0.0, z=(0.95, 1.5)),  # stands on it
        box("chair", 2.0, 0.0, side_m=0.15),  # is far smaller
        box("chair", 2.0, 0.0, np.zeros(0, np.float32)),  # from a detector without embeddings
    ],
)
def test_another_name_for_what_is_not_alike_is_another_thing(other: Sighting):
    assert len(seen((box("armchair", 2, 0), HERE), (other, around(2, 0, 2.0)))) == 2


def test_the_same_name_is_enough_where_there_are_no_embeddings():
    bare = np.zeros(0, np.float32)
    (thing,) = seen(
        (box("chair", 2, 0, bare), HERE), (box("chair", 2.2, 0.1, bare), around(2, 0, 2.0))
    ).values()
    assert thing.embedding.size == 0


def test_a_thing_of_its_own_name_next_to_it_is_preferred_to_a_neighbour():
    chair, armchair = box("chair", 2.0, 0.0, WOOD), box("armchair", 2.0, 0.9)
    things = seen((chair, HERE), (armchair, HERE), (box("chair", 2.0, 0.05, WOOD), HERE))
    assert [set(t.evidence) for t in things.values()] == [{"chair"}, {"armchair"}]
    assert things[1].embedding_sum[2] > things[2].embedding_sum[2]


@given(st.lists(st.sampled_from(["chair", "armchair", "sofa"]), min_size=1, max_size=12))
def test_it_is_called_one_of_its_names_by_evidence_whatever_their_order(names: list[str]):
    views = [(box(n, 2, 0), around(2, 0, 0.5 * k)) for k, n in enumerate(names)]
    things = seen(*views)
    assert len(things) == 1
    assert things[1].name in names
    assert things[1].log_odds == max(known.odds for known in things[1].evidence.values())
    assert abs(things[1].log_odds) <= LOG_ODDS_MAX
    assert len(things[1].views) <= len(names)


@given(
    st.floats(-math.pi, math.pi),
    st.floats(0.3, 2.0),
    st.floats(0.3, 1.0),
    st.floats(0.2, 1.8),
)
def test_its_size_is_the_boxes_however_it_stands(
    turn: float, length: float, share: float, h: float
):
    width = length * share
    u, v = np.meshgrid(
        np.linspace(-length / 2, length / 2, 60), np.linspace(-width / 2, width / 2, 60)
    )
    c, s = math.cos(turn), math.sin(turn)
    x, y = (2 + c * u - s * v).ravel(), (s * u + c * v).ravel()
    z = np.resize(np.linspace(0.1, 0.1 + h, 97), x.size)
    thing = Sighting("table", 0.9, LEATHER, thing_of(2.0, np.stack([x, y, z], axis=1), FRAME))
    (instance,) = seen((thing, HERE)).values()
    got = size_m(instance, FRAME.resolution_m)
    assert got[0] == pytest.approx(length, abs=0.16)  # three cells
    assert got[1] == pytest.approx(width, abs=0.16)  # three cells
    assert got[2] == pytest.approx(h, abs=0.15 * h + 1e-6)
    assert got[0] >= got[1]


@given(st.lists(st.tuples(st.floats(0.2, 1.0), st.floats(-3, 3)), min_size=1, max_size=8))
def test_the_fused_embedding_is_the_views_mean_by_score(views: list[tuple[float, float]]):
    rows = [(score, unit(1.0, 0.3 * math.sin(a), 0.3 * math.cos(a))) for score, a in views]
    things = seen(*((box("chair", 2, 0, row, score=s), HERE) for s, row in rows))
    mean = sum(s * row for s, row in rows)
    assert np.allclose(things[1].embedding, mean / np.linalg.norm(mean), atol=1e-5)


def test_a_view_without_an_embedding_takes_none_away() -> None:
    """As of a frame at which only a detector with a fixed list looked."""
    none = np.zeros(0, np.float32)
    things = seen((box("sofa", 2.0, 0.0), HERE), (box("sofa", 2.0, 0.0, none), HERE))
    assert len(things) == 1
    assert things[1].embedding == pytest.approx(LEATHER)


def test_a_rejection_forgets_for_one_name_alone_and_asks_for_new_views():
    chair = [(box("chair", 2, 0), around(2, 0, 0.6 * k)) for k in range(3)]
    instances = seen(*chair)
    look(instances, 9, box("armchair", 2, 0), around(2, 0, 3.0))
    thing = instances[1]
    before = thing.odds_of("armchair")
    reject(thing, "chair", -1.0)
    assert thing.odds_of("chair") == -1.0
    assert thing.odds_of("armchair") == before
    assert thing.views_as("chair") == []
    assert len(thing.views_as("armchair")) == 4
    look(instances, 9, box("chair", 2, 0), around(2, 0, 0.0))
    assert len(thing.views_as("chair")) == 1
    reject(thing, "chair", -1.0)
    assert thing.odds_of("chair") == -2.0


def test_a_view_that_calls_it_something_else_is_no_second_look():
    instances = seen(*((box("chair", 2, 0), around(2, 0, 0.0)) for _ in range(6)))
    thing = instances[1]
    assert supported(thing, "chair")
    other_side = around(2, 0, 1.5)
    look(instances, 9, box("armchair", 2, 0, score=0.4), other_side)
    assert len(thing.views) == 2
    assert thing.name == "chair"
    assert not confirmed(thing, "chair")
    look(instances, 9, box("chair", 2, 0), other_side)
    assert confirmed(thing, "chair")


def test_what_is_cut_off_at_a_side_says_less_for_a_name_and_against_others():
    toilet, other = seen((box("toilet", 2, 0), HERE))[1], around(2, 0, 2.0)
    before = toilet.odds_of("toilet")
    look({1: toilet}, 9, box("bathtub", 2, 0)._replace(cut=True), other)
    assert toilet.odds_of("bathtub") == pytest.approx(CUT_WEIGHT * MAX_STEP)
    assert toilet.odds_of("toilet") == pytest.approx(before - CUT_WEIGHT * MISS_STEP)


@given(st.integers(1, 30))
def test_a_place_from_where_it_is_missed_speaks_against_it_once(frames: int):
    thing = seen((box("chair", 2, 0), HERE))[1]
    before = thing.odds_of("chair")
    for _ in range(frames):
        uncalled(thing, (), around(2, 0, 2.0))
    rest = (frames - 1) * REPEAT_WEIGHT
    assert thing.odds_of("chair") == pytest.approx(before - MISS_STEP * (1 + rest))


@given(st.floats(0.0, 1.0))
def test_logits_are_bounded_and_odd(p: float):
    assert abs(logit(p)) < 10
    assert logit(p) == pytest.approx(-logit(1 - p), abs=1e-6)
