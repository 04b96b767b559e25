"""`rfnav calibrate` before a camera whose mount is another than is configured: real messages over a
real bus."""

import json
import math
import re
import threading
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from lockstep_double import free_port
from other_half import camera_info, tf

from runtime.__main__ import cli
from runtime.commands.calibrate import _fits, _report
from runtime.core.geometry import optical_rays, optical_to_base
from runtime.core.optics.registered import Extrinsics, mount_beside
from runtime.core.types import F32, Intrinsics, Mount
from runtime.robot import wire
from runtime.robot.session import BusConfig, open_session

CAMERA = Intrinsics(194.0, 194.0, 160.0, 120.0, 320, 240)
BESIDE = (-0.06, 0.01, 0.0)  # of the depth camera in colour's


def depth_of(mount: Mount, floor: bool = True) -> F32:
    """(H, W) m of a floor and of walls 4 m away, with a camera's noise."""
    rays = optical_rays(CAMERA, 1) @ optical_to_base(mount).T
    with np.errstate(divide="ignore"):
        planes = [4.0 / np.abs(rays[..., 0]), 3.0 / np.abs(rays[..., 1])]
        if floor:
            planes.append(np.where(rays[..., 2] < 0, -mount.z_m / rays[..., 2], np.inf))
    depth = np.min(planes, axis=0)
    noise = np.random.default_rng(1).standard_normal(depth.shape)
    return (depth + 0.003 * depth**2 * noise).astype(np.float32)


@contextmanager
def filming(
    depth_m: F32, beside: bool = False, placed: tuple[float, ...] = (), tf_from_ns: int = 0
) -> Iterator[str]:
    """A camera that publishes one image over and over; its endpoint. `placed`: where tf has it;
    `tf_from_ns`: from which stamp on tf tells of the camera beside."""
    endpoint, ending = f"tcp/127.0.0.1:{free_port()}", threading.Event()
    session = open_session(BusConfig(listen=(endpoint,)))
    k = CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy
    frame = "depth_optical" if beside else "camera"

    def film() -> None:
        stamp_ns = 1
        while not ending.wait(0.1):
            stamp_ns += 100_000_000
            session.put("camera/color/camera_info", camera_info((320, 240), k))
            if beside:
                session.put("camera/depth/camera_info", camera_info((320, 240), k, frame=frame))
                if stamp_ns >= tf_from_ns:
                    session.put("tf_static", tf(("camera", frame, BESIDE, (0, 0, 0, 1))))
            if placed:
                session.put("tf_static", placed)
            session.put("camera/depth/image_raw", wire.encode_depth(depth_m, stamp_ns, frame))

    thread = threading.Thread(target=film)
    thread.start()
    try:
        yield endpoint
    finally:
        ending.set()
        thread.join()
        session.close()


def calibrated(endpoint: str, *more: str) -> Result:
    asked = ["calibrate", "--seconds", "3", "--set", f"bus.connect=['{endpoint}']", *more]
    return CliRunner().invoke(cli, asked)


@pytest.mark.parametrize(
    ("true", "keys"),
    [
        (Mount(z_m=0.80), {}),
        (Mount(z_m=0.93, pitch_rad=0.05, roll_rad=-0.03), {}),
        (Mount(z_m=0.4, pitch_rad=0.45), {}),
        (Mount(z_m=0.85, pitch_rad=0.3, roll_rad=math.pi / 2 + 0.04), {"camera.roll_rad": 1.5708}),
    ],
    ids=["low", "leaning", "far off", "on its side"],
)
def test_the_true_mount_is_printed_as_toml(true: Mount, keys: dict, tmp_path: Path):
    told = tmp_path / "mount.json"
    with filming(depth_of(true)) as endpoint:
        settings = [f"--set={name}={value}" for name, value in keys.items()]
        done = calibrated(endpoint, *settings, "--json", str(told))
    assert done.exit_code == 0, done.output
    camera = tomllib.loads(done.stdout[done.stdout.index("[camera]") :])["camera"]
    figures = json.loads(told.read_text())
    for name, within in (("z_m", 0.01), ("pitch_rad", 0.005), ("roll_rad", 0.005)):
        assert camera[name] == pytest.approx(getattr(true, name), abs=within)
        assert figures[name]["value"] == pytest.approx(camera[name], abs=1e-3)
        assert figures[name]["spread"] < within
    assert re.search(r"A floor in \d+ of \d+ depth images", done.stdout)


