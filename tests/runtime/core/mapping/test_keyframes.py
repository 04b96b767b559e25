"""Of the images that look toward a point, the nearest whose way is clear."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest

from runtime.core.mapping.grid import NavigationMap
from runtime.core.mapping.keyframes import (
    Keyframe,
    KeyframeView,
    best_frames,
    best_views,
    consider,
    keep,
    sight_toward,
    take,
)
from runtime.core.types import Detections, Intrinsics, Mount, Observation, Pose


@pytest.fixture(autouse=True, scope="module")
def few_are_kept():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("runtime.core.mapping.keyframes.KEYFRAMES_KEPT", 3)
        yield


def best_view(frames: list[Keyframe], cells_xy: np.ndarray, grid: NavigationMap) -> KeyframeView:
    return best_views(frames, {7: cells_xy}, grid)[7]


def at(x: float, y: float) -> np.ndarray:
    return np.array([[x, y]])


def frame(x: float, y: float, degrees: float, mark: float) -> Keyframe:
    return Keyframe(Pose(x, y, math.radians(degrees)), np.array([mark], np.float32))


def empty() -> NavigationMap:
    grid = NavigationMap.around(Pose(0, 0, 0), 0.18)
    grid.grow(np.array([0.0, 0.0]), 6.0)
    return grid


def seen(features: np.ndarray) -> Detections:
    none = np.zeros((0, 4), np.float32)
    return Detections(
        none, none[:, 0], none[:, 0].astype(np.int32), none, none[:, 0], features=features
    )


def observed() -> Observation:
    k = Intrinsics(320.0, 320.0, 320.0, 240.0, 640, 480)
    grey, depth = np.full((480, 640, 3), 90, np.uint8), np.full((480, 640), 2.0, np.float32)
    grey[:, 320:] += 40
    return Observation(1, grey, depth, Pose(0, 0, 0), k)


PARTS = np.arange(3 * 6 * 8, dtype=np.float32).reshape(3, 6, 8)
NOTHING = np.zeros((0, 0, 0), np.float32)


def test_the_nearest_that_faces_it_is_chosen():
    frames = [frame(0, 0, 0, 1), frame(1, 0, 0, 2), frame(1.5, 0, 180, 3)]
    assert best_view(frames, at(3.0, 0.0), empty()).embedding.tolist() == [2.0]


def test_behind_a_wall_nothing_is_seen():
    grid = empty()
    rows, cols = grid.frame.cells(np.stack([np.full(40, 2.0), np.linspace(-1, 1, 40)], 1)).T
    grid.evidence[rows, cols] = 10
    grid.changed()
    assert best_view([frame(0, 0, 0, 1)], at(3.0, 0.0), grid).embedding.size == 0
    assert best_view([frame(0, 0, 0, 1)], at(1.5, 0.0), grid).embedding.tolist() == [1.0]


def test_one_from_the_same_pose_is_replaced_and_the_oldest_are_forgotten():
    frames: list[Keyframe] = []
    keep(frames, frame(0, 0, 0, 1))
    keep(frames, frame(0.1, 0, 5, 2))
    assert [f.embedding[0] for f in frames] == [2.0]
    for n in range(4):
        keep(frames, frame(2.0 + n, 0, 0, 10 + n))
    assert [f.embedding[0] for f in frames] == [11.0, 12.0, 13.0]


def test_one_that_shows_more_of_a_frontier_is_preferred_to_a_nearer_one_that_shows_its_end():
    cells = np.stack([np.full(20, 4.0), np.linspace(-1.5, 1.5, 20)], axis=1)
    frames = [frame(1, 0, 0, 1), frame(3.2, -1.0, -70, 2)]
    assert best_view(frames, cells, empty()).embedding.tolist() == [1.0]


def test_a_blurred_one_does_not_replace_a_sharp_one():
    frames: list[Keyframe] = []
    sharp, blurred = (replace(frame(0, 0, 0, m), sharpness=s) for m, s in ((1, 10.0), (2, 5.0)))
    keep(frames, sharp)
    keep(frames, blurred)
    assert [f.embedding[0] for f in frames] == [1.0]


def test_of_a_blurred_one_nothing_further_is_worked_out(monkeypatch: pytest.MonkeyPatch):
    frames: list[Keyframe] = []
    consider(frames, observed(), seen(PARTS), Mount(), 0)
    (sharp,) = frames
    grey = np.full_like(observed().rgb, 90)
    grey[:, 320:] += 2  # hardly an edge
    blurred = replace(observed(), rgb=grey, pose=Pose(0.1, 0, 0))
    with monkeypatch.context() as patch:
        patch.setattr("runtime.core.mapping.keyframes.take", None)
        consider(frames, blurred, seen(PARTS), Mount(), 0)
    assert frames == [sharp]
    consider(frames, replace(blurred, pose=Pose(2.0, 0, 0)), seen(PARTS), Mount(), 0)
    assert [f.pose.x_m for f in frames] == [0.0, 2.0]  # where none is beside it, it is kept


@pytest.mark.parametrize("parts", [PARTS, NOTHING])
@pytest.mark.parametrize("edge", [0, 2, 40, 90])
def test_what_is_considered_is_what_is_taken_and_kept(parts: np.ndarray, edge: int):
    grey = np.full_like(observed().rgb, 90)
    grey[:, 320:] += edge
    other = replace(observed(), rgb=grey, pose=Pose(0.1, 0, 0))
    frames, plainly = list[Keyframe](), list[Keyframe]()
    for obs, told in ((observed(), PARTS), (other, parts)):
        consider(frames, obs, seen(told), Mount(), 0)
        keep(plainly, take(obs, seen(told), Mount(), 0))
    assert [(f.pose, f.sharpness, f.tells) for f in frames] == [
        (f.pose, f.sharpness, f.tells) for f in plainly
    ]


def test_one_that_tells_less_does_not_replace_one_that_tells_more():
    none, whole = (np.zeros(n, np.float32) for n in (0, 1))
    of_nothing = replace(frame(0, 0, 0, 0), embedding=none, sharpness=10.0)
    of_whole = replace(of_nothing, embedding=whole, sharpness=4.0)
    of_parts = replace(of_whole, features=PARTS.astype(np.float16), sharpness=1.0)
    ranked = [of_nothing, of_whole, of_parts]
    for old in range(3):
        for new in range(3):
            frames = [ranked[old]]
            keep(frames, replace(ranked[new], pose=Pose(0.1, 0, 0)))
            assert frames[0].pose.x_m == (0.0 if new < old else 0.1)


def test_images_are_kept_when_asked_for_and_told_where_the_frontier_is():
    assert take(observed(), seen(NOTHING), Mount(), 0).image.size == 0
    kept = take(observed(), seen(NOTHING), Mount(), 320)
    assert kept.image.shape == (240, 320, 3)
    left, right = (best_view([kept], at(2.0, y), empty()) for y in (0.5, -0.5))
    assert left.jpeg is right.jpeg  # one file, whatever is asked of it
    assert cv2.imdecode(np.frombuffer(left.jpeg, np.uint8), cv2.IMREAD_COLOR).shape == (240, 320, 3)
    assert left.in_image is not None
    assert right.in_image is not None
    assert left.in_image.column == pytest.approx(0.5 - 0.125, abs=0.01)
    assert right.in_image.column == pytest.approx(0.5 + 0.125, abs=0.01)


def test_the_best_frames_are_told_in_order_and_only_those_that_show_it():
    poses = np.array([[0, 0, 0], [1, 0, 0], [1.5, 0, math.pi], [0.5, 0, 0]], float)
    assert best_frames(poses, at(3.0, 0.0), empty(), 2) == (1, 3)
    assert best_frames(poses, at(3.0, 0.0), empty(), 9) == (1, 3, 0)
    assert best_frames(poses[2:3], at(3.0, 0.0), empty(), 9) == ()


@pytest.mark.parametrize("image_width_px", [0, 320])
def test_what_the_detector_saw_is_shown_with_where_the_frontier_is_in_it(image_width_px: int):
    kept = take(observed(), seen(PARTS), Mount(), image_width_px)
    sight = best_view([kept], np.array([[2.0, 0.4], [2.0, 0.6]]), empty()).sight
    assert sight is not None
    assert (sight.features == PARTS).all()
    assert (sight.depth[0] == 2.0).all()
    assert (sight.depth[1] == 1.0).all()
    assert sight.range_m == pytest.approx(math.hypot(2.0, 0.5))
    assert sight.column == pytest.approx(0.5 - 0.25 * 320 / 640, abs=0.01)


def test_a_keyframe_of_a_detector_that_does_not_tell_gives_no_sight():
    bare = take(observed(), seen(NOTHING), Mount(), 0)
    view = best_view([replace(bare, embedding=np.ones(1, np.float32))], at(2.0, 0.0), empty())
    assert (view.embedding.tolist(), view.sight) == ([1.0], None)
    told = take(observed(), seen(PARTS), Mount(), 320)
    assert sight_toward(told, at(2.0, 0.0)) is not None
    assert sight_toward(told.bare(), at(2.0, 0.0)) is None


@pytest.mark.parametrize("noise", [0.0, 1.0, 2.0, 3.0])
def test_a_picture_of_one_colour_shows_nothing_whatever_its_noise(noise: float):
    rng = np.random.default_rng(7)
    wall = np.array([90.0, 120.0, 200.0]) + rng.normal(0.0, noise, (480, 640, 3))
    plain = replace(observed(), rgb=wall.round().astype(np.uint8))
    assert not take(plain, seen(PARTS), Mount(), 0).features.size
    wall[:, 320:] += 30.0  # the edge of a door
    edge = replace(plain, rgb=wall.round().astype(np.uint8))
    assert take(edge, seen(PARTS), Mount(), 0).features.size


def test_what_half_precision_has_no_number_for_stays_finite():
    kept = take(observed(), seen(PARTS * np.float32(1e6)), Mount(), 0)
    assert np.isfinite(kept.features).all()
    assert kept.features.max() == np.finfo(np.float16).max


def test_keyframes_take_no_more_memory_than_they_may(monkeypatch: pytest.MonkeyPatch):
    one = take(observed(), seen(PARTS), Mount(), 320)
    parts = 5 * 6 * 8 * 2
    assert one.size_bytes == 320 * 240 * 3 + parts
    monkeypatch.setattr(
        "runtime.core.mapping.keyframes.KEYFRAMES_BYTES", one.size_bytes + 2 * parts
    )
    frames: list[Keyframe] = []
    for n in range(3):
        keep(frames, replace(one, pose=Pose(2.0 * n, 0, 0)))
    assert [(f.pose.x_m, f.image.size > 0) for f in frames] == [(0, False), (2, False), (4, True)]
    assert all(f.features.size for f in frames)
    assert frames[2].jpeg
    assert frames[2].size_bytes == one.size_bytes + len(frames[2].jpeg)
    keep(frames, replace(one, pose=Pose(6.0, 0, 0), image=np.zeros((1000, 999, 3), np.uint8)))
    assert [f.pose.x_m for f in frames] == [6.0]  # the newest stays, however large
