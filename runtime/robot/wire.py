"""Bytes <-> values: ROS 2 messages in CDR, as `zenoh-bridge-ros2dds` and `rmw_zenoh` carry them;
images are read in `images/`.

Decoders take the topic's name only to put it into errors; whatever bytes come, nothing but
SensorError leaves this module. Stamps are int nanoseconds, lengths metres, angles radians.
"""

import json
import math
import struct
from dataclasses import dataclass
from typing import Any, Final, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_typestore

from runtime.core.types import F32, F64, U8, Intrinsics, Pose
from runtime.errors import SensorError
from runtime.robot.bounds import ANYWHERE_M, check_camera, check_frame
from runtime.robot.json_text import parse_json

STORE: Final = get_typestore(Stores.ROS2_HUMBLE)
_T: Final = STORE.types

IMAGE: Final = "sensor_msgs/msg/Image"
COMPRESSED_IMAGE: Final = "sensor_msgs/msg/CompressedImage"
CAMERA_INFO: Final = "sensor_msgs/msg/CameraInfo"
ODOMETRY: Final = "nav_msgs/msg/Odometry"
POSE_STAMPED: Final = "geometry_msgs/msg/PoseStamped"
STRING: Final = "std_msgs/msg/String"
TWIST: Final = "geometry_msgs/msg/Twist"
TWIST_STAMPED: Final = "geometry_msgs/msg/TwistStamped"
TF_MESSAGE: Final = "tf2_msgs/msg/TFMessage"

# What the CDR code raises on damaged bytes, besides its own errors.
_DAMAGED: Final = (SerdeError, struct.error, ValueError, IndexError, OverflowError, AssertionError)

V = TypeVar("V")


@dataclass(frozen=True)
class Stamped(Generic[V]):
    """A value and the moment it was true."""

    stamp_ns: int
    value: V


@dataclass(frozen=True)
class FrameTransform:
    """A frame seen from its parent: translation (3,) m, quaternion (4,) x, y, z, w of length 1."""

    parent: str
    child: str
    stamp_ns: int
    translation_m: F64
    quaternion: F64


def peek_stamp(payload: bytes, topic: str) -> int:
    """The stamp of any message that starts with a std_msgs/Header, without decoding the rest."""
    if len(payload) < 12 or payload[0] != 0 or payload[1] > 1:
        raise SensorError(f"{topic}: {len(payload)} bytes are not a stamped CDR message")
    sec, nanosec = struct.unpack_from("<iI" if payload[1] else ">iI", payload, 4)
    return _stamp_ns(sec, nanosec, topic)


# -- decoding ------------------------------------------------------------------------------------


def decode_camera_info(payload: bytes, topic: str) -> Stamped[Intrinsics]:
    """CameraInfo -> Intrinsics of the image as published."""
    message = decode(payload, CAMERA_INFO, topic)
    k = [float(x) for x in message.k]
    if k[0] == 0 and k[4] == 0:  # REP 104: how an uncalibrated camera says so
        raise SensorError(f"{topic}: K is zero: camera without intrinsics; publish calibrated K")
    fx, skew, cx, _, fy, cy = k[:6]
    if not all(map(math.isfinite, k)) or fx <= 0 or fy <= 0 or skew != 0:
        raise SensorError(f"{topic}: K = {k} is not a pinhole matrix [fx 0 cx, 0 fy cy, 0 0 1]")
    intrinsics = published(message, fx, fy, cx, cy)
    check_camera(intrinsics, topic)
    return Stamped(header_stamp(message, topic), intrinsics)


