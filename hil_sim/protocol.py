"""Benchmark protocols: what the robot can do and sense, and what counts as success.

`hm3d` is HM3D ObjectNav 2022 (habitat-challenge): STOP within 0.1 m, geodesic, of a place that is
within 1.0 m of the object and sees it.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from runtime.core.types import Intrinsics
from runtime.errors import ConfigError


@dataclass(frozen=True)
class Ending:
    """How an episode ended, for a protocol's success rule."""

    stopped: bool  # the robot itself said stop
    distance_m: float  # geodesic, to the nearest success position; inf when cut off


@dataclass(frozen=True)
class Protocol:
    """One benchmark's robot, camera and rule."""

    name: str
    success: Callable[[Ending], bool]
    max_steps: int = 500
    step_m: float = 0.25
    turn_rad: float = math.radians(30)
    width: int = 640
    height: int = 480
    hfov_rad: float = math.radians(79)
    camera_z_m: float = 0.88
    depth_min_m: float = 0.0
    depth_max_m: float = math.inf

    @property
    def intrinsics(self) -> Intrinsics:
        """Square pixels, principal point in the middle."""
        focal = self.width / 2 / math.tan(self.hfov_rad / 2)
        return Intrinsics(focal, focal, self.width / 2, self.height / 2, self.width, self.height)

    def sensed(self, depth_m: NDArray[np.float32]) -> NDArray[np.float32]:
        """(H, W) true depth, m -> what the sensor reads; 0 outside its range."""
        inside = (depth_m >= self.depth_min_m) & (depth_m <= self.depth_max_m)
        return np.where(inside, depth_m, np.float32(0))


SUCCESS_M = 0.1

HM3D = Protocol(
    name="hm3d",
    success=lambda end: end.stopped and end.distance_m <= SUCCESS_M,
    depth_min_m=0.5,
    depth_max_m=5.0,
)
PROTOCOLS = {protocol.name: protocol for protocol in (HM3D,)}


def protocol_named(name: str) -> Protocol:
    """A protocol by name; ConfigError lists the known ones."""
    if name not in PROTOCOLS:
        raise ConfigError(f"protocol {name}: unknown; known: {', '.join(sorted(PROTOCOLS))}")
    return PROTOCOLS[name]
