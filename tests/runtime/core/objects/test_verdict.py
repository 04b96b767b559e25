"""The target: when it is believed, from where it is looked at again, what becomes of doubts."""

import math
from dataclasses import replace

import numpy as np
import pytest
from apartment import MOUNT, TWO_ROOMS, Apartment
from hypothesis import given
from hypothesis import strategies as st

from runtime import navigate
from runtime.core.distances.planner import look_around
from runtime.core.geometry import seen_from_m
from runtime.core.mapping.grid import NavigationMap
from runtime.core.objects.candidates import KEEP_LOG_ODDS, apart, on_foot_m, ranked
from runtime.core.objects.instances import Evidence, Instance
from runtime.core.objects.semantic_map import SemanticMap
from runtime.core.objects.standpoints import REACH_M, look_from, other_sides, standpoints
from runtime.core.objects.verdict import (
    INSPECT_LOG_ODDS,
    REJECTION_LOG_ODDS,
    SECOND_SIDE_RAD,
    Reached,
    Verdict,
    confirmed,
    from_two_sides,
    settle,
    verdict,
)
from runtime.core.types import Action, Ballot, Intrinsics, Pose
from runtime.core.world import World

SPOT = (2.0, 0.0)


def at(bearing_rad: float, range_m: float) -> Pose:
    """A pose that looks at the spot from a direction, as seen from the spot."""
    x, y = SPOT[0] + range_m * math.cos(bearing_rad), SPOT[1] + range_m * math.sin(bearing_rad)
    return Pose(x, y, math.atan2(SPOT[1] - y, SPOT[0] - x))


def bed(*views: Pose, odds: float = 4.0, range_m: float = 1.0) -> Instance:
    cells = np.array([[SPOT[0] + 0.025, SPOT[1] + 0.025]])
    known = Evidence(odds, backing=list(views), near_m=range_m)
    return Instance(1, {"bed": known}, SPOT, 0.4, cells, range_m=range_m, views=list(views))


def come(thing: Instance, reached: Reached, pose: Pose) -> Verdict:
    """The robot has come so far with it: what follows, booked."""
    outcome = verdict(thing, "bed", reached)
    settle(thing, "bed", outcome, pose)
    return outcome


def wants_other_side(thing: Instance) -> bool:
    return verdict(thing, "bed", Reached.ON_THE_WAY) is Verdict.OTHER_SIDE


def rejections(thing: Instance) -> int:
    return thing.evidence["bed"].rejections


@given(
    st.floats(-math.pi, math.pi), st.floats(0.8, 3.0), st.floats(-0.34, 0.34), st.floats(1, 1.39)
)
def test_views_from_nearly_one_place_are_one_look(
    bearing: float, range_m: float, turned: float, nearer: float
):
    thing = bed(at(bearing, range_m), at(bearing + turned, range_m / nearer))
    assert not confirmed(thing, "bed")


@given(st.floats(-math.pi, math.pi), st.floats(0.8, 3.0), st.floats(0.36, math.pi))
def test_another_direction_is_a_second_look(bearing: float, range_m: float, turned: float):
    for sign in (1, -1):
        assert confirmed(bed(at(bearing, range_m), at(bearing + sign * turned, range_m)), "bed")


@given(st.floats(-math.pi, math.pi), st.floats(1.0, 3.0), st.floats(1.41, 4.0))
def test_so_is_a_much_nearer_one(bearing: float, range_m: float, nearer: float):
    assert from_two_sides(bed(at(bearing, range_m), at(bearing, range_m / nearer)), "bed")


def test_one_view_is_never_two():
    assert not confirmed(bed(at(0.0, 1.0)), "bed")
    assert not confirmed(bed(), "bed")


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
    thing.evidence_of("sofa").odds = 5.0
    assert ranked(semantic, "bed", near) == []
    assert ranked(semantic, "sofa", near) == [thing]


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


def test_without_embeddings_a_much_larger_thing_does_not_outdo_it():
    semantic = rival("desk", None, 0.0, 0.9, wide_m=1.0)
    assert ranked(semantic, "chair", near) == [semantic.instances[1]]


