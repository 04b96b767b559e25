"""An image of the camera, for agents."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import cv2
import numpy as np
import pytest

from hil_sim.driving.link import free_port
from runtime.agents import camera
from runtime.agents.camera import camera_jpeg
from runtime.errors import BusError, SensorError
from runtime.robot import wire
from runtime.robot.session import BusConfig, open_session

TOPIC = "camera/color/image_raw"


@pytest.fixture
def session() -> Iterator[Any]:
    with open_session(BusConfig(listen=(f"tcp/127.0.0.1:{free_port()}",))) as session:
        yield session


@contextmanager
def publishing(session: Any, payload: Callable[[], bytes]) -> Iterator[None]:
    """Again and again, as a camera does."""
    over = threading.Event()

    def publish() -> None:
        while not over.wait(0.01):
            session.put(TOPIC, payload())

    thread = threading.Thread(target=publish)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def test_it_is_the_next_that_comes_made_small(session: Any):
    red = np.zeros((600, 1200, 3), np.uint8)
    red[..., 0] = 200
    with publishing(session, lambda: wire.encode_color(red, 5)):
        raw = camera_jpeg(session, BusConfig())
    image = cv2.imdecode(np.frombuffer(raw, np.uint8), cv2.IMREAD_COLOR)
    assert image.shape == (320, 640, 3)
    blue, _, shown_red = image[100, 100]
    assert shown_red > 190 > 10 > blue


def test_where_none_comes_that_is_said(session: Any, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(camera, "WITHIN_S", 0.05)
    with pytest.raises(BusError, match=f"{TOPIC}: no image came within 0.05 s"):
        camera_jpeg(session, BusConfig())


def test_one_that_is_damaged_is_said(session: Any):
    with publishing(session, lambda: b"no image"), pytest.raises(SensorError, match=TOPIC):
        camera_jpeg(session, BusConfig())
