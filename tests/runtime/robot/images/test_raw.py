"""Each encoding by its bytes: what they are is what the list in sensor_msgs says."""

import struct

import numpy as np
import pytest
from camera_messages import image

from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot.images.raw import color_pixels, depth_readings

RED, GREEN, BLUE, GREY = (255, 0, 0), (0, 255, 0), (0, 0, 255), (90, 90, 90)


def message(payload: bytes):
    return wire.decode(payload, wire.IMAGE, "t")


@pytest.mark.parametrize(
    ("encoding", "data", "wanted"),
    [
        ("rgb8", b"\xff\0\0\0\xff\0\0\0\xffZZZ", [RED, GREEN, BLUE, GREY]),
        ("bgr8", b"\0\0\xff\0\xff\0\xff\0\0ZZZ", [RED, GREEN, BLUE, GREY]),
        ("8UC3", b"\0\0\xff\0\xff\0\xff\0\0ZZZ", [RED, GREEN, BLUE, GREY]),
        ("rgba8", b"\xff\0\0\x09\0\xff\0\0\0\0\xff\xffZZZ\1", [RED, GREEN, BLUE, GREY]),
        ("bgra8", b"\0\0\xff\x09\0\xff\0\0\xff\0\0\xffZZZ\1", [RED, GREEN, BLUE, GREY]),
        ("8UC4", b"\0\0\xff\x09\0\xff\0\0\xff\0\0\xffZZZ\1", [RED, GREEN, BLUE, GREY]),
        ("mono8", b"\0Z\xff\1", [(0, 0, 0), GREY, (255, 255, 255), (1, 1, 1)]),
        ("8UC1", b"\0Z\xff\1", [(0, 0, 0), GREY, (255, 255, 255), (1, 1, 1)]),
    ],
)
@pytest.mark.parametrize("padding", [0, 5])
def test_colours_by_name(encoding: str, data: bytes, wanted: list, padding: int):
    row = len(data) // 2
    padded = b"".join(data[at : at + row] + b"\xaa" * padding for at in (0, row))
    got = color_pixels(message(image(encoding, (2, 2), padded)), "color")
    assert got.dtype == np.uint8
    assert got.reshape(4, 3).tolist() == [list(pixel) for pixel in wanted]


# ITU-R BT.601 in 16 to 235: black, white, and red, green, blue of full strength.
YUV = {(0, 0, 0): (16, 128, 128), (255, 255, 255): (235, 128, 128), RED: (81, 90, 240),
       GREEN: (145, 54, 34), BLUE: (41, 240, 110)}  # fmt: skip


@pytest.mark.parametrize(
    ("encoding", "order"),
    [("yuv422", "uyvz"), ("uyvy", "uyvz"), ("yuv422_yuy2", "yuzv"), ("yuyv", "yuzv")],
)
@pytest.mark.parametrize("rgb", YUV)
def test_two_pixels_of_yuv_share_a_colour(encoding: str, order: str, rgb: tuple[int, int, int]):
    y, u, v = YUV[rgb]
    parts = {"y": y, "u": u, "v": v, "z": y}
    data = bytes(parts[letter] for letter in order)
    got = color_pixels(message(image(encoding, (2, 2), (data + b"\xaa\xaa") * 2)), "color")
    np.testing.assert_allclose(got.reshape(4, 3).astype(int), [rgb] * 4, atol=2)


@pytest.mark.parametrize(
    ("encoding", "code", "values"),
    [
        ("16UC1", "H", [0, 1, 1000, 65535]),
        ("mono16", "H", [0, 1, 1000, 65535]),
        ("16SC1", "h", [0, -1, 1000, 32767]),
        ("32FC1", "f", [0.0, -1.0, 1.5, 1e9]),
    ],
)
@pytest.mark.parametrize("big", [False, True])
@pytest.mark.parametrize("padding", [0, 3])
def test_depths_by_name(encoding: str, code: str, values: list, big: bool, padding: int):
    rows = (struct.pack(f"{'<>'[big]}2{code}", *pair) for pair in (values[:2], values[2:]))
    data = b"".join(row + b"\xaa" * padding for row in rows)
    got = depth_readings(message(image(encoding, (2, 2), data, big=big)), "depth")
    assert got.dtype == np.dtype(code)
    assert got.ravel().tolist() == values


@pytest.mark.parametrize(
    ("read", "payload", "told"),
    [
        (color_pixels, image("nv21", (2, 2), bytes(6)), "encoding 'nv21': publish rgb8, bgr8, "),
        (color_pixels, image("bayer_rggb8", (2, 2), bytes(4)), "have image_proc make rgb8 of it"),
        (color_pixels, image("16UC1", (2, 2), bytes(8)), "this is depth: are bus.topics.color and"),
        (color_pixels, image("x" * 300, (2, 2), bytes(8)), f"encoding '{'x' * 40}...': publish"),
        (color_pixels, image("yuv422", (3, 1), bytes(6)), "3 pixels of yuv422 wide: must be even"),
        (color_pixels, image("rgb8", (2, 1), bytes(6), step=5), "needs step >= 6"),
        (color_pixels, image("rgb8", (2, 2), bytes(6), step=6), "got step 6 and 6 bytes"),
        (color_pixels, image("rgb8", (0, 2), b""), "an image of 0x2 pixels"),
        (color_pixels, image("mono8", (2**31, 2**31), b"", 1), "2147483648x2147483648 pixels"),
        (depth_readings, image("rgb8", (2, 1), bytes(6)), "publish 16UC1, 16SC1 or 32FC1; this is"),
        (depth_readings, image("64FC1", (2, 1), bytes(16)), "publish 16UC1, 16SC1 or 32FC1"),
        (depth_readings, image("32FC1", (2, 2), bytes(15), step=8), "needs step >= 8"),
    ],
)
def test_what_cannot_be_read_is_told_in_one_line(read, payload: bytes, told: str):
    with pytest.raises(SensorError) as caught:
        read(message(payload), "some/topic")
    assert str(caught.value).startswith("some/topic: ")
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)