def test_what_lies_low_is_stood_before_where_the_camera_still_sees_it():
    grid, pose = open_floor()
    terrain, reach = look_around(grid, pose, 0.18)
    ball = bed(Pose(0.0, 0.0, 0.0))
    lens = Intrinsics(fx=388.0, fy=388.0, cx=320.0, cy=240.0, width=640, height=480)
    for high_m, nearest_m, farthest_m in ((0.2, 0.89, 1.0), (0.5, 0.6, 0.72), (1.2, 0.0, 0.72)):
        seen_from = seen_from_m(lens, MOUNT, high_m)
        stands = standpoints(grid, terrain, reach, ball, "bed", seen_from)
        away = terrain.frame.centres(np.argwhere(stands).astype(np.int32)) - ball.cells_xy[0]
        gaps = np.hypot(*away.T)
        assert nearest_m - 0.03 < gaps.min()
        assert 0.65 < gaps.max() < farthest_m + 0.03


def test_how_far_away_a_thing_is_in_the_image():
    lens = Intrinsics(fx=240.0, fy=240.0, cx=320.0, cy=240.0, width=640, height=480)
    ahead = replace(MOUNT, x_m=0.1, z_m=0.9)  # its lowest ray falls by 45 degrees
    assert seen_from_m(lens, ahead, 0.4) == pytest.approx(0.6)
    assert seen_from_m(lens, ahead, 0.9) == seen_from_m(lens, ahead, 1.5) == 0.0
    assert seen_from_m(lens, replace(ahead, pitch_rad=0.3), 0.4) < 0.5
    assert seen_from_m(lens, replace(ahead, pitch_rad=-1.0), 0.4) == math.inf


# -- two looks ------------------------------------------------------------------------------------


def test_a_doubt_is_settled_by_the_second_look_at_the_latest():
    seen = at(0, 1)
    thing = bed(seen, at(0.1, 1.0), odds=2.0)  # enough evidence, from one side
    assert come(thing, Reached.FACED, seen) is not Verdict.FOUND
    assert wants_other_side(thing)
    come(thing, Reached.NO_OTHER_SIDE, seen)  # there is no other side to stand on
    assert not rejections(thing)
    assert come(thing, Reached.FACED, seen) is Verdict.FOUND


def test_too_little_evidence_after_two_looks_is_a_rejection():
    thing = bed(at(0, 1), at(0.1, 1.0), odds=1.2)
    assert come(thing, Reached.FACED, at(0, 1)) is not Verdict.FOUND
    assert come(thing, Reached.FACED, at(0.5, 1)) is not Verdict.FOUND
    assert rejections(thing) == 1
    assert thing.odds_of("bed") == REJECTION_LOG_ODDS
    assert not wants_other_side(thing)


def test_what_nothing_speaks_for_gets_no_second_look():
    thing = bed(at(0, 1), at(0.1, 1.0), odds=0.0)
    assert come(thing, Reached.FACED, at(0, 1)) is not Verdict.FOUND
    assert rejections(thing) == 1


def test_what_was_only_seen_from_afar_is_not_stopped_at():
    thing = bed(at(0, 4), at(1.0, 2.5), range_m=2.5)
    assert confirmed(thing, "bed")
    assert come(thing, Reached.FACED, at(0, 1)) is not Verdict.FOUND
    assert wants_other_side(thing)  # where it may be seen from near
    assert come(thing, Reached.FACED, at(0, 1)) is not Verdict.FOUND
    assert rejections(thing) == 1


@given(st.floats(-3, 8), st.lists(st.booleans(), min_size=3, max_size=3))
def test_three_looks_always_end_it(odds: float, second_side: list[bool]):
    thing = bed(at(0, 1), odds=odds)
    for other in second_side:
        if come(thing, Reached.FACED, at(0, 1)) is Verdict.FOUND or rejections(thing):
            return
        if other:
            thing.evidence["bed"].backing.append(at(1.0, 1.0))
    raise AssertionError("neither believed nor rejected")


