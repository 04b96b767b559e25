"""Frames that one episode's methods share: a noise-free discrete robot often stands where another
method's robot stood."""

from collections.abc import Callable
from dataclasses import dataclass, field

from hil_sim.simulation.camera import CameraModel, Frame
from runtime.core.types import Pose

LIMIT_BYTES = 1_200_000_000
"""What one worker may keep; then what was not looked at for longest goes."""

Key = tuple[float, float, float, CameraModel, float, bool]
Render = Callable[[float, float, float, CameraModel, float, bool], Frame]


@dataclass
class FrameMemo:
    """Renders each exact pose once. `rendered` and `recalled` count frames since `reset`."""

    render: Render  # x m, y m, yaw rad, camera, pitch rad (down is positive), with colour
    limit_bytes: int = LIMIT_BYTES
    rendered: int = 0
    recalled: int = 0
    _kept: dict[Key, Frame] = field(default_factory=dict)  # the longest unused first
    _bytes: int = 0

    def look(
        self, pose: Pose, camera: CameraModel, pitch_rad: float = 0.0, colour: bool = True
    ) -> Frame:
        """The view from a pose, scene frame. The arrays are shared and cannot be written to."""
        key = (pose.x_m, pose.y_m, pose.yaw_rad, camera, pitch_rad, colour)
        frame = self._kept.pop(key, None)
        if frame is not None:
            self.recalled += 1
            self._kept[key] = frame
            return frame
        self.rendered += 1
        frame = self.render(*key)
        for array in (frame.rgb, frame.depth_m, frame.segmentation):
            array.flags.writeable = False
        self._kept[key] = frame
        self._bytes += _size(frame)
        while self._bytes > self.limit_bytes:
            self._bytes -= _size(self._kept.pop(next(iter(self._kept))))
        return frame

    def clear(self) -> None:
        """Forget every frame, as the next episode begins elsewhere."""
        self._kept.clear()
        self._bytes = 0

    def reset(self) -> None:
        """Count from zero."""
        self.rendered = self.recalled = 0


def _size(frame: Frame) -> int:
    return int(frame.rgb.nbytes + frame.depth_m.nbytes + frame.segmentation.nbytes)
