"""The local policy: what the base does to follow an arrival field. A discrete action of the
benchmark protocols, or a velocity for a differential drive."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from runtime.core.distances.planner import Field, Terrain, descend
from runtime.core.geometry import bearing, wrap_angle
from runtime.core.types import F64, Action, Mask, Pose, Twist

STILL = Twist()
WAYS, STEP_M = 24, 0.15  # headings and length of a step out of a tight spot
SLACK_M = 0.005  # of clearance, that a way along something may lose
_SHARES = (1.0, 0.75, 0.5, 0.25)  # of the wished speed, tried until the way to a halt is clear


@dataclass(frozen=True)
class ControlConfig:
    """[control]. `mode`: one action an observation, or velocities that are followed between
    them."""

    mode: Literal["discrete", "velocity"] = "discrete"
    forward_m: float = 0.25
    turn_rad: float = math.radians(30.0)
    turn_cost_m: float = 0.04  # what a turn must win in arrival time; keeps headings steady
    margin_m: float = 0.01  # added to the body's radius along a step
    samples: int = 5  # points checked along a step
    max_speed_mps: float = 0.4
    max_turn_radps: float = 1.0
    max_accel_mps2: float = 0.5
    max_turn_accel_radps2: float = 3.0
    brake_mps2: float = 0.5  # what the base can surely brake with
    hold_s: float = 0.3  # how long a velocity may act before the next: period, sensing and wire
    side_accel_mps2: float = 0.3  # slows curves
    tight_share: float = 0.4  # of the speed, where the body barely fits
    comfort_m: float = 0.20  # clearance beyond the body from which on nothing slows
    look_ahead_m: float = 0.35  # along the descent path
    turn_gain: float = 2.0  # yaw rate per heading error, 1/s
    turn_on_spot_rad: float = 0.7  # heading error from which on the robot does not drive
    facing_rad: float = 0.1  # heading error at which something counts as faced
    look_radps: float = 0.6  # yaw rate of a look around
    creep_mps: float = 0.05  # speed that is kept up to the very goal


@dataclass(frozen=True)
class Along:
    """Drive down a field to its sources."""

    terrain: Terrain
    field: Field


@dataclass(frozen=True)
class Toward:
    """Turn on the spot until a point, m in the map frame, lies ahead."""

    xy: tuple[float, float]


@dataclass(frozen=True)
class Spin:
    """Turn on the spot at a rate."""

    w_radps: float


Course = Along | Toward | Spin  # what a velocity controller follows until it is given another


# -- discrete --------------------------------------------------------------------------------------


def follow(
    terrain: Terrain, field: Field, pose: Pose, radius_m: float, cfg: ControlConfig
) -> Action | None:
    """The action toward the field's sources: of all headings that a whole number of turns reaches,
    the one whose next step ends nearest to them. None when no heading can be driven."""
    here = field.at(pose.x_m, pose.y_m)
    best: tuple[float, int, int] | None = None
    turnings = whole_turns(cfg)
    arrivals = _after_step(terrain, field, _step(pose, turnings, cfg), radius_m, cfg)
    for turns, arrival in zip(turnings, arrivals, strict=True):
        if arrival >= here + 2 * cfg.forward_m:
            continue
        cost = (float(arrival) + cfg.turn_cost_m * abs(turns), abs(turns), -turns)
        best = min(best, cost) if best else cost
    if best is None:
        return None
    return _begin(-best[2])


def squeeze(terrain: Terrain, pose: Pose, cfg: ControlConfig) -> Action:
    """Out of a place where the map leaves no heading to drive: toward the one whose next step keeps
    the most clearance. The robot came here, so one is wider than the map says."""
    turnings = sorted(whole_turns(cfg), key=abs)
    cells = terrain.frame.cells(_step(pose, turnings, cfg)[:, 1:])
    inside = ((cells >= 0) & (cells < terrain.frame.shape)).all(axis=(1, 2))
    least = np.full(len(turnings), -1.0)
    least[inside] = terrain.clearance_m[cells[inside, :, 0], cells[inside, :, 1]].min(axis=1)
    return _begin(turnings[int(least.argmax())])


def whole_turns(cfg: ControlConfig) -> range:
    """All headings that a whole number of turns reaches, as that number; left is positive."""
    half_turns = round(math.pi / cfg.turn_rad)
    return range(-half_turns + 1, half_turns + 1)


def _begin(turns: int) -> Action:
    """The first action of so many turns and a step."""
    if turns == 0:
        return Action.MOVE_FORWARD
    return Action.TURN_LEFT if turns > 0 else Action.TURN_RIGHT


def _step(pose: Pose, turnings: Sequence[int], cfg: ControlConfig) -> F64:
    """(H, samples + 1, 2) m: points along one step after each number of turns."""
    headings = pose.yaw_rad + np.array(turnings) * cfg.turn_rad
    reach = np.linspace(0.0, cfg.forward_m, cfg.samples + 1)
    along = np.stack([np.cos(headings), np.sin(headings)], axis=1)
    return np.asarray(pose.xy + reach[None, :, None] * along[:, None], np.float64)


def face(pose: Pose, toward_rad: float, cfg: ControlConfig) -> Action | None:
    """The turn that brings the heading closer to `toward_rad`; None when no turn would."""
    error = wrap_angle(toward_rad - pose.yaw_rad)
    if abs(error) <= cfg.turn_rad / 2 + 1e-6:
        return None
    return Action.TURN_LEFT if error > 0 else Action.TURN_RIGHT


def _after_step(
    terrain: Terrain, field: Field, points: F64, radius_m: float, cfg: ControlConfig
) -> F64:
    """(H, N, 2) points along steps -> (H,) arrival time at the end of each; inf where the body
    would touch."""
    fits = _fits(terrain, points, radius_m + cfg.margin_m)
    ends = np.full(len(points), np.inf)
    rows, cols = field.frame.cells(points[fits, -1]).T
    ends[fits] = field.arrival_m[rows, cols]
    return ends


def _fits(terrain: Terrain, points_xy: F64, clear_m: float) -> Mask:
    """(H, N, 2) m -> (H,) whether the body keeps its clearance along each line of points. A way
    out of a tight spot may begin within the clearance, as long as it never loses more."""
    cells = terrain.frame.cells(points_xy)
    inside = ((cells >= 0) & (cells < terrain.frame.shape)).all(axis=(1, 2))
    fits = np.zeros(len(points_xy), bool)
    clearance = terrain.clearance_m[cells[inside, :, 0], cells[inside, :, 1]]
    needed = np.minimum(clear_m, np.maximum.accumulate(clearance, axis=1))
    fits[inside] = ~(clearance[:, 1:] < needed[:, 1:] - 1e-6).any(axis=1)
    return fits


# -- velocity --------------------------------------------------------------------------------------


def steer(
    course: Course | None, pose: Pose, now: Twist, dt_s: float, radius_m: float, cfg: ControlConfig
) -> Twist:
    """The velocity that follows a course; without one, braking to a halt. `now` is the velocity
    commanded `dt_s` ago."""
    if isinstance(course, Along):
        return velocity(course.terrain, course.field, pose, radius_m, cfg, now, dt_s)
    if now.v_mps > cfg.creep_mps:  # halt first, along the curve that is known to be clear
        slower = _slewed(now, STILL, dt_s, cfg).v_mps
        return Twist(slower, now.w_radps * slower / now.v_mps)
    turn = 0.0
    if isinstance(course, Spin):
        turn = course.w_radps
    elif isinstance(course, Toward):
        turn = face_rate(pose, course.xy, cfg) or 0.0
    return _slewed(replace(now, v_mps=0.0), Twist(0.0, turn), dt_s, cfg)


def velocity(
    terrain: Terrain,
    field: Field,
    pose: Pose,
    radius_m: float,
    cfg: ControlConfig,
    now: Twist = STILL,
    dt_s: float = 0.2,
) -> Twist:
    """The velocity down the field: toward a point ahead on the path, slower in curves, in tight
    places and before the goal, on the spot when the heading is far off. It is never faster than
    lets the robot halt on known free ground if no further command came; braking for that is not
    held back by the slew. Where no path leads the robot turns on the spot, to see more."""
    path = _path(field, pose, cfg)
    if not len(path):
        return _slewed(now, Twist(0.0, cfg.look_radps), dt_s, cfg)
    if field.at(pose.x_m, pose.y_m) <= 0.0:
        return _slewed(now, STILL, dt_s, cfg)
    aim = _ahead(terrain, field, path, pose, radius_m, cfg)
    error = wrap_angle(bearing((pose.x_m, pose.y_m), aim) - pose.yaw_rad)
    w = _within(cfg.turn_gain * error, cfg.max_turn_radps)
    v = cfg.max_speed_mps * max(0.0, 1.0 - abs(error) / cfg.turn_on_spot_rad)
    if abs(w) > 1e-6:
        v = min(v, cfg.side_accel_mps2 / abs(w))
    v *= _ease(terrain, pose, aim, radius_m, cfg)
    v = min(v, _before_goal(field, path, pose, cfg))
    wished = _slewed(now, Twist(v, w), dt_s, cfg)
    for share in _SHARES:
        if _can_halt(terrain, pose, Twist(share * wished.v_mps, wished.w_radps), radius_m, cfg):
            return Twist(share * wished.v_mps, wished.w_radps)
    return Twist(0.0, wished.w_radps)


def face_rate(pose: Pose, xy: tuple[float, float], cfg: ControlConfig) -> float | None:
    """The yaw rate that turns the robot toward a point; None when it is faced."""
    error = wrap_angle(bearing((pose.x_m, pose.y_m), xy) - pose.yaw_rad)
    if abs(error) <= cfg.facing_rad:
        return None
    return _within(cfg.turn_gain * error, cfg.max_turn_radps)


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


def _path(field: Field, pose: Pose, cfg: ControlConfig) -> F64:
    """(N, 2) m down the field from the robot, a little longer than is looked ahead. A robot that
    stands just beside the field's cells starts from the best of those next to it."""
    frame = field.frame
    limit = 2 + math.ceil(2 * cfg.look_ahead_m / frame.resolution_m)
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
    terrain: Terrain, field: Field, path: F64, pose: Pose, radius_m: float, cfg: ControlConfig
) -> tuple[float, float]:
    """The farthest point of the path within the look-ahead to which the body fits in a straight
    line; corners are not cut. Where the path begins too tight for the body, as it may right at the
    robot, the best of the points around to which it fits."""
    here = pose.xy
    gaps = np.hypot(*(path - here).T)
    resolution = terrain.frame.resolution_m
    near = path[(gaps <= cfg.look_ahead_m) & (gaps > 0.7 * resolution)]
    aim = near[0] if len(near) else path[-1]
    for point in near[::-1]:
        if _drivable(terrain, _line(here, point, resolution), radius_m, cfg):
            aim = point
            break
    else:
        aim = _way_out(terrain, field, here, radius_m, cfg, aim)
    return float(aim[0]), float(aim[1])