def published(message: Any, fx: float, fy: float, cx: float, cy: float) -> Intrinsics:
    """A CameraInfo's K or P, px of the whole image that was calibrated -> of what is sent of that:
    a region of interest, with so many pixels in one (sensor_msgs/CameraInfo: binning, roi)."""
    roi, across, down = message.roi, max(1, message.binning_x), max(1, message.binning_y)
    width, height, x, y = message.width, message.height, 0, 0
    if roi.width > 0 and roi.height > 0:
        width, height, x, y = roi.width, roi.height, roi.x_offset, roi.y_offset
    size = int(width) // int(across), int(height) // int(down)
    middle = (cx - x) / across, (cy - y) / down
    return Intrinsics(fx / across, fy / down, *middle, *size)


def decode_transforms(payload: bytes, topic: str) -> list[FrameTransform | SensorError]:
    """TFMessage -> its transforms, or what is wrong with one; names without old ones' slash."""
    found: list[FrameTransform | SensorError] = []
    for one in decode(payload, TF_MESSAGE, topic).transforms:
        at, q = one.transform.translation, one.transform.rotation
        moved, turn = np.array([at.x, at.y, at.z]), np.array([q.x, q.y, q.z, q.w])
        try:
            names = [check_frame(n, topic) for n in (one.header.frame_id, one.child_frame_id)]
        except SensorError as error:
            found.append(error)
            continue
        parent, child = (name.lstrip("/") for name in names)
        norm = math.hypot(*turn)
        if not (np.abs(moved) <= ANYWHERE_M).all() or not abs(norm - 1) <= 0.1:
            what = f"{topic}: {child} at {moved.tolist()}, quaternion of length {norm:.3g}"
            found.append(SensorError(f"{what}: publish finite positions and unit quaternions"))
            continue
        found.append(FrameTransform(parent, child, header_stamp(one, topic), moved, turn / norm))
    return found


def decode_json(payload: bytes, topic: str) -> dict[str, Any]:
    """String that holds a JSON object -> dict."""
    return parse_json(decode(payload, STRING, topic).data, topic)


def decode_twist(payload: bytes, topic: str) -> tuple[float, float]:
    """Twist -> (forward m/s, yaw rate rad/s)."""
    message = decode(payload, TWIST, topic)
    forward, turn = float(message.linear.x), float(message.angular.z)
    if not (math.isfinite(forward) and math.isfinite(turn)):
        raise SensorError(f"{topic}: velocity ({forward}, {turn}) is not finite")
    return forward, turn


# -- encoding ------------------------------------------------------------------------------------


def encode_color(rgb: U8, stamp_ns: int, frame: str = "camera", encoding: str = "rgb8") -> bytes:
    """(H, W, 3) RGB -> Image, as rgb8 or bgr8."""
    pixels = rgb if encoding == "rgb8" else rgb[:, :, ::-1]
    return _encode_image(pixels, stamp_ns, frame, encoding)


def encode_depth(
    depth_m: F32, stamp_ns: int, frame: str = "camera", encoding: str = "32FC1"
) -> bytes:
    """(H, W) m -> Image, as 32FC1 (m) or 16UC1 (mm, 0 where invalid or beyond 65.5 m)."""
    if encoding == "32FC1":
        return _encode_image(np.asarray(depth_m, "<f4"), stamp_ns, frame, encoding)
    mm = np.nan_to_num(np.round(depth_m * 1000.0), nan=0, posinf=0, neginf=0)
    mm = np.where((mm < 0) | (mm >= 65535), 0, mm)
    return _encode_image(mm.astype("<u2"), stamp_ns, frame, encoding)


