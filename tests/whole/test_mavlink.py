"""A whole search over MAVLink: PyBullet's robot obeys ArduPilot's rules by its stand-in, frames
come over Zenoh, commands and odometry over MAVLink. In real time."""

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from mavlink_messages import GUIDED, MANUAL
from places import TESTS

from hil_sim.commands.demo import _stage
from hil_sim.driving.base_wires import MavlinkWire
from hil_sim.driving.link import Runtime, rfnav_command
from hil_sim.driving.realtime import run_realtime
from hil_sim.driving.rig import open_world
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.protocol import protocol_named
from hil_sim.simulation.rover_stand_in import RoverStandIn
from runtime.core.types import Twist
from runtime.journal import read_journal

pytestmark = pytest.mark.slow  # whole processes

FLAT = str(TESTS / "refs/flat.json")
HAND_S = 5.0


def test_a_search_from_goal_to_found(tmp_path: Path):
    out = tmp_path / "run"
    command = [sys.executable, "-m", "hil_sim", "demo", "--goal", "toilet", "--scene", FLAT]
    more = ["--realtime", "--base", "mavlink", "--out", str(out)]
    done = subprocess.run([*command, *more], capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "SUCCESS" in done.stdout
    summary = json.loads((out / "summary.json").read_text())
    assert summary["success"]
    assert summary["stopped"]
    assert summary["path_m"] >= summary["shortest_path_m"] - 0.5
    log = (out / "runtime.log").read_text()
    assert "base: ArduPilot rover, system 1" in log


def test_a_base_on_mavlink_needs_real_time(tmp_path: Path):
    command = [sys.executable, "-m", "hil_sim", "demo", "--goal", "toilet", "--scene", FLAT]
    more = ["--base", "mavlink", "--out", str(tmp_path)]
    done = subprocess.run([*command, *more], capture_output=True, text=True, timeout=900)
    assert done.returncode == 2
    assert "--base mavlink: a stand-in drives in real time: add --realtime" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


class Pilot:
    """Switches to MANUAL when the rover has driven for a while, turns it on the spot, and switches
    back."""

    def __init__(self) -> None:
        self.driving_s: float | None = None
        self.took = self.gave = False
        self.obeyed_meanwhile = 0

    def __call__(self, rover: RoverStandIn, now_s: float) -> None:
        if self.driving_s is None and rover.velocity(now_s).v_mps > 0.2:
            self.driving_s = now_s
        if self.driving_s is None or self.gave:
            return
        if not self.took and now_s - self.driving_s > 1.0:
            self.took, rover.sticks = True, Twist(0.0, 0.6)
            rover.switch(MANUAL)
            self.obeyed_meanwhile = -rover.set_points - rover.ignored
        elif self.took and now_s - self.driving_s > 1.0 + HAND_S:
            self.gave = True
            self.obeyed_meanwhile += rover.set_points + rover.ignored
            rover.switch(GUIDED)


@pytest.fixture
def settings(tmp_path: Path) -> Iterator[tuple[Pilot, MavlinkWire, Runtime]]:
    pilot = Pilot()
    with MavlinkWire(RoverStandIn(), pilot) as wire:
        log, command = tmp_path / "runtime.log", rfnav_command(("--arm",))
        with Runtime(log, None, wire.settings, command, odometry=False) as runtime:
            yield pilot, wire, runtime


def test_a_pilot_takes_over_in_mid_search_and_gives_back(settings, tmp_path: Path):
    pilot, wire, runtime = settings
    protocol, assets = protocol_named("hm3d", "level", (), ()), Assets()
    with open_world(open_scene(FLAT), assets, "auto") as world:
        episode, home = _stage(world, assets, protocol, "toilet", 0)
        result = run_realtime(episode, home, runtime, protocol, "rfnav", tmp_path, wire=wire)
    assert (pilot.took, pilot.gave) == (True, True)
    assert result.success, result
    # A few set-points were under way until the heartbeat told the runtime.
    assert pilot.obeyed_meanwhile <= 40
    halts = [line for line in read_journal(tmp_path / "decisions.jsonl") if line["kind"] == "halt"]
    assert any(line["halts"].get("hand") for line in halts)
