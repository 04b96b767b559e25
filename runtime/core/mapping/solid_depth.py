"""Depth without flying pixels: where a pixel sees the edge of one thing and what is behind it, many
cameras read something between the two, in mid-air."""

from typing import Final

from runtime.core.kernels import mapping as kernels
from runtime.core.types import F32

JUMP_PER_M: Final = 0.02  # of inverse depth: more than noise explains; 2 cm at 1 m, 18 cm at 3 m
SAME_PER_M: Final = 0.005  # less than that from one pixel to the next: a surface, however narrow
_UNITS: Final = 1600  # of inverse depth to 1/m, so that it fits 16 bits
_NEAREST_M: Final = 0.2  # what is nearer counts as there


def solid(depth_m: F32) -> F32:
    """(H, W) m along the optical axis, 0 or NaN where unknown -> a copy, 0 where a pixel flies.

    It does when it lies between what is to either side of it, far from both, with none like it
    next to it, and goes on to neither side as a plane would, whose inverse depth is linear in the
    image. What is nearer than both sides, such as a chair's leg, is left. Unknown counts as far.
    """
    jump, same = round(JUMP_PER_M * _UNITS), round(SAME_PER_M * _UNITS)
    return kernels.solid(depth_m, _UNITS, _NEAREST_M, jump, same)