def _way_out(
    terrain: Terrain, field: Field, here: F64, radius_m: float, cfg: ControlConfig, otherwise: F64
) -> F64:
    """Of the points a short step away that the body can reach, the one nearest the field's
    sources."""
    best, aim = math.inf, otherwise
    for turn in range(WAYS):  # headings of the map, so that the choice stays while the robot turns
        heading = turn * math.tau / WAYS
        point = here + STEP_M * np.array([math.cos(heading), math.sin(heading)])
        arrival = field.at(float(point[0]), float(point[1]))
        line = _line(here, point, terrain.frame.resolution_m)
        if arrival < best and _drivable(terrain, line, radius_m, cfg):
            best, aim = arrival, point
    return aim


def _line(start: F64, end: F64, resolution_m: float) -> F64:
    """(N, 2) points from start to end, two a cell."""
    n = math.ceil(2 * float(np.hypot(*(end - start))) / resolution_m) + 1
    line: F64 = start + np.linspace(0.0, 1.0, n)[:, None] * (end - start)
    return line


def _ease(
    terrain: Terrain, pose: Pose, aim: tuple[float, float], radius_m: float, cfg: ControlConfig
) -> float:
    """The share of the speed that the clearance here and at the aim allows."""
    spare = math.inf
    for x, y in ((pose.x_m, pose.y_m), aim):
        row, col = terrain.frame.cell(x, y)
        if terrain.frame.contains(row, col):
            spare = min(spare, float(terrain.clearance_m[row, col]) - radius_m - cfg.margin_m)
    return cfg.tight_share + (1 - cfg.tight_share) * min(1.0, max(0.0, spare / cfg.comfort_m))


