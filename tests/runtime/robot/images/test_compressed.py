"""JPEG and PNG, of colour and of depth; and how large they are before they are unpacked."""

import struct
import zlib

import cv2
import numpy as np
import pytest
from camera_messages import compressed_image, png

from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot.images.compressed import color_picture, depth_picture

RGB = np.zeros((16, 24, 3), np.uint8)
RGB[:, :12] = 200, 100, 20
RGB[:, 12:] = 10, 60, 220


def jpeg(rgb: np.ndarray = RGB, *options: int) -> bytes:
    return bytes(cv2.imencode(".jpg", rgb[:, :, ::-1], options)[1])


def read(format: str, data: bytes) -> np.ndarray:
    message = wire.decode(compressed_image(format, data), wire.COMPRESSED_IMAGE, "t")
    return color_picture(message, "color")


@pytest.mark.parametrize("format", ["jpeg", "jpg", "rgb8; jpeg compressed bgr8", ""])
@pytest.mark.parametrize("options", [(), (cv2.IMWRITE_JPEG_PROGRESSIVE, 1)])
def test_a_jpeg_whatever_it_is_called(format: str, options: tuple[int, ...]):
    got = read(format, jpeg(RGB, *options))
    assert got.shape == RGB.shape
    assert np.abs(got.astype(int) - RGB)[:, [2, 21]].max() <= 6  # off the edge between the two


def test_a_jpeg_in_grey_is_grey():
    grey = np.tile(np.arange(0, 240, 10, dtype=np.uint8), (16, 1))
    got = read("mono8; jpeg compressed ", bytes(cv2.imencode(".jpg", grey)[1]))
    assert np.abs(got.astype(int) - grey[..., None]).max() <= 6


@pytest.mark.parametrize("format", ["png", "rgb8; png compressed bgr8"])
def test_a_png_to_the_last_bit(format: str):
    assert np.array_equal(read(format, png(RGB)), RGB)


def test_red_that_was_packed_as_blue_is_red():
    """Of `rgb8; jpeg compressed rgb8` the picture has the bytes of RGB in the order of BGR."""
    assert np.array_equal(read("rgb8; png compressed rgb8", png(RGB[:, :, ::-1])), RGB)


def test_a_png_of_16_bits_of_colour_is_read_too():
    assert np.array_equal(read("png", png(RGB.astype(np.uint16) * 257)), RGB)


def test_a_picture_is_not_turned_by_its_own_notes():
    exif = b"Exif\0\0MM\0*\0\0\0\x08\0\1" + struct.pack(">HHIHH", 0x112, 3, 1, 6, 0) + bytes(4)
    plain = jpeg()
    noted = plain[:2] + b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif + plain[2:]
    assert cv2.imdecode(np.frombuffer(noted, np.uint8), cv2.IMREAD_COLOR).shape == (24, 16, 3)
    assert np.array_equal(read("jpeg", noted), read("jpeg", plain))


def test_depth_is_a_png_of_16_bits():
    readings = np.arange(48, dtype=np.uint16).reshape(6, 8) * 1365
    data = np.frombuffer(png(readings), np.uint8)
    assert np.array_equal(depth_picture(data, "depth", "16UC1; png compressed "), readings)


def bomb(width: int, height: int) -> bytes:
    return png(np.zeros((2, 2), np.uint16), (width, height))


