"""`hil-sim demo --serve`."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from threading import Event

import pytest
from click.testing import CliRunner, Result
from places import ROOT

from hil_sim.commands import demo_serve
from hil_sim.commands.demo import demo_command
from hil_sim.driving.link import free_port
from runtime.commands.running import running
from runtime.config import load


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--serve", "--goal", "bed"), "--goal is of one episode"),
        (("--serve", "--realtime"), "--realtime is of one episode"),
        (("--goal", "bed", "--listen", "tcp/127.0.0.1:7"), "--listen goes with --serve"),
    ],
)
def test_options_that_say_nothing_are_refused(words: tuple[str, ...], said: str):
    result = CliRunner().invoke(demo_command, words)
    assert result.exit_code == 2
    assert said in result.output


class Ticking:
    """A robot, to which the signals come in the midst of a tick, and what runs beside it."""

    def __init__(self, *signals: int) -> None:
        self.signals, self.begun, self.whole = list(signals), 0, 0
        self.did, self.ready = list[str](), Event()

    def tick(self) -> None:
        self.begun += 1
        if self.signals:
            signal.raise_signal(self.signals.pop(0))
        self.whole += 1

    def check(self) -> None:
        self.did.append("check")

    def close(self, meanwhile: Callable[[], None]) -> None:
        self.did.append("close")
        meanwhile()

    def kill(self) -> None:
        self.did.append("kill")


@pytest.fixture
def served(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    """Serves that."""
    before = [(number, signal.getsignal(number)) for number in demo_serve.SIGNALS]
    monkeypatch.setattr(demo_serve, "keep_stdout_for_python", lambda: None)

    def serve(ticking: Ticking) -> Result:
        monkeypatch.setattr(demo_serve, "living_in", lambda *_: ticking)
        monkeypatch.setattr(demo_serve, "Served", lambda *_: ticking)
        return CliRunner().invoke(demo_command, ("--serve", "--out", str(tmp_path)))

    yield serve
    for number, handler in before:
        signal.signal(number, handler)


@pytest.mark.parametrize("number", demo_serve.SIGNALS)
def test_a_signal_cuts_no_tick_short(served: Callable[[Ticking], Result], number: int):
    robot = Ticking(number)
    assert served(robot).exit_code == 0
    assert robot.did == ["check", "close", "kill"]
    assert robot.whole == robot.begun == 2


def test_a_second_one_is_not_waited_for(served: Callable[[Ticking], Result]):
    robot = Ticking(signal.SIGINT, signal.SIGINT)
    assert served(robot).exit_code != 0
    assert robot.did == ["check", "close", "kill"]
    assert (robot.begun, robot.whole) == (2, 1)


@pytest.mark.slow  # PyBullet, and the models
def test_it_stays_up_until_it_is_ended(tmp_path: Path):
    endpoint, out = f"tcp/127.0.0.1:{free_port()}", tmp_path / "serve"
    command = [sys.executable, "-m", "hil_sim", "demo", "--serve", "--listen", endpoint]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        [*command, "--out", str(out)], cwd=ROOT, text=True, stdout=subprocess.PIPE, env=environment
    ) as child:
        try:
            assert child.stdout is not None
            said = child.stdout.readline() + child.stdout.readline()
            hint = f'type in another terminal: rfnav find "toilet" --config {out}/robot.toml;'
            assert hint in said
            with running(load(out / "robot.toml").bus) as runtime:
                assert runtime.ask("status", {})["runtime"]["state"] in ("ready", "held")
            child.send_signal(signal.SIGINT)
            assert child.wait(60.0) == 0
        finally:
            child.kill()
    assert (out / "state" / "goals.json").is_file()
    assert (out / "rfnav.log").read_text().splitlines()[-1] == "rfnav: starting -> ready"