def test_by_the_depth_camera_s_image_it_is_colour_s_mount():
    true = Mount(0.0, 0.0, 0.8, 0.0, 0.1, 0.0)
    placed = np.eye(4)
    placed[:3, 3] = BESIDE
    own = mount_beside(true, Extrinsics.of(placed))
    with filming(depth_of(own), beside=True) as endpoint:
        done = calibrated(endpoint)
    assert done.exit_code == 0, done.output
    camera = tomllib.loads(done.stdout[done.stdout.index("[camera]") :])["camera"]
    assert camera["z_m"] == pytest.approx(0.8, abs=0.01)
    assert camera["pitch_rad"] == pytest.approx(0.1, abs=0.005)


def test_tf_that_comes_after_the_first_images_is_waited_for():
    with filming(depth_of(Mount()), beside=True, tf_from_ns=2_000_000_000) as endpoint:
        done = calibrated(endpoint)
    assert done.exit_code == 0, done.output


def test_where_tf_never_comes_it_says_so():
    with filming(depth_of(Mount()), beside=True, tf_from_ns=1 << 62) as endpoint:
        done = calibrated(endpoint)
    assert done.exit_code == 1
    assert "tf does not relate them" in done.stderr
    assert done.stdout == ""


def test_no_angle_is_minus_nothing():
    middle = np.array([0.88, -1e-6, -1e-6])
    told = "\n".join((*_report(Mount(), middle, np.zeros(3), 3, 3), *_fits(middle, by_tf=False)))
    assert "-0.0" not in told
    assert told.endswith("z_m = 0.880\npitch_rad = 0.0000\nroll_rad = 0.0000")


def test_where_tf_is_gone_by_it_is_held_against_that_and_no_keys_are_told():
    level = ("head", "camera", (0, 0, 0), (-0.5, 0.5, -0.5, 0.5))
    placed = tf(
        ("base_link", "head", (0.1, 0, 1.15), (0, math.sin(0.35), 0, math.cos(0.35))), level
    )
    with filming(depth_of(Mount(z_m=1.2, pitch_rad=0.75)), placed=placed) as endpoint:
        done = calibrated(endpoint, "--set", "camera.mount=tf")
    assert done.exit_code == 0, done.output
    assert re.search(r"height +1\.[12]\d\d m, .*; configured 1\.150", done.stdout)
    assert "[camera]" not in done.stdout
    fits = re.search(r"on the base at z (\S+) m, pitch (\S+), roll (\S+) rad", done.stdout)
    assert fits is not None
    assert [float(v) for v in fits.groups()] == pytest.approx([1.2, 0.75, 0.0], abs=0.01)


def test_without_a_floor_it_ends_with_1_and_says_what_to_do():
    with filming(depth_of(Mount(), floor=False)) as endpoint:
        done = calibrated(endpoint)
    assert done.exit_code == 1
    assert done.stderr.startswith("rfnav: a floor in 0 of ")
    assert "turn the robot to free floor" in done.stderr


def test_without_a_camera_it_ends_with_1():
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    session = open_session(BusConfig(listen=(endpoint,)))
    try:
        done = calibrated(endpoint)
    finally:
        session.close()
    assert done.exit_code == 1
    assert done.stderr == (
        "rfnav: camera/depth/image_raw: no depth image with its camera info "
        "(camera/color/camera_info) in 3 s: rfnav doctor tells what comes and what to mend\n"
    )
