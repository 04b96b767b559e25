"""The arc that a body sweeps, and how fast it may go along it."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.core.mapping.near_memory import Nearby
from runtime.core.motion.caution import FREE
from runtime.core.motion.reflex import (
    BESIDE_M,
    INSIDE_M,
    REST_M,
    cautioned,
    free_way_m,
    halting_mps,
    stopping_m,
    sure_mps,
)
from runtime.core.motion.safety import HaltKind
from runtime.core.motion.velocity_policy import CREEP_MPS, FRESH_S, HOLD_S
from runtime.core.types import Pose, Twist

RADIUS_M, BRAKE = 0.18, 0.5
HERE = Pose(0.0, 0.0, 0.0)
NOTHING = np.zeros((0, 2), np.float32)
METRES = st.floats(-2.0, 2.0)


def near(*obstacles, drops=NOTHING):
    return Nearby(0, np.array(obstacles, np.float32).reshape(-1, 2), np.asarray(drops, np.float32))


def caution_at(wished, seen, pose=HERE):
    return cautioned(wished, pose, seen, RADIUS_M, BRAKE)


def rolled_m(point, bend, radius_m):
    """The same by small steps along the arc, half a turn at most."""
    s = np.arange(0.0, math.pi / max(abs(bend), 0.5), 0.001)
    if abs(bend) < 1e-3:
        x, y = s, np.zeros_like(s)
    else:
        x, y = np.sin(s * bend) / bend, (1 - np.cos(s * bend)) / bend
    met = np.hypot(x - point[0], y - point[1]) < radius_m
    return float(s[np.argmax(met)]) if met.any() else math.inf


@given(METRES, METRES, st.floats(-6.0, 6.0), st.floats(0.05, 0.4))
def test_the_way_along_an_arc_is_that_of_small_steps(x, y, bend, radius_m):
    way_m = free_way_m(np.array([[x, y]]), bend, radius_m)
    rolled = rolled_m((x, y), bend, radius_m)
    if math.hypot(x, y) < radius_m + 0.002:
        return  # it touches already, or may: the next test
    if rolled < math.inf:
        assert way_m == pytest.approx(rolled, abs=0.06)  # a graze is met a step late
        assert way_m <= rolled + 1e-6
    elif abs(bend) >= 1e-3:
        assert way_m > math.pi / max(abs(bend), 0.5) - 0.06


def test_what_is_touched_counts_only_where_the_way_leads_into_it():
    assert free_way_m(np.array([[0.1, 0.1]]), 0.0, RADIUS_M) == 0.0
    assert free_way_m(np.array([[-0.1, 0.1]]), 0.0, RADIUS_M) == math.inf
    assert free_way_m(np.array([[-0.01, 0.1]]), 3.0, RADIUS_M) == math.inf


@pytest.mark.parametrize("yaw_rad", [0.0, 1.0, -2.5])
@pytest.mark.parametrize("v", [0.1, 0.3, 0.6])
def test_the_body_halts_before_what_is_ahead(v, yaw_rad):
    """Rolled on with the speed that is allowed, a turn of control after the other."""
    pose = Pose(1.0, -2.0, yaw_rad)
    ahead = np.array([math.cos(yaw_rad), math.sin(yaw_rad)])
    thing, rolled, speed = pose.xy + ahead * (RADIUS_M + 0.9), 0.0, v
    for _ in range(400):
        here = Pose(*(pose.xy + ahead * rolled), yaw_rad)
        wished = Twist(min(v, speed + BRAKE * 0.05), 0.0)
        asked = caution_at(wished, near(thing), here).allowed(wished).v_mps
        speed = max(asked, speed - BRAKE * 0.05) if asked < speed else asked
        rolled += speed * 0.05
    rest_m = 0.9 - rolled
    assert speed == 0.0
    assert 0.0 < rest_m < REST_M + 0.05


@pytest.mark.parametrize("off_deg", [0, 20, 45, 60, 75, -60])
@pytest.mark.parametrize("gap_m", [0.02, 0.1, 0.5])
def test_the_body_halts_before_a_wall_that_it_meets_at_a_slant(off_deg, gap_m):
    """A disc meets it with its side, long before what is straight ahead is near."""
    off = math.radians(off_deg)
    away, along = (
        np.array([math.cos(off), math.sin(off)]),
        np.array([-math.sin(off), math.cos(off)]),
    )
    far_m = RADIUS_M + gap_m
    wall = near(*(far_m * away + t * along for t in np.arange(-2.0, 2.0, 0.04)))
    rolled, speed, nearest = 0.0, 0.0, math.inf
    for _ in range(600):
        wished = Twist(min(0.4, speed + BRAKE * 0.05), 0.0)
        asked = caution_at(wished, wall, Pose(rolled, 0.0, 0.0)).allowed(wished).v_mps
        speed = max(asked, speed - BRAKE * 0.05) if asked < speed else asked
        rolled += speed * 0.05
        nearest = min(nearest, far_m - rolled * math.cos(off))
    assert speed == 0.0
    assert RADIUS_M < nearest < RADIUS_M + gap_m + 1e-9
    if gap_m > 0.05:
        assert rolled > 0.0


def test_a_wall_beside_the_way_is_passed_however_near():
    for gap_m in (0.0, 0.004, 0.02):
        wall = near(*((x, RADIUS_M + gap_m) for x in np.arange(-1.0, 2.0, 0.04)))
        caution = caution_at(Twist(0.4, 0.0), wall)
        assert caution.most_mps >= CREEP_MPS
        away = caution_at(Twist(0.4, -0.4), wall)
        assert away.most_mps >= CREEP_MPS


@pytest.mark.parametrize("w", [1.0, -1.0])
def test_a_body_that_touches_something_does_not_push_against_it_while_it_turns(w):
    """A tight arc leads little farther into it: that is enough to push."""
    touched = near((0.12, 0.12), (0.12, -0.12))
    wished = Twist(0.03, w)
    assert caution_at(wished, touched).allowed(wished) == Twist(0.0, w)


def test_where_slowing_is_not_enough_it_is_zero_at_once():
    """What was there before is slowed down for; what appears within the halting distance is not."""
    gap_m = 0.15
    thing = near((RADIUS_M + gap_m, 0.0))
    fast, slow = Twist(0.4, 0.0), Twist(0.2, 0.0)
    assert stopping_m(fast.v_mps, BRAKE) > gap_m > stopping_m(slow.v_mps, BRAKE)
    assert caution_at(fast, thing).most_mps == 0.0
    assert caution_at(slow, thing).allowed(slow).v_mps > 0.1
    drop = near(drops=[(RADIUS_M / 2 + gap_m, 0.0)])
    assert caution_at(fast, drop).most_mps == 0.0
    assert caution_at(fast, drop).kind is HaltKind.FLOOR


def test_what_is_far_enough_or_beside_the_way_slows_nothing():
    full = Twist(0.4, 0.0)
    wall = [(x / 25, RADIUS_M + BESIDE_M + 0.002) for x in range(-20, 60)]
    assert caution_at(full, near(*wall)) == FREE
    assert caution_at(full, near((1.0, 0.0))) == FREE
    assert caution_at(full, near((-0.1, 0.0))) == FREE


def test_what_the_body_barely_misses_is_passed_at_a_creep():
    grazed = near((0.3, RADIUS_M - INSIDE_M + 0.005))
    caution = caution_at(Twist(0.4, 0.0), grazed)
    assert CREEP_MPS <= caution.most_mps < 0.4
    assert caution_at(Twist(0.4, 0.0), near((0.05, RADIUS_M - 0.005))).most_mps == CREEP_MPS


def test_turning_on_the_spot_is_never_held():
    beset = near((0.17, 0.0), (0.0, 0.17), (0.12, -0.12))
    assert caution_at(Twist(0.0, 1.0), beset) == FREE
    caution = caution_at(Twist(0.2, 1.0), beset)
    assert caution.allowed(Twist(0.2, 1.0)) == Twist(0.0, 1.0)
    assert caution.kind is HaltKind.OBSTACLE
    assert "0.00 m ahead" in caution.reason


def test_a_curve_is_swept_as_a_curve():
    """What lies straight ahead is passed by a tight turn; what lies on the turn is not."""
    assert caution_at(Twist(0.3, 1.5), near((0.5, 0.0))) == FREE
    on_it = near((0.2, 0.2))
    assert caution_at(Twist(0.3, 1.5), on_it).most_mps < 0.3
    assert caution_at(Twist(0.3, -1.5), on_it) == FREE


def test_missing_floor_holds_as_an_obstacle_does():
    caution = caution_at(Twist(0.4, 0.0), near(drops=[(0.12, 0.0)]))
    assert caution.most_mps == 0.0
    assert caution.kind is HaltKind.FLOOR
    assert caution.reason.startswith("no floor 0.0")
    assert caution_at(Twist(0.4, 0.0), near(drops=[(0.3, RADIUS_M)])) == FREE


@given(st.floats(0.0, 3.0))
def test_the_halting_speed_takes_just_the_way_that_there_is(way_m):
    v = halting_mps(way_m, BRAKE)
    assert v * HOLD_S + v * v / (2 * BRAKE) == pytest.approx(way_m, abs=1e-9)


def test_the_surest_speed_is_what_is_watched_less_what_passes_unseen():
    v = sure_mps(RADIUS_M, BRAKE, 5.0)
    assert v * (FRESH_S + HOLD_S) + v * v / (2 * BRAKE) == pytest.approx(2.5 - RADIUS_M - REST_M)
    assert sure_mps(RADIUS_M, BRAKE, 1.0) < v
    assert sure_mps(RADIUS_M, BRAKE, 0.1) == 0.0


# -- to the number ---------------------------------------------------------------------------------

FAST = Twist(0.6, 0.0)


def halting(way_m: float) -> float:
    """By hand: v * HOLD_S + v^2 / 2b = way, with b = 0.5."""
    return 0.5 * (math.sqrt(HOLD_S**2 + 4 * way_m) - HOLD_S)


def test_the_speed_is_the_one_that_halts_before_the_nearest_that_is_on_the_way():
    caution = caution_at(FAST, near((0.6, 0.1), (0.5, 1.0), (0.9, 0.0)))
    beside_m = 0.6 - math.sqrt((RADIUS_M + BESIDE_M) ** 2 - 0.1**2)
    assert caution.most_mps == pytest.approx(halting(beside_m), rel=1e-6)
    assert (caution.kind, caution.reason) == (HaltKind.OBSTACLE, "something 0.45 m ahead")
    assert caution.most_radps == math.inf


def test_what_only_a_wider_body_would_touch_is_passed_at_its_own_speed():
    """0.17 m to the side: within the rim, but not within what is surely touched."""
    caution = caution_at(FAST, near((0.5, 0.17)))
    beside_m = 0.5 - math.sqrt((RADIUS_M + BESIDE_M) ** 2 - 0.17**2)
    assert caution.most_mps == pytest.approx(halting(beside_m), rel=1e-6)
    assert caution.reason == f"something {beside_m + BESIDE_M:.2f} m ahead"


def test_what_is_within_the_rim_and_what_is_surely_on_the_way_part_at_three_centimetres():
    surely_m = RADIUS_M - INSIDE_M
    near_by = Twist(0.3, 0.0)
    assert caution_at(near_by, near((0.15, surely_m - 0.001))).most_mps == 0.0
    assert caution_at(near_by, near((0.15, surely_m + 0.001))).most_mps >= CREEP_MPS
    assert caution_at(near_by, near((0.2, RADIUS_M + BESIDE_M + 0.001))) == FREE


def test_a_drop_is_braked_for_with_half_of_the_body():
    caution = caution_at(FAST, near(drops=[(0.6, 0.05)]))
    way_m = 0.6 - math.sqrt((RADIUS_M / 2) ** 2 - 0.05**2)
    assert caution.most_mps == pytest.approx(halting(way_m - REST_M), rel=1e-6)
    assert (caution.kind, caution.reason) == (HaltKind.FLOOR, "no floor 0.53 m ahead")
    assert caution_at(FAST, near(drops=[(0.6, RADIUS_M / 2 + 0.001)])) == FREE


def test_of_an_obstacle_and_a_drop_the_nearer_is_said():
    drops = [(0.6, 0.0)]
    told = caution_at(FAST, near((0.5, 0.0), drops=drops))
    assert (told.kind, told.reason) == (HaltKind.OBSTACLE, "something 0.32 m ahead")
    told = caution_at(FAST, near((0.9, 0.0), drops=drops))
    assert (told.kind, told.reason) == (HaltKind.FLOOR, "no floor 0.51 m ahead")
    told = caution_at(FAST, near((0.5, RADIUS_M + 0.005), drops=[(1.2, 0.0)]))
    assert told.kind is HaltKind.OBSTACLE  # it is passed slower than the drop is reached
    told = caution_at(FAST, near((0.1, 0.0), drops=[(0.05, 0.0)]))
    assert (told.kind, told.reason) == (HaltKind.FLOOR, "no floor 0.00 m ahead")
    told = caution_at(FAST, near((0.1, 0.0)))
    assert (told.kind, told.reason) == (HaltKind.OBSTACLE, "something 0.00 m ahead")
    told = caution_at(FAST, near(drops=[(0.05, 0.0)]))
    assert (told.kind, told.reason) == (HaltKind.FLOOR, "no floor 0.00 m ahead")


def test_a_robot_that_may_hardly_go_stands():
    gap_m = RADIUS_M - INSIDE_M + REST_M
    slow = Twist(0.03, 0.0)
    assert caution_at(slow, near((gap_m + 0.008, 0.0))).most_mps == pytest.approx(
        halting(0.008), rel=1e-3
    )
    assert 0.0 < halting(0.0055) < 0.02
    assert caution_at(slow, near((gap_m + 0.0055, 0.0))).most_mps == 0.0


def test_to_halt_is_told_at_once_where_slowing_is_not_enough_any_more():
    assert stopping_m(0.4, 0.5) == pytest.approx(0.4 * 0.1 + 0.4**2)
    assert stopping_m(0.4, 1.0) == pytest.approx(0.4 * 0.1 + 0.4**2 / 2)
    gap_m = RADIUS_M - INSIDE_M + REST_M
    for more_m, stops in ((0.001, False), (-0.001, True)):
        thing = near((gap_m + stopping_m(0.4, BRAKE) + more_m, 0.0))
        assert (caution_at(Twist(0.4, 0.0), thing).most_mps == 0.0) is stops


@pytest.mark.parametrize("yaw_rad", [0.0, 0.7, -2.0])
def test_where_the_base_is_does_not_matter(yaw_rad):
    pose, c, s = Pose(3.0, -5.0, yaw_rad), math.cos(yaw_rad), math.sin(yaw_rad)
    seen = near((3.0 + 0.6 * c - 0.1 * s, -5.0 + 0.6 * s + 0.1 * c))
    assert caution_at(FAST, seen, pose).most_mps == pytest.approx(
        caution_at(FAST, near((0.6, 0.1))).most_mps, rel=1e-5
    )


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_way_along_a_circle_by_hand(side):
    """Half a metre round (0, 0.5), to a thing that lies a quarter turn on, or three."""
    for along, at in ((0.25, (0.5, 0.5)), (0.75, (-0.5, 0.5))):
        way_m = free_way_m(np.array([[at[0], side * at[1]]]), side * 2.0, 0.1)
        assert way_m == pytest.approx(0.5 * (along * math.tau - math.acos(0.98)))
    assert free_way_m(np.array([[0.3, side * 0.5]]), side * 2.0, 0.1) == math.inf
    assert free_way_m(np.array([[0.0, side * 0.5]]), side * 2.0, 0.1) == math.inf


def test_the_way_straight_on_by_hand():
    points = np.array([[1.0, 0.06], [0.5, 0.2], [-0.5, 0.0], [2.0, 0.0]])
    assert free_way_m(points, 0.0, 0.1) == pytest.approx(1.0 - 0.08)
    assert free_way_m(points, 0.0009, 0.1) == pytest.approx(1.0 - 0.08)
    assert free_way_m(points, -0.0011, 0.1) == pytest.approx(1.0 - 0.08, abs=0.002)
    assert free_way_m(points[1:3], 0.0, 0.1) == math.inf


def test_what_is_touched_at_the_side_and_ahead_of_the_middle_ends_the_way():
    assert free_way_m(np.array([[0.001, 0.09]]), 0.0, 0.1) == 0.0
    assert free_way_m(np.array([[0.0, 0.09]]), 0.0, 0.1) == math.inf
    assert free_way_m(np.array([[0.0, 0.09], [0.5, 0.0]]), 0.0, 0.1) == pytest.approx(0.4)
    assert free_way_m(np.array([[-0.05, 0.05], [0.5, 0.5]]), 2.0, 0.1) > 0.5


def test_the_halting_speed_where_there_is_no_way_and_no_end_of_it():
    assert halting_mps(0.0, BRAKE) == 0.0
    assert halting_mps(-1.0, BRAKE) == 0.0
    assert halting_mps(math.inf, BRAKE) == math.inf
    assert halting_mps(0.5, 1.0) == pytest.approx(math.sqrt(0.09 + 1.0) - 0.3)


def test_the_surest_speed_of_a_camera_that_sees_less_far_and_of_other_brakes():
    v = sure_mps(0.2, 1.0, 1.0)
    assert v * 0.7 + v * v / 2 == pytest.approx(1.0 - 0.2 - REST_M)


def test_what_a_tight_turn_is_turned_against_is_not_passed_by():
    """Within the rim alone, on an arc of 17 cm."""
    told = caution_at(Twist(0.5, 3.0), near((1 / 6 + 0.17, 1 / 6)))
    assert (told.kind, told.most_mps) == (HaltKind.OBSTACLE, 0.0)


def test_beyond_what_is_passed_by_it_halts_before_what_is_on_the_way():
    fast, passed = Twist(0.7, 0.0), (0.3, 0.17)
    way_m = stopping_m(0.7, BRAKE) + RADIUS_M - INSIDE_M + REST_M
    assert caution_at(fast, near(passed, (way_m - 0.01, 0.0))).most_mps == 0.0
    beside_m = 0.3 - math.sqrt((RADIUS_M + BESIDE_M) ** 2 - 0.17**2)
    slower = caution_at(fast, near(passed, (way_m + 0.01, 0.0)))
    assert slower.most_mps == pytest.approx(halting(beside_m), rel=1e-6)


def test_what_is_in_the_middle_of_an_arc_of_the_body_s_own_radius_is_no_mistake():
    assert free_way_m(np.array([[0.0, 0.5]]), 2.0, 0.5) == math.inf
