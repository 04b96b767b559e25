"""Episodes in lockstep with faults, noise and velocities, against a child over real Zenoh."""

import json
import math
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from corridor import EPISODE, SMALL, Corridor, start
from places import ROOT

from hil_sim.driving import link
from hil_sim.driving.episode_result import EpisodeResult
from hil_sim.driving.episode_run import run_episode
from hil_sim.driving.link import Runtime
from hil_sim.simulation.faults import parse_faults
from hil_sim.simulation.noise import NONE, Noise
from hil_sim.simulation.protocol import ONROBOT, ROBOTHOR, Protocol
from runtime.errors import ConfigError

pytestmark = pytest.mark.slow  # many episodes

ROLLING = replace(ONROBOT, width=64, height=48, max_steps=60, noise=NONE)


@pytest.fixture(autouse=True)
def importable(monkeypatch: pytest.MonkeyPatch) -> None:
    root = str(ROOT)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([root, os.environ.get("PYTHONPATH", "")]))


@pytest.fixture
def walker(tmp_path: Path) -> Iterator[Runtime]:
    with start("walk", tmp_path / "runtime.log") as runtime:
        yield runtime


@pytest.fixture
def roller(tmp_path: Path) -> Iterator[Runtime]:
    with start("roll", tmp_path / "runtime.log") as runtime:
        yield runtime


def drive(
    runtime: Runtime, log_dir: Path, *faults: str, protocol: Protocol = SMALL, seed: int = 0
) -> EpisodeResult:
    home = Corridor().home()
    given = parse_faults(faults)
    return run_episode(EPISODE, home, runtime, protocol, "rfnav", log_dir, faults=given, seed=seed)


def actions(log_dir: Path) -> list[str]:
    rows = (log_dir / "track.jsonl").read_text().splitlines()
    return [json.loads(row)["action"] for row in rows]


def test_dropped_frames_are_steps_in_which_the_robot_stands(
    walker: Runtime, tmp_path: Path
) -> None:
    result = drive(walker, tmp_path, "camera-drop:at=2,for=3")
    assert (str(result.ended), result.success, result.steps) == ("stop", True, 8)
    assert actions(tmp_path) == [
        "move_forward", "none", "none", "none", *["move_forward"] * 3, "stop",
    ]  # fmt: skip
    assert (result.fault, result.stopped) == ("camera-drop:at=2,for=3", True)


def test_a_frame_that_never_comes_ends_standing_still(walker: Runtime, tmp_path: Path) -> None:
    result = drive(walker, tmp_path, "camera-drop:at=3,for=99")
    assert (str(result.ended), result.steps, result.stopped) == ("steps", 20, True)


def test_a_deaf_base_goes_nowhere_until_it_hears_again(walker: Runtime, tmp_path: Path) -> None:
    result = drive(walker, tmp_path, "base-deaf:at=1,for=4")
    assert (result.success, result.steps, result.path_m) == (True, 9, 1.0)


def test_what_is_frozen_or_blank_reaches_the_runtime(walker: Runtime, tmp_path: Path) -> None:
    result = drive(walker, tmp_path, "depth-blank:at=5")
    assert result.reason == "red 200, nearest 99.00 m"
    result = drive(walker, tmp_path, "camera-freeze:at=2")
    assert result.reason == "red 200, nearest 3.35 m"  # the view of the second step


def test_odometry_that_jumps_misleads_the_runtime_and_not_the_judge(
    walker: Runtime, tmp_path: Path
) -> None:
    result = drive(walker, tmp_path, "odometry-jump:at=3,size=0.5")
    assert (str(result.ended), result.success, result.steps) == ("stop", False, 3)
    assert (result.distance_m, result.path_m) == (0.5, 0.5)


def test_clocks_step_forward_and_never_back_in_lockstep(walker: Runtime, tmp_path: Path) -> None:
    assert drive(walker, tmp_path, "clock-step:at=3,size=3600").success
    with pytest.raises(ConfigError, match=r"^fault clock-step: size: must be positive in lockstep"):
        drive(walker, tmp_path, "clock-step:size=-5")


@pytest.mark.slow
def test_a_link_that_is_lost_comes_back(walker: Runtime, tmp_path: Path) -> None:
    result = drive(walker, tmp_path, "link-lost:at=2,for=3")
    assert (str(result.ended), result.success, result.steps) == ("stop", True, 8)
    result = drive(walker, tmp_path, "link-lost:at=2,for=99")
    assert (str(result.ended), result.steps) == ("steps", 20)  # and its episode could be ended