def open_floor() -> tuple[NavigationMap, Pose]:
    grid, pose = NavigationMap.around(Pose(0, 0, 0), 0.18), Pose(0.0, 0.0, 0.0)
    low, high = grid.frame.cells(np.array([[-1.0, -3.0], [5.0, 3.0]]))
    grid.evidence[low[0] : high[0], low[1] : high[1]] = -10
    row, col = grid.frame.cell(*SPOT)
    grid.evidence[row - 3 : row + 4, col - 3 : col + 4] = 10
    grid.changed()
    return grid, pose


@given(st.floats(math.pi - 1.2, math.pi + 1.2))
def test_other_sides_differ_from_every_view_and_can_be_stood_on(bearing: float):
    grid, pose = open_floor()
    terrain, reach = look_around(grid, pose, 0.18)
    thing = bed(at(bearing, 1.2))
    thing.cells_xy = grid.frame.centres(np.argwhere(grid.occupied).astype(np.int32))
    thing.looks.append(at(bearing + 0.2, 1.0))
    cells = np.argwhere(other_sides(grid, terrain, reach, thing, "bed"))
    assert len(cells)
    xy = terrain.frame.centres(cells.astype(np.int32)) - SPOT
    angles = np.arctan2(xy[:, 1], xy[:, 0])
    for seen in (bearing, bearing + 0.2):
        off = np.abs(np.angle(np.exp(1j * (angles - seen))))
        assert off.min() >= SECOND_SIDE_RAD - 1e-3
    assert np.isfinite(reach.arrival_m[tuple(cells.T)]).all()
    assert np.hypot(*xy.T).max() < REACH_M + 0.3


def test_where_to_look_from_is_the_nearest_standpoint_on_foot():
    grid, pose = open_floor()
    terrain, reach = look_around(grid, pose, 0.18)
    thing = bed(at(math.pi, 2.0))
    thing.cells_xy = grid.frame.centres(np.argwhere(grid.occupied).astype(np.int32))
    spot = look_from(grid, terrain, reach, thing)
    assert spot is not None
    stands = standpoints(grid, terrain, reach, thing, "bed")
    assert stands[terrain.frame.cell(*spot)]
    assert reach.at(*spot) == pytest.approx(reach.arrival_m[stands].min())
    thing.cells_xy = thing.cells_xy + 40.0  # beyond what is known
    assert look_from(grid, terrain, reach, thing) is None


# -- the whole loop -------------------------------------------------------------------------------


class Silent:
    def ask(self, brief: object, by: None) -> Ballot:
        return Ballot()


def drive(score: float, steps: int = 200) -> tuple[World, list[navigate.Command]]:
    """The robot begins right before a thing that is reported with a constant score while it is in
    view, though never from any other side than the one it is in."""
    home, cfg = Apartment.of(TWO_ROOMS, Pose(6.4, 2.2, 0.0)), navigate.NavigateConfig()
    home.things = {"toilet": (7.4, 2.2, 0.3)}
    world, commands = None, []
    for _ in range(steps):
        obs = home.observe()
        if world is None:
            world = World.begin("toilet", ("toilet",), (), obs.pose, 0.18)
        navigate.perceive(world, obs, home.detect(("toilet",), obs, score), MOUNT, cfg)
        why = navigate.due(world, cfg)
        if why:
            snap = navigate.snapshot(world, why, cfg)
            navigate.adopt(world, navigate.decide(snap, Silent(), None, cfg))
        commands.append(navigate.steer(world, navigate.act(world, cfg), cfg))
        if commands[-1].action is Action.STOP:
            break
        home.apply(commands[-1].action)
    assert world is not None
    return world, commands


def test_a_target_it_begins_before_is_looked_at_from_another_side_first():
    world, commands = drive(0.8)
    assert commands[-1].reason.startswith("found toilet")
    assert any("from another side" in c.reason for c in commands)
    (toilet,) = (i for i in world.semantic.instances.values() if i.log_odds > 1)
    assert from_two_sides(toilet, "toilet")
