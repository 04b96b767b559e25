"""Whose pose odometry tells: worked out by hand for bases, cameras and far origins."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from other_half import odometry_of, slam_pose

from runtime.core.geometry import optical_to_base
from runtime.core.types import F64, Mount, Pose
from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot.odometry import LINES, BaseOdometry, mounted
from runtime.robot.sync import RawMessage
from runtime.robot.transforms import CameraConfig

CAMERA = CameraConfig(x_m=0.2, y_m=-0.1, z_m=0.9, roll_rad=0.1, pitch_rad=0.3, yaw_rad=0.4)
OPTICAL = "camera_color_optical_frame"
UP, UPSIDE_DOWN = (0.0, 0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0)
POSES = st.builds(
    Pose,
    st.floats(-900, 900),
    st.floats(-900, 900),
    st.floats(-math.pi, math.pi, exclude_min=True),
)


def base(pose: Pose) -> F64:
    matrix, c, s = np.eye(4), math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    matrix[:2, :2] = [[c, -s], [s, c]]
    matrix[:2, 3] = pose.x_m, pose.y_m
    return matrix


def quaternion(turn: F64) -> tuple[float, float, float, float]:
    """x y z w, by the largest of the four."""
    m = turn
    squares = np.array(
        [1 + m[0, 0] - m[1, 1] - m[2, 2], 1 - m[0, 0] + m[1, 1] - m[2, 2],
         1 - m[0, 0] - m[1, 1] + m[2, 2], 1 + m[0, 0] + m[1, 1] + m[2, 2]]
    )  # fmt: skip
    n = int(squares.argmax())
    s = 2 * math.sqrt(squares[n])
    rows = [
        (s / 4, (m[0, 1] + m[1, 0]) / s, (m[0, 2] + m[2, 0]) / s, (m[2, 1] - m[1, 2]) / s),
        ((m[0, 1] + m[1, 0]) / s, s / 4, (m[1, 2] + m[2, 1]) / s, (m[0, 2] - m[2, 0]) / s),
        ((m[0, 2] + m[2, 0]) / s, (m[1, 2] + m[2, 1]) / s, s / 4, (m[1, 0] - m[0, 1]) / s),
        ((m[2, 1] - m[1, 2]) / s, (m[0, 2] - m[2, 0]) / s, (m[1, 0] - m[0, 1]) / s, s / 4),
    ]
    return rows[n]


def told(matrix: F64, **frames: str) -> RawMessage:
    payload = odometry_of(tuple(matrix[:3, 3]), quaternion(matrix[:3, :3]), 5, **frames)
    return RawMessage(5, payload, 1.0)


def same(got: Pose, wanted: Pose, within: float = 1e-6) -> None:
    assert (got.x_m, got.y_m) == pytest.approx((wanted.x_m, wanted.y_m), abs=within)
    assert math.remainder(got.yaw_rad - wanted.yaw_rad, math.tau) == pytest.approx(0, abs=within)


@given(POSES, st.integers(1, 2**60))
def test_a_base_s_pose_is_told_as_it_is(pose: Pose, stamp_ns: int):
    for slam, payload in (
        (False, wire.encode_odometry(pose, stamp_ns)),
        (True, slam_pose(pose, stamp_ns)),
    ):
        got, tilt = BaseOdometry("odom", slam).read(RawMessage(stamp_ns, payload, 0.0))
        assert got.stamp_ns == stamp_ns
        assert (got.value.x_m, got.value.y_m) == (pose.x_m, pose.y_m)
        same(got.value, pose, 1e-9)
        assert -math.pi < got.value.yaw_rad <= math.pi
        assert tilt == pytest.approx(0, abs=1e-7)


@given(POSES)
def test_a_pose_of_the_optical_frame_is_taken_to_the_base(pose: Pose):
    lines: list[str] = []
    odometry = BaseOdometry("odom", False, CAMERA, tell=lines.append)
    optical = base(pose) @ mounted(CAMERA, True)
    for _ in range(2):
        got, tilt = odometry.read(told(optical, child=OPTICAL))
        same(got.value, pose)
        assert tilt == pytest.approx(0, abs=1e-6)
    assert lines == [f"odom: is of {OPTICAL}: taken to the base by the camera's mount"]


def test_the_camera_s_mount_is_worked_out_by_hand():
    level = Mount(0.2, 0.0, 0.9)
    expected = [[0, 0, 1, 0.2], [-1, 0, 0, 0], [0, -1, 0, 0.9], [0, 0, 0, 1]]
    np.testing.assert_allclose(mounted(level, True), expected, atol=1e-12)
    np.testing.assert_allclose(mounted(level, False)[:3, :3], np.eye(3), atol=1e-12)


def test_a_camera_that_has_turned_with_its_robot_is_not_beside_it():
    """The robot turned to the left on the spot: its camera, 0.2 m ahead, went along a circle."""
    odometry = BaseOdometry("odom", False, CameraConfig(x_m=0.2), tell=lambda line: None)
    matrix = np.eye(4)
    matrix[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    matrix[:3, 3] = 0.0, 0.2, 0.88
    got, _ = odometry.read(told(matrix, child="camera_link"))
    same(got.value, Pose(0.0, 0.0, math.pi / 2))


def test_what_tf_knows_of_a_frame_goes_before_its_name():
    placed = mounted(Mount(0.5, 0.1, 0.3, 0.0, 0.0, math.pi), False)
    odometry = BaseOdometry("odom", False, CAMERA, lambda frame, stamp_ns: placed)
    pose = Pose(3.0, 4.0, 1.0)
    same(odometry.read(told(base(pose) @ placed, child="imu"))[0].value, pose)


def test_an_optical_pose_under_another_name_is_known_by_how_it_leans():
    lines: list[str] = []
    level = CameraConfig(x_m=0.2)
    odometry = BaseOdometry("pose", True, level, tell=lines.append)
    for pose in (Pose(1.0, 2.0, 0.3), Pose(1.5, 2.0, -2.0)):
        matrix = base(pose) @ mounted(level, True)
        payload = odometry_of(tuple(matrix[:3, 3]), quaternion(matrix[:3, :3]), 5)
        whole = wire.decode(payload, wire.ODOMETRY, "odom")
        stamped = wire.STORE.types[wire.POSE_STAMPED](whole.header, whole.pose.pose)
        same(odometry.read(RawMessage(5, wire.encode(stamped), 1.0))[0].value, pose)
    assert lines == ["pose: is an optical frame's pose: taken to the base by the camera's mount"]


def test_a_base_that_leans_later_is_no_camera():
    odometry = BaseOdometry("odom", False, CAMERA)
    odometry.read(told(np.eye(4)))
    fallen = np.eye(4)
    fallen[:3, :3] = optical_to_base(Mount(0.0, 0.0, 0.0))
    assert odometry.read(told(fallen))[1] == pytest.approx(math.pi / 2)


def test_a_base_that_is_upside_down_is_told_of_with_the_remedy():
    lines: list[str] = []
    odometry = BaseOdometry("odom", tell=lines.append)
    for _ in range(2):  # whoever judges how it leans holds it
        told = odometry.read(RawMessage(5, odometry_of((0, 0, 0), UPSIDE_DOWN, 5), 1.0))
        assert told[1] == pytest.approx(math.pi)
    assert lines == ["odom: tilted by 180 degrees: publish the base's pose (x forward, z up)"]


def test_odometry_in_an_optical_frame_is_set_upright():
    """Visual odometry that calls where the camera began its origin: z ahead, y down."""
    odometry = BaseOdometry("odom", False, CameraConfig(), tell=lambda line: None)
    matrix = np.eye(4)
    matrix[:3, 3] = -0.5, 0.0, 2.0  # 2 m ahead, half a metre to the left
    raw = told(matrix, child=OPTICAL, frame="odom_optical")
    same(odometry.read(raw)[0].value, Pose(2.0, 0.5, 0.0))


@pytest.mark.parametrize("origin", [(500_000.25, 4_649_776.5), (-3000.0, 20.0)])
def test_a_far_origin_is_taken_off(origin: tuple[float, float]):
    lines: list[str] = []
    odometry = BaseOdometry("odom", tell=lines.append)
    first = odometry.read(told(base(Pose(*origin, 0.5))))[0].value
    second = odometry.read(told(base(Pose(origin[0] + 1.5, origin[1] - 2.0, 0.5))))[0].value
    assert max(abs(first.x_m), abs(first.y_m)) <= 0.5
    assert (second.x_m - first.x_m, second.y_m - first.y_m) == pytest.approx((1.5, -2.0))
    x0_m, y0_m = odometry.origin_xy
    assert (first.x_m + x0_m, first.y_m + y0_m) == pytest.approx(origin)
    assert len(lines) == 1
    near = np.float32(second.x_m)  # what the map's parts in single precision make of it
    assert float(near) == pytest.approx(second.x_m, abs=1e-6)


def test_a_near_origin_stays_where_it_is():
    odometry = BaseOdometry("odom")
    same(odometry.read(told(base(Pose(900.0, -900.0, 0.0))))[0].value, Pose(900.0, -900.0, 0.0))
    assert odometry.origin_xy == (0.0, 0.0)


@pytest.mark.parametrize(
    ("at", "turn", "why"),
    [((math.nan, 0, 0), UP, "finite"), ((1e9, 0, 0), UP, "finite"),
     ((0, 0, 0), (0, 0, 0, 0), "unit"), ((0, 0, 0), (0, 0, 0, 2.0), "length 2")],
)  # fmt: skip
def test_what_is_no_pose_is_told_of(at: tuple, turn: tuple, why: str):
    with pytest.raises(SensorError, match=f"^odom: .*{why}"):
        BaseOdometry("odom").read(RawMessage(5, odometry_of(at, turn, 5), 1.0))


def test_a_quaternion_that_is_a_little_too_long_is_a_turn_all_the_same():
    half = 0.4
    long = (0.0, 0.0, 1.05 * math.sin(half), 1.05 * math.cos(half))
    got, _ = BaseOdometry("odom").read(RawMessage(5, odometry_of((1, 2, 0), long, 5), 1.0))
    same(got.value, Pose(1.0, 2.0, 0.8))


def test_where_tf_is_late_a_frame_is_where_it_was():
    placed, known = mounted(Mount(0.5, 0.1, 0.3), False), {0}
    odometry = BaseOdometry(
        "odom", False, CAMERA, lambda frame, stamp_ns: placed if stamp_ns in known else None
    )
    pose = Pose(3.0, -1.0, 0.4)
    for stamp_ns in (0, 50_000_000):
        raw = told(base(pose) @ placed, child="camera_link")
        same(odometry.read(replace(raw, stamp_ns=stamp_ns))[0].value, pose)


def test_frames_that_always_are_others_are_told_of_a_few_times_and_in_one_line_each():
    lines: list[str] = []
    odometry = BaseOdometry("odom", False, CAMERA, tell=lines.append)
    for n in range(100):
        odometry.read(told(np.eye(4), child=f"camera_{n}"))
    assert len(lines) == LINES
    for name in ("camera\nrfnav: all is well", "camera" * 1000, "camera\x1b[2J"):
        with pytest.raises(SensorError, match=r"^odom: .* can be printed$") as caught:
            odometry.read(told(np.eye(4), child=name))
        assert len(str(caught.value)) < 200
        assert str(caught.value).isprintable()
