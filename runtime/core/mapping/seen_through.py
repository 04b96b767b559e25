"""What has gone: a cell whose obstacle is seen through at the heights at which it stood there.

Floor seen in a cell clears it, but not all floor is seen: far off, rays end farther apart than
cells, and close by, a level camera looks over the floor on which somebody stood a moment ago.
What is flat, as a table's top, may lie between those heights: it is looked for all the way up.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from runtime.core.geometry import GridFrame, optical_to_base
from runtime.core.kernels import mapping as kernels
from runtime.core.mapping.windows import Window, between
from runtime.core.types import U8, Mount, Observation

LOWEST_M: Final = 0.07  # a ray that passes so low over a cell shows that floor is there
APART_M: Final = 0.15  # heights at which a cell is looked at; what is less high has only the lowest
MARGIN_M: Final = 0.04  # beyond a cell's middle, what is read there is beyond the cell
SLACK: Final = 0.02  # and so much a metre away, for depth errs
PIXEL_M: Final = 0.0125  # of a pixel's width; from farther off flat things may be thinner


def unlearn(
    evidence: NDArray[np.int16],
    stood: U8,
    frame: GridFrame,
    obs: Observation,
    mount: Mount,
    max_depth_m: float,
    cells_around: int,
    miss: int,
) -> Window | None:
    """Take `miss` from the evidence (R, C) of what an image sees through, in place; `stood` (R, C)
    is kept from image to image. The window of what changed, None for nothing."""
    pose, k = obs.pose, obs.intrinsics
    flat_m = PIXEL_M * min(k.fx, k.fy)
    changed = kernels.see_through(
        evidence, stood, np.ascontiguousarray(obs.depth_m),
        (frame.x0_m, frame.y0_m, frame.resolution_m, cells_around),
        (pose.x_m, pose.y_m, float(np.cos(pose.yaw_rad)), float(np.sin(pose.yaw_rad))),
        (mount.x_m, mount.y_m, mount.z_m, *optical_to_base(mount).ravel().tolist(),
         k.fx, k.fy, k.cx, k.cy),
        kernels.Through(max_depth_m, LOWEST_M, APART_M, MARGIN_M, SLACK, miss, flat_m),
    )  # fmt: skip
    return between(changed) if changed else None
