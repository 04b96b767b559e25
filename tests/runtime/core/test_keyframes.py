"""Of the images that look toward a point, the nearest whose way is clear."""

import math

import numpy as np

from runtime.core.keyframes import Keyframe, KeyframeConfig, best_view, keep
from runtime.core.map import MapConfig, NavigationMap
from runtime.core.types import Pose

CFG = KeyframeConfig(kept=3)


def frame(x: float, y: float, degrees: float, mark: float) -> Keyframe:
    return Keyframe(Pose(x, y, math.radians(degrees)), np.array([mark], np.float32))


def empty() -> NavigationMap:
    grid = NavigationMap.around(Pose(0, 0, 0), 0.18, MapConfig())
    grid.grow(np.array([0.0, 0.0]), 6.0)
    return grid


def test_the_nearest_that_faces_it_is_chosen():
    frames = [frame(0, 0, 0, 1), frame(1, 0, 0, 2), frame(1.5, 0, 180, 3)]
    assert best_view(frames, (3.0, 0.0), empty(), CFG).tolist() == [2.0]


def test_behind_a_wall_nothing_is_seen():
    grid = empty()
    rows, cols = grid.frame.cells(np.stack([np.full(40, 2.0), np.linspace(-1, 1, 40)], 1)).T
    grid.evidence[rows, cols] = 10
    grid.changed()
    assert best_view([frame(0, 0, 0, 1)], (3.0, 0.0), grid, CFG).size == 0
    assert best_view([frame(0, 0, 0, 1)], (1.5, 0.0), grid, CFG).tolist() == [1.0]


def test_one_from_the_same_pose_is_replaced_and_the_oldest_are_forgotten():
    frames: list[Keyframe] = []
    keep(frames, frame(0, 0, 0, 1), CFG)
    keep(frames, frame(0.1, 0, 5, 2), CFG)
    assert [f.embedding[0] for f in frames] == [2.0]
    for n in range(4):
        keep(frames, frame(2.0 + n, 0, 0, 10 + n), CFG)
    assert [f.embedding[0] for f in frames] == [11.0, 12.0, 13.0]
