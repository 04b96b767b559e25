"""What others' code costs on the same frames, where somebody has fetched it: nothing of it is here.

VLFM's obstacle map with its frontiers wants its own checkout, that of `frontier_exploration`, and
numba; SemExp's planner its checkout and scikit-image.
"""

import importlib
import math
import sys
from collections.abc import Iterable
from pathlib import Path
from time import thread_time
from typing import Any

import cv2
import numpy as np

from hil_sim.benchmarks.drive import RecordedDrive
from hil_sim.simulation.protocol import HM3D
from runtime.core.world import World
from runtime.errors import ConfigError

VLFM_CELLS = 1000  # its map's side, and
PER_M = 20  # its cells a metre
ROBOT_M = (0.18, 0.15, 0.88)  # radius, and the heights between which something is an obstacle
SEMEXP_RADIUS = 3  # cells by which it widens obstacles
NEAR_M, FAR_M = 0.5, 5.0


def vlfm(checkout: Path, others: Iterable[Path], drive: RecordedDrive) -> list[float]:
    """Seconds of `ObstacleMap.update_map`, a frame each."""
    found = _imported("vlfm.mapping.obstacle_map", [checkout, *others])
    radius, low, high = ROBOT_M
    grid = found.ObstacleMap(low, high, radius, size=VLFM_CELLS, pixels_per_meter=PER_M)
    k, seconds = HM3D.intrinsics, []
    for obs, _ in drive.frames():
        c, s = math.cos(obs.pose.yaw_rad), math.sin(obs.pose.yaw_rad)
        pose = np.array([[c, -s, 0, obs.pose.x_m], [s, c, 0, obs.pose.y_m],
                         [0, 0, 1, HM3D.camera_z_m], [0, 0, 0, 1.0]])  # fmt: skip
        depth = np.clip((obs.depth_m - NEAR_M) / (FAR_M - NEAR_M), 0, 1)
        began_s = thread_time()
        grid.update_map(depth, pose, NEAR_M, FAR_M, k.fx, k.fy, HM3D.hfov_rad)
        seconds.append(thread_time() - began_s)
    return seconds[1:]  # numba compiles in the first


def semexp(checkout: Path, world: World, times: int = 20) -> list[float]:
    """Seconds of a short-term goal on our map: obstacles widened, a fast march, a step."""
    # By the file: the package around it wants torch and a simulator.
    found = _imported("fmm_planner", [checkout / "envs" / "utils"])
    grid, seconds = world.map, []
    size = 2 * SEMEXP_RADIUS + 1
    for _ in range(times):
        began_s = thread_time()
        wide = cv2.dilate(grid.occupied.astype(np.uint8), np.ones((size, size), np.uint8))
        planner, goal = found.FMMPlanner(1.0 - wide), np.zeros(grid.frame.shape)
        row, col = grid.frame.cell(world.pose.x_m, world.pose.y_m)
        goal[row + 10, col + 10] = 1
        planner.set_multi_goal(goal)
        planner.get_short_term_goal([float(row), float(col)])
        seconds.append(thread_time() - began_s)
    return seconds


def _imported(module: str, paths: Iterable[Path]) -> Any:
    for path in paths:
        if not path.is_dir():
            raise ConfigError(f"{path}: no such folder; name a checkout")
        sys.path.insert(0, str(path))
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ConfigError(
            f"{module}: cannot be imported ({error}); install what it needs"
        ) from error
