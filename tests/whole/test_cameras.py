"""Cameras of every kind, played by another process: the bus reads what they show. And `rfnav run`
beside one that does what it should not: it is told everywhere, ends nothing, and mends itself."""

import subprocess
import sys
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from apartment import INTRINSICS, TWO_ROOMS, Apartment
from camera_double import DEPTH_M, KINDS, LENS, POSE
from camera_messages import compressed_depth, compressed_image, image, png
from places import DOUBLES
from robot_double import RobotDouble
from run_process import process

from hil_sim.driving.link import free_port
from runtime.clock import SystemClock
from runtime.core.types import Pose
from runtime.journal import read_journal
from runtime.robot import wire
from runtime.robot.bus import Bus
from runtime.robot.session import BusConfig, TopicsConfig
from runtime.robot.transforms import CameraConfig

PATIENCE_S = 20.0


@pytest.fixture(scope="module")
def cameras() -> Iterator[str]:
    """Where they are."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    command = [sys.executable, str(DOUBLES / "camera_double.py"), endpoint]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == "plays\n"
        yield endpoint
        child.kill()


@pytest.mark.parametrize("name", KINDS)
def test_a_camera_shows_what_is_there(cameras: str, name: str):
    kind = KINDS[name]
    topics = TopicsConfig(**dict(kind.topics))
    config = BusConfig(connect=(cameras,), prefix=name, topics=topics, compressed=kind.compressed)
    with Bus(config, SystemClock(), camera=CameraConfig(**dict(kind.camera))) as bus:
        obs = bus.next(PATIENCE_S)
        health = bus.health()
    assert obs is not None, health
    off = np.abs(obs.rgb.astype(int) - kind.rgb)
    middle = DEPTH_M.shape[1] // 2
    off[:, middle - 8 : middle + 8] = 0  # where a JPEG's blocks see both colours
    assert off.max() <= kind.within
    np.testing.assert_allclose(obs.depth_m, DEPTH_M, atol=kind.step_m)
    assert (obs.intrinsics, obs.pose.x_m, obs.pose.y_m) == (LENS, POSE.x_m, POSE.y_m)
    assert {topic: h.last_error for topic, h in health.items() if h.bad} == {}


PATIENT = "safety.odom_stale_s=2.0", "safety.frame_stale_s=4.0", "safety.plan_stale_s=5.0"
HALF = replace(INTRINSICS, width=INTRINSICS.width // 2, height=INTRINSICS.height // 2)


def mm(ns: int) -> np.ndarray:
    """Of a depth image that lives, as its colour does."""
    return np.full((INTRINSICS.height, INTRINSICS.width), 2000 + ns // 1000 % 50, np.uint16)


WRONG = {
    "camera/color/camera_info: nothing received in 5 s": ("camera_info", lambda ns: b""),
    "camera/color/image_raw: encoding 'nv21': publish rgb8, bgr8": (
        "color", lambda ns: image("nv21", (4, 4), bytes(24), stamp_ns=ns),
    ),
    "camera/depth/image_raw: is a CompressedImage, '16UC1; compressedDepth png': add \"depth\"": (
        "depth", lambda ns: compressed_image(*compressed_depth(png(mm(ns))), ns),
    ),
    "describes 80x60": ("camera_info", lambda ns: wire.encode_camera_info(HALF, ns)),
    "where one step is 0.001 m: if it is 0.0001 m, set camera.depth_unit_m = 0.0001": (
        "depth", lambda ns: image("16UC1", (160, 120), (mm(ns) * 20).tobytes(), stamp_ns=ns),
    ),
}  # fmt: skip


def shows(robot: RobotDouble, told: str) -> None:
    """What is wrong from now on."""
    stream, make = WRONG[told]

    def filmed(of: str, payload: bytes) -> bytes:
        return make(wire.peek_stamp(payload, of)) if of == stream else payload

    robot.filmed = filmed


@pytest.mark.slow
def test_what_a_camera_does_wrong_is_told_and_waited_for(tmp_path: Path):
    home, said = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, 0.0)), list[str]()
    first, *others = list(WRONG)
    unit = others.pop()
    with process(home, 100_000, *PATIENT, "panel.experts=[]") as (child, robot):
        listening = threading.Thread(target=lambda: said.extend(child.stderr or ()))
        listening.start()
        shows(robot, first)
        body = {"goal": "toilet", "log_dir": str(tmp_path)}
        assert robot.ask("goal", body)["accepted"]
        for told in (first, unit, *others):
            shows(robot, told)
            robot.until(lambda told=told: told in robot.state().get("halt", ""))
            assert robot.state()["runtime"]["state"] == "held"
            assert child.poll() is None
            if told is first:
                continue  # its unit is told before any of its images is mapped
            robot.filmed = lambda stream, payload: payload
            robot.until(lambda: robot.twist.v_mps > 0.05 or robot.twist.w_radps > 0.05)
        robot.ask("cancel")
        child.terminate()
        child.wait(30.0)
    listening.join(30.0)
    standing = [line["now"] for line in read_journal(tmp_path / "decisions.jsonl")
                if line["kind"] == "standing"]  # fmt: skip
    for told in WRONG:
        assert any(told in line for line in said), said
        assert any(told in line for line in standing), standing
