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
    ("x_m", "yaw_rad", "repeats"),
    [(0.0, 0.0, False), (0.04, 0.04, False), (0.06, 0.0, True), (0.0, -0.06, True)],
)
def test_the_same_from_elsewhere_is_no_news(
    first: Observation, x_m: float, yaw_rad: float, repeats: bool
):
    watch = CameraWatch()
    assert not watch.repeats(first, 10.0)
    assert watch.repeats(again(first, x_m, yaw_rad), 10.2) is repeats
    assert (watch.repeated, watch.doubt) == (int(repeats), None)


def test_another_colour_or_another_depth_is_news(first: Observation):
    for other in ({"rgb": first.rgb + 1}, {"depth_m": first.depth_m + 1}):
        watch = CameraWatch()
        watch.repeats(first, 10.0)
        assert not watch.repeats(replace(again(first, 0.5), **other), 10.2)


def test_an_image_without_a_difference_in_it_is_no_place(first: Observation):
    dark = replace(first, rgb=first.rgb * 0, depth_m=first.depth_m * 0)
    for seen, repeats in ((dark, False), (replace(first, rgb=first.rgb * 0), True)):
        watch = CameraWatch()
        watch.repeats(seen, 10.0)
        assert watch.repeats(again(seen, 0.5), 11.0) is repeats


def test_a_robot_that_creeps_is_told_too_and_for_how_long(first: Observation):
    watch = CameraWatch()
    told = []
    for n in range(5):
        repeats = watch.repeats(again(first, 0.02 * n), 10.0 + 0.15 * n)
        told.append((repeats, watch.doubt is not None))
    assert told == [(False, False)] * 3 + [(True, False), (True, True)]
    assert watch.doubt is not None
    assert watch.doubt.kind is HaltKind.FRAME
    assert watch.doubt.reason == (
        "the camera has repeated itself for 0.6 s, although the base moved"
    )
    other = replace(again(first, 0.1), rgb=first.rgb + 1)
    assert not watch.repeats(other, 11.0)
    assert watch.doubt is None
    assert not watch.repeats(other, 11.2)
    assert watch.repeated == 2


def test_where_a_base_came_to_rest_may_be_told_later_than_its_image(first: Observation):
    watch = CameraWatch()
    watch.repeats(first, 10.0)
    late = again(first, 0.07)
    for now_s, repeats, held in ((10.3, True, False), (10.6, True, True), (11.3, False, False)):
        assert watch.repeats(late, now_s) is repeats
        assert (watch.doubt is not None) is held
    for n in range(20):  # it stands there, and the image stays
        assert not watch.repeats(late, 12.0 + n)


def test_a_base_that_moves_once_more_from_where_it_stood_is_held_for_good(first: Observation):
    watch, now_s = CameraWatch(), 10.0
    watch.repeats(first, now_s)
    for x_m, count, held in ((0.2, 4, True), (0.2, 8, False), (0.3, 12, True)):
        for _ in range(count):
            now_s += 0.2
            watch.repeats(again(first, x_m), now_s)
        assert (watch.doubt is not None) is held
    for _ in range(100):
        now_s += 0.2
        watch.repeats(again(first, 0.3), now_s)
        assert watch.doubt is not None
