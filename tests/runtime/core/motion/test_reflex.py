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
