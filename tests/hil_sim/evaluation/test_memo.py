"""Frames are rendered once per exact pose and camera, and memory is bounded."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from hil_sim.evaluation.memo import FrameMemo
from runtime.core.types import Pose

CAMERA, SMALL = "large", "small"  # only compared


@dataclass(frozen=True)
class Frame:
    rgb: np.ndarray
    depth_m: np.ndarray
    segmentation: np.ndarray


@dataclass
class Renderer:
    asked: list[tuple[float, ...]] = field(default_factory=list)

    def __call__(
        self, x: float, y: float, yaw: float, camera: str, pitch: float, colour: bool
    ) -> Frame:
        self.asked.append((x, y, yaw))
        blank = np.zeros((10, 10), np.float32)
        return Frame(np.full((10, 10, 3), x, np.uint8), blank, blank.astype(np.int32))


def test_a_pose_is_rendered_once_for_each_camera_and_pitch() -> None:
    renderer = Renderer()
    memo = FrameMemo(renderer)  # type: ignore[arg-type]
    first = memo.look(Pose(1.0, 2.0, 0.5), CAMERA)  # type: ignore[arg-type]
    assert memo.look(Pose(1.0, 2.0, 0.5), CAMERA) is first  # type: ignore[arg-type]
    memo.look(Pose(1.0, 2.0, 0.5), SMALL)  # type: ignore[arg-type]
    memo.look(Pose(1.0, 2.0, 0.5), CAMERA, 0.1)  # type: ignore[arg-type]
    memo.look(Pose(1.0, 2.0, np.nextafter(0.5, 1)), CAMERA)  # type: ignore[arg-type]
    assert (memo.rendered, memo.recalled) == (4, 1)
    memo.reset()
    assert (memo.rendered, memo.recalled) == (0, 0)
    memo.clear()
    memo.look(Pose(1.0, 2.0, 0.5), CAMERA)  # type: ignore[arg-type]
    assert memo.rendered == 1


def test_nobody_can_change_a_shared_frame() -> None:
    frame = FrameMemo(Renderer()).look(Pose(1, 2, 0), CAMERA)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="read-only"):
        frame.rgb[0, 0] = 3


def test_what_was_unused_for_longest_goes_first() -> None:
    renderer = Renderer()
    memo = FrameMemo(renderer, limit_bytes=2 * 1100)  # type: ignore[arg-type]
    for x in (1.0, 2.0, 1.0, 3.0, 1.0, 2.0):
        memo.look(Pose(x, 0.0, 0.0), CAMERA)  # type: ignore[arg-type]
    assert [x for x, _, _ in renderer.asked] == [1.0, 2.0, 3.0, 2.0]
