"""A camera's images, decoded as they are configured, and depth once for all who look at it."""

import threading
from collections import deque
from typing import Final

from runtime.core.mapping.solid_depth import solid
from runtime.core.types import F32, U8
from runtime.robot.images.reading import DepthScale, decode_color, metres, read_depth, unit_of
from runtime.robot.session import BusConfig
from runtime.robot.sync import RawMessage
from runtime.robot.transforms import CameraConfig

KEPT: Final = 4  # decoded depth images: between the reflex and the frame lie fewer


class DepthImage:
    """(H, W) m along the optical axis, 0 where there is no reading; one step of it was taken for
    `unit_m`. Nobody may write to it."""

    def __init__(self, depth_m: F32, unit_m: float) -> None:
        depth_m.flags.writeable = False
        self.depth_m, self.unit_m = depth_m, unit_m
        self.solid_m: F32 | None = None  # without flying pixels, once somebody asked

    def solid(self) -> F32:
        """The same without flying pixels."""
        found = self.solid_m
        if found is None:  # two who ask at once find the same
            found = solid(self.depth_m)
            found.flags.writeable = False
            self.solid_m = found
        return found


class CameraImages:
    """Any thread may ask. Nobody waits for another who decodes the same: it is decoded twice
    then."""

    def __init__(self, config: BusConfig, camera: CameraConfig) -> None:
        self._topics = config.topics
        self._packed = {stream: config.is_packed(stream) for stream in ("color", "depth")}
        self._scale = DepthScale(camera.depth_unit_m, camera.depth_nothing_m)
        self._lock = threading.Lock()
        self._kept: deque[tuple[RawMessage, DepthImage]] = deque(maxlen=KEPT)

    def color(self, raw: RawMessage) -> U8:
        """(H, W, 3) RGB. SensorError for what cannot be read."""
        return decode_color(raw.payload, self._topics.color, self._packed["color"]).value

    def depth(self, raw: RawMessage) -> DepthImage:
        """SensorError for what cannot be read."""
        with self._lock:
            found = next((image for one, image in self._kept if one is raw), None)
        if found is None:
            told = read_depth(raw.payload, self._topics.depth, self._packed["depth"]).value
            found = DepthImage(metres(told, self._scale), unit_of(told, self._scale))
            with self._lock:
                self._kept.append((raw, found))
        return found
