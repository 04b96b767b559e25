"""The floor against the configured mount, by depth that was computed by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hearings import LEVEL, floor_depth, healthy

from runtime.config import Config, load
from runtime.core.types import Mount
from runtime.doctor.diagnosis import Diagnosis, Grade
from runtime.doctor.floor import judge_floor, seen_mount

CONFIG = Config()


def found(depth: np.ndarray, config: Config = CONFIG) -> Diagnosis:
    (told,) = judge_floor(replace(healthy(config), depths=[depth] * 3), config)
    return told


@pytest.mark.parametrize("height_m", [0.80, 0.88, 0.95])
@pytest.mark.parametrize("pitch_deg", [-4.0, 0.0, 6.0])
def test_height_and_tilt_are_recovered(height_m: float, pitch_deg: float):
    seen = seen_mount(floor_depth(height_m, math.radians(pitch_deg)), LEVEL, Mount())
    assert seen is not None
    assert seen.z_m == pytest.approx(height_m, abs=0.01)
    assert math.degrees(seen.pitch_rad) == pytest.approx(pitch_deg, abs=0.3)
    assert math.degrees(seen.roll_rad) == pytest.approx(0.0, abs=0.3)


def test_the_configured_mount_is_well():
    assert found(floor_depth()).grade is Grade.OK


@pytest.mark.parametrize(
    ("height_m", "pitch_deg", "grade"),
    [(0.935, 0.0, Grade.WARNING), (0.88, 0.8, Grade.WARNING), (0.98, 0.0, Grade.BAD),
     (0.88, 5.0, Grade.BAD), (0.88, 20.0, Grade.BAD)],
)  # fmt: skip
def test_another_is_told_with_the_lines_that_fit(height_m: float, pitch_deg: float, grade: Grade):
    told = found(floor_depth(height_m, math.radians(pitch_deg)))
    assert told.grade is grade
    fits = {key: float(value) for key, value in told.settings}
    assert fits.keys() == {"camera.z_m" if height_m != 0.88 else "camera.pitch_rad"}
    assert fits.get("camera.z_m", height_m) == pytest.approx(height_m, abs=0.01)
    turned = fits.get("camera.pitch_rad", math.radians(pitch_deg))
    assert math.degrees(turned) == pytest.approx(pitch_deg, abs=0.3)


@pytest.mark.parametrize("depth", [np.full((120, 160), 9.0), np.ones((120, 160))])
def test_no_floor_is_not_known(depth: np.ndarray):
    told = found(np.asarray(depth, np.float32))
    assert told.grade is Grade.UNKNOWN
    assert "face free floor" in told.remedy


def test_a_mount_that_tf_tells_is_held_against_the_floor():
    config = load(None, ["camera.mount=tf"])
    hearing = replace(healthy(config), depths=[floor_depth(0.5)] * 3)
    assert list(judge_floor(hearing, config)) == []  # nothing came on tf
    (lost,) = judge_floor(replace(hearing, errors={"tf": "tf: no way from base_link"}), config)
    assert (lost.about, lost.grade) == ("mount", Grade.BAD)
    mount, floor = judge_floor(replace(hearing, mount=Mount(z_m=0.5)), config)
    assert (mount.grade, floor.grade) == (Grade.OK, Grade.OK)
    _, off = judge_floor(replace(hearing, mount=Mount(z_m=0.6)), config)
    assert off.grade is Grade.BAD
    assert "URDF" in off.remedy
    assert not off.settings


def test_a_mount_that_the_floor_tells_may_be_off():
    config = load(None, ["camera.mount=floor"])
    assert found(floor_depth(0.8, 0.1), config).grade is Grade.OK


def test_a_camera_on_its_side_keeps_its_roll():
    mount = Mount(roll_rad=math.pi / 2)
    seen = seen_mount(floor_depth(0.9), LEVEL, mount)  # images are upright by then
    assert seen is not None
    assert seen.z_m == pytest.approx(0.9, abs=0.01)
    assert seen.roll_rad == pytest.approx(math.pi / 2, abs=0.01)


def test_without_a_frame_nothing_is_said():
    assert list(judge_floor(replace(healthy(CONFIG), intrinsics=None), CONFIG)) == []
