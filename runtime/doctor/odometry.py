"""Odometry as it is told: frames, and whether it goes on without a jump."""

import itertools
import math
from collections.abc import Iterator

from runtime.config import Config
from runtime.core.geometry import wrap_angle
from runtime.doctor.diagnosis import Diagnosis, bad, ok, warning
from runtime.doctor.hearing import HeardPose, Hearing

OF_A_CAMERA = ("optical", "camera", "cam_")


def judge_odometry(hearing: Hearing, config: Config) -> Iterator[Diagnosis]:
    """Frames and continuity."""
    if hearing.odometry:
        yield from _frames(hearing.odometry, bool(config.bus.topics.pose))
        yield _continuity(hearing.odometry, config)


def _frames(poses: list[HeardPose], slam: bool) -> Iterator[Diagnosis]:
    frames = sorted({(pose.frame, pose.child) for pose in poses})
    told = ", ".join(f'"{child or "?"}" in "{frame}"' for frame, child in frames[:3])
    if slam:
        told = ", ".join(f'a pose in "{frame}"' for frame, _ in frames[:3])
    if len(frames) > 1:
        yield bad(
            "odometry frames",
            f"several tell it: {told}",
            "one node alone publishes odometry on a topic: stop the others",
        )
    elif any(word in frames[0][1].lower() for word in OF_A_CAMERA):
        yield ok("odometry frames", f"{told}: the camera's, taken to the base by its mount")
    elif frames[0][0].strip("/") == "map":
        yield warning(
            "odometry frames",
            f"{told}: corrections of a map make it jump (REP 105), and a jump holds the base",
            "use odometry in the frame odom, which drifts but never jumps",
        )
    else:
        yield ok("odometry frames", told)


def _continuity(poses: list[HeardPose], config: Config) -> Diagnosis:
    safety = config.safety
    jumps, back, far_m, far_rad = 0, 0, 0.0, 0.0
    for a, b in itertools.pairwise(poses):
        if b.stamp_ns < a.stamp_ns:
            back += 1
            continue
        moved_m = math.hypot(b.xy[0] - a.xy[0], b.xy[1] - a.xy[1])
        turned_rad = abs(wrap_angle(b.yaw_rad - a.yaw_rad))
        jumps += moved_m > safety.odom_jump_m or turned_rad > safety.odom_jump_rad
        far_m, far_rad = max(far_m, moved_m), max(far_rad, turned_rad)
    most = f"at most {100 * far_m:.1f} cm and {far_rad:.3f} rad from one message to the next"
    if back:
        told = f"its stamps go back {back} times in {len(poses)} messages"
        return bad("odometry goes on", told, "one node alone publishes it, by one clock")
    if jumps:
        return bad(
            "odometry goes on",
            f"{jumps} jumps in {len(poses)} messages, {most}",
            "each holds the base: use odometry that is continuous (REP 105), of one node alone",
        )
    return ok("odometry goes on", f"{most}")
