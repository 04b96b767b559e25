"""The runtime's side of its watchdog."""

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from places import ROOT

from hil_sim.driving.link import free_port
from runtime import guard
from runtime.robot import pulse as module
from runtime.robot import wire
from runtime.robot.pulse import Pulse
from runtime.robot.session import BusConfig, open_session

NOWHERE = BusConfig(connect=("tcp/127.0.0.1:9",))  # a bus that nobody else is on
PATIENCE_S = 30.0


def until(what: Callable[[], object]) -> None:
    by_s = time.monotonic() + PATIENCE_S
    while not what():
        assert time.monotonic() < by_s
        time.sleep(0.01)


def driven(pulse: Pulse, what: Callable[[], object]) -> None:
    """Turns of the control loop until something is so, however briefly."""
    until(lambda: (pulse.beat(True), what())[1])


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
        assert pulse.beat(False) == "the guard reaches nobody"


def test_a_guard_is_started_and_ends_when_it_may(bus: BusConfig):
    with Pulse(bus) as pulse:
        ready(pulse)
        process = pulse._process
        assert process is not None
        assert pulse.beat(True) == ""
        assert process.poll() is None
        pulse.beat(False)
    assert process.returncode == 0
    pulse.close()


def test_a_runtime_that_ends_while_the_base_moves_leaves_it_to_the_guard():
    """The one zero that it commands itself may be lost."""
    heard: list[bytes] = []
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    base = open_session(BusConfig(listen=(endpoint,)))
    base.declare_subscriber("cmd_vel", lambda sample: heard.append(sample.payload.to_bytes()))
    try:
        with Pulse(BusConfig(connect=(endpoint,))) as pulse:
            ready(pulse)
            time.sleep(0.5)  # a link of Zenoh's loses what is sent in its first moments
            process = pulse._process
            assert process is not None
            pulse.beat(True)
        assert process.wait(PATIENCE_S) == 0
        assert len(heard) > 3
        assert {wire.decode_twist(told, "cmd_vel") for told in heard} == {(0.0, 0.0)}
    finally:
        base.close()


def test_a_guard_that_is_gone_is_told_of_in_every_turn(bus: BusConfig):
    with Pulse(bus, again_s=(60.0,)) as pulse:
        ready(pulse)
        assert pulse._process is not None
        pulse._process.kill()
        until(lambda: pulse.beat(True).startswith("the guard is gone ("))
        assert {pulse.beat(False)[:18] for _ in range(3)} == {"the guard is gone "}


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
def test_another_guard_takes_the_place_of_one_that_is_gone_or_hangs(bus: BusConfig, how: int):
    said: list[str] = []
    with Pulse(bus, tell=said.append, again_s=(0.1, 0.1, 0.1)) as pulse:
        for deaths in (1, 2):
            until(lambda: pulse.beat(False) == "")
            first = pulse._process
            assert first is not None
            os.kill(first.pid, how)
            driven(pulse, lambda deaths=deaths: len(said) == deaths)
            assert first.returncode == -signal.SIGKILL  # it is not left there
        until(lambda: pulse.beat(False) == "")
    why = "is gone (" if how == signal.SIGKILL else "does not read what it is told"
    assert all(line.startswith(f"the guard {why}") for line in said)
    assert all(line.endswith("nobody watches over control; another try in 0.1 s") for line in said)


def test_a_guard_that_cannot_guard_is_tried_a_few_times_and_then_left():
    said: list[str] = []
    nobody = BusConfig(mode="client", connect=("tcp/127.0.0.1:9",))
    with Pulse(nobody, tell=said.append, again_s=(0.05, 0.1)) as pulse:
        until(lambda: pulse.beat(False) and len(said) == 3)
        assert pulse.beat(False).startswith("the guard ")
    assert ["try in 0.05 s" in said[0], "try in 0.1 s" in said[1]] == [True, True]
    assert said[2].endswith(" once more: no other is started; see to it, then start rfnav anew")


def test_a_guard_of_somebody_else_is_waited_for_when_it_is_gone(tmp_path: Path):
    path, said = tmp_path / "guard", list[str]()

    def door() -> socket.socket:
        made = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        made.bind(str(path))
        made.listen(1)
        return made

    with door() as first, Pulse(NOWHERE, path, said.append, again_s=(0.05,) * 100) as pulse:
        first.accept()[0].close()
        driven(pulse, lambda: said)
        first.close()
        path.unlink()
        until(lambda: pulse.beat(True).startswith("the guard cannot be started"))
        assert f"{path}: no guard waits there" in pulse.beat(True)
        with door() as second:
            link, _ = second.accept()
            with link:
                assert guard.Orders.read(link.recv(guard.LARGEST)).cmd_vel == "cmd_vel"
                until(lambda: not pulse.beat(True).startswith("the guard cannot be started"))
                assert pulse.beat(True) == "the guard reaches nobody"
                link.send(guard.READY)
                ready(pulse)
                pulse.beat(False)
    assert said[0].startswith("the guard is gone")


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
            pulse.beat(False)
        server.join(PATIENCE_S)
    assert guard.Orders.read(told[0]).cmd_vel == "cmd_vel"
    assert told[-3:] == [guard.MOVING, guard.STILL, guard.BYE]


# A guard that waits for the next turn longer than a busy machine keeps a test waiting.
PATIENT_GUARD = f"""\
import sys
from runtime import guard
guard.SILENCE_S = {PATIENCE_S}
sys.exit(guard.main(["--socket", sys.argv[1]]))
"""


def test_a_guard_of_somebody_else_that_hung_commands_no_zero_when_it_goes_on(tmp_path: Path):
    """It is told of the turns again, as if nothing had been; the base is driven all the while."""
    path, zeros, said = tmp_path / "guard", list[bytes](), list[str]()
    command = [sys.executable, "-c", PATIENT_GUARD, str(path)]
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    listener = open_session(BusConfig(listen=(endpoint,)))
    listener.declare_subscriber("cmd_vel", lambda sample: zeros.append(sample.payload.to_bytes()))
    with subprocess.Popen(command, cwd=ROOT) as process:
        try:
            until(path.exists)
            until(lambda: _served(path))
            with Pulse(BusConfig(connect=(endpoint,)), path, said.append) as pulse:
                ready(pulse)
                process.send_signal(signal.SIGSTOP)
                until(lambda: pulse.beat(True) == module.HANGS)
                process.send_signal(signal.SIGCONT)
                driven(pulse, lambda: pulse.beat(True) == "")
                pulse.beat(False)
            assert _served(path)  # and so it has done with that runtime
        finally:
            process.kill()
            listener.close()
    assert (zeros, said) == ([], [])


def _served(path: Path) -> bool:
    """Whether a guard takes a runtime there, once it has time for it."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as link, suppress(OSError):
        link.settimeout(PATIENCE_S)
        link.connect(str(path))
        link.send(guard.BYE)
        return link.recv(guard.LARGEST) == b""
    return False
