"""What only other people's programs put on the bus, or take from it: CDR made and read by rosbags
alone, without the runtime's own wire."""

import math
from typing import Any

import cv2
import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from runtime.core.types import U8, Pose

STORE = get_typestore(Stores.ROS2_HUMBLE)
STORE.register(
    get_types_from_msg(
        "uint8 BUMP=1\nuint8 CLIFF=2\nstd_msgs/Header header\nuint8 type",
        "irobot_create_msgs/msg/HazardDetection",
    )
)
STORE.register(
    get_types_from_msg(
        "std_msgs/Header header\nHazardDetection[] detections",
        "irobot_create_msgs/msg/HazardDetectionVector",
    )
)
TYPES = STORE.types


def compressed_color(rgb: U8, stamp_ns: int) -> bytes:
    """(H, W, 3) RGB -> CompressedImage (JPEG), as an image_transport sends it."""
    _, data = cv2.imencode(".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR))
    kind = TYPES["sensor_msgs/msg/CompressedImage"]
    return _cdr(kind(_header(stamp_ns, "camera"), "jpeg", data.ravel()))


def slam_pose(pose: Pose, stamp_ns: int) -> bytes:
    """Pose of the base -> PoseStamped, as a SLAM sends it."""
    half = pose.yaw_rad / 2
    there = TYPES["geometry_msgs/msg/Pose"](
        TYPES["geometry_msgs/msg/Point"](float(pose.x_m), float(pose.y_m), 0.0),
        TYPES["geometry_msgs/msg/Quaternion"](0.0, 0.0, math.sin(half), math.cos(half)),
    )
    return _cdr(TYPES["geometry_msgs/msg/PoseStamped"](_header(stamp_ns, "map"), there))


def tf(*told: tuple[str, str, tuple[float, ...], tuple[float, ...]], stamp_ns: int = 0) -> bytes:
    """(parent, child, translation m, quaternion x y z w) each -> TFMessage."""
    vector, turn = TYPES["geometry_msgs/msg/Vector3"], TYPES["geometry_msgs/msg/Quaternion"]
    transforms = [
        TYPES["geometry_msgs/msg/TransformStamped"](
            _header(stamp_ns, parent),
            child,
            TYPES["geometry_msgs/msg/Transform"](vector(*map(float, at)), turn(*map(float, q))),
        )
        for parent, child, at, q in told
    ]
    return _cdr(TYPES["tf2_msgs/msg/TFMessage"](transforms))


def laser_scan(
    ranges: list[float],
    stamp_ns: int,
    first_rad: float = -math.pi,
    step_rad: float = 0.1,
    near_m: float = 0.1,
    far_m: float = 12.0,
    step_s: float = 0.0,
    frame: str = "laser",
) -> bytes:
    """A LaserScan, as a driver sends it."""
    last, none = first_rad + step_rad * max(0, len(ranges) - 1), np.zeros(0, np.float32)
    angles = first_rad, last, step_rad
    told = np.array(ranges, np.float32)
    kind = TYPES["sensor_msgs/msg/LaserScan"]
    return _cdr(kind(_header(stamp_ns, frame), *angles, step_s, 0.1, near_m, far_m, told, none))


def base_pose(payload: bytes) -> Pose:
    """Odometry of a base that is level -> where it is."""
    told: Any = STORE.deserialize_cdr(payload, "nav_msgs/msg/Odometry").pose.pose
    yaw = 2 * math.atan2(told.orientation.z, told.orientation.w)
    return Pose(told.position.x, told.position.y, yaw)


def odometry_of(
    at: tuple[float, float, float],
    quaternion: tuple[float, float, float, float],
    stamp_ns: int,
    child: str = "base_link",
    frame: str = "odom",
) -> bytes:
    """Odometry of any frame of a robot, x y z w."""
    pose = TYPES["geometry_msgs/msg/Pose"](
        TYPES["geometry_msgs/msg/Point"](*map(float, at)),
        TYPES["geometry_msgs/msg/Quaternion"](*map(float, quaternion)),
    )
    vector = TYPES["geometry_msgs/msg/Vector3"]
    still = TYPES["geometry_msgs/msg/Twist"](vector(0.0, 0.0, 0.0), vector(0.0, 0.0, 0.0))
    with_covariance = TYPES["geometry_msgs/msg/PoseWithCovariance"](pose, np.zeros(36))
    moving = TYPES["geometry_msgs/msg/TwistWithCovariance"](still, np.zeros(36))
    kind = TYPES["nav_msgs/msg/Odometry"]
    return _cdr(kind(_header(stamp_ns, frame), child, with_covariance, moving))


def camera_info(
    size: tuple[int, int],
    k: tuple[float, float, float, float],
    distortion: tuple[float, ...] = (),
    model: str = "plumb_bob",
    p: tuple[float, float, float, float] | None = None,
    frame: str = "camera",
    binning: tuple[int, int] = (0, 0),
    roi: tuple[int, int, int, int] = (0, 0, 0, 0),
) -> bytes:
    """CameraInfo of width x height with fx, fy, cx, cy, as a driver sends it. `roi`: x, y, height,
    width."""
    fx, fy, cx, cy = k
    px, py, qx, qy = p or k
    region = TYPES["sensor_msgs/msg/RegionOfInterest"](*roi, False)
    kind = TYPES["sensor_msgs/msg/CameraInfo"]
    return _cdr(
        kind(
            _header(0, frame), size[1], size[0], model, np.array(distortion, float),
            np.array([fx, 0, cx, 0, fy, cy, 0, 0, 1], float), np.eye(3).ravel(),
            np.array([px, 0, qx, 0, 0, py, qy, 0, 0, 0, 1, 0], float), *binning, region,
        )
    )  # fmt: skip


def flag(value: bool) -> bytes:
    """Bool, as a bumper sends it."""
    return _cdr(TYPES["std_msgs/msg/Bool"](value))


def hazards(told: list[tuple[str, int]], stamp_ns: int) -> bytes:
    """(frame, type) each -> HazardDetectionVector, as a Create 3 sends it."""
    one = TYPES["irobot_create_msgs/msg/HazardDetection"]
    found = [one(_header(stamp_ns, frame), kind) for frame, kind in told]
    vector = TYPES["irobot_create_msgs/msg/HazardDetectionVector"]
    return _cdr(vector(_header(stamp_ns, "base_link"), found))


def battery_state(share: float, stamp_ns: int, charging: bool = False) -> bytes:
    """BatteryState of that percentage, its voltage known."""
    none, nan = np.zeros(0, np.float32), math.nan
    values = 14.8, 25.0, -0.5, nan, 2.6, 2.6, share
    kind = TYPES["sensor_msgs/msg/BatteryState"]
    return _cdr(
        kind(_header(stamp_ns, ""), *values, 1 if charging else 2, 1, 2, True, none, none, "", "")
    )


def stamped_twist(payload: bytes) -> tuple[int, float, float]:
    """TwistStamped -> (stamp ns, forward m/s, yaw rate rad/s), as a base reads it."""
    message: Any = STORE.deserialize_cdr(payload, "geometry_msgs/msg/TwistStamped")
    stamp, twist = message.header.stamp, message.twist
    return stamp.sec * 10**9 + stamp.nanosec, twist.linear.x, twist.angular.z


def _header(stamp_ns: int, frame: str) -> Any:
    stamp = TYPES["builtin_interfaces/msg/Time"](*divmod(stamp_ns, 10**9))
    return TYPES["std_msgs/msg/Header"](stamp, frame)


def _cdr(message: Any) -> bytes:
    return bytes(STORE.serialize_cdr(message, message.__msgtype__))
