"""Where the camera is, by the floor that it sees, against where it is configured to be."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from runtime.config import Config
from runtime.core.mapping.floor_plane import CARRIED, floor_seen
from runtime.core.mapping.solid_depth import solid
from runtime.core.types import F32, Intrinsics, Mount
from runtime.doctor.diagnosis import Diagnosis, bad, ok, unknown, warning
from runtime.doctor.hearing import Hearing
from runtime.robot.transforms import TF

SAME_M, SAME_RAD = 0.02, math.radians(1.0)  # as much a map hardly shows
WRONG_M, WRONG_RAD = 0.06, math.radians(3.0)  # a floor that is mapped as obstacle or as drop


def judge_floor(hearing: Hearing, config: Config) -> Iterator[Diagnosis]:
    """The floor's plane against the mount, as it is configured or as tf tells it."""
    camera, by_tf = config.camera, config.camera.mount == "tf"
    mount: Mount = camera
    if by_tf and hearing.mount is not None:
        mount = hearing.mount
        yield ok("mount", f"tf has the camera {_placed(mount)}")
    elif by_tf:
        why = hearing.errors.get(TF, "")
        if why:
            yield bad("mount", why, "publish tf and tf_static (robot_state_publisher)")
        return
    k = hearing.intrinsics
    if k is None or not hearing.depths:
        return
    depths = [depth for depth in hearing.depths if depth.shape == (k.height, k.width)]
    found = [one for depth in depths if (one := seen_mount(depth, k, mount)) is not None]
    if found:
        yield _compared(mount, found, len(depths), by_tf)
    else:
        yield unknown(
            "floor",
            f"no floor is seen within {CARRIED.height_m:g} m and "
            f"{math.degrees(CARRIED.tilt_rad):.0f} degrees of that of a camera {_placed(mount)}",
            "face free floor; or measure the camera's height and tilt anew (camera.z_m, "
            "camera.pitch_rad, camera.roll_rad)",
        )


def seen_mount(depth_m: F32, intrinsics: Intrinsics, nominal: Mount) -> Mount | None:
    """The mount by the floor in one image; None where too little floor is seen near enough to where
    it should be."""
    return floor_seen(solid(depth_m), intrinsics, nominal, CARRIED)


def _compared(camera: Mount, found: list[Mount], looks: int, by_tf: bool) -> Diagnosis:
    z_m, pitch, roll = (
        float(np.median([getattr(one, name) for one in found]))
        for name in ("z_m", "pitch_rad", "roll_rad")
    )
    seen = replace(camera, z_m=z_m, pitch_rad=pitch, roll_rad=roll)
    off_m = abs(z_m - camera.z_m)
    off_rad = max(abs(pitch - camera.pitch_rad), abs(roll - camera.roll_rad))
    told = f"by the floor in {len(found)} of {looks} images the camera is {_placed(seen)}"
    if off_m <= SAME_M and off_rad <= SAME_RAD:
        return ok("floor", told)
    told += f"; {'tf has it' if by_tf else 'it is configured as'} {_placed(camera)}"
    fits: tuple[tuple[str, str], ...] = tuple(
        (f"camera.{name}", f"{there:.{digits}f}")
        for name, there, now, most, digits in (
            ("z_m", z_m, camera.z_m, SAME_M, 3),
            ("pitch_rad", pitch, camera.pitch_rad, SAME_RAD, 4),
            ("roll_rad", roll, camera.roll_rad, SAME_RAD, 4),
        )
        if abs(there - now) > most
    )
    remedy = "set " + ", ".join(f"{key} = {value}" for key, value in fits)
    if by_tf:
        remedy, fits = "mend the camera's joint in the robot's description (URDF)", ()
    if off_m > WRONG_M or off_rad > WRONG_RAD:
        return bad("floor", told, remedy, *fits)
    return warning("floor", told, remedy, *fits)


def _placed(mount: Mount) -> str:
    pitch, roll = (round(math.degrees(a), 1) + 0.0 for a in (mount.pitch_rad, mount.roll_rad))
    return f"{mount.z_m:.3f} m high, pitch {pitch:.1f}, roll {roll:.1f} degrees"
