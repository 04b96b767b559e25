"""What is compiled unpacks what plain Python packs, and says no to anything else."""

import struct

import numpy as np
import pytest
from camera_messages import rvl_of
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from runtime.core.kernels import _compiled
from runtime.core.kernels.packed import unpack_rvl

SIZES = st.tuples(st.integers(1, 13), st.integers(1, 13))
READINGS = st.one_of(st.just(0), st.integers(0, 5), st.integers(1000, 1100), st.integers(0, 65535))


def unpacked(packed: bytes, size: tuple[int, int]) -> np.ndarray | None:
    readings = np.full(size, 7, np.uint16)
    return readings if unpack_rvl(readings, np.frombuffer(packed, np.uint8)) else None


def words(*numbers: int) -> bytes:
    return b"".join(struct.pack("<I", number) for number in numbers)


@pytest.mark.parametrize(
    ("packed", "wanted"),
    [
        # no zeros, then four: +5, +1, -1, +0; as 0, 4, 10 (2 and 1), 2, 1, 0
        (words(0x04A12100), [[5, 6], [5, 5]]),
        # four zeros, and none else
        (words(0x40000000), [[0, 0], [0, 0]]),
        # two zeros, two others: 65535 and, one more of 16 bits, 0
        (words(0x22EFFFF3, 0x20000000), [[0, 0], [65535, 0]]),
        (words(0x11000000, 0), None),  # a zero, one other (0), and then nothing without end
    ],
)
def test_what_was_packed_by_hand(packed: bytes, wanted: list[list[int]] | None):
    found = unpacked(packed, (2, 2))
    assert (found.tolist() if found is not None else None) == wanted


@given(SIZES.flatmap(lambda size: hnp.arrays(np.uint16, size, elements=READINGS)))
def test_it_is_what_was_packed(readings: np.ndarray):
    packed = rvl_of(readings)[8:]
    assert np.array_equal(unpacked(packed, readings.shape), readings)
    assert np.array_equal(unpacked(packed + b"more of it", readings.shape), readings)
    apart = np.full((readings.shape[0], readings.shape[1] + 3), 9, np.uint16)
    assert unpack_rvl(apart[:, :-3], np.frombuffer(packed, np.uint8))
    assert np.array_equal(apart[:, :-3], readings)
    assert (apart[:, -3:] == 9).all()


@given(SIZES.flatmap(lambda size: hnp.arrays(np.uint16, size, elements=READINGS)), st.data())
def test_what_is_cut_short_is_none(readings: np.ndarray, data: st.DataObject):
    packed = rvl_of(readings)[8:]
    end = data.draw(st.integers(0, len(packed) - 4))
    assert unpacked(packed[:end], readings.shape) is None


@given(st.binary(max_size=200), SIZES)
def test_bytes_of_no_meaning_do_no_harm(packed: bytes, size: tuple[int, int]):
    unpacked(packed, size)


def test_lengths_beyond_the_image_and_numbers_without_end_are_refused():
    assert unpacked(words(0x50000000), (2, 2)) is None  # five zeros of four pixels
    assert unpacked(words(0x05000000, 0), (2, 2)) is None  # five others
    assert unpacked(words(0xFFFFFFFF, 0xFFFFFFFF), (2, 2)) is None
    assert unpacked(words(0xFFFFFFFF, 0xF1000000), (2, 2)) is None
    assert unpacked(words(0x00000000), (2, 2)) is None  # it would go on for ever


def test_what_does_not_fit_is_named():
    bytes_of, readings = np.zeros((2, 4), np.uint8), np.zeros((2, 2), np.uint16)
    with pytest.raises(ValueError, match="packed: not one row of bytes"):
        _compiled.unpack_rvl(readings, bytes_of)
    with pytest.raises(TypeError, match="readings"):
        _compiled.unpack_rvl(readings.astype(np.float32), bytes_of[:1])
    with pytest.raises(TypeError, match="2"):
        _compiled.unpack_rvl(readings)
    readings.flags.writeable = False
    with pytest.raises(ValueError, match="read-only"):
        unpack_rvl(readings, bytes_of[0])