def encode_camera_info(intrinsics: Intrinsics, stamp_ns: int, frame: str = "camera") -> bytes:
    """Intrinsics -> CameraInfo without distortion."""
    i = intrinsics
    k = np.array([i.fx, 0, i.cx, 0, i.fy, i.cy, 0, 0, 1], float)
    p = np.array([i.fx, 0, i.cx, 0, 0, i.fy, i.cy, 0, 0, 0, 1, 0], float)
    region = _T["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)
    return encode(
        _T[CAMERA_INFO](
            header=header(stamp_ns, frame),
            height=i.height,
            width=i.width,
            distortion_model="plumb_bob",
            d=np.zeros(5),
            k=k,
            r=np.eye(3).ravel(),
            p=p,
            binning_x=0,
            binning_y=0,
            roi=region,
        )
    )


def encode_odometry(
    pose: Pose, stamp_ns: int, frame: str = "odom", child_frame: str = "base_link"
) -> bytes:
    """Pose of the base -> Odometry with zero velocity and covariance."""
    with_covariance = _T["geometry_msgs/msg/PoseWithCovariance"](ros_pose(pose), np.zeros(36))
    still = _T["geometry_msgs/msg/TwistWithCovariance"](_ros_twist(0.0, 0.0), np.zeros(36))
    return encode(_T[ODOMETRY](header(stamp_ns, frame), child_frame, with_covariance, still))


def encode_json(value: object) -> bytes:
    """A JSON-able value -> String."""
    return encode(_T[STRING](json.dumps(value, allow_nan=False)))


def encode_twist(forward_mps: float, turn_radps: float) -> bytes:
    """Forward speed and yaw rate of the base -> Twist."""
    return encode(_ros_twist(forward_mps, turn_radps))


def encode_twist_stamped(
    forward_mps: float, turn_radps: float, stamp_ns: int, frame: str = "base_link"
) -> bytes:
    """Forward speed and yaw rate of the base -> TwistStamped."""
    twist = _ros_twist(forward_mps, turn_radps)
    return encode(_T[TWIST_STAMPED](header(stamp_ns, frame), twist))


# -- CDR -----------------------------------------------------------------------------------------


def decode(payload: bytes, kind: str, topic: str) -> Any:
    """CDR -> a message of one of `STORE`'s types."""
    try:
        return STORE.deserialize_cdr(payload, kind)
    except _DAMAGED as error:
        raise SensorError(f"{topic}: {len(payload)} bytes are not a CDR {kind}") from error


def encode(message: Any) -> bytes:
    """A message made of `STORE`'s types -> CDR."""
    return bytes(STORE.serialize_cdr(message, message.__msgtype__))


def _encode_image(pixels: NDArray[Any], stamp_ns: int, frame: str, encoding: str) -> bytes:
    height, width = pixels.shape[:2]
    data = np.ascontiguousarray(pixels).view(np.uint8).ravel()
    step = data.size // height
    return encode(_T[IMAGE](header(stamp_ns, frame), height, width, encoding, 0, step, data))


def header(stamp_ns: int, frame: str) -> Any:
    """A std_msgs/Header."""
    sec, nanosec = divmod(stamp_ns, 1_000_000_000)
    return _T["std_msgs/msg/Header"](_T["builtin_interfaces/msg/Time"](sec, nanosec), frame)


def header_stamp(message: Any, topic: str) -> int:
    """The stamp of a message with a header."""
    return _stamp_ns(message.header.stamp.sec, message.header.stamp.nanosec, topic)


def _stamp_ns(sec: int, nanosec: int, topic: str) -> int:
    if sec < 0 or nanosec >= 1_000_000_000:
        raise SensorError(f"{topic}: header.stamp {sec} s + {nanosec} ns is not a time")
    return int(sec) * 1_000_000_000 + int(nanosec)


def ros_pose(pose: Pose) -> Any:
    """A geometry_msgs/Pose."""
    half = pose.yaw_rad / 2
    return _T["geometry_msgs/msg/Pose"](
        _T["geometry_msgs/msg/Point"](float(pose.x_m), float(pose.y_m), 0.0),
        _T["geometry_msgs/msg/Quaternion"](0.0, 0.0, math.sin(half), math.cos(half)),
    )


def _ros_twist(forward_mps: float, turn_radps: float) -> Any:
    vector = _T["geometry_msgs/msg/Vector3"]
    return _T[TWIST](vector(float(forward_mps), 0.0, 0.0), vector(0.0, 0.0, float(turn_radps)))