def _before_goal(field: Field, path: F64, pose: Pose, cfg: ControlConfig) -> float:
    """The speed from which the robot can brake gently to the field's sources."""
    if field.at(float(path[-1][0]), float(path[-1][1])) > 0.0:
        return math.inf  # the goal is beyond the part of the path that is looked at
    left = float(np.hypot(*np.diff(np.vstack([pose.xy, path[1:]]), axis=0).T).sum())
    return max(cfg.creep_mps, math.sqrt(cfg.brake_mps2 * left))


def _can_halt(
    terrain: Terrain, pose: Pose, twist: Twist, radius_m: float, cfg: ControlConfig
) -> bool:
    """Whether the robot stays on free ground if it drives so for `hold_s` and then brakes along
    the same curve."""
    v, w = twist.v_mps, twist.w_radps
    if v <= 0:
        return True
    length = v * cfg.hold_s + v * v / (2 * cfg.brake_mps2)
    n = math.ceil(2 * length / terrain.frame.resolution_m) + 2
    s = np.linspace(0.0, length, n)
    turn = s * (w / v)
    step = np.diff(s, prepend=0.0)
    heading = pose.yaw_rad + turn - step * (w / v) / 2
    points = pose.xy + np.cumsum(
        np.stack([step * np.cos(heading), step * np.sin(heading)], axis=1), axis=0
    )
    return _drivable(terrain, points, radius_m, cfg)


