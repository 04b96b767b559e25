"""Whether the camera is mounted as it is configured, by the floor that it shows while the robot
looks around."""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from runtime.core.geometry import wrap_angle
from runtime.core.mapping.floor_plane import MISTAKEN, Slack, floor_seen
from runtime.core.optics.upright import upright_mount
from runtime.core.types import F32, F64, Intrinsics, Mount

SECTORS: Final = 8  # of a turn: each counts once, for what stands before one may look like a floor
ENOUGH: Final = 3  # of them
AGAIN: Final = 5  # every n-th image counts in a direction that was seen before
AGREED: Final = 2 / 3  # of those, at least, are near their middle:
AGREED_M: Final = 0.03
AGREED_RAD: Final = math.radians(1.0)
# By how much the floor is off, m, that far ahead and to a side: that is what a map suffers from.
AHEAD_M: Final = 4.0
ASIDE_M: Final = 2.0
FITS_M: Final = 0.045  # as good as it can be measured in a home that is furnished
MAPS_M: Final = 0.07  # beyond that floor becomes obstacle, or obstacles floor


@dataclass(frozen=True)
class MountVerdict:
    """`found`: the upright mount that the floor fits to. `fits`: it is as configured; `maps`: near
    enough to it to go on."""

    found: Mount
    fits: bool
    maps: bool

    def in_words(self, configured: Mount, by_tf: bool = False) -> str:
        """With the numbers that would fit. `configured`: the keys, or what tf told."""
        found, high_m = self.found, configured.z_m - self.found.z_m
        where = "high" if high_m > 0 else "low"
        pitch_rad, roll_rad = _off(found, upright_mount(configured))[1:]
        pitch, roll = math.degrees(pitch_rad), math.degrees(roll_rad)
        what = f"the floor appears {abs(high_m):.2f} m {where}, tilted by {pitch:+.1f} and "
        what += f"rolled by {roll:+.1f} degrees"
        roll_rad = wrap_angle(configured.roll_rad + roll_rad)
        if by_tf:
            fit = f"z {found.z_m:.3f} m, pitch {found.pitch_rad:.4f}, roll {roll_rad:.4f} rad"
            return f"tf: {what}; what fits of the camera on the base: {fit}"
        return (
            f"camera: {what}; what fits: camera.z_m = {found.z_m:.3f}, camera.pitch_rad = "
            f"{found.pitch_rad:.4f}, camera.roll_rad = {roll_rad:.4f} (rfnav calibrate)"
        )


class MountCheck:
    """Shown images until there is a verdict that lets the robot go on; and no more after that.
    `carried`: what a mount may be off by that is followed in each image."""

    def __init__(self, carried: Slack | None = None) -> None:
        self._carried = carried
        self._seen: dict[int, F64] = {}  # by sector: off by so much height, pitch, roll
        self._refused = False
        self._shown = 0  # images
        self.done = False

    def look(self, depth_m: F32, intrinsics: Intrinsics, mount: Mount, yaw_rad: float) -> None:
        """(H, W) m, upright, by a mount as configured, when the base was turned like that. Where
        it was turned like that before, few images are looked at; all where what was seen is
        refused: then it may be mended."""
        sector = math.floor(yaw_rad / math.tau * SECTORS) % SECTORS
        self._shown += 1
        if sector in self._seen and self._shown % AGAIN and not self._refused:
            return
        found = floor_seen(depth_m, intrinsics, mount, MISTAKEN)
        if found is None:
            return
        off = _off(found, mount)
        if self._refused and self._within(off, MAPS_M):
            self._seen.clear()
        self._seen[sector] = off

    def verdict(self, mount: Mount) -> MountVerdict | None:
        """None until enough was seen that agrees."""
        self._refused = False
        if len(self._seen) < ENOUGH:
            return None
        seen = np.array([self._seen[sector] for sector in sorted(self._seen)])
        apart = np.abs(seen - np.median(seen, axis=0))
        near = (apart < (AGREED_M, AGREED_RAD, AGREED_RAD)).all(axis=1)
        if near.mean() < AGREED:
            return None
        off = np.median(seen[near], axis=0)
        fits, maps = self._within(off, FITS_M), self._within(off, MAPS_M)
        self.done, self._refused = maps, not maps
        height_m, pitch_rad, roll_rad = (float(v) for v in off)
        found = replace(
            mount,
            z_m=mount.z_m + height_m,
            pitch_rad=mount.pitch_rad + pitch_rad,
            roll_rad=wrap_angle(mount.roll_rad + roll_rad),
        )
        return MountVerdict(found, fits, maps)

    def _within(self, off: F64, most_m: float) -> bool:
        height_m, pitch_rad, roll_rad = (float(v) for v in np.abs(off))
        if self._carried is not None:
            most = self._carried
            return height_m < most.height_m and max(pitch_rad, roll_rad) < most.tilt_rad
        return height_m + AHEAD_M * pitch_rad + ASIDE_M * roll_rad <= most_m


def _off(found: Mount, mount: Mount) -> F64:
    """(3,) by which it is higher, m, and its pitch and roll are more, rad."""
    tilts = found.pitch_rad - mount.pitch_rad, found.roll_rad - mount.roll_rad
    return np.array([found.z_m - mount.z_m, *map(wrap_angle, tilts)])