def test_a_door_that_closes_stops_the_robot(walker: Runtime, tmp_path: Path) -> None:
    home = Corridor()
    result = run_episode(
        EPISODE, home.home(), walker, SMALL, "rfnav", tmp_path,
        faults=parse_faults(["door-closes:at=2"]),
    )  # fmt: skip
    assert (str(result.ended), result.success) == ("steps", False)
    assert result.collisions == 18  # it is at 3.5 m after two steps, the door at 3.8 m
    assert home.bodies[-1] == ()  # the next episode's home is as it was


def test_a_robot_that_leaves_the_floor_has_fallen(walker: Runtime, tmp_path: Path) -> None:
    home = Corridor(floor_until_m=3.6)
    result = run_episode(EPISODE, home.home(), walker, SMALL, "rfnav", tmp_path)
    assert (str(result.ended), result.success, result.collisions) == ("fell", False, 0)
    assert result.steps == 3
    assert 0.6 < result.path_m < 0.65


def test_velocities_drive_the_robot_and_stop_brakes_it(roller: Runtime, tmp_path: Path) -> None:
    result = drive(roller, tmp_path, protocol=ROLLING)
    assert (str(result.ended), result.collisions) == ("stop", 0)
    assert 1.0 < result.path_m < 1.3
    assert result.success
    assert result.steps == 15  # five a second; 0.4 m/s are reached in half a second
    assert result.stopped


def test_without_frames_the_watchdog_stops_the_base(roller: Runtime, tmp_path: Path) -> None:
    result = drive(roller, tmp_path, "camera-drop:at=8,for=999", protocol=ROLLING)
    assert (str(result.ended), result.stopped) == ("steps", True)
    assert result.path_m < 0.9


def test_running_out_of_time_on_the_move_is_not_standing_still(
    roller: Runtime, tmp_path: Path
) -> None:
    result = drive(roller, tmp_path, protocol=replace(ROLLING, max_steps=8))
    assert (str(result.ended), result.stopped) == ("steps", False)


def facts(result: EpisodeResult) -> EpisodeResult:
    return replace(result, wall={})


def test_the_same_seed_gives_the_same_episode(walker: Runtime, tmp_path: Path) -> None:
    protocol = replace(SMALL, noise=Noise(motion=1.0, drift=0.02, depth=0.01, exposure=0.1))
    first, second, other = (
        drive(walker, tmp_path / str(n), protocol=protocol, seed=seed)
        for n, seed in enumerate([5, 5, 6])
    )
    assert facts(first) == facts(second)
    assert facts(first) != facts(other)
    tracks = [(tmp_path / str(n) / "track.jsonl").read_bytes() for n in (0, 1)]
    assert tracks[0] == tracks[1]


def test_robothor_stops_in_view_of_the_toilet(walker: Runtime, tmp_path: Path) -> None:
    protocol = replace(ROBOTHOR, width=64, height=48, max_steps=20)
    assert drive(walker, tmp_path, protocol=protocol).success
    jumped = drive(walker, tmp_path, "odometry-jump:at=2,size=0.9", protocol=protocol)
    assert (str(jumped.ended), jumped.success) == ("stop", False)  # 1.25 m off and in no view


def test_scan_and_bumper_go_beside_the_camera(roller: Runtime, tmp_path: Path) -> None:
    heard: list[str] = []
    keep = lambda sample: heard.append(str(sample.key_expr))  # noqa: E731
    subscriptions = [roller._session.declare_subscriber(key, keep) for key in ("scan", "bumper")]
    result = drive(roller, tmp_path, protocol=replace(ROLLING, laser=True, bumper=True))
    for subscription in subscriptions:
        subscription.undeclare()
    assert heard.count("scan") == heard.count("bumper") == result.steps


def test_an_action_without_finite_speed_is_an_error() -> None:
    with pytest.raises(link.HarnessError, match="velocity"):
        link._twist({"v_mps": math.nan})
    with pytest.raises(link.HarnessError, match="velocity"):
        link._twist({"w_radps": "fast"})


@pytest.mark.parametrize("fault", ["hand", "battery-low:size=5"])
def test_some_faults_are_of_real_time_alone(fault: str, walker: Runtime, tmp_path: Path) -> None:
    result = None
    with pytest.raises(ConfigError, match="there is none in lockstep; add --realtime"):
        result = drive(walker, tmp_path, fault)
    assert result is None
