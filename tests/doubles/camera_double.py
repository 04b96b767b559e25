"""A process of its own that plays cameras, one of each kind below a name of its own, ten times a
second, until it is ended. Its bytes are made by camera_messages.

  camera_double.py ENDPOINT
"""

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np

HERE = Path(__file__).resolve().parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent.parent)]

from camera_messages import (  # noqa: E402
    compressed_depth,
    compressed_image,
    image,
    png,
    rvl_of,
)

from runtime.core.types import Intrinsics, Pose  # noqa: E402
from runtime.robot import wire  # noqa: E402
from runtime.robot.session import BusConfig, open_session  # noqa: E402

WIDTH, HEIGHT = 64, 48
LENS = Intrinsics(40.0, 40.0, 32.0, 24.0, WIDTH, HEIGHT)
POSE = Pose(1.0, 2.0, 0.5)
PERIOD_S = 0.1

RGB = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
RGB[:, : WIDTH // 2] = 220, 60, 30
RGB[:, WIDTH // 2 :] = 20, 90, 200
GREY = np.tile(np.arange(WIDTH, dtype=np.uint8) * 3, (HEIGHT, 1))
DEPTH_M = np.tile(np.linspace(0.5, 3.0, WIDTH, dtype=np.float32), (HEIGHT, 1)).round(3)
DEPTH_M[:5] = 0.0  # nothing is there
MM = (DEPTH_M * 1000).round().astype(np.uint16)
SIZE = WIDTH, HEIGHT


@dataclass(frozen=True)
class Kind:
    """`bus`, `camera`: what the configuration says of it. `color`, `depth`: a message by its stamp.
    `rgb`: what is seen, and within what, as JPEG and YUV blur; `step_m`: of the depth."""

    color: Callable[[int], bytes] = lambda ns: image("rgb8", SIZE, RGB.tobytes(), stamp_ns=ns)
    depth: Callable[[int], bytes] = lambda ns: image("16UC1", SIZE, MM.tobytes(), stamp_ns=ns)
    topics: tuple[tuple[str, str], ...] = ()
    compressed: tuple[str, ...] = ()
    camera: tuple[tuple[str, Any], ...] = ()
    rgb: np.ndarray = field(default_factory=lambda: RGB)
    within: int = 0
    step_m: float = 1e-6


def colored(encoding: str, pixels: np.ndarray, **seen: Any) -> Kind:
    return Kind(lambda ns: image(encoding, SIZE, pixels.tobytes(), stamp_ns=ns), **seen)


def compressed(
    format: str, data: bytes, topic: str = "camera/color/compressed", **more: Any
) -> Kind:
    topics = (("color", topic),)
    return Kind(lambda ns: compressed_image(format, data, ns), topics=topics, **more)


def measured(
    make: Callable[[int], bytes], topic: str = "camera/depth/image_raw", **more: Any
) -> Kind:
    return Kind(depth=make, topics=(("depth", topic),), **more)


def packed(format: str, data: bytes, topic: str, **more: Any) -> Kind:
    return measured(lambda ns: compressed_image(format, data, ns), topic, **more)


def _with_alpha(pixels: np.ndarray) -> np.ndarray:
    return np.dstack([pixels, np.full(pixels.shape[:2], 77, np.uint8)])


def _yuv(order: str) -> np.ndarray:
    """Two pixels of one colour share it here: no pair of columns is of two."""
    y, v, u = np.moveaxis(cv2.cvtColor(RGB, cv2.COLOR_RGB2YCrCb).astype(float), 2, 0)
    y, u, v = 16 + y * 219 / 255, 128 + (u - 128) * 224 / 255, 128 + (v - 128) * 224 / 255
    chroma = np.where(np.arange(WIDTH) % 2, v, u)
    pair = (y, chroma) if order == "yuyv" else (chroma, y)
    return np.stack(pair, axis=2).round().astype(np.uint8)


JPEG = bytes(cv2.imencode(".jpg", RGB[:, :, ::-1], (cv2.IMWRITE_JPEG_QUALITY, 98))[1])
INVERSE = np.where(DEPTH_M > 0, 10100.0 / np.maximum(DEPTH_M, 0.1) - 1009.0, 0).astype(np.uint16)
FLOATS = np.where(DEPTH_M > 0, DEPTH_M, np.nan).astype("<f4")
FAR = np.where(DEPTH_M > 0, DEPTH_M, 4.0).astype("<f4")
PACKED_DEPTH = "camera/depth/image_raw/compressedDepth"

KINDS: dict[str, Kind] = {
    "rgb8": Kind(),
    "bgr8": colored("bgr8", RGB[:, :, ::-1]),
    "rgba8": colored("rgba8", _with_alpha(RGB)),
    "bgra8": colored("bgra8", _with_alpha(RGB[:, :, ::-1])),
    "mono8": colored("mono8", GREY, rgb=np.dstack([GREY] * 3)),
    "yuv422": colored("yuv422", _yuv("uyvy"), within=4),
    "yuv422_yuy2": colored("yuv422_yuy2", _yuv("yuyv"), within=4),
    "jpeg": compressed("jpeg", JPEG, within=40),
    "png": compressed("rgb8; png compressed bgr8", png(RGB)),
    "renamed-jpeg": compressed("jpeg", JPEG, "oak/rgb", compressed=("color",), within=40),
    "16SC1": measured(lambda ns: image("16SC1", SIZE, MM.tobytes(), stamp_ns=ns)),
    "big-endian": measured(
        lambda ns: image("16UC1", SIZE, MM.astype(">u2").tobytes(), big=True, stamp_ns=ns)
    ),
    "32FC1": measured(lambda ns: image("32FC1", SIZE, FLOATS.tobytes(), stamp_ns=ns)),
    "far": measured(
        lambda ns: image("32FC1", SIZE, FAR.tobytes(), stamp_ns=ns),
        camera=(("depth_nothing_m", 4.0),),
    ),
    "tenths": measured(
        lambda ns: image("16UC1", SIZE, (MM * 10).astype("<u2").tobytes(), stamp_ns=ns),
        camera=(("depth_unit_m", 0.0001),),
    ),
    "depth-png": packed("16UC1; png compressed ", png(MM), "camera/depth/compressed"),
    "compressedDepth": packed(*compressed_depth(png(MM)), PACKED_DEPTH),
    "rvl": packed(*compressed_depth(rvl_of(MM), packing=" rvl"), PACKED_DEPTH),
    "inverse": packed(
        *compressed_depth(png(INVERSE), "32FC1", a=10100.0, b=-1009.0), PACKED_DEPTH, step_m=0.002
    ),
    "renamed-depth": packed(
        *compressed_depth(png(MM)), "oak/stereo", compressed=("depth",)
    ),
}  # fmt: skip


def play(endpoint: str) -> None:
    session = open_session(BusConfig(listen=(endpoint,)))
    buses = {name: BusConfig(prefix=name) for name in KINDS}
    print("plays", flush=True)
    while True:
        stamp_ns = time.time_ns()
        for name, kind in KINDS.items():
            topics = {"color": buses[name].topics.color, "depth": buses[name].topics.depth}
            topics |= dict(kind.topics)
            told = {
                buses[name].topics.camera_info: wire.encode_camera_info(LENS, stamp_ns),
                buses[name].topics.odom: wire.encode_odometry(POSE, stamp_ns),
                topics["depth"]: kind.depth(stamp_ns),
                topics["color"]: kind.color(stamp_ns),
            }
            for topic, payload in told.items():
                session.put(buses[name].key(topic), payload)
        time.sleep(PERIOD_S)


if __name__ == "__main__":
    play(sys.argv[1])
