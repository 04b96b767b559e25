"""`rfnav doctor` as a process, beside a robot on the bus: what it says of a healthy one, and of
what may be wrong with one."""

import json
import os
import signal
import struct
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from apartment import TWO_ROOMS
from painted import Painted
from places import DOUBLES, ROOT
from robot_double import RobotDouble

from hil_sim.driving.link import free_port
from runtime.core.types import Pose
from runtime.robot.session import BusConfig

pytestmark = pytest.mark.slow  # whole processes

START = Pose(4.0, 3.0, 0.2)
ODOM_HZ, FPS = 25.0, 6.0
# However busy the machine is, the robot's messages are no reason to hold it.
PATIENT = [word for setting in ("odom_stale_s=2.0", "depth_stale_s=2.0", "frame_stale_s=4.0",
           "plan_stale_s=5.0") for word in ("--set", f"safety.{setting}")]  # fmt: skip
AHEAD_S = 2  # the camera's clock, where that is another
# Models that need no files: those of the tests of `doctor/models.py` are what is slow about it.
PROCESS = f"""
import sys
sys.path[:0] = [{str(DOUBLES)!r}]
from apartment import TWO_ROOMS, Apartment
from fake_models import FakeModels, farthest
import runtime.commands.doctor as doctor
import runtime.__main__ as program
from runtime.core.types import Pose

class Models(FakeModels):
    def __init__(self, config, clock, book):
        super().__init__(Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, 0.0)), o2f=farthest)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.panel.close()

doctor.LoadedModels = Models
doctor.check_present = lambda models: None
program.main()
"""


def command(port: int, *arguments: str) -> list[str]:
    where = f"bus.connect=['tcp/127.0.0.1:{port}']"
    words = "doctor", "--seconds", "3", "--json", "--set", where, *PATIENT, *arguments
    return [sys.executable, "-c", PROCESS, *words]


def environment(state: Path) -> dict[str, str]:
    return {**os.environ, "XDG_STATE_HOME": str(state), "PYTHONPATH": str(ROOT)}


def doctor(port: int, *arguments: str, state: Path) -> tuple[int, dict[str, Any]]:
    """Its exit status, and its findings by what they are about."""
    done = subprocess.run(
        command(port, *arguments), capture_output=True, text=True, timeout=300, check=False,
        cwd=ROOT, env=environment(state),
    )  # fmt: skip
    assert done.returncode in (0, 1), done.stderr
    told = json.loads(done.stdout)
    assert told["ready"] is (done.returncode == 0)
    return done.returncode, {one["about"]: one for one in told["found"]}


def elsewhere(stream: str, payload: bytes) -> bytes:
    """Depth is told in another camera's frame."""
    return payload.replace(b"camera\0", b"infra1\0", 1) if stream == "depth" else payload


def ahead(stream: str, payload: bytes) -> bytes:
    """All of a camera is stamped by another clock."""
    (seconds,) = struct.unpack_from("<i", payload, 4)
    return payload[:4] + struct.pack("<i", seconds + AHEAD_S) + payload[8:]


@pytest.fixture
def robot() -> Iterator[tuple[RobotDouble, int]]:
    port = free_port()
    bus = BusConfig(listen=(f"tcp/127.0.0.1:{port}",))
    patient = RobotDouble(Painted.of(TWO_ROOMS, START), bus, ODOM_HZ, FPS)
    yield patient, port
    patient.close()


def bad(found: dict[str, Any]) -> set[str]:
    return {about for about, one in found.items() if one["grade"] == "bad"}


def test_a_healthy_robot_can_search_and_its_turn_is_what_the_images_show(
    robot: tuple[RobotDouble, int], tmp_path: Path
):
    patient, port = robot
    patient.start()
    status, found = doctor(port, "--turn", state=tmp_path)
    assert bad(found) == set()
    assert status == 0
    for about in ("pairs", "registration", "floor", "turning", "turning about"):
        assert found[about]["grade"] == "ok", found[about]
    assert found["base"]["told"] == "somebody listens on cmd_vel; it is told Twist"
    turned = [twist for twist in patient.commands if twist.w_radps]
    assert turned
    assert all(twist.v_mps == 0 and 0 <= twist.w_radps <= 0.6 + 1e-6 for twist in turned)
    patient.until(lambda: patient.commands[-1].w_radps == 0)


