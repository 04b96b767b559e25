"""`rfnav run` beside robots that nobody here built: real messages, a real process."""

import math
import threading
from pathlib import Path

import cv2
import numpy as np
import pytest
from apartment import CELL, TWO_ROOMS, Apartment
from odd_robot import FAR_XY, LEAN, films
from run_process import process

from runtime.core.types import Pose
from runtime.journal import read_map

pytestmark = pytest.mark.slow  # whole processes

PATIENT = "safety.frame_stale_s=4.0", "safety.plan_stale_s=5.0"


def off_m(folder: Path, home: Apartment, shift: tuple[float, float]) -> np.ndarray:
    """How far each obstacle of the map that is left is from one of the apartment's. `shift`: from
    the map's frame to the apartment's."""
    arrays, meta = read_map(folder)
    frame, occupied = meta["frame"], arrays["occupied"]
    rows, cols = np.nonzero(occupied)
    x = frame["x0_m"] + (cols + 0.5) * frame["resolution_m"] + shift[0]
    y = frame["y0_m"] + (rows + 0.5) * frame["resolution_m"] + shift[1]
    away = cv2.distanceTransform((home.heights == 0).astype(np.uint8), cv2.DIST_L2, 5) * CELL
    r = np.clip((y / CELL).astype(int), 0, away.shape[0] - 1)
    c = np.clip((x / CELL).astype(int), 0, away.shape[1] - 1)
    return away[r, c]


def test_a_camera_on_its_side_with_depth_from_beside_and_odometry_of_its_own_maps_what_is_there(
    tmp_path: Path,
):
    home, said = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, -0.5)), list[str]()
    settings = LEAN, *PATIENT, "panel.experts=[]"
    with process(home, 100_000, *settings, odom_hz=3.0) as (child, robot):
        listening = threading.Thread(target=lambda: said.extend(child.stderr or ()))
        listening.start()
        films(robot, home)
        assert robot.ask("goal", {"goal": "toilet", "log_dir": str(tmp_path)})["accepted"]
        start = home.pose
        robot.until(lambda: math.dist(home.pose.xy, start.xy) > 1.2, 120.0)
        state = robot.state()
        robot.ask("cancel")
        child.terminate()
        child.wait(30.0)
    listening.join(30.0)
    assert home.collisions == 0
    assert any("taken to the base by the camera's mount" in line for line in said), said
    origin = state["origin_xy"]
    assert origin == pytest.approx((FAR_XY[0] + 4.0, FAR_XY[1] + 3.0))
    away = off_m(tmp_path, home, (origin[0] - FAR_XY[0], origin[1] - FAR_XY[1]))
    assert len(away) > 150
    assert np.quantile(away, 0.95) < 0.12


def test_a_camera_that_is_lower_than_configured_is_held_with_the_numbers_that_fit(tmp_path: Path):
    home = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, -0.5))
    settings = "camera.z_m=0.98", *PATIENT, "panel.experts=[]"
    with process(home, 100_000, *settings) as (child, robot):
        assert robot.ask("goal", {"goal": "toilet", "log_dir": str(tmp_path)})["accepted"]
        robot.until(lambda: "camera.z_m = 0.88" in robot.state().get("halt", ""), 120.0)
        state = next(one for one in robot.states if "camera.z_m = 0.88" in one.get("halt", ""))
        assert state["halt"].startswith("camera: the floor appears 0.10 m high")
        assert state["runtime"]["state"] == "held"
        robot.until(lambda: robot.twist.w_radps == 0)
        assert child.poll() is None
        assert robot.state()["state"] == "searching"  # and never "not found"
        robot.ask("cancel")
