"""Depth in sensor_msgs/CompressedImage as image_transport's `compressedDepth` packs it: 12 bytes of
parameters, then a PNG or RVL of 16 bits a pixel, which are the readings of 16UC1, or inverse depth
in steps where it was 32FC1.

RVL: A. D. Wilson, Fast lossless depth image compression, ISS 2017. Before it stand columns and
rows, 4 bytes each.
"""

import math
import struct
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from runtime.core.kernels.packed import unpack_rvl
from runtime.errors import SensorError
from runtime.robot.images.compressed import depth_picture
from runtime.robot.images.raw import DEPTHS, check_area, shown

_PARAMETERS: Final = 12  # bytes: an enumerator, and two numbers of the steps
_WORST: Final = 3  # bytes that RVL takes for a pixel at most


def depth_of(message: Any, topic: str) -> NDArray[Any]:
    """A CompressedImage -> (H, W) of uint16, in the driver's unit, or of float32 in that of 32FC1,
    0 where there is none. SensorError for what is none of that."""
    format, data = str(message.format), message.data
    encoding, _, packing = (part.strip() for part in format.partition(";"))
    told = f"{topic}: {shown(format)}"
    if encoding not in ("16UC1", "mono16", "32FC1"):
        raise SensorError(f"{told}: compressedDepth has 16UC1 or 32FC1 in it: publish one of those")
    if len(data) <= _PARAMETERS:
        raise SensorError(f"{told}: {len(data)} bytes: publish whole images")
    packed = data[_PARAMETERS:]
    if "rvl" in packing.lower():
        readings = _rvl(packed, topic, told)
    else:
        readings = depth_picture(packed, topic, format)
    if DEPTHS[encoding] is not np.float32:
        return readings
    _, a, b = struct.unpack("<iff", bytes(data[:_PARAMETERS]))
    if not (math.isfinite(a) and math.isfinite(b) and a > 0):
        raise SensorError(f"{told}: depth in steps of {a}, {b}: publish finite ones above 0")
    return _in_units(readings, a, b)


def _in_units(steps: NDArray[np.uint16], a: float, b: float) -> NDArray[np.float32]:
    """Of inverse depth, a / d + b, rounded down; 0: nothing."""
    inverse = steps.astype(np.float32) - np.float32(b)
    known = (steps > 0) & (inverse > 0)
    depth = np.divide(np.float32(a), inverse, out=np.zeros_like(inverse), where=known)
    return np.asarray(depth, np.float32)


def _rvl(packed: NDArray[np.uint8], topic: str, told: str) -> NDArray[np.uint16]:
    if len(packed) < 8:
        raise SensorError(f"{told}: {len(packed)} bytes of RVL: publish whole images")
    width, height = struct.unpack("<II", bytes(packed[:8]))
    check_area(height, width, topic)
    readings = np.empty((height, width), np.uint16)
    if not unpack_rvl(readings, packed[8 : 8 + _WORST * height * width + 4]):
        raise SensorError(
            f"{told}: {len(packed)} bytes are no RVL of {width}x{height} pixels: "
            "publish whole images"
        )
    return readings
