"""Messages of images -> RGB and metres. Whatever bytes come, nothing but SensorError is raised, of
one line that names the topic, what came, and the remedy."""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from runtime.core.types import F32, U8
from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot.images.compressed import color_picture, depth_picture
from runtime.robot.images.compressed_depth import depth_of
from runtime.robot.images.raw import color_pixels, depth_readings, shown
from runtime.robot.wire import Stamped

MM: Final = 0.001  # what a step of 16 bits is where nobody says otherwise (REP 118)


@dataclass(frozen=True)
class DepthScale:
    """What a depth camera's readings mean. unit_m: of one step; 0: 1 mm of 16 bits, 1 m of floats.
    nothing_m: what reads that or more is nothing; 0: all that is no number, 0, below it, or the
    most that 16 bits hold is, and nothing else."""

    unit_m: float = 0.0
    nothing_m: float = 0.0


AS_ENCODED: Final = DepthScale()


def decode_color(payload: bytes, topic: str, packed: bool = False) -> Stamped[U8]:
    """Image, or CompressedImage where it is `packed` -> (H, W, 3) RGB."""
    message = _message(payload, packed, topic, "color")
    pixels = color_picture(message, topic) if packed else color_pixels(message, topic)
    return Stamped(wire.header_stamp(message, topic), np.ascontiguousarray(pixels))


def decode_depth(
    payload: bytes, topic: str, packed: bool = False, scale: DepthScale = AS_ENCODED
) -> Stamped[F32]:
    """Image, or CompressedImage where it is `packed` -> (H, W) m along the optical axis; 0 where
    there is no reading."""
    told = read_depth(payload, topic, packed)
    return Stamped(told.stamp_ns, metres(told.value, scale))


def read_depth(payload: bytes, topic: str, packed: bool) -> Stamped[NDArray[Any]]:
    """Image, or CompressedImage where it is `packed` -> (H, W) of uint16, int16 or float32."""
    message = _message(payload, packed, topic, "depth")
    readings = _packed_depth(message, topic) if packed else depth_readings(message, topic)
    return Stamped(wire.header_stamp(message, topic), readings)


def unit_of(readings: NDArray[Any], scale: DepthScale) -> float:
    """What one step of readings is, m."""
    return scale.unit_m or (1.0 if readings.dtype == np.float32 else MM)


def metres(readings: NDArray[Any], scale: DepthScale) -> F32:
    """(H, W) of uint16, int16 or float32 -> m, 0 where there is none."""
    depth, unit_m = readings.astype(np.float32), unit_of(readings, scale)
    if unit_m != 1.0:
        depth /= np.float32(1 / unit_m)  # exact where a metre has a whole number of steps
    known = depth > 0  # not of what is no number
    if readings.dtype == np.float32:
        known &= np.isfinite(depth)
    else:
        known &= readings != np.iinfo(readings.dtype).max  # what fills the bits where nothing is
    if scale.nothing_m > 0:
        known &= depth < np.float32(scale.nothing_m)
    return np.where(known, depth, np.float32(0))


def _packed_depth(message: Any, topic: str) -> NDArray[Any]:
    if topic.endswith("/compressedDepth") or "compressedDepth" in str(message.format):
        return depth_of(message, topic)
    return depth_picture(message.data, topic, str(message.format))


def _message(payload: bytes, packed: bool, topic: str, stream: str) -> Any:
    kinds = wire.IMAGE, wire.COMPRESSED_IMAGE
    kind, other = reversed(kinds) if packed else kinds
    try:
        return wire.decode(payload, kind, topic)
    except SensorError as error:
        try:
            message = wire.decode(payload, other, topic)
        except SensorError:
            raise error from None
    if packed:
        what, remedy = f"an Image, {shown(str(message.encoding))}", "its topic is another one, or"
        remedy += f' take "{stream}" out of bus.compressed'
    else:
        what = f"a CompressedImage, {shown(str(message.format))}"
        remedy = f'add "{stream}" to bus.compressed, or name a topic that ends in /compressed'
    raise SensorError(f"{topic}: is {what}: {remedy}")
