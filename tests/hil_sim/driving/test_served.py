"""`rfnav run` beside a robot that lives."""

import json
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import zenoh

from hil_sim.driving.link import HarnessError, free_port
from hil_sim.driving.served import Served, served_command
from runtime.robot.session import BusConfig, open_session

SLEEPS = [sys.executable, "-c", "import time; time.sleep(600)"]
FAILS = [sys.executable, "-c", "import sys; print('rfnav: no such model'); sys.exit(3)"]
STUBBORN = [
    sys.executable,
    "-c",
    "import signal, time; signal.signal(signal.SIGTERM, lambda *_: print('ends', flush=True));"
    "print('up', flush=True); time.sleep(0.3); time.sleep(600)",
]


@pytest.fixture
def endpoint() -> str:
    return f"tcp/127.0.0.1:{free_port()}"


@pytest.fixture
def robot(endpoint: str) -> Iterator[zenoh.Session]:
    with open_session(BusConfig(listen=(endpoint,))) as session:
        yield session


def waited(for_: Callable[[], bool], most_s: float = 20.0) -> bool:
    until_s = time.monotonic() + most_s
    while time.monotonic() < until_s:
        if for_():
            return True
        time.sleep(0.02)
    return False


def test_it_is_ready_when_it_answers(endpoint: str, robot: zenoh.Session, tmp_path: Path):
    served = Served(SLEEPS, endpoint, tmp_path / "log")
    try:
        states = ["starting", "starting", "ready"]

        def answer(query: zenoh.Query) -> None:
            query.reply(query.key_expr, json.dumps({"runtime": {"state": states.pop(0)}}))

        robot.declare_queryable("rfnav/status", answer)
        assert served.ready.wait(20.0)
        assert not states
        served.check()
    finally:
        served.kill()


@pytest.mark.usefixtures("robot")
def test_one_that_ends_by_itself_is_told_with_its_last_line(endpoint: str, tmp_path: Path):
    log = tmp_path / "log"
    served = Served(FAILS, endpoint, log)

    def ended() -> bool:
        try:
            served.check()
        except HarnessError as error:
            return str(error) == f"rfnav run ended with status 3: rfnav: no such model ({log})"
        return False

    assert waited(ended)
    served.kill()
    served.kill()


@pytest.mark.usefixtures("robot")
def test_the_robot_lives_until_it_has_ended(
    endpoint: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("hil_sim.driving.served.ENDS_S", 1.0)
    log, ticks = tmp_path / "log", list[float]()
    served = Served(STUBBORN, endpoint, log)
    assert waited(lambda: "up" in log.read_text())

    def tick() -> None:
        ticks.append(time.monotonic())
        time.sleep(0.01)

    served.close(tick)
    assert "ends" in log.read_text()  # it was asked first, and then made to
    assert len(ticks) > 1
    with pytest.raises(HarnessError, match="status -9"):
        served.check()


def test_it_is_started_as_an_owner_would(tmp_path: Path):
    state, file = tmp_path / "state", tmp_path / "robot.toml"
    command = served_command(state, "tcp/127.0.0.1:7447", file, ("camera.z_m=0.5",), ("--privacy",))
    assert command[1] == f"STATE_DIRECTORY={state}"
    assert command[4:9] == ["runtime", "run", "--privacy", "--config", str(file)]
    assert "--harness" not in command
    assert command[-1] == "camera.z_m=0.5"  # what was asked for has the last word
