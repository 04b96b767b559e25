"""The camera's intrinsics: decoded when they are needed, and waited for only so long."""

from collections.abc import Callable

from runtime.core.optics.lens import Lens
from runtime.core.types import Intrinsics
from runtime.errors import SensorError
from runtime.robot.calibration import decode_lens
from runtime.robot.sync import RawMessage
from runtime.robot.transforms import peek_frame

SENSOR_TIMEOUT_S = 5.0  # how long a stream may stay away before the first frame


class CameraInfo:
    """Of one topic; messages that cannot be read are told to `bad`. `rectified`: the images are
    without what of distortion it tells. Not for several threads."""

    def __init__(
        self, topic: str, bad: Callable[[str, SensorError], None], rectified: bool = False
    ) -> None:
        self.topic, self._bad, self._rectified = topic, bad, rectified
        self._newest: RawMessage | None = None  # not decoded yet
        self._error: SensorError | None = None
        self._awaited_since_s: float | None = None
        self.lens: Lens | None = None
        self.frame = ""  # of the camera; "" where it does not say

    @property
    def intrinsics(self) -> Intrinsics | None:
        """Of the images as they are published."""
        return self.lens.intrinsics if self.lens else None

    def file(self, raw: RawMessage) -> None:
        """Keep a message."""
        self._newest = raw

    def read(self) -> Intrinsics | None:
        """By the newest message that could be read; None before there is one."""
        raw, self._newest = self._newest, None
        if raw is not None:
            try:
                frame = peek_frame(raw.payload, self.topic).lstrip("/")
                self.lens = decode_lens(raw.payload, self.topic, self._rectified)
                self.frame = frame
            except SensorError as error:
                self._bad(self.topic, error)
                self._error = error
        return self.intrinsics

    def awaited_until_s(self, now_s: float) -> float:
        """Images wait for their intrinsics: until when? SensorError when that is in vain."""
        if self._error is not None:
            raise self._error
        if self._awaited_since_s is None:
            self._awaited_since_s = now_s
        until_s = self._awaited_since_s + SENSOR_TIMEOUT_S
        if now_s >= until_s:
            self._awaited_since_s = None
            raise SensorError(
                f"{self.topic}: no intrinsics received in "
                f"{SENSOR_TIMEOUT_S:g} s although images come: publish camera_info"
            )
        return until_s
