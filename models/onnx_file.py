"""What an ONNX file holds, read without a library: whether weights of it lie in other files."""

import mmap
from collections.abc import Iterator
from pathlib import Path

from models.errors import ModelFileError

TENSOR = "tensor"
EXTERNAL_DATA = 13
"""Of a tensor's fields, the one that names another file."""
# By message: which of its fields (onnx.proto) hold messages in which there may be tensors.
INSIDE = {
    "model": {7: "graph", 20: "training", 25: "function"},
    "training": {1: "graph", 2: "graph"},
    "graph": {1: "node", 5: TENSOR, 15: "sparse"},
    "function": {7: "node", 11: "attribute"},
    "node": {5: "attribute"},
    "attribute": {5: TENSOR, 6: "graph", 10: TENSOR, 11: "graph", 22: "sparse", 23: "sparse"},
    "sparse": {1: TENSOR, 2: TENSOR},
    TENSOR: {},
}
VARINT, WIDE, BYTES, NARROW = 0, 1, 2, 5
"""Kinds of fields that protobuf writes."""


def refuse_external_data(path: Path) -> None:
    """Raise ModelFileError where the file names others as a part of it: they are not under its
    checksum, and may be any on this machine. So does what is no ONNX file."""
    try:
        with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, prot=mmap.PROT_READ) as data:
            external = _has_external(data)
    except (OSError, ValueError) as error:
        raise ModelFileError(
            f"{path}: not a usable ONNX file ({error}); fetch it again or name another"
        ) from error
    if external:
        raise ModelFileError(
            f"{path}: keeps weights in other files, which is refused; save it again as one file"
        )


def _has_external(data: mmap.mmap) -> bool:
    waiting = [("model", 0, len(data))]
    while waiting:
        kind, start, end = waiting.pop()
        for number, low, high in _fields(data, start, end):
            if kind == TENSOR and number == EXTERNAL_DATA:
                return True
            if number in INSIDE[kind]:
                waiting.append((INSIDE[kind][number], low, high))
    return False


def _fields(data: mmap.mmap, at: int, end: int) -> Iterator[tuple[int, int, int]]:
    """Number, start and end of each field of a message that has a length. Raises ValueError."""
    while at < end:
        tag, at = _varint(data, at, end)
        kind = tag & 7
        if kind == VARINT:
            _, at = _varint(data, at, end)
        elif kind == BYTES:
            length, at = _varint(data, at, end)
            if length > end - at:
                raise ValueError("it ends too early")
            yield tag >> 3, at, at + length
            at += length
        elif kind in (WIDE, NARROW):
            at += 8 if kind == WIDE else 4
        else:  # groups, which ONNX has none of
            raise ValueError("its fields cannot be read")


def _varint(data: mmap.mmap, at: int, end: int) -> tuple[int, int]:
    value = shift = 0
    while at < end and shift < 70:
        byte = data[at]
        value |= (byte & 127) << shift
        at, shift = at + 1, shift + 7
        if byte < 128:
            return value, at
    raise ValueError("its fields cannot be read")
