"""What the camera's noise does, and that it is the same twice."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from hil_sim.scenes.format import Room, Scene, SceneObject
from hil_sim.simulation.noise import NONE, USUAL, Noise
from hil_sim.simulation.protocol import HM3D, ONROBOT
from hil_sim.simulation.sensors import (
    beside,
    colour_read,
    depth_read,
    encode_bumper,
    encode_scan,
    sense,
)
from runtime.robot.wire_senses import decode_range

NO_GLASS = np.zeros((60, 80), bool)
STEP = np.where(np.arange(80) < 40, 2.0, 4.0).astype(np.float32) * np.ones((60, 1), np.float32)


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


@pytest.mark.parametrize("metres", [1.0, 2.0, 4.0])
def test_depth_noise_grows_with_the_square_of_the_distance(metres: float) -> None:
    true = np.full((60, 80), metres, np.float32)
    read = depth_read(true, NO_GLASS, Noise(depth=0.003), rng())
    assert read.std() == pytest.approx(0.003 * metres**2, rel=0.05)
    assert read.mean() == pytest.approx(metres, abs=0.002 * metres**2)


def test_holes_lie_at_edges() -> None:
    read = depth_read(STEP, NO_GLASS, Noise(edges=1.0), rng())
    assert (read[:, 39:41] == 0).all()
    assert (read[:, :38] == 2.0).all()
    assert (read[:, 42:] == 4.0).all()


def test_glass_and_mirrors_have_no_depth() -> None:
    objects = (
        SceneObject("m", "mirror", "builtin:box", (0, 0, 0)),
        SceneObject("window-1", "other", "builtin:box", (0, 0, 0)),
        SceneObject("t", "table", "builtin:box", (0, 0, 0)),
    )
    scene = Scene("s", (), (), (Room("r", "kitchen", ((0, 0), (1, 0), (1, 1))),), objects)
    seen = np.full((60, 80), -1, np.int32)
    seen[:10], seen[10:20], seen[20:30] = 0, 1, 2
    view = View(np.zeros((60, 80, 3), np.uint8), np.full((60, 80), 2.0, np.float32), seen)
    _, depth = sense(view, scene, replace(HM3D, noise=Noise(glass=1.0)), 0.0, rng())
    assert (depth[:20] == 0).all()
    assert (depth[20:] == 2.0).all()


def test_a_camera_by_name_is_photographed_with() -> None:
    view = View(
        np.full((60, 80, 3), 120, np.uint8),
        np.full((60, 80), 4.2, np.float32),
        np.full((60, 80), -1, np.int32),
    )
    scene = Scene("s", (), (), (Room("r", "kitchen", ((0, 0), (1, 0), (1, 1))),), ())
    noise = Noise(camera="azure-kinect")
    _, depth = sense(view, scene, replace(HM3D, noise=noise), 0.0, rng())
    assert (depth == 0).all()  # beyond 3.86 m
    _, depth = sense(view, scene, replace(HM3D, noise=Noise(flying=1.0)), 0.0, rng())
    assert (depth == np.float32(4.2)).all()  # no edge


def test_nothing_is_read_where_nothing_is_and_nothing_is_negative() -> None:
    true = STEP.copy()
    true[:5] = 0.0
    read = depth_read(true, NO_GLASS, replace(USUAL, depth=0.5), rng())
    assert (read[:5] == 0).all()
    assert read.min() >= 0


def test_exposure_scales_all_pixels_alike_and_blur_smears_rows() -> None:
    grey = np.full((60, 80, 3), 100, np.uint8)
    read = colour_read(grey, 0.0, Noise(exposure=0.2), rng())
    assert len(np.unique(read)) == 1
    assert read[0, 0, 0] != 100
    bars = np.zeros((60, 80, 3), np.uint8)
    bars[:, 40:] = 200
    smeared = colour_read(bars, -8.2, Noise(blur=0.01), rng())
    assert len(np.unique(smeared[30, :, 0])) == 9  # a ramp of eight pixels
    assert (smeared[0] == smeared[59]).all()
    assert (colour_read(bars, 0.3, Noise(blur=0.01), rng()) == bars).all()


@dataclass
class View:
    rgb: np.ndarray
    depth_m: np.ndarray
    segmentation: np.ndarray


def test_the_same_seed_gives_the_same_bytes() -> None:
    scene = Scene("s", (), (), (Room("r", "kitchen", ((0, 0), (1, 0), (1, 1))),), ())
    view = View(rng(5).integers(0, 255, (60, 80, 3), np.uint8), STEP, np.full((60, 80), -1))
    first, second = (sense(view, scene, ONROBOT, 1.0, rng(7)) for _ in range(2))
    other = sense(view, scene, ONROBOT, 1.0, rng(8))
    assert [a.tobytes() for a in first] == [b.tobytes() for b in second]
    assert [a.tobytes() for a in first] != [b.tobytes() for b in other]


def test_without_noise_the_truth_passes_untouched() -> None:
    scene = Scene("s", (), (), (Room("r", "kitchen", ((0, 0), (1, 0), (1, 1))),), ())
    view = View(rng(5).integers(0, 255, (60, 80, 3), np.uint8), STEP, np.full((60, 80), -1))
    rgb, depth = sense(view, scene, HM3D, 3.0, rng())
    assert HM3D.noise == NONE
    assert rgb is view.rgb
    assert (depth == STEP).all()


def test_scan_and_bumper_are_ros_messages() -> None:
    store = get_typestore(Stores.ROS2_HUMBLE)
    ranges = np.array([1.0, np.inf, 2.5, 0.2], np.float32)
    stamp_ns = 3_200_000_000
    scan = store.deserialize_cdr(encode_scan(ranges, stamp_ns), "sensor_msgs/msg/LaserScan")
    assert (scan.header.stamp.sec, scan.header.stamp.nanosec) == (3, 200_000_000)
    assert scan.ranges.tolist() == ranges.tolist()
    assert scan.angle_min + 3 * scan.angle_increment == pytest.approx(scan.angle_max)
    assert store.deserialize_cdr(encode_bumper(True), "std_msgs/msg/Bool").data


def test_what_a_robot_does_not_carry_is_not_published() -> None:
    ranges = np.ones(4, np.float32)
    below_m = {"cliff/left": 0.03, "cliff/right": np.inf}
    assert beside(HM3D, ranges, True, below_m, 1) == {}
    every = replace(HM3D, laser=True, bumper=True, cliffs=True)
    found = beside(every, ranges, True, below_m, 1)
    assert set(found) == {"scan", "bumper", "cliff/left", "cliff/right"}
    for topic, range_m in below_m.items():
        assert decode_range(found[topic], topic).value == pytest.approx(range_m)
