"""The runtime's side of its watchdog."""

import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from hil_sim.driving.link import free_port
from runtime import guard
from runtime.errors import BusError
from runtime.robot.pulse import Pulse
from runtime.robot.session import BusConfig, open_session

NOWHERE = BusConfig(connect=("tcp/127.0.0.1:9",))  # a bus that nobody else is on
PATIENCE_S = 30.0


def ready(pulse: Pulse) -> None:
    by_s = time.monotonic() + PATIENCE_S
    while why := pulse.beat(False):
        assert why == "the guard reaches nobody"
        assert time.monotonic() < by_s
        time.sleep(0.01)


@pytest.fixture
def bus() -> Iterator[BusConfig]:
    """One that somebody is on."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    session = open_session(BusConfig(listen=(endpoint,)))
    yield BusConfig(connect=(endpoint,))
    session.close()


def test_a_guard_that_reaches_nobody_says_so():
    with Pulse(NOWHERE) as pulse:
        time.sleep(1.0)
        assert pulse.beat(True) == "the guard reaches nobody"


def test_a_guard_is_started_and_ends_when_it_may(bus: BusConfig):
    with Pulse(bus) as pulse:
        ready(pulse)
        assert pulse._process is not None
        assert pulse.beat(True) == ""
        assert pulse._process.poll() is None
    assert pulse._process.returncode == 0
    pulse.close()


def test_a_guard_that_is_gone_is_told_of_in_every_turn(bus: BusConfig):
    with Pulse(bus) as pulse:
        ready(pulse)
        assert pulse._process is not None
        pulse._process.kill()
        pulse._process.wait()
        assert {pulse.beat(True) for _ in range(3)} == {"the guard is gone (Broken pipe)"}


def test_a_guard_that_cannot_guard_is_gone():
    with Pulse(BusConfig(mode="client", connect=("tcp/127.0.0.1:9",))) as pulse:
        by_s = time.monotonic() + PATIENCE_S
        while (why := pulse.beat(False)) == "the guard reaches nobody":
            assert time.monotonic() < by_s
            time.sleep(0.01)
    assert why.startswith("the guard ")


def test_a_guard_that_is_there_already_is_fed(tmp_path: Path):
    path, told = tmp_path / "guard", []
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as door:
        door.bind(str(path))
        door.listen(1)

        def serve() -> None:
            link, _ = door.accept()
            with link:
                told.append(link.recv(guard.LARGEST))
                link.send(guard.READY)
                while (turn := link.recv(guard.LARGEST)) not in (b"", guard.BYE):
                    told.append(turn)
                told.append(turn)

        server = threading.Thread(target=serve)
        server.start()
        with Pulse(NOWHERE, path) as pulse:
            ready(pulse)
            pulse.beat(True)
        server.join(PATIENCE_S)
    assert guard.Orders.read(told[0]).cmd_vel == "cmd_vel"
    assert told[-2:] == [guard.MOVING, guard.BYE]


def test_where_no_guard_waits_it_is_said_how_to_start_one(tmp_path: Path):
    with pytest.raises(BusError, match=r"no guard waits there .*: start `rfnav guard --socket"):
        Pulse(NOWHERE, tmp_path / "guard")
