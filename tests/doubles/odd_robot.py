"""A robot whose camera is on its side, sees its depth from beside, and tells odometry of itself: in
the messages of a RobotDouble."""

import math

import numpy as np
from apartment import INTRINSICS, MOUNT, Apartment
from other_half import camera_info, odometry_of, tf
from robot_double import RobotDouble

from runtime.core.geometry import rays
from runtime.core.types import Intrinsics, Pose
from runtime.robot import wire

BESIDE_M = 0.05  # to the left of the colour camera,
WIDER = Intrinsics(80.0, 80.0, 70.0, 60.0, 140, 120)  # and a wider view, if both were upright
COLOR, DEPTH = "color_optical", "depth_optical"
FAR_XY = 500_000.0, 4_000_000.0  # where odometry begins
LEAN = "camera.roll_rad=1.5708"  # its right side is down


def leaning(camera: Intrinsics) -> tuple[tuple[int, int], tuple[float, float, float, float]]:
    """Size and fx, fy, cx, cy of the same camera when it leans to the right by a quarter turn: what
    was up in its image is to the left."""
    c = camera
    return (c.height, c.width), (c.fy, c.fx, c.cy, c.width - c.cx)


def films(robot: RobotDouble, home: Apartment) -> None:
    """From now on it publishes like that."""

    def filmed(stream: str, payload: bytes) -> bytes:
        if stream == "camera_info":
            robot.session.put("camera/depth/camera_info", camera_info(*leaning(WIDER), frame=DEPTH))
            # Seen from a camera that leans so, what is to the left of it is below.
            robot.session.put("tf_static", tf((COLOR, DEPTH, (0, BESIDE_M, 0), (0, 0, 0, 1))))
            return camera_info(*leaning(INTRINSICS), frame=COLOR)
        stamp_ns = wire.peek_stamp(payload, stream)
        if stream == "color":
            image = np.zeros((INTRINSICS.width, INTRINSICS.height, 3), np.uint8)
            return wire.encode_color(image, stamp_ns, COLOR)
        pose = home.pose
        there = Pose(
            pose.x_m - BESIDE_M * math.sin(pose.yaw_rad),
            pose.y_m + BESIDE_M * math.cos(pose.yaw_rad),
            pose.yaw_rad,
        )
        depth = home.depth(rays(WIDER, MOUNT, 1), there)
        return wire.encode_depth(np.ascontiguousarray(np.rot90(depth)), stamp_ns, DEPTH)

    robot.filmed, robot.telling = filmed, telling


def telling(pose: Pose, stamp_ns: int) -> bytes:
    """The pose of the colour camera, z ahead, x down, y to the left, as odometry far away."""
    half = pose.yaw_rad / 2
    # Of a camera that looks along x, its right side down: a quarter turn about y.
    a, b = (0.0, 0.0, math.sin(half), math.cos(half)), (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))
    turn = (
        a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
        a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
        a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3],
        a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2],
    )
    at = pose.x_m + FAR_XY[0], pose.y_m + FAR_XY[1], MOUNT.z_m
    return odometry_of(at, turn, stamp_ns, COLOR)
