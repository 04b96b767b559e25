"""sensor_msgs/Image -> pixels, whatever a camera's driver calls them (REP 118 and the list in
sensor_msgs/image_encodings.hpp)."""

from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from runtime.core.types import U8
from runtime.errors import SensorError
from runtime.robot.bounds import MOST_PIXELS

# How many bytes a pixel has, and what makes RGB of them; None: it is that. Without a colour of
# their own OpenCV's types are in its order, blue first.
_COLORS: Final[dict[str, tuple[int, int | None]]] = {
    "rgb8": (3, None),
    "bgr8": (3, cv2.COLOR_BGR2RGB),
    "8UC3": (3, cv2.COLOR_BGR2RGB),
    "rgba8": (4, cv2.COLOR_RGBA2RGB),
    "bgra8": (4, cv2.COLOR_BGRA2RGB),
    "8UC4": (4, cv2.COLOR_BGRA2RGB),
    "mono8": (1, cv2.COLOR_GRAY2RGB),
    "8UC1": (1, cv2.COLOR_GRAY2RGB),
    "yuv422": (2, cv2.COLOR_YUV2RGB_UYVY),
    "uyvy": (2, cv2.COLOR_YUV2RGB_UYVY),
    "yuv422_yuy2": (2, cv2.COLOR_YUV2RGB_YUYV),
    "yuyv": (2, cv2.COLOR_YUV2RGB_YUYV),
}
_YUV422: Final = frozenset({"yuv422", "uyvy", "yuv422_yuy2", "yuyv"})  # two pixels share a colour
DEPTHS: Final = {"16UC1": np.uint16, "mono16": np.uint16, "16SC1": np.int16, "32FC1": np.float32}
_SHOWN: Final = 40  # letters of what somebody else calls an encoding or a format


def color_pixels(message: Any, topic: str) -> U8:
    """An Image -> (H, W, 3) RGB. SensorError for another encoding, or too few bytes."""
    encoding = str(message.encoding)
    if encoding not in _COLORS:
        raise SensorError(f"{topic}: encoding {shown(encoding)}: {_color_remedy(encoding)}")
    channels, code = _COLORS[encoding]
    lines = _lines(message, channels, topic)
    if encoding in _YUV422 and message.width % 2:
        raise SensorError(f"{topic}: {message.width} pixels of {encoding} wide: must be even")
    pixels = lines.reshape(message.height, message.width, channels)
    return pixels if code is None else np.asarray(cv2.cvtColor(pixels, code), np.uint8)


def depth_readings(message: Any, topic: str) -> NDArray[Any]:
    """An Image -> (H, W) of uint16, int16 or float32, in the driver's unit. SensorError for another
    encoding, or too few bytes."""
    encoding = str(message.encoding)
    if encoding not in DEPTHS:
        remedy = "publish 16UC1, 16SC1 or 32FC1"
        if encoding in _COLORS:
            remedy += "; this is colour: are bus.topics.depth and bus.topics.color exchanged?"
        raise SensorError(f"{topic}: encoding {shown(encoding)}: {remedy}")
    dtype = np.dtype(DEPTHS[encoding])
    lines = _lines(message, dtype.itemsize, topic)
    told = lines.view(dtype.newbyteorder(">" if message.is_bigendian else "<"))
    readings: NDArray[Any] = told.astype(dtype, copy=False)
    return readings


def check_area(height: int, width: int, topic: str) -> None:
    """SensorError for an image that is none, or larger than any; asked before it is made."""
    if not (height > 0 and width > 0) or height * width > MOST_PIXELS:
        raise SensorError(
            f"{topic}: an image of {width}x{height} pixels: 1 to {MOST_PIXELS} are taken"
        )


def shown(name: str) -> str:
    """What somebody else calls a thing, fit for a line."""
    return repr(name if len(name) <= _SHOWN else f"{name[:_SHOWN]}...")


def _lines(message: Any, pixel: int, topic: str) -> U8:
    """The rows of an Image without their padding: (H, W * pixel) bytes."""
    height, width, step = int(message.height), int(message.width), int(message.step)
    row = width * pixel
    check_area(height, width, topic)
    if step < row or len(message.data) < height * step:
        raise SensorError(
            f"{topic}: {width}x{height} {message.encoding} needs step >= {row} and "
            f"{height} rows of it, got step {step} and {len(message.data)} bytes"
        )
    lines = np.asarray(message.data[: height * step], np.uint8).reshape(height, step)[:, :row]
    return np.ascontiguousarray(lines)


def _color_remedy(encoding: str) -> str:
    if encoding in DEPTHS:
        return "this is depth: are bus.topics.color and bus.topics.depth exchanged?"
    if encoding.startswith("bayer"):
        return "have image_proc make rgb8 of it, and publish that"
    return "publish rgb8, bgr8, rgba8, bgra8, mono8, yuv422 or yuv422_yuy2"
