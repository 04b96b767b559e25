"""image_transport's compressedDepth: its parameters, what it packs, and in what."""

import struct

import numpy as np
import pytest
from camera_messages import compressed_depth, compressed_image, png, rvl_of

from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot.images.compressed_depth import depth_of

MM = np.array([[0, 1, 500], [1000, 4000, 65535]], np.uint16)


def read(format: str, data: bytes) -> np.ndarray:
    message = wire.decode(compressed_image(format, data), wire.COMPRESSED_IMAGE, "t")
    return depth_of(message, "depth")


@pytest.mark.parametrize(
    ("packed", "packing"),
    [(png(MM), " png"), (png(MM), ""), (rvl_of(MM), " rvl")],
)
@pytest.mark.parametrize("encoding", ["16UC1", "mono16"])
def test_16_bits_come_as_they_were(packed: bytes, packing: str, encoding: str):
    got = read(*compressed_depth(packed, encoding, packing))
    assert got.dtype == np.uint16
    assert np.array_equal(got, MM)


def quantised(depth: float, most_m: float, steps: float) -> tuple[int, float, float]:
    """As the publisher does it, with its parameters `depth_max` and `depth_quantization`."""
    a = steps * (steps + 1.0)
    b = 1.0 - a / most_m
    return (int(a / depth + b) if 0 < depth < most_m else 0), a, b


@pytest.mark.parametrize(("pack", "packing"), [(png, " png"), (rvl_of, " rvl")])
@pytest.mark.parametrize(("most_m", "steps"), [(10.0, 100.0), (5.0, 40.0)])
def test_floats_come_back_within_a_step(pack, packing: str, most_m: float, steps: float):
    depth = np.linspace(0.5, 1.2 * most_m, 60).reshape(6, 10)
    depth[0, 0] = np.nan
    told = [quantised(d, most_m, steps) for d in depth.ravel().tolist()]
    inverse = np.array([one for one, _, _ in told], np.uint16).reshape(depth.shape)
    got = read(*compressed_depth(pack(inverse), "32FC1", packing, *told[1][1:]))
    assert got.dtype == np.float32
    known = depth < most_m
    assert np.array_equal(got > 0, known)
    step_m = depth[known] ** 2 / told[1][1]  # of inverse depth, at that depth
    off = got[known] - depth[known]
    assert (off > -1e-4).all()
    assert (off < 1.1 * step_m + 1e-4).all()


@pytest.mark.parametrize(
    ("told", "format", "data"),
    [
        ("compressedDepth has 16UC1 or 32FC1 in it", "8UC1; compressedDepth png", bytes(12)),
        ("compressedDepth has 16UC1 or 32FC1 in it", "", bytes(12)),
        ("12 bytes: publish whole images", "16UC1; compressedDepth png", bytes(12)),
        ("are no JPEG or PNG", "16UC1; compressedDepth png", bytes(40)),
        ("4 bytes of RVL", *compressed_depth(bytes(4), packing=" rvl")),
        ("an image of 0x0 pixels", *compressed_depth(bytes(8), packing=" rvl")),
        (
            "an image of 100000x100000 pixels",
            *compressed_depth(struct.pack("<II", 100_000, 100_000) + bytes(99), packing=" rvl"),
        ),
        ("are no RVL of 3x2 pixels", *compressed_depth(rvl_of(MM)[:-4], packing=" rvl")),
        ("an image of 70000x70000", *compressed_depth(png(MM, (70000, 70000)))),
        ("in steps of nan, 0.0", *compressed_depth(png(MM), "32FC1", a=float("nan"))),
        ("in steps of 0.0, 0.0", *compressed_depth(png(MM), "32FC1")),
    ],
)
def test_what_cannot_be_unpacked_is_told_in_one_line(told: str, format: str, data: bytes):
    with pytest.raises(SensorError) as caught:
        read(format, data)
    assert str(caught.value).startswith("depth: ")
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)


def test_steps_beyond_all_bounds_are_nothing():
    got = read(*compressed_depth(png(MM), "32FC1", a=1.0, b=600.0))
    assert np.isfinite(got).all()
    assert np.array_equal(got > 0, MM > 600)