def test_odometry_that_turns_the_wrong_way(robot: tuple[RobotDouble, int], tmp_path: Path):
    patient, port = robot
    patient.bend = lambda pose: Pose(pose.x_m, pose.y_m, -pose.yaw_rad)
    patient.start()
    status, found = doctor(port, "--turn", state=tmp_path)
    assert status == 1
    assert bad(found) == {"turning"}
    assert "the other way" in found["turning"]["told"]
    assert found["turning"]["remedy"].startswith("swap the sign of yaw in the base's odometry")


def test_a_robot_without_depth(robot: tuple[RobotDouble, int], tmp_path: Path):
    patient, port = robot
    patient.filmed = lambda stream, payload: b"" if stream == "depth" else payload
    token = patient.session.liveliness().declare_token(
        "@/z/@ros2_lv/MP/oak§stereo§image_raw/sensor_msgs§msg§Image/:::5,10"
    )
    patient.start()
    status, found = doctor(port, state=tmp_path)
    token.undeclare()
    assert status == 1
    assert bad(found) == {"depth"}
    assert found["depth"]["remedy"] == 'bus.topics.depth = "oak/stereo/image_raw"'


def test_depth_that_is_not_registered(robot: tuple[RobotDouble, int], tmp_path: Path):
    patient, port = robot
    patient.filmed = elsewhere
    patient.start()
    status, found = doctor(port, state=tmp_path)
    assert status == 1
    assert bad(found) == {"frames"}
    assert "align_depth" in found["frames"]["remedy"]


def test_a_mount_that_is_configured_wrongly(robot: tuple[RobotDouble, int], tmp_path: Path):
    patient, port = robot
    patient.start()
    wrong = "--set", "camera.pitch_rad=0.12", "--set", "camera.z_m=0.8"
    status, found = doctor(port, *wrong, state=tmp_path)
    assert status == 1
    assert bad(found) == {"floor"}
    fits = {key: float(value) for key, value in found["floor"]["settings"]}
    assert fits["camera.z_m"] == pytest.approx(0.88, abs=0.02)
    assert fits["camera.pitch_rad"] == pytest.approx(0.0, abs=0.01)


def test_a_camera_of_another_clock(robot: tuple[RobotDouble, int], tmp_path: Path):
    patient, port = robot
    patient.filmed = ahead
    patient.start()
    status, found = doctor(port, state=tmp_path)
    assert status == 1
    assert "clocks" in bad(found)
    assert "chrony" in found["clocks"]["remedy"]


def test_nobody_turns_while_a_runtime_is_on_the_bus(robot: tuple[RobotDouble, int], tmp_path: Path):
    patient, port = robot
    busy = patient.session.declare_queryable("rfnav/status", lambda query: None)
    patient.start()
    status, found = doctor(port, "--turn", state=tmp_path)
    busy.undeclare()
    assert status == 1
    assert bad(found) == {"turn"}
    assert "two would drive" in found["turn"]["told"]
    assert not patient.commands


def test_a_robot_that_speaks_the_other_dialect(tmp_path: Path):
    port = free_port()
    home, bus = Painted.of(TWO_ROOMS, START), BusConfig(listen=(f"tcp/127.0.0.1:{port}",))
    robot = RobotDouble(home, bus, ODOM_HZ, FPS, "rmw_zenoh")
    robot.start()
    try:
        status, found = doctor(port, "--set", "bus.dialect=rmw_zenoh", state=tmp_path)
    finally:
        robot.close()
    assert bad(found) == set()
    assert status == 0
    assert found["base"]["grade"] == found["registration"]["grade"] == "ok"


def test_nothing_at_all(tmp_path: Path):
    status, found = doctor(free_port(), state=tmp_path)
    assert status == 1
    assert bad(found) == {"bus"}
    assert found["bus"]["told"].startswith("nobody is at tcp/127.0.0.1:")
    assert found["topics"]["grade"] == "not known"


def test_ctrl_c_stops_the_turn_and_ends_it(robot: tuple[RobotDouble, int], tmp_path: Path):
    patient, port = robot
    patient.start()
    words = command(port, "--turn")
    process = subprocess.Popen(words, cwd=ROOT, env=environment(tmp_path))
    try:
        patient.until(lambda: patient.twist.w_radps > 0.3 or process.poll() is not None)
        process.send_signal(signal.SIGINT)
        assert process.wait(60.0) == 130
    finally:
        process.kill()
        process.wait()
    patient.until(lambda: patient.commands[-1].w_radps == 0)
