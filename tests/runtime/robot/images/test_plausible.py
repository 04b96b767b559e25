"""A depth camera's unit that cannot be is told, with the one that was probably meant."""

import numpy as np
import pytest
from apartment import INTRINSICS, MOUNT, TWO_ROOMS, Apartment

from runtime.core.types import Mount, Pose
from runtime.errors import SensorError
from runtime.robot.images.camera_images import DepthImage
from runtime.robot.images.plausible import SETTLED, VIEWS, DepthWatch
from runtime.robot.transforms import CameraConfig

MM = 0.001


def views(scale: float = 1.0) -> list[np.ndarray]:
    """A turn in a home."""
    home, seen = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, 0.0)), []
    for n in range(12):
        home.pose = Pose(4.0, 3.0, 0.5 * n)
        seen.append((home.observe().depth_m * scale).astype(np.float32))
    return seen


def refused(depth_m: np.ndarray, unit_m: float = MM, watch: DepthWatch | None = None) -> str:
    watch = watch or DepthWatch("depth", CameraConfig())
    try:
        watch.check(DepthImage(depth_m, unit_m), INTRINSICS, MOUNT)
    except SensorError as error:
        return str(error)
    return ""


def test_a_home_is_plausible():
    assert [refused(view) for view in views()] == [""] * 12


@pytest.mark.parametrize(
    ("scale", "unit_m", "meant"),
    [(10.0, MM, "0.0001"), (5.0, MM, "0.0002"), (1000.0, 1.0, "0.001"), (0.001, MM, "1")],
)
def test_a_wrong_unit_is_told_from_the_first_look_on(scale: float, unit_m: float, meant: str):
    told = [refused(view, unit_m) for view in views(scale)]
    assert told[0]
    assert sum(map(bool, told)) >= 6  # where the floor is out of view, a wall may be anywhere
    for line in filter(None, told):
        assert line.startswith("depth: ")
        assert line.endswith(f"if it is {meant} m, set camera.depth_unit_m = {meant}")
        assert f"where one step is {unit_m:g} m" in line
        assert "\n" not in line


def test_once_it_is_settled_nothing_is_doubted():
    watch, far = DepthWatch("depth", CameraConfig()), np.full((120, 160), 30.0, np.float32)
    assert refused(far, watch=watch).startswith("depth: half of it is farther than 30 m")
    for view in views():
        assert refused(view, watch=watch) == ""
    assert refused(far, watch=watch) == ""


def test_an_image_with_next_to_nothing_in_it_says_nothing():
    watch, view = DepthWatch("depth", CameraConfig()), np.zeros((120, 160), np.float32)
    view[:2, :20] = 60.0
    for _ in range(2 * SETTLED):
        assert refused(view, watch=watch) == ""
    assert refused(views(10.0)[0], watch=watch)


def test_down_a_storey_from_a_gallery_is_no_wrong_unit():
    """Nothing but a floor 2.9 m below the one that the robot stands on."""
    rows = (np.arange(120) + 0.5 - INTRINSICS.cy) / INTRINSICS.fy
    with np.errstate(divide="ignore"):
        depth = np.where(rows > 0.2, (MOUNT.z_m + 2.9) / rows, 0.0)
    view = np.repeat(depth[:, None], 160, axis=1).astype(np.float32)
    assert refused(view) == ""


def test_a_camera_that_looks_straight_down_is_judged_by_its_floor():
    down = Mount(0.0, 0.0, 0.5, 0.0, 1.5, 0.0)
    watch = DepthWatch("depth", CameraConfig())
    watch.check(DepthImage(np.full((120, 160), 0.5, np.float32), MM), INTRINSICS, down)
    with pytest.raises(SensorError, match=r"the floor is 5\.\d* m below the camera, not 0\.5 m"):
        watch.check(DepthImage(np.full((120, 160), 5.0, np.float32), MM), INTRINSICS, down)


def test_a_unit_that_is_configured_is_believed():
    watch = DepthWatch("depth", CameraConfig(depth_unit_m=0.001))
    assert [refused(view, watch=watch) for view in views(10.0)] == [""] * 12


def clipped(at_m: float) -> list[np.ndarray]:
    return [np.minimum(view, np.float32(at_m)) for view in views() * 2]


def told_of(seen: list[np.ndarray], **camera: float) -> list[str]:
    told: list[str] = []
    watch = DepthWatch("depth", CameraConfig(**camera), told.append)
    for view in seen:
        watch.check(DepthImage(view, 1.0), INTRINSICS, MOUNT)
    return told


def test_a_farthest_reading_that_comes_again_wherever_the_camera_looks_is_told_once():
    assert told_of(clipped(1.5)) == [
        "depth: 1.5 m is the farthest that it ever reads, and often: if that is where nothing is "
        "near, set camera.depth_nothing_m = 1.5"
    ]
    assert told_of(clipped(1.5), depth_nothing_m=1.5) == []


def test_walls_are_no_farthest_reading_however_long_the_robot_stands_before_one():
    assert told_of(views() * 3) == []
    assert told_of(clipped(1.5)[:1] * 3 * VIEWS) == []
    wall = [np.full((120, 160), 2.0, np.float32) for _ in range(3 * VIEWS)]
    assert told_of(wall) == []
