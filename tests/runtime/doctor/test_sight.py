"""How far the base turned, by images of a painted apartment whose pose is known."""

import math
from dataclasses import replace

import numpy as np
import pytest
from apartment import INTRINSICS, MOUNT, TWO_ROOMS
from painted import Painted

from runtime.core.types import Mount, Pose
from runtime.doctor.hearing import Glimpse, glimpse
from runtime.doctor.sight import seen_turn, seen_turns


def seen_from(pose: Pose, deep: bool = True) -> Glimpse:
    obs = Painted.of(TWO_ROOMS, pose).observe()
    return glimpse(obs.stamp_ns, obs.rgb, obs.depth_m if deep else None)


@pytest.mark.parametrize("turn", [-0.2, -0.05, 0.0, 0.03, 0.1, 0.2])
@pytest.mark.parametrize("deep", [True, False])
def test_a_turn_on_the_spot_is_measured_with_its_sign(turn: float, deep: bool):
    here = Pose(4.0, 3.0, 0.4)
    found = seen_turn(
        seen_from(here, deep), seen_from(replace(here, yaw_rad=0.4 + turn), deep), INTRINSICS, MOUNT
    )
    assert found == pytest.approx(turn, abs=0.01 if deep else 0.02)


def test_driving_ahead_is_no_turn():
    found = seen_turn(
        seen_from(Pose(4.0, 3.0, 0.0)), seen_from(Pose(4.1, 3.0, 0.0)), INTRINSICS, MOUNT
    )
    assert found == pytest.approx(0.0, abs=0.01)


def test_a_camera_that_hangs_upside_down_sees_the_same_turn_once_it_is_known():
    here = Pose(4.0, 3.0, 0.4)
    before, after = seen_from(here), seen_from(replace(here, yaw_rad=0.5))
    a, b = (
        Glimpse(g.stamp_ns, g.grey[::-1, ::-1].copy(), g.depth_m[::-1, ::-1].copy())
        for g in (before, after)
        if g.depth_m is not None
    )
    assert seen_turn(a, b, INTRINSICS, Mount(roll_rad=math.pi)) == pytest.approx(0.1, abs=0.01)
    assert seen_turn(a, b, INTRINSICS, MOUNT) == pytest.approx(-0.1, abs=0.02)


@pytest.mark.parametrize("level", [0, 128])
def test_where_nothing_is_to_be_seen_nothing_is_said(level: int):
    even = Glimpse(1, np.full((120, 160), level, np.uint8))
    assert seen_turn(even, even, INTRINSICS, MOUNT) is None


def test_noise_tells_of_no_turn():
    noise = [
        Glimpse(n, np.random.default_rng(n).integers(256, size=(120, 160), dtype=np.uint8))
        for n in range(2)
    ]
    assert seen_turn(noise[0], noise[1], INTRINSICS, MOUNT) is None


def test_images_that_are_too_far_apart_or_of_another_size_are_not_compared():
    a = seen_from(Pose(4.0, 3.0, 0.0))
    late = replace(a, stamp_ns=a.stamp_ns + 2 * 10**9)
    assert seen_turns([a, late], INTRINSICS, MOUNT) == []
    small = Glimpse(a.stamp_ns + 10**8, np.zeros((60, 80), np.uint8))
    assert seen_turns([a, small], INTRINSICS, MOUNT) == []
    back = replace(a, stamp_ns=a.stamp_ns - 1)
    assert seen_turns([a, back], INTRINSICS, MOUNT) == []
    (soon,) = seen_turns([a, replace(a, stamp_ns=a.stamp_ns + 10**8)], INTRINSICS, MOUNT)
    assert soon.turn_rad == pytest.approx(0.0, abs=0.003)
