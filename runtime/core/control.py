"""The local policy: one of the discrete actions that follows an arrival field."""

import math
from dataclasses import dataclass

import numpy as np

from runtime.core.geometry import wrap_angle
from runtime.core.planner import Field, Terrain
from runtime.core.types import Action, Pose


@dataclass(frozen=True)
class ControlConfig:
    """[control]"""

    forward_m: float = 0.25
    turn_rad: float = math.radians(30.0)
    turn_cost_m: float = 0.04  # what a turn must win in arrival time; keeps headings steady
    margin_m: float = 0.01  # added to the body's radius along a step
    samples: int = 5  # points checked along a step


def follow(
    terrain: Terrain, field: Field, pose: Pose, radius_m: float, cfg: ControlConfig
) -> Action | None:
    """The action toward the field's sources: of all headings that a whole number of turns reaches,
    the one whose next step ends nearest to them. None when no heading can be driven."""
    here = field.at(pose.x_m, pose.y_m)
    best: tuple[float, int, int] | None = None
    half_turns = round(math.pi / cfg.turn_rad)
    for turns in range(-half_turns + 1, half_turns + 1):
        heading = pose.yaw_rad + turns * cfg.turn_rad
        arrival = _after_step(terrain, field, pose, heading, radius_m, cfg)
        if arrival >= here + 2 * cfg.forward_m:
            continue
        cost = (arrival + cfg.turn_cost_m * abs(turns), abs(turns), -turns)
        best = min(best, cost) if best else cost
    if best is None:
        return None
    turns = -best[2]
    if turns == 0:
        return Action.MOVE_FORWARD
    return Action.TURN_LEFT if turns > 0 else Action.TURN_RIGHT


def face(pose: Pose, toward_rad: float, cfg: ControlConfig) -> Action | None:
    """The turn that brings the heading closer to `toward_rad`; None when no turn would."""
    error = wrap_angle(toward_rad - pose.yaw_rad)
    if abs(error) <= cfg.turn_rad / 2 + 1e-6:
        return None
    return Action.TURN_LEFT if error > 0 else Action.TURN_RIGHT


def _after_step(
    terrain: Terrain, field: Field, pose: Pose, heading: float, radius_m: float, cfg: ControlConfig
) -> float:
    """Arrival time at the end of one step along the heading; inf when the body would touch. A step
    that leaves a tight spot may begin within the clearance, as long as it never loses more."""
    c, s = math.cos(heading), math.sin(heading)
    reach = np.linspace(0.0, cfg.forward_m, cfg.samples + 1)
    cells = terrain.frame.cells(np.stack([pose.x_m + c * reach, pose.y_m + s * reach], axis=1))
    if ((cells < 0) | (cells >= terrain.frame.shape)).any():
        return math.inf
    clearance = terrain.clearance_m[tuple(cells.T)]
    needed = np.minimum(radius_m + cfg.margin_m, np.maximum.accumulate(clearance))
    if (clearance[1:] < needed[1:] - 1e-6).any():
        return math.inf
    return field.at(pose.x_m + c * cfg.forward_m, pose.y_m + s * cfg.forward_m)
