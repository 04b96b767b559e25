"""Where the camera is, by the floor that it sees, against where it is configured to be."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from runtime.config import Config
from runtime.core.geometry import wrap_angle
from runtime.core.mapping.floor_plane import MISTAKEN, floor_seen
from runtime.core.mapping.mount_check import AHEAD_M, ASIDE_M, FITS_M, MAPS_M
from runtime.core.mapping.solid_depth import solid
from runtime.core.optics.upright import upright_mount
from runtime.core.types import F32, Intrinsics, Mount
from runtime.doctor.diagnosis import Diagnosis, bad, ok, unknown, warning
from runtime.doctor.hearing import Hearing
from runtime.robot.transforms import TF

MEASURED: Final = "; rfnav calibrate measures it for longer"
SAME_M, SAME_RAD = 0.01, math.radians(0.3)  # of one of the three: it need not be set


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
    if found and camera.mount == "floor":
        yield ok("floor", f"seen in {len(found)} of {len(depths)} images, and gone by")
    elif found:
        yield _compared(mount, found, len(depths), by_tf)
    else:
        yield unknown(
            "floor",
            f"no floor is seen within {MISTAKEN.height_m:g} m and {_degrees(MISTAKEN.tilt_rad):g} "
            f"degrees of that of a camera {_placed(mount)}",
            "face free floor; where that is done, measure the camera's height and tilt anew",
        )


def seen_mount(depth_m: F32, intrinsics: Intrinsics, mount: Mount) -> Mount | None:
    """The mount by the floor in one upright image, with the roll that the camera itself has, as
    `mount` has it; None where too little floor is seen near enough to where it should be."""
    upright = upright_mount(mount)
    seen = floor_seen(solid(depth_m), intrinsics, upright, MISTAKEN)
    if seen is None:
        return None
    roll_rad = wrap_angle(mount.roll_rad + wrap_angle(seen.roll_rad - upright.roll_rad))
    return replace(mount, z_m=seen.z_m, pitch_rad=seen.pitch_rad, roll_rad=roll_rad)


def _compared(camera: Mount, found: list[Mount], looks: int, by_tf: bool) -> Diagnosis:
    z_m, pitch = (float(np.median([getattr(m, n) for m in found])) for n in ("z_m", "pitch_rad"))
    off_roll = float(np.median([wrap_angle(m.roll_rad - camera.roll_rad) for m in found]))
    roll = wrap_angle(camera.roll_rad + off_roll)
    seen = replace(camera, z_m=z_m, pitch_rad=pitch, roll_rad=roll)
    off_m, off_pitch = abs(z_m - camera.z_m), abs(pitch - camera.pitch_rad)
    floor_m = off_m + AHEAD_M * off_pitch + ASIDE_M * abs(off_roll)  # ahead and to a side
    told = f"by the floor in {len(found)} of {looks} images the camera is {_placed(seen)}"
    if floor_m <= FITS_M:
        return ok("floor", told)
    told += f"; {'tf has it' if by_tf else 'it is configured as'} {_placed(camera)}"
    fits: tuple[tuple[str, str], ...] = tuple(
        (f"camera.{name}", f"{there:.{digits}f}")
        for name, there, off, most, digits in (
            ("z_m", z_m, off_m, SAME_M, 3),
            ("pitch_rad", pitch, off_pitch, SAME_RAD, 4),
            ("roll_rad", roll, abs(off_roll), SAME_RAD, 4),
        )
        if off > most
    )
    remedy = "set " + ", ".join(f"{key} = {value}" for key, value in fits) + MEASURED
    if by_tf:
        remedy, fits = "mend the camera's joint in the robot's description (URDF)", ()
    if floor_m > MAPS_M:
        return bad("floor", told, remedy, *fits)
    return warning("floor", told, remedy, *fits)


def _placed(mount: Mount) -> str:
    pitch, roll = _degrees(mount.pitch_rad), _degrees(mount.roll_rad)
    return f"{mount.z_m:.3f} m high, pitch {pitch:.1f}, roll {roll:.1f} degrees"


def _degrees(angle_rad: float) -> float:
    return round(math.degrees(angle_rad), 1) + 0.0
