"""What odometry tells, as the base's pose in the map frame: whose pose it is, and where its frame
begins."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from runtime.core.geometry import optical_to_base
from runtime.core.types import F64, Mount, Pose
from runtime.errors import SensorError
from runtime.log import say
from runtime.robot import wire
from runtime.robot.bounds import ANYWHERE_M, FARTHEST_M, all_within, check_frame
from runtime.robot.sync import RawMessage
from runtime.robot.transforms import FIXED, CameraConfig
from runtime.robot.wire import Stamped

FAR_M: Final = 1000.0  # from where odometry begins, the map has an origin of its own
LEVEL_RAD: Final = math.radians(20.0)  # a base leans by less,
STEEP_RAD: Final = math.radians(45.0)  # a pose by more that is no base's
LINES: Final = 20  # that are told at most, whatever frames are named
OPTICAL: Final = "optical"  # in the names of frames whose z looks ahead
PUBLISH: Final = "publish the base's pose (x forward, z up)"

Told = tuple[Stamped[Pose], float]  # and how far the base leans, rad
ByTf = Callable[[str, int], F64 | None]  # (4, 4) from a frame to the base's at a stamp


@dataclass(frozen=True)
class Whose:
    """Whose pose odometry tells: the base's, or `placed` (4, 4) from that frame to the base's; and
    whether the frame that it is told in is an optical one."""

    placed: F64 | None
    optical_frame: bool = False


BASE: Final = Whose(None)


class BaseOdometry:
    """Of one topic. `slam`: PoseStamped; `by_tf`: None for a frame that tf does not know."""

    def __init__(
        self,
        topic: str = "odom",
        slam: bool = False,
        camera: CameraConfig = FIXED,
        by_tf: ByTf = lambda frame, stamp_ns: None,
        tell: Callable[[str], None] = say,
    ) -> None:
        self._topic, self._slam, self._camera = topic, slam, camera
        self._by_tf, self._tell = by_tf, tell
        self._kind = wire.POSE_STAMPED if slam else wire.ODOMETRY
        self._optical: bool | None = None  # by its first pose, whatever its frame is called
        self._last: tuple[str, F64 | None] = "", None  # whose frame tf told of, and where it is
        self._told: set[str] = set()
        self.frame = ""  # that it is told in, as it is called
        self.origin_xy: tuple[float, float] | None = None
        """Where the map's origin is in odometry's frame, m; None before the first message."""

    def read(self, raw: RawMessage) -> Told:
        """SensorError for what is no pose."""
        message = wire.decode(raw.payload, self._kind, self._topic)
        placed = message.pose if self._slam else message.pose.pose
        self.frame = check_frame(message.header.frame_id, self._topic).lstrip("/")
        whose = self._whose(message, placed, raw.stamp_ns)
        if whose is BASE:
            x_m, y_m, yaw, tilt = _plain(placed, self._topic)
        else:
            x_m, y_m, yaw, tilt = _of_base(_matrix(placed, self._topic), whose)
        if self.origin_xy is None:
            self.origin_xy = self._begins(x_m, y_m)
        x_m, y_m = x_m - self.origin_xy[0], y_m - self.origin_xy[1]
        if not all_within((-FARTHEST_M, FARTHEST_M), (x_m, y_m)):
            what = f"{self._topic}: position ({x_m:.0f}, {y_m:.0f})"
            raise SensorError(f"{what}: publish finite positions within 100 km of the first")
        return Stamped(raw.stamp_ns, Pose(x_m, y_m, yaw)), tilt

    def _begins(self, x_m: float, y_m: float) -> tuple[float, float]:
        """The map's origin: odometry's own, unless that is so far that millimetres are lost."""
        if max(abs(x_m), abs(y_m)) <= FAR_M:
            return 0.0, 0.0
        origin = float(round(x_m)), float(round(y_m))
        self._say_once(f"begins at ({x_m:.1f}, {y_m:.1f}): poses are told from {origin} on")
        return origin

    def _whose(self, message: Any, placed: Any, stamp_ns: int) -> Whose:
        """By the frames that it names, by tf, and where neither says, by how its first pose leans:
        no base is on its side, and every optical frame is."""
        child = "" if self._slam else check_frame(message.child_frame_id, self._topic).lstrip("/")
        optical_frame = OPTICAL in message.header.frame_id
        if child and child != self._camera.base_frame:
            told = self._placed(child, stamp_ns)
            if told is not None:
                return BASE if _is_base(told) and not optical_frame else Whose(told, optical_frame)
            if OPTICAL in child or "camera" in child:
                self._say_once(f"is of {child}: taken to the base by the camera's mount")
                return Whose(mounted(self._camera, OPTICAL in child), optical_frame)
        if optical_frame:
            return Whose(mounted(self._camera, True), True)
        if self._optical is None:
            self._optical = self._leans_as_a_camera(placed)
        return Whose(mounted(self._camera, True)) if self._optical else BASE

    def _placed(self, child: str, stamp_ns: int) -> F64 | None:
        """By tf, which may come late: then as it was last, for elsewhere would be a jump."""
        told = self._by_tf(child, stamp_ns)
        if told is not None:
            self._last = child, told
        return self._last[1] if self._last[0] == child else None

    def _leans_as_a_camera(self, placed: Any) -> bool:
        matrix = _matrix(placed, self._topic)
        if _tilt(matrix) < STEEP_RAD:
            return False
        *_, tilt = _of_base(matrix, Whose(mounted(self._camera, True)))
        if tilt > LEVEL_RAD:
            lean_deg = math.degrees(_tilt(matrix))
            self._say_once(f"tilted by {lean_deg:.0f} degrees: {PUBLISH}")
            return False
        self._say_once("is an optical frame's pose: taken to the base by the camera's mount")
        return True

    def _say_once(self, what: str) -> None:
        if what not in self._told and len(self._told) < LINES:
            self._told.add(what)
            self._tell(f"{self._topic}: {what}")


def mounted(mount: Mount, optical: bool) -> F64:
    """(4, 4) from the camera to the base: from its optical frame, or from its body's (x ahead)."""
    placed, turn = np.eye(4), optical_to_base(mount)
    placed[:3, :3] = turn if optical else turn @ optical_to_base(Mount(0.0, 0.0, 0.0)).T
    placed[:3, 3] = mount.x_m, mount.y_m, mount.z_m
    return placed


