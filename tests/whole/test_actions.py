"""Goals by ROS 2's actions, against `rfnav run` as a process that drives a robot."""

import json
import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from apartment import TWO_ROOMS, Apartment
from goal_client import GO, GoalClient, a_pose, a_thing
from robot_double import RobotDouble
from run_process import process

from hil_sim.driving.robot_wire import Spoken
from runtime.core.types import Pose
from runtime.robot import wire

pytestmark = pytest.mark.slow  # whole processes

ONE, TWO, THREE = (f"goal of number {n}".encode() for n in "123")
CANCELED, SUCCEEDED, ABORTED = 5, 4, 6
QUICK = ("control.look_radps=1.0", "safety.plan_stale_s=5.0")
LABELS = ("research.detector_source='topic'",)
# A busy machine must not decide a test.
PATIENT = ("safety.odom_stale_s=2.0", "safety.frame_stale_s=4.0")


def tells_what_is_seen(robot: RobotDouble) -> None:
    """It says with each image what a detector would."""

    def filmed(stream: str, payload: bytes) -> bytes:
        if stream == "color":
            seen = robot.home.detect(("toilet",), robot.home.observe())
            told = {
                "stamp_ns": wire.peek_stamp(payload, stream),
                "boxes": seen.boxes_px.tolist(),
                "names": ["toilet"] * len(seen.scores),
                "scores": seen.scores.tolist(),
                "room": None,
            }
            robot._put("rfnav/labels", wire.encode_json(told))
        return payload

    robot.filmed = filmed


@contextmanager
def running(spoken: Spoken, folder: Path) -> Iterator[tuple[subprocess.Popen[str], RobotDouble]]:
    home = Apartment.of(TWO_ROOMS, Pose(5.2, 2.4, -0.5))
    home.things = {"toilet": (7.4, 2.2, 0.3)}
    env = {**os.environ, "XDG_STATE_HOME": str(folder)}
    settings = *QUICK, *PATIENT, *LABELS
    with process(home, 100_000, *settings, env=env, spoken=spoken) as (child, robot):
        tells_what_is_seen(robot)
        yield child, robot


def test_goals_are_refused_cancelled_and_found_behind_the_bridge(tmp_path: Path):
    with running("ros2dds", tmp_path) as (_, robot):
        client = GoalClient(robot.session, "ros2dds")
        assert client.send(ONE, a_thing("toilet", if_busy="perhaps"))
        status, refused = client.result(ONE)
        assert (status, refused.result) == (ABORTED, "refused")
        assert refused.code > 0
        assert "if_busy" in refused.sentence
        assert client.send(TWO, a_thing("toilet", time_limit_s=600.0))
        robot.until(lambda: any(id == TWO and fed.mode for id, fed in client.fed))
        assert client.cancel(TWO) == (0, 1)
        status, cancelled = client.result(TWO)
        assert (status, cancelled.result) == (CANCELED, "cancelled")
        robot.until(lambda: robot.twist.v_mps == robot.twist.w_radps == 0)
        assert client.send(THREE, a_thing("toilet", if_busy="refuse"))
        status, found = client.result(THREE)
        client.close()
    assert (status, found.result, found.code) == (SUCCEEDED, "found", 0)
    assert found.sentence
    assert found.frame_id == "odom"
    told = [fed for id, fed in client.fed if id == THREE]
    assert [fed.state for fed in told if fed.state != "searching"] == ["found"]
    assert max(fed.driven_m for fed in told) > 0.5
    at, pose = told[-1].current_pose, robot.home.pose
    assert at.header.frame_id == "odom"
    there = at.pose.position.x, at.pose.position.y
    assert there == pytest.approx((pose.x_m, pose.y_m), abs=0.3)
    assert json.loads(told[-1].details)["goal"] == "toilet"


def test_a_pose_is_gone_to_and_the_runtimes_end_is_a_result_over_rmw_zenoh(tmp_path: Path):
    with running("rmw_zenoh", tmp_path) as (child, robot):
        goer = GoalClient(robot.session, "rmw_zenoh", GO)
        assert goer.send(ONE, a_pose(6.2, 2.4, 0.5, "odom"))
        status, arrived = goer.result(ONE)
        pose = robot.home.pose
        finder = GoalClient(robot.session, "rmw_zenoh")
        assert finder.send(TWO, a_thing("toilet"))
        robot.until(lambda: any(id == TWO for id, _ in finder.fed))
        left = finder.asked_result(TWO)
        assert finder.cancel(THREE) == (2, 0)  # nobody knows it; what was asked before has come
        child.send_signal(signal.SIGTERM)
        status_at_end, ended = left()
        finder.close()
        goer.close()
    assert (status, arrived.result, arrived.error_code) == (SUCCEEDED, "arrived", 0)
    assert (pose.x_m, pose.y_m) == pytest.approx((6.2, 2.4), abs=0.5)
    assert pose.yaw_rad == pytest.approx(0.5, abs=0.5)
    assert max(fed.distance_remaining for _, fed in goer.fed) > 0.5
    assert (status_at_end, ended.result, ended.cause) == (ABORTED, "failed", "restart")
