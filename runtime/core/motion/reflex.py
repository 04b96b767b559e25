"""How fast the robot may go by what its newest depth image shows in the way that it is about to
sweep. It knows no map and waits for no evidence: what has just stepped in front is braked for."""

import math
from typing import Final

import numpy as np

from runtime.core.mapping.grid import FOOTING
from runtime.core.mapping.near_memory import Nearby
from runtime.core.mapping.near_points import AHEAD_M
from runtime.core.motion.caution import FREE, Caution
from runtime.core.motion.safety import HaltKind
from runtime.core.motion.velocity_policy import CREEP_MPS, FRESH_S, HOLD_S
from runtime.core.types import F64, Pose, Twist

INSIDE_M: Final = 0.03  # of the body's rim, by which depth, pose and the map's cells may be off:
BESIDE_M: Final = 0.01  # what is so near to the way is passed at a creep, what is on it never
REST_M: Final = INSIDE_M + BESIDE_M  # kept to what is on the way: a centimetre from the rim
PASSED_M: Final = 0.2  # from touching to being stopped, and of an arc's radius: what has less of
# either is driven at on a slant, or turned against, and not passed by
TOLD_S: Final = 0.1  # from what the odometry told to a base that brakes
STILL_MPS: Final = 0.02  # a robot that may go no faster stands


def cautioned(
    wished: Twist, pose: Pose, near: Nearby, radius_m: float, brake_mps2: float
) -> Caution:
    """How much slower than wished, for the body of that radius, lets it halt before whatever is on
    the arc that it is about to sweep: v * HOLD_S + v^2 / 2b; zero where only that still does. Only
    driving forward is held; turning on the spot sweeps nothing, and is how a robot gets away."""
    if wished.v_mps <= 0:
        return FREE
    bend = wished.w_radps / wished.v_mps
    obstacles, drops = _in_base(near.obstacles, pose), _in_base(near.drops, pose)
    rim_m = free_way_m(obstacles, bend, radius_m + BESIDE_M)
    way_m = free_way_m(obstacles, bend, radius_m - INSIDE_M)
    # On a slant the body's side touches first, long before its middle is stopped.
    passed = way_m > rim_m + PASSED_M and abs(bend) * PASSED_M <= 1
    way_m = way_m - REST_M if passed else rim_m
    floor_m = free_way_m(drops, bend, FOOTING * radius_m) - REST_M
    kind = HaltKind.OBSTACLE if way_m <= floor_m else HaltKind.FLOOR
    sure = halting_mps(min(way_m, floor_m), brake_mps2)
    beside = max(CREEP_MPS, halting_mps(rim_m, brake_mps2)) if passed else math.inf
    most = min(sure, beside)
    if stopping_m(wished.v_mps, brake_mps2) > min(way_m, floor_m):
        most = 0.0  # slowing is not enough any more
    if wished.v_mps <= most:
        return FREE
    if kind is HaltKind.FLOOR and most <= sure <= beside:
        reason = f"no floor {max(0.0, floor_m + REST_M):.2f} m ahead"
    else:
        at_m = rim_m + BESIDE_M if rim_m > 0 else 0.0
        kind, reason = HaltKind.OBSTACLE, f"something {at_m:.2f} m ahead"
    return Caution(kind, reason, most if most >= STILL_MPS else 0.0)


def free_way_m(points: F64, bend_per_m: float, radius_m: float) -> float:
    """How far the middle of a disc goes along an arc, from the origin ahead, until it touches one
    of the points (N, 2) m, x ahead and y to the left; inf where it does not within one turn. What
    it touches already counts only if the way leads on into it, as 0."""
    if not len(points):
        return math.inf
    x, y = points[:, 0], points[:, 1]
    touching = x * x + y * y < radius_m * radius_m
    if (touching & (x > 0)).any():
        return 0.0
    if abs(bend_per_m) < 1e-3:
        met = (np.abs(y) < radius_m) & (x > 0)
        ways = x[met] - np.sqrt(radius_m**2 - y[met] ** 2)
        return float(ways.min(initial=math.inf))
    turn = 1 / abs(bend_per_m)  # of the arc, radius, around (0, turn) once it bends to the left
    y = math.copysign(1.0, bend_per_m) * y - turn
    away = np.hypot(x, y)
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = (turn * turn + away * away - radius_m * radius_m) / (2 * turn * away)
    met = (np.abs(cosine) < 1) & ~touching
    along = np.remainder(np.arctan2(y[met], x[met]) + math.pi / 2, math.tau)
    ways = turn * (along - np.arccos(cosine[met]))
    return max(0.0, float(ways.min(initial=math.inf)))


def halting_mps(way_m: float, brake_mps2: float) -> float:
    """The speed from which the robot halts within so much: v * HOLD_S + v^2 / 2b = way."""
    if not math.isfinite(way_m):
        return math.inf
    return brake_mps2 * (math.sqrt(HOLD_S * HOLD_S + 2 * max(0.0, way_m) / brake_mps2) - HOLD_S)


def stopping_m(v_mps: float, brake_mps2: float) -> float:
    """The way to a halt of a robot that is told zero at once."""
    return v_mps * TOLD_S + v_mps * v_mps / (2 * brake_mps2)


def sure_mps(radius_m: float, brake_mps2: float, max_depth_m: float) -> float:
    """The fastest that a robot halts from before whatever comes into what it watches, m from its
    middle: by an image of the age up to which nothing slows, v * (FRESH_S + HOLD_S) + v^2 / 2b."""
    blind_s, way_m = FRESH_S + HOLD_S, min(AHEAD_M, max_depth_m) - radius_m - REST_M
    return brake_mps2 * (math.sqrt(blind_s * blind_s + 2 * max(0.0, way_m) / brake_mps2) - blind_s)


def _in_base(points: np.ndarray[tuple[int, int], np.dtype[np.float32]], pose: Pose) -> F64:
    """(N, 2) m, map frame -> x ahead, y to the left."""
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    x, y = points[:, 0] - pose.x_m, points[:, 1] - pose.y_m
    return np.stack([c * x + s * y, c * y - s * x], axis=1).astype(np.float64)