def swollen(width: int, height: int) -> bytes:
    """A JPEG whose head tells another size."""
    whole = jpeg()
    at = whole.index(b"\xff\xc0") + 5
    return whole[:at] + struct.pack(">HH", height, width) + whole[at + 4 :]


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (bomb(60000, 60000), "an image of 60000x60000 pixels: 1 to 16000000 are taken"),
        (bomb(0, 5), "an image of 0x5 pixels"),
        (bomb(2**32 - 1, 2**32 - 1), "pixels: 1 to"),
        (swollen(65000, 65000), "an image of 65000x65000 pixels"),
        (swollen(0, 0), "an image of 0x0 pixels"),
        (b"", "0 bytes are no JPEG or PNG: publish one of those"),
        (b"RIFF....WEBPVP8 ", "are no JPEG or PNG"),
        (b"\xff\xd8" * 40, "are no JPEG or PNG"),
        (b"\xff\xd8" + b"\xff\xe0\0\0" * 5000, "are no JPEG or PNG"),
        (b"\xff\xd8" + b"\xff" * 60, "are no JPEG or PNG"),
        (jpeg()[:150], "are no JPEG or PNG"),
        (png(RGB)[:33], "damaged: publish whole JPEG or PNG"),
        (png(RGB)[:20], "are no JPEG or PNG"),
    ],
)
def test_a_picture_that_cannot_be_is_told_in_one_line(data: bytes, told: str):
    with pytest.raises(SensorError) as caught:
        read("some format", data)
    assert str(caught.value).startswith("color: ")
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)


def chunk(name: bytes, body: bytes, length: int | None = None) -> bytes:
    told = struct.pack(">I", len(body) if length is None else length)
    return told + name + body + struct.pack(">I", zlib.crc32(name + body))


def with_chunk(added: bytes) -> bytes:
    """Before a PNG's pixels."""
    whole = png(RGB)
    at = whole.index(b"IDAT") - 4
    return whole[:at] + added + whole[at:]


@pytest.mark.parametrize(
    "added",
    [
        chunk(b"zTXt", b"Comment\0\0" + zlib.compress(bytes(10_000_000))),
        chunk(b"acTL", struct.pack(">II", 1000, 0)),
        chunk(b"tIME", b"nonsense"),
    ],
)
def test_what_a_png_has_beside_its_pixels_is_not_looked_at(added: bytes):
    assert np.array_equal(read("png", with_chunk(added)), RGB)


@pytest.mark.parametrize(
    "data",
    [
        with_chunk(chunk(b"IDAT", b"", 2**32 - 20)),  # OpenCV would make room for all of it
        with_chunk(chunk(b"tEXt", b"", 2**31 - 1)),
        png(RGB)[:-4],
        png(RGB)[:-12],
        with_chunk(chunk(b"tIME", b"") * 30_000),
    ],
)
def test_a_png_of_chunks_that_are_not_whole_is_damaged(data: bytes):
    with pytest.raises(SensorError, match="damaged: publish whole JPEG or PNG"):
        read("png", data)


def test_a_jpeg_that_goes_over_its_pixels_without_end_is_not_followed():
    whole = jpeg(np.zeros((2000, 3000, 3), np.uint8), cv2.IMWRITE_JPEG_PROGRESSIVE, 1)
    assert read("jpeg", whole).shape == (2000, 3000, 3)
    scan = whole[whole.rindex(b"\xff\xda") : -2]
    with pytest.raises(SensorError, match="are damaged"):
        read("jpeg", whole[:-2] + scan * 100 + whole[-2:])


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (jpeg(), "a JPEG blurs depth: publish the raw image, or use its /compressedDepth"),
        (png(RGB), "a PNG of 8 bits: depth is 16 bits of grey"),
        (png(RGB[:, :, 0]), "a PNG of 8 bits"),
        (png(RGB.astype(np.uint16)), "a PNG of 16 bits: depth is 16 bits of grey"),
        (bomb(60000, 60000), "an image of 60000x60000 pixels"),
        (bomb(3, 3), "are damaged"),
        (b"no picture", "are no JPEG or PNG"),
    ],
)
def test_depth_that_is_none_is_told_in_one_line(data: bytes, told: str):
    with pytest.raises(SensorError) as caught:
        depth_picture(np.frombuffer(data, np.uint8), "depth", "png")
    assert str(caught.value).startswith("depth: ")
    assert told in str(caught.value)
