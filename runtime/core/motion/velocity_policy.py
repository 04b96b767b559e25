"""The velocity of a differential drive that follows a course."""

import math
from dataclasses import replace
from enum import Enum

import numpy as np

from runtime.core.distances.planner import Field, descend
from runtime.core.distances.terrain import Terrain, clearance_between
from runtime.core.geometry import bearing, wrap_angle
from runtime.core.mapping.grid import FOOTING
from runtime.core.motion.courses import MARGIN_M, STILL, Along, ControlConfig, Course, Spin, Toward
from runtime.core.types import F64, Action, Pose, Twist

HOLD_S = 0.3  # how long a velocity may act before the next: period, sensing and wire
FELT_S = 0.2  # from the floor's end under a sensor to the command that halts: it speaks, and a turn
FRESH_S = 0.4  # age of an image up to which nothing slows: a camera's period, and the map's update
SIDE_ACCEL_MPS2 = 0.3  # slows curves
TIGHT_SHARE = 0.4  # of the speed, where the body barely fits
FULL_SPEED_M = 0.20  # clearance beyond the body from which on nothing slows
LOOK_AHEAD_M = 0.35  # along the descent path
TURN_GAIN = 2.0  # yaw rate per heading error, 1/s
TURN_ON_SPOT_RAD = 0.7  # heading error from which on the robot does not drive
FACING_RAD = 0.1  # heading error at which something counts as faced
CREEP_MPS = 0.05  # speed that is kept up to the very goal
WAYS, STEP_M = 24, 0.15  # headings and length of a step out of a tight spot
SLACK_M = 0.005  # of clearance, that a way along something may lose
_SHARES = (1.0, 0.75, 0.5, 0.25)  # of the wished speed, tried until the way to a halt is clear


def steer(
    course: Course | None,
    pose: Pose,
    now: Twist,
    dt_s: float,
    radius_m: float,
    cfg: ControlConfig,
    age_s: float = 0.0,
    cliffs_watch: bool = False,
) -> Twist:
    """The velocity that follows a course; without one, braking to a halt. `now` is the velocity
    commanded `dt_s` ago, `age_s` how old the image is that the course was made of; `cliffs_watch`:
    sensors at the body's rim hold the base where the floor ends."""
    if isinstance(course, Along):
        return velocity(course, pose, radius_m, cfg, now, dt_s, age_s, cliffs_watch)
    if now.v_mps > CREEP_MPS:  # halt first, along the curve that is known to be clear
        slower = _slewed(now, STILL, dt_s, cfg).v_mps
        return Twist(slower, now.w_radps * slower / now.v_mps)
    turn = 0.0
    if isinstance(course, Spin):
        turn = course.w_radps
    elif isinstance(course, Toward):
        turn = face_rate(pose, course.xy, cfg) or 0.0
    return _slewed(replace(now, v_mps=0.0), Twist(0.0, turn), dt_s, cfg)


def velocity(
    course: Along,
    pose: Pose,
    radius_m: float,
    cfg: ControlConfig,
    now: Twist = STILL,
    dt_s: float = 0.2,
    age_s: float = 0.0,
    cliffs_watch: bool = False,
) -> Twist:
    """The velocity down the field: toward a point ahead on the path, slower in curves, in tight
    places and before the goal, on the spot when the heading is far off. It is never faster than
    lets the robot halt on known free ground if no further command came, the longer ahead the older
    that knowledge is (`age_s`); braking for that is not held back by the slew. Ground is what the
    course's footing calls floor. Over what it calls blind the robot creeps; where `cliffs_watch`,
    it drives over all that is free, but over what it has not seen to be floor no faster than they
    are of use. Where no path leads the robot turns on the spot, to see more."""
    terrain, field = course.terrain, course.field
    path = _path(field, pose)
    if not len(path):
        return _slewed(now, Twist(0.0, cfg.look_radps), dt_s, cfg)
    if field.at(pose.x_m, pose.y_m) <= 0.0:
        return _slewed(now, STILL, dt_s, cfg)
    aim = _ahead(terrain, field, path, pose, radius_m)
    error = wrap_angle(bearing((pose.x_m, pose.y_m), aim) - pose.yaw_rad)
    w = _within(TURN_GAIN * error, cfg.max_turn_radps)
    v = sighted_mps(age_s, cfg) * max(0.0, 1.0 - abs(error) / TURN_ON_SPOT_RAD)
    if abs(w) > 1e-6:
        v = min(v, SIDE_ACCEL_MPS2 / abs(w))
    v *= _ease(terrain, pose, aim, radius_m)
    v = min(v, _before_goal(field, path, pose, cfg))
    wished = _slewed(now, Twist(v, w), dt_s, cfg)
    stale_s, unseen_mps = _stale_s(age_s), within_rim_mps(radius_m, cfg)
    for share in _SHARES:
        twist = Twist(share * wished.v_mps, wished.w_radps)
        if cliffs_watch and twist.v_mps > unseen_mps:
            if _can_halt(course, pose, twist, radius_m, cfg, stale_s, _Ground.SEEN):
                return twist
        elif _can_halt(course, pose, twist, radius_m, cfg, stale_s):
            return twist
    twist = Twist(min(wished.v_mps, unseen_mps if cliffs_watch else CREEP_MPS), wished.w_radps)
    ground = _Ground.ANY if cliffs_watch else _Ground.BLIND
    if course.footing and _can_halt(course, pose, twist, radius_m, cfg, stale_s, ground):
        return twist
    return Twist(0.0, wished.w_radps)


