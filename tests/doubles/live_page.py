"""What tests of a page's live feed share: a state of the robot, and patience."""

import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from page_service import PageService

from runtime.config import Config, load
from runtime.robot.session import BusConfig
from runtime.view.hearing import page_topics
from runtime.view.live import LiveFeed

PATIENCE_S = 15.0
STATE = {
    "runtime": {"state": "searching", "cause": ""}, "pose": [1.0, 2.0, 0.5], "v_mps": 0.2,
    "w_radps": 0.0, "halt": "", "base": {"hand": "", "battery_percent": 50.0}, "mode": "frontier",
    "reason": "drive to frontier 7", "toward_xy": [3.0, 1.0], "frontier": 7,
}  # fmt: skip


def at_port(port: int) -> Config:
    bus = BusConfig(mode="client", connect=(f"tcp/127.0.0.1:{port}",))
    return replace(load(None), bus=bus)


class Dozing(threading.Condition):
    """A feed's, which knows who of its threads does nothing until somebody tells them of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.who: frozenset[str] = frozenset()

    def wait_for(self, predicate: Callable[[], bool], timeout: float | None = None) -> bool:
        me = {threading.current_thread().name} if timeout is None and not predicate() else set()
        self.who |= me
        awake = super().wait_for(predicate, timeout)
        self.who -= me
        return awake


def until(what: Callable[[], Any]) -> None:
    by_s = time.monotonic() + PATIENCE_S
    while not what():
        assert time.monotonic() < by_s
        time.sleep(0.02)


def looked_at(feed: LiveFeed, service: PageService) -> None:
    feed.attend(1, 0)
    for topic in page_topics().values():
        until(lambda name=topic.name: service.heard(name))
