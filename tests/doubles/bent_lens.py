"""Images as a lens takes them that bends straight lines, and as a pinhole would: made from the
direction of each pixel, by the formulas that the ROS 2 and OpenCV documentation give, undone by
Newton's method and not by OpenCV."""

import math

import numpy as np

from runtime.core.types import F32, F64, U8, Intrinsics


def bend(x: F64, y: F64, model: str, d: tuple[float, ...]) -> tuple[F64, F64]:
    """Where a direction (x right, y down, 1 ahead) is in the normalised image plane."""
    if model == "equidistant":
        r = np.hypot(x, y)
        t = np.arctan(r)
        bent = t * (1 + d[0] * t**2 + d[1] * t**4 + d[2] * t**6 + d[3] * t**8)
        share = np.where(r > 1e-12, bent / np.maximum(r, 1e-12), 1.0)
        return share * x, share * y
    k1, k2, p1, p2, k3, k4, k5, k6 = (*d, 0.0, 0.0, 0.0, 0.0)[:8]
    r2 = x * x + y * y
    radial = (1 + k1 * r2 + k2 * r2**2 + k3 * r2**3) / (1 + k4 * r2 + k5 * r2**2 + k6 * r2**3)
    return (
        x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
        y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
    )


def directions(camera: Intrinsics, model: str = "", d: tuple[float, ...] = ()) -> tuple[F64, F64]:
    """(H, W) each: what the pixels of a camera look at, right and down per metre ahead."""
    u, v = np.meshgrid(np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5)
    wanted = (u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy
    x, y = wanted[0].copy(), wanted[1].copy()
    step = 1e-6
    for _ in range(30 if d else 0):
        at, right, below = (
            bend(x, y, model, d),
            bend(x + step, y, model, d),
            bend(x, y + step, model, d),
        )
        a, c = ((r - p) / step for r, p in zip(right, at, strict=True))
        b, e = ((r - p) / step for r, p in zip(below, at, strict=True))
        off_x, off_y = at[0] - wanted[0], at[1] - wanted[1]
        det = a * e - b * c
        x, y = x - (e * off_x - b * off_y) / det, y - (a * off_y - c * off_x) / det
    return x, y


def painted(x: F64, y: F64) -> U8:
    """(H, W, 3): smooth waves by direction, no two of which look alike nearby."""
    waves = [np.sin(5 * x + 1), np.cos(4 * y), np.sin(3 * (x + y))]
    return np.stack([127.5 + 100 * wave for wave in waves], -1).astype(np.uint8)


def wall(x: F64, y: F64, distance_m: float = 2.0, lean_rad: float = 0.4) -> F32:
    """(H, W) m along the optical axis of a wall that leans away to the right."""
    depth = distance_m / (1 - math.tan(lean_rad) * x)
    return depth.astype(np.float32)