def within_rim_mps(radius_m: float, cfg: ControlConfig) -> float:
    """The speed from which a robot that learns at its rim that the floor ends halts before its feet
    are there: v * FELT_S + v^2 / 2b."""
    brake, way_m = cfg.brake_mps2, (1 - FOOTING) * radius_m
    return brake * (math.sqrt(FELT_S * FELT_S + 2 * way_m / brake) - FELT_S)


def sighted_mps(age_s: float, cfg: ControlConfig) -> float:
    """The speed at which the robot, `age_s` after the image that it drives by, comes to a halt
    within as many metres of it as at full speed by a fresh one: v * (age + HOLD_S) + v^2 / 2b. Full
    speed up to FRESH_S, falling without a step from there."""
    full, brake = cfg.max_speed_mps, cfg.brake_mps2
    if age_s <= FRESH_S:
        return full
    allowed_m = full * (FRESH_S + HOLD_S) + full * full / (2 * brake)
    blind_s = age_s + HOLD_S
    return brake * (math.sqrt(blind_s * blind_s + 2 * allowed_m / brake) - blind_s)


def _stale_s(age_s: float) -> float:
    return max(0.0, age_s - FRESH_S)


def face_rate(pose: Pose, xy: tuple[float, float], cfg: ControlConfig) -> float | None:
    """The yaw rate that turns the robot toward a point; None when it is faced."""
    error = wrap_angle(bearing((pose.x_m, pose.y_m), xy) - pose.yaw_rad)
    if abs(error) <= FACING_RAD:
        return None
    return _within(TURN_GAIN * error, cfg.max_turn_radps)


def nearest_action(twist: Twist) -> Action:
    """The discrete action that a velocity resembles, for logs and counts."""
    if twist.v_mps > 0:
        return Action.MOVE_FORWARD
    return Action.TURN_LEFT if twist.w_radps >= 0 else Action.TURN_RIGHT


def _slewed(now: Twist, wished: Twist, dt_s: float, cfg: ControlConfig) -> Twist:
    """As far from `now` to `wished` as the accelerations and the limits allow."""
    dv = _within(wished.v_mps - now.v_mps, cfg.max_accel_mps2 * dt_s)
    dw = _within(wished.w_radps - now.w_radps, cfg.max_turn_accel_radps2 * dt_s)
    v = min(max(0.0, now.v_mps + dv), cfg.max_speed_mps)
    return Twist(v, _within(now.w_radps + dw, cfg.max_turn_radps))


def _path(field: Field, pose: Pose) -> F64:
    """(N, 2) m down the field from the robot, a little longer than is looked ahead. A robot that
    stands just beside the field's cells starts from the best of those next to it."""
    frame = field.frame
    limit = 2 + math.ceil(2 * LOOK_AHEAD_M / frame.resolution_m)
    path = descend(field, (pose.x_m, pose.y_m), limit)
    if len(path):
        return path
    row, col = frame.cell(pose.x_m, pose.y_m)
    r0, c0 = max(0, row - 3), max(0, col - 3)
    around = field.arrival_m[r0 : max(0, row + 4), c0 : max(0, col + 4)]
    if not around.size or not np.isfinite(around).any():
        return path
    dr, dc = divmod(int(np.argmin(around)), around.shape[1])
    x, y = frame.centres(np.array([r0 + dr, c0 + dc], np.int32))
    return descend(field, (float(x), float(y)), limit)


def _ahead(
    terrain: Terrain, field: Field, path: F64, pose: Pose, radius_m: float
) -> tuple[float, float]:
    """The farthest point of the path within the look-ahead to which the body fits in a straight
    line; corners are not cut. Where the path begins too tight for the body, as it may right at the
    robot, the best of the points around to which it fits."""
    here = pose.xy
    gaps = np.hypot(*(path - here).T)
    resolution = terrain.frame.resolution_m
    near = path[(gaps <= LOOK_AHEAD_M) & (gaps > 0.7 * resolution)]
    aim = near[0] if len(near) else path[-1]
    for point in near[::-1]:
        if _drivable(terrain, _line(here, point, resolution), radius_m):
            aim = point
            break
    else:
        aim = _way_out(terrain, field, here, radius_m, aim)
    return float(aim[0]), float(aim[1])


