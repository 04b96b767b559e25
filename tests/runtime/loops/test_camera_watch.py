"""What a camera shows again from elsewhere."""

from dataclasses import replace

import pytest
from apartment import TWO_ROOMS, Apartment

from runtime.core.motion.safety import HaltKind
from runtime.core.types import Observation, Pose
from runtime.loops.camera_watch import CameraWatch


@pytest.fixture
def first() -> Observation:
    return Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, 0.0)).observe()


def again(first: Observation, x_m: float, yaw_rad: float = 0.0) -> Observation:
    pose = Pose(4.0 + x_m, 3.0, yaw_rad)
    return replace(first, rgb=first.rgb.copy(), depth_m=first.depth_m.copy(), pose=pose)


@pytest.mark.parametrize(
    ("x_m", "yaw_rad", "held"),
    [(0.0, 0.0, False), (0.04, 0.04, False), (0.06, 0.0, True), (0.0, -0.06, True)],
)
def test_the_same_from_elsewhere_is_no_news(
    first: Observation, x_m: float, yaw_rad: float, held: bool
):
    watch = CameraWatch()
    assert watch.note(first, 10.0) is None
    halt = watch.note(again(first, x_m, yaw_rad), 10.2)
    assert (halt is not None, watch.repeated) == (held, int(held))


def test_another_colour_or_another_depth_is_news(first: Observation):
    for other in ({"rgb": first.rgb + 1}, {"depth_m": first.depth_m + 1}):
        watch = CameraWatch()
        watch.note(first, 10.0)
        assert watch.note(replace(again(first, 0.5), **other), 10.2) is None


def test_a_robot_that_creeps_is_told_too_and_for_how_long(first: Observation):
    watch = CameraWatch()
    told = [watch.note(again(first, 0.02 * n), 10.0 + 0.2 * n) for n in range(5)]
    assert [halt is not None for halt in told] == [False, False, False, True, True]
    assert told[-1] is not None
    assert told[-1].kind is HaltKind.FRAME
    assert told[-1].reason == (
        "the camera has repeated itself for 0.8 s, although the base moved by 0.08 m, 0.00 rad"
    )
    assert watch.note(replace(again(first, 0.1), rgb=first.rgb + 1), 11.0) is None
    assert watch.note(replace(again(first, 0.1), rgb=first.rgb + 1), 11.2) is None
    assert watch.repeated == 2
