"""Real time against a child over real Zenoh: the base rolls, frames come, faults are felt."""

import os
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from blink import Blink
from corridor import EPISODE, SMALL, Corridor
from places import DOUBLES, ROOT

from hil_sim.driving import realtime
from hil_sim.driving.episode_result import EpisodeResult
from hil_sim.driving.episode_run import run_episode
from hil_sim.driving.link import Runtime
from hil_sim.simulation.faults import parse_faults
from hil_sim.simulation.protocol import DifferentialDrive

ROVER = DOUBLES / "fake_rover.py"
PROTOCOL = replace(SMALL, base=DifferentialDrive(), max_steps=30, observe_s=0.2)


@pytest.fixture(autouse=True)
def importable(monkeypatch: pytest.MonkeyPatch) -> None:
    root = str(ROOT)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([root, os.environ.get("PYTHONPATH", "")]))


@pytest.fixture
def rover(tmp_path: Path) -> Iterator[Runtime]:
    command = [sys.executable, str(ROVER), "find"]
    with Runtime(tmp_path / "runtime.log", command=command) as runtime:
        yield runtime


def drive(
    runtime: Runtime, log_dir: Path, *faults: str, max_steps: int = 30
) -> tuple[EpisodeResult, Blink]:
    camera = Blink()
    result = run_episode(
        EPISODE,
        Corridor().home(),
        runtime,
        replace(PROTOCOL, max_steps=max_steps),
        "rfnav",
        log_dir,
        faults=parse_faults(faults),
        play=partial(realtime.drive, camera=camera),
    )
    return result, camera


def test_the_base_obeys_reports_and_comes_to_rest(rover: Runtime, tmp_path: Path) -> None:
    result, camera = drive(rover, tmp_path)
    assert (str(result.ended), result.collisions, result.stopped) == ("stop", 0, True)
    assert 0.6 < result.path_m < 1.1
    assert result.wall["runtime.frames"] >= 2
    assert result.believed_at is not None
    assert result.claim == "true"
    assert result.reason == "found it"
    assert result.actions["stop"] == 1
    numbers = [glance.number for glance in camera.glances]
    assert numbers == list(range(1, len(numbers) + 1))
    rows = (tmp_path / "track.jsonl").read_text().splitlines()
    assert len(rows) == result.steps


@pytest.mark.slow
def test_a_deaf_base_stands(rover: Runtime, tmp_path: Path) -> None:
    result, _ = drive(rover, tmp_path, "base-deaf:at=1,for=999", max_steps=8)
    assert (str(result.ended), result.path_m, result.stopped) == ("steps", 0.0, True)


@pytest.mark.slow
def test_without_odometry_the_runtime_holds_the_base(rover: Runtime, tmp_path: Path) -> None:
    result, _ = drive(rover, tmp_path, "odometry-stop:at=3,for=999", max_steps=12)
    assert (str(result.ended), result.stopped) == ("steps", True)
    assert result.path_m < 0.6


def test_a_hand_drives_the_base_and_the_runtime_is_silent(rover: Runtime, tmp_path: Path) -> None:
    hand = "hand:at=1,for=1.5s,size=0.2"
    heard: list[float] = []
    subscriber = rover._session.declare_subscriber(
        "cmd_vel_teleop", lambda sample: heard.append(time.monotonic())
    )
    result, camera = drive(rover, tmp_path, hand)
    subscriber.undeclare()
    assert 5 <= len(heard) <= 20
    assert result.fault == hand
    turned = max(
        abs(glance.pose.yaw_rad - camera.glances[0].pose.yaw_rad) for glance in camera.glances
    )
    assert turned > 0.5


@pytest.mark.slow
def test_a_lost_link_stops_the_base_by_its_watchdog(rover: Runtime, tmp_path: Path) -> None:
    result, _ = drive(rover, tmp_path, "link-lost:at=3,for=999", max_steps=15)
    assert result.stopped
    assert result.path_m < 0.6


def test_real_time_needs_a_runtime(tmp_path: Path) -> None:
    class Bound:
        def ask(self, query: str, body: dict[str, object]) -> dict[str, bool]:
            return {"accepted": True}

        def forget(self) -> None: ...

    result, _ = drive(Bound(), tmp_path)  # type: ignore[arg-type]
    assert str(result.ended) == "error: real time needs a runtime, and a base that drives"
