"""Whole searches in real time over both dialects of ROS 2, what others draw of them, and the
watchdog's zero."""

import json
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest
from apartment import TWO_ROOMS, Apartment
from drawn_reader import read
from robot_double import RobotDouble
from run_process import process
from zenoh.ext import HistoryConfig, declare_advanced_subscriber

from hil_sim.driving.robot_wire import Spoken
from runtime.core.types import Pose
from runtime.robot import drawn_messages
from runtime.robot.diagnostics import DIAGNOSTICS

pytestmark = pytest.mark.slow  # whole processes

MAP_HASH = "RIHS01_8d348150c12913a31ee0ec170fbf25089e4745d17035792a1ba94d6f0bc0cfc7"
KINDS = {
    "rfnav/map": drawn_messages.OCCUPANCY_GRID,
    "rfnav/path": drawn_messages.PATH,
    "rfnav/frontiers": drawn_messages.MARKERS,
    "rfnav/objects": drawn_messages.MARKERS,
    "rfnav/detections": drawn_messages.DETECTIONS,
    "rfnav/keep_out": drawn_messages.MARKERS,
    "diagnostics": DIAGNOSTICS,
}


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


class Viewer:
    """Who draws: on every key of what is drawn, whatever its type's hash."""

    def __init__(self, robot: RobotDouble) -> None:
        self.newest: dict[str, Any] = {}
        self.changed, self._robot = threading.Condition(), robot
        for topic in KINDS:
            key = topic if robot.wire.spoken == "ros2dds" else f"0/{topic}/*/*"
            robot.session.declare_subscriber(key, self._see)

    def _see(self, sample: Any) -> None:
        topic = self._robot.wire.topic(str(sample.key_expr))
        with self.changed:
            self.newest[topic] = read(sample.payload.to_bytes(), KINDS[topic])
            self.changed.notify_all()


def drawn(payload: bytes) -> list[int]:
    """The cells of a map."""
    return list(read(payload, KINDS["rfnav/map"]).data)


@pytest.mark.parametrize("spoken", ["ros2dds", "rmw_zenoh"])
def test_others_can_draw_a_search_and_who_joins_late_gets_the_map(spoken: Spoken, tmp_path: Path):
    with process(home(), 10_000, spoken=spoken) as (child, robot):
        viewer = Viewer(robot)
        robot.ask("status")
        assert robot.ask("goal", {"goal": "toilet", "log_dir": str(tmp_path)})["accepted"]
        with viewer.changed:
            assert viewer.changed.wait_for(lambda: set(viewer.newest) == set(KINDS), 60.0)
        robot.until(lambda: viewer.newest["rfnav/frontiers"].markers)
        assert viewer.newest["rfnav/path"].header.frame_id == "odom"
        robot.ask("cancel")
        time.sleep(1.0)  # what was under way is published
        late: list[Any] = []
        key = f"0/rfnav/map/nav_msgs::msg::dds_::OccupancyGrid_/{MAP_HASH}"
        joined = declare_advanced_subscriber(
            robot.session,
            key if spoken == "rmw_zenoh" else "rfnav/map",
            lambda sample: late.append(sample.payload.to_bytes()),
            history=HistoryConfig(detect_late_publishers=True, max_samples=1),
        )
        robot.until(lambda: late and drawn(late[-1]) == list(viewer.newest["rfnav/map"].data), 10.0)
        assert drawn(late[-1]).count(0) > 1000
        joined.undeclare()
        child.send_signal(signal.SIGTERM)
        assert child.wait(30.0) == 0


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
