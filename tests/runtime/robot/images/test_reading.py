"""Messages of images become RGB and metres; damaged ones end in SensorError and nothing else."""

import math
import struct
from contextlib import suppress

import numpy as np
import pytest
from camera_messages import compressed_depth, compressed_image, image, png, rvl_of
from damaged import damaged
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from other_half import compressed_color

from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot.images.reading import DepthScale, decode_color, decode_depth, metres

STAMPS = st.integers(0, (2**31 - 1) * 10**9 + 999_999_999)
SIZES = st.tuples(st.integers(1, 9), st.integers(1, 9))
NAN, INF = math.nan, math.inf


@given(
    SIZES.flatmap(lambda s: hnp.arrays(np.uint8, (*s, 3))),
    STAMPS,
    st.sampled_from(["rgb8", "bgr8"]),
)
def test_colour_round_trip(rgb: np.ndarray, stamp_ns: int, encoding: str) -> None:
    payload = wire.encode_color(rgb, stamp_ns, encoding=encoding)
    got = decode_color(payload, "color")
    assert got.stamp_ns == stamp_ns == wire.peek_stamp(payload, "color")
    np.testing.assert_array_equal(got.value, rgb)


@given(
    SIZES.flatmap(lambda s: hnp.arrays(np.float32, s, elements=st.floats(0, 60, width=32))), STAMPS
)
def test_depth_round_trip_in_both_units(depth: np.ndarray, stamp_ns: int) -> None:
    got = decode_depth(wire.encode_depth(depth, stamp_ns), "depth")
    np.testing.assert_array_equal(got.value, depth)
    assert got.value.dtype == np.float32
    got = decode_depth(wire.encode_depth(depth, stamp_ns, encoding="16UC1"), "depth")
    np.testing.assert_allclose(got.value, depth, atol=0.00051)
    assert got.stamp_ns == stamp_ns


def test_compressed_colour_comes_back_as_rgb() -> None:
    rgb = np.full((16, 16, 3), (200, 100, 20), np.uint8)
    got = decode_color(compressed_color(rgb, 9), "color/compressed", packed=True)
    assert got.stamp_ns == 9
    np.testing.assert_allclose(got.value.astype(int), rgb, atol=6)


@pytest.mark.parametrize(
    ("kind", "scale", "readings", "wanted"),
    [
        ("u2", DepthScale(), [0, 1, 1000, 65534, 65535], [0, 0.001, 1.0, 65.534, 0]),
        ("i2", DepthScale(), [0, -5, 1000, 32766, 32767], [0, 0, 1.0, 32.766, 0]),
        ("f4", DepthScale(), [NAN, INF, -INF, -1.0, 0.0, 2.5, 70.0], [0, 0, 0, 0, 0, 2.5, 70.0]),
        ("u2", DepthScale(unit_m=0.0001), [1, 12345, 65535], [0.0001, 1.2345, 0]),
        ("u2", DepthScale(unit_m=1 / 5000), [5000, 12500], [1.0, 2.5]),
        ("u2", DepthScale(unit_m=0.00025), [4000, 1], [1.0, 0.00025]),
        ("u2", DepthScale(unit_m=1.0), [3, 65535], [3.0, 0]),
        ("f4", DepthScale(unit_m=0.001), [1500.0, NAN], [1.5, 0]),
        ("u2", DepthScale(nothing_m=4.0), [3999, 4000, 4001], [3.999, 0, 0]),
        ("f4", DepthScale(nothing_m=5.0), [4.99, 5.0, INF], [4.99, 0, 0]),
        ("f4", DepthScale(0.001, 3.3), [3299.0, 3300.0], [3.299, 0]),
    ],
)
def test_readings_are_metres_or_nothing(kind: str, scale: DepthScale, readings: list, wanted: list):
    got = metres(np.array([readings], kind), scale)
    assert got.dtype == np.float32
    np.testing.assert_array_equal(got, np.array([wanted], np.float32))


MM = np.array([[500, 1000, 4000]], np.uint16)
TOLD = {
    "raw": (image("16UC1", (3, 1), MM.tobytes()), "d", False),
    "png": (compressed_image("16UC1; png compressed ", png(MM)), "d/compressed", True),
    "packed": (compressed_image(*compressed_depth(png(MM))), "d/compressedDepth", True),
    "rvl": (
        compressed_image(*compressed_depth(rvl_of(MM), packing=" rvl")), "d/compressedDepth", True,
    ),
    "by its format": (compressed_image(*compressed_depth(png(MM))), "depth_image", True),
}  # fmt: skip


@pytest.mark.parametrize("way", TOLD)
def test_depth_by_whatever_way_it_comes(way: str):
    payload, topic, packed = TOLD[way]
    got = decode_depth(payload, topic, packed, DepthScale(nothing_m=3.0))
    assert got.stamp_ns == 7
    np.testing.assert_array_equal(got.value, np.array([[0.5, 1.0, 0.0]], np.float32))


@pytest.mark.parametrize(
    ("payload", "packed", "told"),
    [
        (TOLD["packed"][0], False, "is a CompressedImage, '16UC1; compressedDepth png': add "),
        (TOLD["raw"][0], True, "is an Image, '16UC1': its topic is another one, or take \"depth\""),
        (b"\0\1\0\0" + bytes(50), False, "54 bytes are not a CDR sensor_msgs/msg/Image"),
        (b"\0\1\0\0" + bytes(50), True, "54 bytes are not a CDR sensor_msgs/msg/CompressedImage"),
        (image("16UC1", (3, 1), MM.tobytes(), stamp_ns=-(10**9)), False, "is not a time"),
    ],
)
def test_the_other_kind_of_message_is_told_with_the_key(payload: bytes, packed: bool, told: str):
    with pytest.raises(SensorError) as caught:
        decode_depth(payload, "some/topic", packed)
    assert str(caught.value).startswith("some/topic: ")
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)


def test_colour_that_is_the_other_kind_is_told_with_its_own_name():
    with pytest.raises(SensorError, match=r'^c: is a CompressedImage, .jpeg.: add "color" to bus'):
        decode_color(compressed_color(np.zeros((4, 4, 3), np.uint8), 1), "c")


GREY = struct.pack("<4B", 1, 2, 3, 4)
SAMPLES = [
    *(payload for payload, _, _ in TOLD.values()),
    image("mono8", (2, 2), GREY), image("yuv422", (2, 1), GREY), image("bgra8", (1, 1), GREY),
    compressed_color(np.zeros((3, 4, 3), np.uint8), 1),
    compressed_image("png", png(np.zeros((3, 4, 3), np.uint8))),
    compressed_image(*compressed_depth(rvl_of(MM), "32FC1", " rvl", 1.0, 2.0)),
]  # fmt: skip


def _only_sensor_errors(payload: bytes) -> None:
    for topic in ("a/topic", "a/compressedDepth"):
        for packed in (False, True):
            with suppress(SensorError):
                assert decode_color(payload, topic, packed).value.ndim == 3
            with suppress(SensorError):
                assert np.isfinite(decode_depth(payload, topic, packed).value).all()


@given(st.binary(max_size=400))
def test_random_bytes_raise_nothing_but_sensor_errors(payload: bytes) -> None:
    _only_sensor_errors(payload)
    _only_sensor_errors(b"\0\1\0\0" + payload)


@given(damaged(SAMPLES))
def test_damaged_messages_raise_nothing_but_sensor_errors(payload: bytes) -> None:
    _only_sensor_errors(payload)