def _drivable(terrain: Terrain, points_xy: F64, radius_m: float, cfg: ControlConfig) -> bool:
    """Whether the body keeps its clearance along (N, 2) m points, and its centre known ground.
    Where it stands too close to something already, it must not come closer."""
    cells = terrain.frame.cells(points_xy)
    if ((cells < 1) | (cells >= np.array(terrain.frame.shape) - 1)).any():
        return False
    at = tuple(cells.T)
    roomy = terrain.clearance_m[at] > radius_m + 2 * cfg.margin_m + 1e-3  # as the planner asks
    unknown = roomy & ~terrain.traversable[at]  # there is room, and yet it is no way
    if unknown[1:].any() and not unknown[0]:
        return False
    clearance = clearance_between(terrain, points_xy)
    needed = np.minimum(radius_m + cfg.margin_m, np.maximum.accumulate(clearance) - SLACK_M)
    return not (clearance < needed)[1:].any()


def clearance_between(terrain: Terrain, points_xy: F64) -> F64:
    """(...) m at (..., 2) m points, bilinear between the cells' centres: steps of a cell would hide
    whether the robot comes closer."""
    frame = terrain.frame
    u = (points_xy - (frame.x0_m, frame.y0_m)) / frame.resolution_m - 0.5
    low = np.floor(u).astype(np.int32)
    part = u - low
    cols, rows, x, y = low[..., 0], low[..., 1], part[..., 0], part[..., 1]
    grid = terrain.clearance_m
    bottom = grid[rows, cols] * (1 - x) + grid[rows, cols + 1] * x
    top = grid[rows + 1, cols] * (1 - x) + grid[rows + 1, cols + 1] * x
    return np.asarray(bottom * (1 - y) + top * y, np.float64)


def _within(value: float, limit: float) -> float:
    return min(limit, max(-limit, value))