def _way_out(terrain: Terrain, field: Field, here: F64, radius_m: float, otherwise: F64) -> F64:
    """Of the points a short step away that the body can reach, the one nearest the field's
    sources."""
    best, aim = math.inf, otherwise
    for turn in range(WAYS):  # headings of the map, so that the choice stays while the robot turns
        heading = turn * math.tau / WAYS
        point = here + STEP_M * np.array([math.cos(heading), math.sin(heading)])
        arrival = field.at(float(point[0]), float(point[1]))
        line = _line(here, point, terrain.frame.resolution_m)
        if arrival < best and _drivable(terrain, line, radius_m):
            best, aim = arrival, point
    return aim


def _line(start: F64, end: F64, resolution_m: float) -> F64:
    """(N, 2) points from start to end, two a cell."""
    n = math.ceil(2 * float(np.hypot(*(end - start))) / resolution_m) + 1
    line: F64 = start + np.linspace(0.0, 1.0, n)[:, None] * (end - start)
    return line


def _ease(terrain: Terrain, pose: Pose, aim: tuple[float, float], radius_m: float) -> float:
    """The share of the speed that the clearance here and at the aim allows."""
    spare = math.inf
    for x, y in ((pose.x_m, pose.y_m), aim):
        row, col = terrain.frame.cell(x, y)
        if terrain.frame.contains(row, col):
            spare = min(spare, float(terrain.clearance_m[row, col]) - radius_m - MARGIN_M)
    return TIGHT_SHARE + (1 - TIGHT_SHARE) * min(1.0, max(0.0, spare / FULL_SPEED_M))


def _before_goal(field: Field, path: F64, pose: Pose, cfg: ControlConfig) -> float:
    """The speed from which the robot can brake gently to the field's sources."""
    if field.at(float(path[-1][0]), float(path[-1][1])) > 0.0:
        return math.inf  # the goal is beyond the part of the path that is looked at
    left = float(np.hypot(*np.diff(np.vstack([pose.xy, path[1:]]), axis=0).T).sum())
    return max(CREEP_MPS, math.sqrt(cfg.brake_mps2 * left))


class _Ground(Enum):
    """What the robot may halt on."""

    SEEN = "seen"  # to be floor
    FLOOR = "floor"
    BLIND = "blind"  # or what was never in view, round the start
    ANY = "any"  # that is free


def _can_halt(
    course: Along,
    pose: Pose,
    twist: Twist,
    radius_m: float,
    cfg: ControlConfig,
    stale_s: float,
    ground: _Ground = _Ground.FLOOR,
) -> bool:
    """Whether the robot stays on ground known to be free if it drives so for HOLD_S, and `stale_s`
    more, and then brakes along the same curve; its feet, too, where there is a footing."""
    v, w = twist.v_mps, twist.w_radps
    if v <= 0:
        return True
    terrain, footing = course.terrain, course.footing
    resolution_m = terrain.frame.resolution_m
    length = v * (HOLD_S + stale_s) + v * v / (2 * cfg.brake_mps2)
    if not _drivable(terrain, _curve(pose, w / v, length, resolution_m), radius_m):
        return False
    if footing is None or ground is _Ground.ANY:
        return True
    feet = _curve(pose, w / v, length + FOOTING * radius_m, resolution_m)
    if ground is _Ground.SEEN:
        return footing.was_seen(feet[1:])
    return footing.bears(feet[1:], ground is _Ground.BLIND)


def _curve(pose: Pose, bend_per_m: float, length_m: float, resolution_m: float) -> F64:
    """(N, 2) m points along an arc from the pose, two a cell."""
    n = math.ceil(2 * length_m / resolution_m) + 2
    s = np.linspace(0.0, length_m, n)
    step = np.diff(s, prepend=0.0)
    heading = pose.yaw_rad + s * bend_per_m - step * bend_per_m / 2
    ahead = np.stack([step * np.cos(heading), step * np.sin(heading)], axis=1)
    points: F64 = pose.xy + np.cumsum(ahead, axis=0)
    return points


def _drivable(terrain: Terrain, points_xy: F64, radius_m: float) -> bool:
    """Whether the body keeps its clearance along (N, 2) m points, and its centre known ground.
    Where it stands too close to something already, it must not come closer."""
    cells = terrain.frame.cells(points_xy)
    if ((cells < 1) | (cells >= np.array(terrain.frame.shape) - 1)).any():
        return False
    at = tuple(cells.T)
    roomy = terrain.clearance_m[at] > radius_m + 2 * MARGIN_M + 1e-3  # as the planner asks
    unknown = roomy & ~terrain.traversable[at]  # there is room, and yet it is no way
    if unknown[1:].any() and not unknown[0]:
        return False
    clearance = clearance_between(terrain, points_xy)
    needed = np.minimum(radius_m + MARGIN_M, np.maximum.accumulate(clearance) - SLACK_M)
    return not (clearance < needed)[1:].any()


def _within(value: float, limit: float) -> float:
    return min(limit, max(-limit, value))
