"""One session for all, and another where it failed."""

import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import pytest
import zenoh

from runtime.agents.link import RobotLink
from runtime.errors import BusError


class Wires:
    """`open`: sessions that are."""

    def __init__(self) -> None:
        self.opened, self.open = 0, 0
        self.fails: Exception | None = None
        self.held = threading.Event()
        self.asked = threading.Event()
        self.held.set()
        self.session = object()

    @contextmanager
    def connect(self) -> Iterator["Wires"]:
        self.opened += 1
        self.open += 1
        yield self
        self.open -= 1

    def ask(self, kind: str, body: Mapping[str, object], within_s: float) -> dict[str, Any]:
        self.asked.set()
        assert self.held.wait(5.0)
        if self.fails is not None:
            raise self.fails
        return {"asked": kind}


def test_a_session_is_kept():
    wires = Wires()
    link = RobotLink(wires.connect)
    assert wires.opened == 0
    assert [link.ask("status", {}, 1.0) for _ in range(2)] == [{"asked": "status"}] * 2
    assert (wires.opened, wires.open) == (1, 1)
    link.close()
    link.close()
    assert wires.open == 0


@pytest.mark.parametrize("error", [BusError("nobody answers"), zenoh.ZError("closed")])
def test_over_one_that_failed_nothing_is_asked(error: Exception):
    wires = Wires()
    link = RobotLink(wires.connect)
    wires.fails = error
    with pytest.raises(BusError):
        link.ask("status", {}, 1.0)
    assert wires.open == 0
    wires.fails = None
    link.ask("status", {}, 1.0)
    assert (wires.opened, wires.open) == (2, 1)


def test_a_session_is_closed_when_its_last_question_has_ended():
    wires = Wires()
    link = RobotLink(wires.connect)
    wires.held.clear()
    asking = threading.Thread(target=link.ask, args=("goal", {}, 5.0))
    asking.start()
    assert wires.asked.wait(5.0)
    link.close()
    assert wires.open == 1
    wires.held.set()
    asking.join()
    assert wires.open == 0
