"""Keyframes: which of the images seen so far looks toward a frontier best."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from runtime.core.geometry import wrap_angle
from runtime.core.map import NavigationMap
from runtime.core.types import F32, Pose


@dataclass(frozen=True)
class KeyframeConfig:
    """[keyframes]"""

    kept: int = 200  # the oldest are forgotten
    moved_m: float = 0.3  # from every other, to be worth keeping
    turned_rad: float = math.radians(25.0)
    range_m: tuple[float, float] = (0.4, 5.0)  # to the frontier it shows
    half_view_rad: float = math.radians(32.0)  # the frontier is well inside the image


@dataclass(frozen=True)
class Keyframe:
    """An image's embedding (D,) and where it was taken, map frame."""

    pose: Pose
    embedding: F32


def keep(frames: list[Keyframe], frame: Keyframe, cfg: KeyframeConfig) -> None:
    """Add a keyframe, in place of one from nearly the same pose if there is one."""
    same = [f for f in frames if _alike(f.pose, frame.pose, cfg)]
    for old in same:
        frames.remove(old)
    frames.append(frame)
    del frames[: -cfg.kept]


def best_view(
    frames: Sequence[Keyframe],
    xy: tuple[float, float],
    grid: NavigationMap,
    cfg: KeyframeConfig,
) -> F32:
    """(D,) of the nearest keyframe that has the point in view with nothing known in between; (0,)
    when none has."""
    ranked = sorted((gap, n) for n, f in enumerate(frames) if (gap := _gap(f.pose, xy, cfg)))
    for _, n in ranked:
        if _clear(grid, frames[n].pose, xy):
            return frames[n].embedding
    return np.zeros(0, np.float32)


def _gap(pose: Pose, xy: tuple[float, float], cfg: KeyframeConfig) -> float:
    """Metres to a point in view, lengthened when it is far from the middle; 0 when out of view."""
    dx, dy = xy[0] - pose.x_m, xy[1] - pose.y_m
    gap = math.hypot(dx, dy)
    off = abs(wrap_angle(math.atan2(dy, dx) - pose.yaw_rad))
    if off > cfg.half_view_rad or not cfg.range_m[0] <= gap <= cfg.range_m[1]:
        return 0.0
    return gap * (1.0 + off / cfg.half_view_rad)


def _clear(grid: NavigationMap, pose: Pose, xy: tuple[float, float]) -> bool:
    steps = max(2, math.ceil(math.dist(pose.xy, xy) / grid.frame.resolution_m))
    line = np.linspace(pose.xy, np.array(xy), steps)
    rows, cols = grid.frame.cells(line).T
    return not bool(grid.occupied[rows, cols].any())


def _alike(a: Pose, b: Pose, cfg: KeyframeConfig) -> bool:
    moved = math.hypot(a.x_m - b.x_m, a.y_m - b.y_m)
    return moved < cfg.moved_m and abs(wrap_angle(a.yaw_rad - b.yaw_rad)) < cfg.turned_rad
