"""A camera's messages byte by byte, as the formats' own documents have them: CDR, PNG, RVL. Neither
the runtime's code nor a library that reads them has a part in it."""

import struct
import zlib
from collections.abc import Iterable

import numpy as np


def image(
    encoding: str,
    size: tuple[int, int],
    data: bytes,
    step: int | None = None,
    big: bool = False,
    stamp_ns: int = 7,
    frame: str = "camera",
) -> bytes:
    """sensor_msgs/Image of (width, height) in CDR. `step`: bytes of a row, as many as there are
    unless it is told."""
    width, height = size
    told = _header(stamp_ns, frame) + struct.pack("<II", height, width) + _text(encoding)
    told = _aligned(told + bytes([big]))
    rows = step if step is not None else len(data) // max(1, height)
    return b"\0\1\0\0" + told + struct.pack("<II", rows, len(data)) + data


def compressed_image(format: str, data: bytes, stamp_ns: int = 7, frame: str = "camera") -> bytes:
    """sensor_msgs/CompressedImage in CDR."""
    told = _aligned(_header(stamp_ns, frame) + _text(format))
    return b"\0\1\0\0" + told + struct.pack("<I", len(data)) + data


def png(pixels: np.ndarray, size: tuple[int, int] | None = None) -> bytes:
    """(H, W) grey or (H, W, 3) RGB of 8 or 16 bits. `size`: another (width, height) in its head."""
    height, width = pixels.shape[:2]
    bits = 8 * pixels.dtype.itemsize
    head = struct.pack(
        ">IIBBBBB", *(size or (width, height)), bits, 2 * (pixels.ndim == 3), 0, 0, 0
    )
    rows = b"".join(b"\0" + row.astype(row.dtype.newbyteorder(">")).tobytes() for row in pixels)
    chunks = (b"IHDR", head), (b"IDAT", zlib.compress(rows)), (b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in chunks
    )


def compressed_depth(
    packed: bytes, encoding: str = "16UC1", packing: str = " png", a: float = 0.0, b: float = 0.0
) -> tuple[str, bytes]:
    """Format and data as image_transport's compressedDepth has them."""
    return f"{encoding}; compressedDepth{packing}", struct.pack("<iff", 0, a, b) + packed


def rvl_of(readings: np.ndarray) -> bytes:
    """(H, W) of 16 bits -> columns, rows and RVL."""
    height, width = readings.shape
    return struct.pack("<II", width, height) + _words(_numbers(readings.ravel().tolist()))


def _numbers(readings: list[int]) -> Iterable[int]:
    at, last = 0, 0
    while at < len(readings):
        for zero in (True, False):
            begin = at
            while at < len(readings) and (readings[at] == 0) == zero:
                at += 1
            yield at - begin
            if not zero:
                for value in readings[begin:at]:
                    step, last = value - last, value
                    yield 2 * step if step >= 0 else -2 * step - 1


def _words(numbers: Iterable[int]) -> bytes:
    nibbles = []
    for number in numbers:
        while number > 7:
            nibbles.append(8 | (number & 7))
            number >>= 3
        nibbles.append(number)
    nibbles += [0] * (-len(nibbles) % 8)
    words = (nibbles[at : at + 8] for at in range(0, len(nibbles), 8))
    return b"".join(
        struct.pack("<I", sum(n << (28 - 4 * k) for k, n in enumerate(word))) for word in words
    )


def _header(stamp_ns: int, frame: str) -> bytes:
    sec, nanosec = divmod(stamp_ns, 10**9)
    return _aligned(struct.pack("<iI", sec, nanosec) + _text(frame))


def _text(text: str) -> bytes:
    coded = text.encode() + b"\0"
    return struct.pack("<I", len(coded)) + coded


def _aligned(told: bytes) -> bytes:
    """So that a number of 32 bits may follow."""
    return told + bytes(-len(told) % 4)
