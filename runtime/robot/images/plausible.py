"""Whether a depth camera's unit is what it is taken for: a wrong one is told by how far all is, and
by where the floor would lie."""

import math
from typing import Final

import numpy as np

from runtime.core.geometry import rays
from runtime.core.types import F32, Intrinsics, Mount
from runtime.errors import SensorError
from runtime.robot.images.reading import MM

FAR_M: Final = 20.0  # half of an image that is farther is of no room,
NEAR_M: Final = 0.05  # nor is one that is nearer
# Floor so many camera's heights below the camera: more than a storey, for where the camera only
# sees down one.
DEEP: Final = 4.5
SETTLED: Final = 5  # images with floor where it should be, after which the unit is believed
UNITS_M: Final = (1.0, MM, 0.00025, 0.0002, 0.000125, 0.0001)  # that drivers have
_USUAL_M: Final = 2.5  # half of what a camera sees in a home is nearer
_SAMPLES: Final = 80  # across an image
_LEAST: Final = 0.05  # of the image, that says something
_FLAT: Final = 0.1  # of its depth: as level as that is floor


class UnitWatch:
    """Of one camera. `unit_m` in what it is told: of one step, as it is taken."""

    def __init__(self, topic: str) -> None:
        self._topic, self._plausible = topic, 0

    def check(self, depth_m: F32, unit_m: float, intrinsics: Intrinsics, mount: Mount) -> None:
        """SensorError for (H, W) m that cannot be, as long as the unit is not settled."""
        if self._plausible >= SETTLED:
            return
        stride = max(1, round(intrinsics.width / _SAMPLES))
        table = rays(intrinsics, mount, stride)
        sampled = depth_m[stride // 2 :: stride, stride // 2 :: stride]
        seen = sampled > 0
        if seen.sum() < _LEAST * sampled.size:
            return
        below = -sampled * np.broadcast_to(table.up, sampled.shape)
        floor = np.abs(below - mount.z_m) < _FLAT * mount.z_m
        if floor.sum() >= _LEAST * sampled.size:
            self._plausible += 1
            return
        deep_m = _floor(below[seen & (below > DEEP * mount.z_m)], sampled.size)
        if deep_m:
            what = f"the floor is {deep_m:.3g} m below the camera, not {mount.z_m:.3g} m"
            self._refuse(what, unit_m, deep_m / mount.z_m)
        half_m = float(np.median(sampled[seen]))
        if not NEAR_M <= half_m <= FAR_M:
            what = f"half of it is {'farther' if half_m > FAR_M else 'nearer'} than {half_m:.3g} m"
            self._refuse(what, unit_m, half_m / _USUAL_M)

    def _refuse(self, what: str, unit_m: float, times: float) -> None:
        meant_m = min(UNITS_M, key=lambda unit: abs(math.log(unit * times / unit_m)))
        if meant_m == unit_m:
            remedy = f"set camera.depth_unit_m to what it is, {unit_m:g} m if that is right"
        else:
            remedy = f"if it is {meant_m:g} m, set camera.depth_unit_m = {meant_m:g}"
        raise SensorError(f"{self._topic}: {what}, where one step is {unit_m:g} m: {remedy}")


def _floor(below_m: F32, pixels: int) -> float:
    """How far below the camera most of what is so deep lies, where it is level; 0: it is not."""
    if below_m.size < _LEAST * pixels:
        return 0.0
    floor_m = float(np.percentile(below_m, 80))
    level = np.abs(below_m - floor_m) < _FLAT * floor_m
    return floor_m if level.mean() > 0.4 else 0.0