def _plain(placed: Any, topic: str) -> tuple[float, float, float, float]:
    """Of a base's pose: x, y (m), yaw, lean (rad)."""
    at, q = placed.position, placed.orientation
    norm = checked_pose(placed, topic)
    yaw = math.atan2(2 * (q.w * q.z + q.x * q.y), norm * norm - 2 * (q.y * q.y + q.z * q.z))
    # The share of the base's own z axis that still points up.
    up = 1 - 2 * (q.x * q.x + q.y * q.y) / (norm * norm)
    yaw = math.pi if yaw == -math.pi else yaw
    return float(at.x), float(at.y), yaw, math.acos(max(-1.0, min(1.0, up)))


def _of_base(matrix: F64, whose: Whose) -> tuple[float, float, float, float]:
    """The same of the base, by (4, 4) of another frame's pose."""
    base = matrix if whose.placed is None else matrix @ np.linalg.inv(whose.placed)
    if whose.optical_frame:
        base[:3] = optical_to_base(Mount(0.0, 0.0, 0.0)) @ base[:3]
    yaw = math.atan2(base[1, 0], base[0, 0])
    return float(base[0, 3]), float(base[1, 3]), yaw, _tilt(base)


def _tilt(matrix: F64) -> float:
    return math.acos(max(-1.0, min(1.0, float(matrix[2, 2]))))


def _is_base(placed: F64) -> bool:
    """Whether a frame of the robot is the base's, as far as the plane is concerned."""
    flat = abs(placed[2, 2] - 1) < 1e-3 and float(np.hypot(placed[0, 3], placed[1, 3])) < 1e-3
    return bool(flat and abs(math.atan2(placed[1, 0], placed[0, 0])) < 1e-3)


def _matrix(placed: Any, topic: str) -> F64:
    """geometry_msgs/Pose -> (4, 4)."""
    at, q, norm = placed.position, placed.orientation, checked_pose(placed, topic)
    x, y, z, w = q.x / norm, q.y / norm, q.z / norm, q.w / norm
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), at.x],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), at.y],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), at.z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def checked_pose(placed: Any, topic: str) -> float:
    """The length of a geometry_msgs/Pose's quaternion; SensorError for what is no pose."""
    at, q = placed.position, placed.orientation
    norm = math.hypot(q.w, q.x, q.y, q.z)
    if not all_within((-ANYWHERE_M, ANYWHERE_M), (at.x, at.y)) or not abs(norm - 1) <= 0.1:
        raise SensorError(
            f"{topic}: position ({at.x}, {at.y}), quaternion of length {norm:.3g}: "
            "publish finite positions within 100,000 km and unit quaternions"
        )
    return norm
