"""A camera's images, in whatever they are packed."""

import struct
from itertools import product

import numpy as np
from answers import refused_in_a_line
from camera_messages import compressed_depth, compressed_image, image, png, rvl_of
from other_half import compressed_color

from runtime.errors import SensorError
from runtime.robot.images.reading import DepthScale, decode_color, decode_depth

RGB = np.arange(8 * 12 * 3, dtype=np.uint8).reshape(8, 12, 3)
MM = np.arange(8 * 12, dtype=np.uint16).reshape(8, 12) * 600
WAYS = list(product(("color", "depth"), (False, True)))  # and whether it is packed
SCALES = (DepthScale(), DepthScale(0.0001, 3.0))

COLORS = [
    (False, image("rgb8", (12, 8), RGB.tobytes())),
    (False, image("bgra8", (2, 2), bytes(range(20)), step=10)),
    (False, image("mono8", (4, 2), bytes(range(8)))),
    (False, image("yuv422", (4, 2), bytes(range(16)))),
    (False, image("yuv422_yuy2", (4, 2), bytes(range(16)))),
    (True, compressed_color(RGB, 5)),
    (True, compressed_image("rgb8; png compressed bgr8", png(RGB))),
]
DEPTHS = [
    (False, image("16UC1", (12, 8), MM.tobytes())),
    (False, image("16SC1", (4, 2), bytes(range(16)), big=True)),
    (False, image("32FC1", (2, 2), struct.pack("<4f", 1.0, 2.0, 3.0, 4.0))),
    (True, compressed_image("16UC1; png compressed ", png(MM))),
    (True, compressed_image(*compressed_depth(png(MM)))),
    (True, compressed_image(*compressed_depth(rvl_of(MM), packing=" rvl"))),
    (True, compressed_image(*compressed_depth(rvl_of(MM), "32FC1", " rvl", 10100.0, -1009.0))),
]


def images(data: bytes) -> None:
    """The first byte says what a message is taken for."""
    if not data:
        return
    stream, packed = WAYS[data[0] % len(WAYS)]
    with refused_in_a_line(SensorError):
        if stream == "color":
            rgb = decode_color(data[1:], "topic", packed).value
            assert rgb.ndim == 3
            assert rgb.dtype == np.uint8
        else:
            depth = decode_depth(data[1:], "topic", packed, SCALES[data[0] > 127]).value
            assert np.isfinite(depth).all()
            assert (depth >= 0).all()


def pictures() -> list[bytes]:
    """Good ones."""
    told = [("color", *one) for one in COLORS] + [("depth", *one) for one in DEPTHS]
    return [bytes((WAYS.index((stream, packed)),)) + data for stream, packed, data in told]
