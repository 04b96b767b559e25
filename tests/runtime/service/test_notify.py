"""What systemd hears of the process, on a socket of its own."""

import os
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from manual_clock import ManualClock

from runtime.errors import BusError
from runtime.service.notify import SHARE, SILENT_S, STATUS_S, Systemd

LIMIT_S = 4.0


class Heard:
    """systemd's end."""

    def __init__(self, door: socket.socket) -> None:
        self._door = door

    def __call__(self) -> list[str]:
        """All that came since the last time."""
        came = []
        while True:
            try:
                came.append(self._door.recv(1000).decode())
            except BlockingIOError:
                return came


@pytest.fixture
def heard(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Heard]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as door:
        door.bind(str(tmp_path / "notify"))
        door.setblocking(False)
        monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
        yield Heard(door)


def watched(clock: ManualClock, **more: str) -> Systemd:
    return Systemd(clock, {"WATCHDOG_USEC": str(round(LIMIT_S * 1e6)), **more})


def never() -> bool:
    return False


def test_a_start_is_over_when_goals_are_taken_and_how_it_stands_is_told_as_it_changes(
    heard: Heard,
) -> None:
    clock, words, over = ManualClock(), "ready", False
    with Systemd(clock, {}) as systemd:
        assert heard() == ["STATUS=starting: models load"]
        turn = systemd.served(lambda: over, lambda: words)
        assert not turn()
        assert heard() == ["READY=1", "STATUS=ready"]
        words = "held: frame: no\nimage"
        assert not turn()
        assert heard() == []  # it was looked just now
        clock.advance(STATUS_S)
        assert not turn()
        assert heard() == ["STATUS=held: frame: no image"]
        clock.advance(STATUS_S)
        assert not turn()
        assert heard() == []  # nothing new
        over = True
        assert turn()
        assert heard() == ["STOPPING=1"]
    assert heard() == ["STOPPING=1"]


def test_what_ends_it_is_told(heard: Heard) -> None:
    with pytest.raises(BusError), Systemd(ManualClock(), {}):
        raise BusError("bus: cannot be opened")
    assert heard()[1:] == ["STOPPING=1", "STATUS=ends: bus: cannot be opened"]


def test_turns_of_control_feed_the_watchdog_often_enough_and_no_more(heard: Heard) -> None:
    clock, moved = ManualClock(), []

    def beat(moving: bool) -> str:
        moved.append(moving)
        return "nobody guards"

    turn = watched(clock).fed(beat)
    assert turn(True) == "nobody guards"
    assert heard() == ["WATCHDOG=1"]
    clock.advance(LIMIT_S / SHARE - 0.01)
    turn(False)
    assert heard() == []
    clock.advance(0.02)
    turn(False)
    assert heard() == ["WATCHDOG=1"]
    assert moved == [True, False, False]


def test_control_alone_does_not_feed_it_for_long(heard: Heard) -> None:
    clock = ManualClock()
    systemd = watched(clock)
    beat, turn = systemd.fed(lambda moving: ""), systemd.served(never, str)
    clock.advance(SILENT_S + 1)
    beat(False)
    assert heard() == ["WATCHDOG=1"]  # models may load for as long as they like
    turn()
    clock.advance(SILENT_S)
    beat(False)
    assert heard()[-1] == "WATCHDOG=1"
    clock.advance(SILENT_S)
    beat(False)
    assert heard() == []
    turn()
    beat(False)
    assert heard() == ["WATCHDOG=1"]


@pytest.mark.parametrize(
    "given",
    [{}, {"WATCHDOG_USEC": ""}, {"WATCHDOG_USEC": "5 s"},
     {"WATCHDOG_USEC": "1000", "WATCHDOG_PID": str(os.getpid() + 1)}],
)  # fmt: skip
def test_where_nobody_watches_nothing_is_fed(heard: Heard, given: dict[str, str]) -> None:
    assert Systemd(ManualClock(), given).fed(lambda moving: "")(True) == ""
    assert heard() == []


def test_its_own_number_is_who_is_watched(heard: Heard) -> None:
    watched(ManualClock(), WATCHDOG_PID=str(os.getpid())).fed(lambda moving: "")(True)
    assert heard() == ["WATCHDOG=1"]


def test_without_systemd_nothing_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NOTIFY_SOCKET", raising=False)
    with Systemd(ManualClock(), {}) as systemd:
        assert not systemd.served(never, str)()
