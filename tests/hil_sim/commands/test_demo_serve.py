"""`hil-sim demo --serve`."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from places import ROOT

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
