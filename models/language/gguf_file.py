"""What a GGUF file's head says, read without a library: whether it can be what it claims. llama.cpp
ends the process over some heads that cannot."""

import mmap
import struct
from pathlib import Path
from typing import Final

from models.errors import ModelFileError

MAGIC: Final = b"GGUF"
VERSIONS: Final = (2, 3)
KEYS: Final = 10_000
TENSORS: Final = 100_000
DIMENSIONS: Final = 4
ITEMS: Final = 10_000_000  # of an array: a large vocabulary has 300,000 words
NAME_BYTES: Final = 65_535
STRING_BYTES: Final = 16 << 20  # a chat template is one
STRING, ARRAY = 8, 9
SIZES: Final = {0: 1, 1: 1, 2: 2, 3: 2, 4: 4, 5: 4, 6: 4, 7: 1, 10: 8, 11: 8, 12: 8}
"""Bytes of a value, by its type's number."""
# By a tensor's type: how many weights are one block, and its bytes (ggml.h). Of others only the
# place of their first byte is looked at.
BLOCKS: Final = {
    0: (1, 4), 1: (1, 2), 2: (32, 18), 3: (32, 20), 6: (32, 22), 7: (32, 24), 8: (32, 34),
    10: (256, 84), 11: (256, 110), 12: (256, 144), 13: (256, 176), 14: (256, 210), 15: (256, 292),
    24: (1, 1), 25: (1, 2), 26: (1, 4), 27: (1, 8), 28: (1, 8), 30: (1, 2),
}  # fmt: skip
ALIGNMENT: Final = "general.alignment"
TOWERS: Final = (b"clip.vision.projector_type", b"clip.projector_type")
LARGEST_ALIGNMENT: Final = 1 << 20


def refuse_damaged(path: Path) -> str:
    """Raise ModelFileError where the head cannot be read, asks for what no model has, or names
    weights beyond the end of the file. Returns of a picture's tower which kind it is, else ""."""
    try:
        with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, prot=mmap.PROT_READ) as data:
            head = _Head(data)
            head.check()
            return head.tower
    except (OSError, ValueError, struct.error) as error:
        raise ModelFileError(
            f"{path}: not a GGUF file, or damaged ({error}); check the path or run `rfnav models "
            "pull`"
        ) from error


class _Head:
    """A reader of the head. Raises ValueError."""

    def __init__(self, data: mmap.mmap) -> None:
        self._data, self._at, self._alignment = data, 0, 32
        self.tower = ""

    def check(self) -> None:
        if self._take(4) != MAGIC:
            raise ValueError("it does not begin with GGUF")
        if (version := self._number(4)) not in VERSIONS:
            raise ValueError(f"of version {version}; known are 2 and 3")
        tensors, keys = self._number(8), self._number(8)
        if tensors > TENSORS or keys > KEYS:
            raise ValueError(f"{tensors} tensors and {keys} keys")
        for _ in range(keys):
            name = self._string(NAME_BYTES)
            self._value(name, self._number(4))
        ends = [self._tensor() for _ in range(tensors)]
        begin = -(-self._at // self._alignment) * self._alignment
        if ends and begin + max(ends) > len(self._data):
            raise ValueError("weights are beyond its end")

    def _value(self, name: bytes, kind: int) -> None:
        if kind == ARRAY:
            self._array()
        elif kind == STRING:
            text = self._string(STRING_BYTES)
            if name in TOWERS:
                self.tower = text.decode(errors="replace")
        elif kind not in SIZES:
            raise ValueError(f"a value of type {kind}")
        elif name == ALIGNMENT.encode():
            self._alignment = self._number(SIZES[kind])
            if not 0 < self._alignment <= LARGEST_ALIGNMENT:
                raise ValueError(f"aligned to {self._alignment} bytes")
        else:
            self._take(SIZES[kind])

    def _array(self) -> None:
        kind, count = self._number(4), self._number(8)
        if count > ITEMS:
            raise ValueError(f"an array of {count} values")
        if kind == STRING:
            for _ in range(count):
                self._string(STRING_BYTES)
        elif kind in SIZES:
            self._take(SIZES[kind] * count)
        else:
            raise ValueError(f"an array of type {kind}")

    def _tensor(self) -> int:
        """Where it ends, from the first weight of all."""
        self._string(NAME_BYTES)
        dimensions = self._number(4)
        if dimensions > DIMENSIONS:
            raise ValueError(f"a tensor of {dimensions} dimensions")
        weights = 1
        for _ in range(dimensions):
            weights *= self._number(8)
        kind, offset = self._number(4), self._number(8)
        block, size = BLOCKS.get(kind, (1, 0))
        return offset + -(-weights // block) * size

    def _string(self, most: int) -> bytes:
        length = self._number(8)
        if length > most:
            raise ValueError(f"a text of {length} bytes")
        return self._take(length)

    def _number(self, size: int) -> int:
        return int.from_bytes(self._take(size), "little")

    def _take(self, size: int) -> bytes:
        if size > len(self._data) - self._at:
            raise ValueError("it ends too early")
        taken = self._data[self._at : self._at + size]
        self._at += size
        return taken
