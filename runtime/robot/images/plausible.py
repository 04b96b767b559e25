"""Whether a depth camera's readings are what they are taken for: a wrong unit is told by how far
all is, and by where the floor would lie; a farthest reading that means nothing, by its coming again
wherever the camera looks."""

import math
from collections.abc import Callable
from typing import Final

import numpy as np

from runtime.core.geometry import rays
from runtime.core.types import F32, Intrinsics, Mount
from runtime.errors import SensorError
from runtime.log import say
from runtime.robot.images.camera_images import DepthImage
from runtime.robot.images.reading import MM
from runtime.robot.transforms import CameraConfig

FAR_M: Final = 20.0  # half of an image that is farther is of no room,
NEAR_M: Final = 0.05  # nor is one that is nearer
# Floor so many camera's heights below the camera: more than a storey, for where the camera only
# sees down one.
DEEP: Final = 4.5
SETTLED: Final = 5  # images with floor where it should be, after which the unit is believed
UNITS_M: Final = (1.0, MM, 0.00025, 0.0002, 0.000125, 0.0001)  # that drivers have
VIEWS: Final = 4  # that differ, and end at the very same reading: no wall is everywhere
_ANOTHER: Final = 0.05  # readings that differ by that share, in
_ANOTHER_OF: Final = 0.25  # that share of the image: another view
_CLIPPED: Final = 0.02  # of what is seen, that reads it
_USUAL_M: Final = 2.5  # half of what a camera sees in a home is nearer
_SAMPLES: Final = 80  # across an image
_LEAST: Final = 0.05  # of the image, that says something
_FLAT: Final = 0.1  # of its depth: as level as that is floor


class DepthWatch:
    """Of one camera, for what its configuration leaves open. `tell` is told once."""

    def __init__(self, topic: str, camera: CameraConfig, tell: Callable[[str], None] = say) -> None:
        self._topic, self._tell = topic, tell
        self._plausible = SETTLED if camera.depth_unit_m > 0 else 0
        self._views = VIEWS if camera.depth_nothing_m > 0 else 0  # that end at one reading
        self._most_m, self._last = 0.0, np.zeros((0, 0), np.float32)  # that, and the last view

    def check(self, image: DepthImage, intrinsics: Intrinsics, mount: Mount) -> None:
        """SensorError for depth that cannot be, as long as the unit is not settled."""
        stride = max(1, round(intrinsics.width / _SAMPLES))
        sampled = image.depth_m[stride // 2 :: stride, stride // 2 :: stride]
        seen = sampled > 0
        if seen.sum() < _LEAST * sampled.size:
            return
        if self._plausible < SETTLED:
            up = np.broadcast_to(rays(intrinsics, mount, stride).up, sampled.shape)
            self._check_unit(sampled, -sampled * up, image.unit_m, mount.z_m)
        if self._views < VIEWS:
            self._look_for_clipping(sampled)

    def _look_for_clipping(self, sampled: F32) -> None:
        most_m = float(sampled.max())
        if (sampled == most_m).sum() < _CLIPPED * (sampled > 0).sum():
            return
        before, self._last = self._last, sampled.copy()
        if most_m != self._most_m:
            self._most_m, self._views = most_m, 0
        elif before.shape == sampled.shape:
            apart = np.abs(sampled - before) > _ANOTHER * before
            if apart.mean() < _ANOTHER_OF:
                self._last = before  # the same view again
                return
            self._views += 1
        if self._views == VIEWS:
            what = f"{self._topic}: {most_m:g} m is the farthest that it ever reads, and often"
            remedy = f"if that is where nothing is near, set camera.depth_nothing_m = {most_m:g}"
            self._tell(f"{what}: {remedy}")

    def _check_unit(self, sampled: F32, below: F32, unit_m: float, height_m: float) -> None:
        """`below`: how far below the camera each is, which is so high above the floor, m."""
        seen = sampled > 0
        floor = np.abs(below - height_m) < _FLAT * height_m
        if floor.sum() >= _LEAST * sampled.size:
            self._plausible += 1
            return
        deep_m = _floor(below[seen & (below > DEEP * height_m)], sampled.size)
        if deep_m:
            what = f"the floor is {deep_m:.3g} m below the camera, not {height_m:.3g} m"
            self._refuse(what, unit_m, deep_m / height_m)
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
