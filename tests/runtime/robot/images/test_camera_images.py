"""Depth is decoded once, by whoever comes first, as the configuration says that it is."""

import threading
from functools import partial

import numpy as np
import pytest
from camera_messages import compressed_depth, compressed_image, image, png

from runtime.core.mapping.solid_depth import solid
from runtime.errors import SensorError
from runtime.robot.images import camera_images
from runtime.robot.images.camera_images import KEPT, CameraImages
from runtime.robot.session import BusConfig, TopicsConfig
from runtime.robot.sync import RawMessage
from runtime.robot.transforms import CameraConfig

MM = np.arange(400, 400 + 30 * 40, dtype=np.uint16).reshape(30, 40)
MM[:, 20] = 9000  # beside it a pixel flies


def raw(payload: bytes, stamp_ns: int = 7) -> RawMessage:
    return RawMessage(stamp_ns, payload, 0.0)


def depth_message(offset: int = 0) -> RawMessage:
    return raw(image("16UC1", (40, 30), (MM + np.uint16(offset)).tobytes()))


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> dict[str, int]:
    counts = {"read_depth": 0, "solid": 0}

    def call(name: str, real, *args):
        counts[name] += 1
        return real(*args)

    for name in counts:
        real = getattr(camera_images, name)
        monkeypatch.setattr(camera_images, name, partial(call, name, real))
    return counts


def test_a_message_is_decoded_once(counted: dict[str, int]):
    images = CameraImages(BusConfig(), CameraConfig())
    one, other = depth_message(), depth_message(5)
    found = images.depth(one)
    np.testing.assert_array_equal(found.depth_m, MM.astype(np.float32) / 1000)
    assert found.solid_m is None  # nobody has asked
    np.testing.assert_array_equal(found.solid(), solid(found.depth_m))
    assert found.solid() is found.solid_m
    assert images.depth(one) is found
    assert images.depth(other) is not found
    assert images.depth(one) is found
    assert counted == {"read_depth": 2, "solid": 1}


def test_few_are_kept_and_none_may_be_written_to(counted: dict[str, int]):
    images = CameraImages(BusConfig(), CameraConfig())
    first = depth_message()
    found = images.depth(first)
    for part in (found.depth_m, found.solid()):
        with pytest.raises(ValueError, match="read-only"):
            part[0, 0] = 1
    for _ in range(KEPT):
        images.depth(depth_message())
    again = images.depth(first)
    assert again is not found
    assert np.array_equal(again.depth_m, found.depth_m)
    assert counted["read_depth"] == KEPT + 2


def test_who_comes_second_does_not_wait(monkeypatch: pytest.MonkeyPatch):
    images, message = CameraImages(BusConfig(), CameraConfig()), depth_message()
    begun, go_on, real = threading.Event(), threading.Event(), camera_images.read_depth

    def slow(*args):
        begun.set()
        assert go_on.wait(20.0)
        return real(*args)

    monkeypatch.setattr(camera_images, "read_depth", slow)
    found = []
    first = threading.Thread(target=lambda: found.append(images.depth(message)))
    first.start()
    assert begun.wait(20.0)
    monkeypatch.setattr(camera_images, "read_depth", real)
    second = images.depth(message)  # while the first one stands still
    assert first.is_alive()
    go_on.set()
    first.join(20.0)
    assert np.array_equal(found[0].depth_m, second.depth_m)


def test_what_cannot_be_read_is_not_kept():
    images = CameraImages(BusConfig(), CameraConfig())
    for _ in range(2):
        with pytest.raises(SensorError, match="camera/depth/image_raw: encoding"):
            images.depth(raw(image("64FC1", (1, 1), bytes(8))))


@pytest.mark.parametrize(
    ("topic", "compressed", "payload"),
    [
        ("d/compressedDepth", (), compressed_image(*compressed_depth(png(MM)))),
        ("d/compressed", (), compressed_image("16UC1; png compressed ", png(MM))),
        ("d", ("depth",), compressed_image(*compressed_depth(png(MM)))),
        ("d", ("depth",), compressed_image("png", png(MM))),
    ],
)
def test_the_topic_or_a_key_says_what_comes(topic: str, compressed: tuple, payload: bytes):
    config = BusConfig(topics=TopicsConfig(depth=topic), compressed=compressed)
    scale = CameraConfig(depth_unit_m=0.0001, depth_nothing_m=0.09)
    found = CameraImages(config, scale).depth(raw(payload)).depth_m
    wanted = MM.astype(np.float32) / 10000
    np.testing.assert_array_equal(found, np.where(wanted < np.float32(0.09), wanted, 0))


def test_so_it_is_with_colour():
    rgb = np.full((4, 4, 3), (1, 2, 3), np.uint8)
    for topic, compressed in (("c/compressed", ()), ("c", ("color",))):
        config = BusConfig(topics=TopicsConfig(color=topic), compressed=compressed)
        found = CameraImages(config, CameraConfig()).color(raw(compressed_image("png", png(rgb))))
        np.testing.assert_array_equal(found, rgb)
