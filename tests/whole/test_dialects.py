"""Whole searches in real time over both dialects of ROS 2, what others draw of them, and the
watchdog's zero."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from apartment import TWO_ROOMS, Apartment
from run_process import process

from hil_sim.driving.robot_wire import Spoken
from runtime.core.types import Pose

pytestmark = pytest.mark.slow  # whole processes

PLANT_XY = 4.6, 1.5


def home() -> Apartment:
    return Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, -0.5))


def room(folder: Path) -> Path:
    """A room with a plant at its far end."""
    corners = [[0, 0], [5.5, 0], [5.5, 3], [0, 3]]
    walls = [
        {"from": a, "to": b, "kind": "outer"}
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True)
    ]
    plant = {"id": "plant", "category": "plant", "mesh": "builtin:plant"}
    scene = {
        "format": "rf-nav-scene/1",
        "name": "room",
        "wall_height_m": 2.5,
        "walls": walls,
        "doors": [],
        "rooms": [{"name": "hall", "type": "hallway", "polygon": corners}],
        "objects": [{**plant, "position_m": [*PLANT_XY, 0]}],
        "spawn": [[[0.7, 1.4], [0.9, 1.4], [0.9, 1.6], [0.7, 1.6]]],
        "holes": [],
    }
    path = folder / "room.json"
    path.write_text(json.dumps(scene))
    return path


@pytest.mark.parametrize("spoken", ["ros2dds", "rmw_zenoh"])
def test_a_goal_is_found_in_real_time_over_each_dialect(spoken: Spoken, tmp_path: Path):
    out = tmp_path / "run"
    how = ("--realtime", "--method", "oracle-perception", "--protocol", "onrobot")
    done = subprocess.run(
        [sys.executable, "-m", "hil_sim", "demo", "--goal", "plant", "--scene",
         str(room(tmp_path)), *how, "--dialect", spoken, "--out", str(out)],
        capture_output=True, text=True, timeout=600.0, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr
    summary = json.loads((out / "summary.json").read_text())
    assert summary["success"], summary
    assert summary["collisions"] == 0


@pytest.mark.parametrize("spoken", ["ros2dds", "rmw_zenoh"])
def test_a_runtime_that_is_killed_leaves_a_base_that_is_told_zero(spoken: Spoken, tmp_path: Path):
    with process(home(), 10_000, spoken=spoken) as (child, robot):
        robot.ask("status")
        assert robot.ask("goal", {"goal": "toilet", "log_dir": str(tmp_path)})["accepted"]
        robot.until(lambda: robot.commands and robot.commands[-1].v_mps > 0.1, 60.0)
        child.kill()
        child.wait()
        count = len(robot.commands)
        robot.until(lambda: len(robot.commands) > count + 2, 10.0)
        assert all((c.v_mps, c.w_radps) == (0.0, 0.0) for c in robot.commands[count + 1 :])
