"""sensor_msgs/CompressedImage -> pixels: JPEG and PNG, as image_transport's `compressed` and
webcams' drivers send them. How large a picture is, is read before it is unpacked."""

import struct
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from runtime.core.types import U8
from runtime.errors import SensorError
from runtime.robot.bounds import MOST_PIXELS
from runtime.robot.images.raw import check_area, shown

_PNG: Final = b"\x89PNG\r\n\x1a\n"
_JPEG: Final = b"\xff\xd8"
_GREY16: Final = (16, 0)  # a PNG's bits and kind of colour
_FRAMES: Final = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}  # JPEG markers that tell a size
_BARE: Final = frozenset({0x01, *range(0xD0, 0xD9)})  # and those that have no length
_SEGMENTS: Final = 1000  # before the size: more is no camera's
_SCAN: Final = b"\xff\xda"  # a JPEG's data: each goes over the whole picture again
_SCANNED: Final = 8 * MOST_PIXELS  # in all
_CHUNKS: Final = 20_000  # of a PNG
_ANCILLARY: Final = 0x20  # a bit of a chunk's name: the pixels can be had without it


def color_picture(message: Any, topic: str) -> U8:
    """A CompressedImage -> (H, W, 3) RGB. SensorError for anything but a JPEG or PNG."""
    data, told = message.data, f"{topic}: {shown(str(message.format))}"
    height, width = _size(data, told)
    check_area(height, width, topic)
    # As the camera's pixels lie, whatever a picture's own notes say of how it should be turned.
    how = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
    pixels = _unpacked(data, how, height * width)
    if pixels is None or pixels.shape != (height, width, 3):
        raise SensorError(f"{told}: {len(data)} bytes are damaged: publish whole JPEG or PNG")
    if "compressed rgb" in str(message.format):  # red was packed where blue belongs
        return np.ascontiguousarray(pixels, np.uint8)
    return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB), np.uint8)


def depth_picture(data: NDArray[np.uint8], topic: str, format: str) -> NDArray[np.uint16]:
    """A PNG of 16-bit grey -> (H, W). SensorError for anything else."""
    told = f"{topic}: {shown(format)}"
    if bytes(data[:2]) == _JPEG:
        raise SensorError(
            f"{told}: a JPEG blurs depth: publish the raw image, or use its /compressedDepth"
        )
    height, width = _size(data, told)
    check_area(height, width, topic)
    if tuple(data[24:26].tolist()) != _GREY16:
        raise SensorError(f"{told}: a PNG of {data[24]} bits: depth is 16 bits of grey")
    readings = _unpacked(data, cv2.IMREAD_UNCHANGED, height * width)
    if readings is None or readings.shape != (height, width) or readings.dtype != np.uint16:
        raise SensorError(f"{told}: {len(data)} bytes are damaged: publish whole PNG")
    return np.asarray(readings, np.uint16)


def _unpacked(data: NDArray[np.uint8], how: int, pixels: int) -> NDArray[Any] | None:
    """By OpenCV; None for what is damaged, or meant to take long or much."""
    whole = bytes(data)
    if whole.startswith(_PNG):
        sound = _sound_png(whole)
    else:
        sound = whole if whole.count(_SCAN) * pixels <= _SCANNED else None
    if sound is None:
        return None
    try:
        return cv2.imdecode(np.frombuffer(sound, np.uint8), how)
    except cv2.error:
        return None


def _sound_png(whole: bytes) -> bytes | None:
    """A PNG of whole chunks, without those that its pixels can be had without: OpenCV makes room
    for as much as a chunk says that it has, and unpacks animations. None for a damaged one."""
    parts, at = [_PNG], len(_PNG)
    for _ in range(_CHUNKS):
        length = int.from_bytes(whole[at : at + 4])
        name, end = whole[at + 4 : at + 8], at + 12 + length
        if len(name) < 4 or end > len(whole):
            return None
        if not name[0] & _ANCILLARY:
            parts.append(whole[at:end])
        if name == b"IEND":
            return b"".join(parts)
        at = end
    return None


def _size(data: NDArray[np.uint8], told: str) -> tuple[int, int]:
    """Height and width by a picture's head. SensorError where it has none."""
    start = bytes(data[:26])
    if start.startswith(_PNG) and len(start) == 26 and start[12:16] == b"IHDR":
        width, height = struct.unpack(">II", start[16:24])
        return height, width
    if (
        start.startswith(_JPEG)
        and (size := _jpeg_size(np.ascontiguousarray(data).data)) is not None
    ):
        return size
    raise SensorError(f"{told}: {len(data)} bytes are no JPEG or PNG: publish one of those")


def _jpeg_size(data: memoryview) -> tuple[int, int] | None:
    """Height and width by the first frame header (ITU-T T.81, B.1.1); None without one."""
    at = len(_JPEG)
    for _ in range(_SEGMENTS):
        while at + 1 < len(data) and data[at] == 0xFF == data[at + 1]:
            at += 1  # padding
        if at + 9 > len(data) or data[at] != 0xFF:
            return None
        marker = data[at + 1]
        if marker in _FRAMES:
            height, width = struct.unpack(">HH", data[at + 5 : at + 9])
            return height, width
        at += 2
        if marker not in _BARE:
            at += int(struct.unpack(">H", data[at : at + 2])[0])
    return None
