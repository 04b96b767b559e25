"""What a base follows until it is told otherwise, and the limits that it keeps to."""

import math
from dataclasses import dataclass
from typing import Literal

from runtime.core.distances.planner import Field, Terrain
from runtime.core.keys import key
from runtime.core.types import Twist

STILL = Twist()


@dataclass(frozen=True)
class ControlConfig:
    """[control]. `mode`: one action an observation, or velocities that are followed between
    them."""

    mode: Literal["discrete", "velocity"] = key(
        "discrete",
        '"discrete": one action an observation; "velocity": velocities that are followed between '
        "them, as `rfnav run` always has it but in lockstep.",
        research="control_mode",
    )
    forward_m: float = 0.25
    turn_rad: float = math.radians(30.0)
    turn_cost_m: float = 0.04  # what a turn must win in arrival time; keeps headings steady
    margin_m: float = 0.01  # added to the body's radius along a step
    samples: int = 5  # points checked along a step
    max_speed_mps: float = key(
        0.4, "The fastest that the robot drives forward.", "m/s", positive=True
    )
    max_turn_radps: float = key(1.0, "The fastest that it turns.", "rad/s", positive=True)
    max_accel_mps2: float = key(
        0.5, "How fast its forward speed may change.", "m/s^2", positive=True
    )
    max_turn_accel_radps2: float = key(3.0, "How fast its yaw rate may change.", "rad/s^2")
    brake_mps2: float = key(0.5, "What the base can surely brake with.", "m/s^2", positive=True)
    hold_s: float = 0.3  # how long a velocity may act before the next: period, sensing and wire
    side_accel_mps2: float = 0.3  # slows curves
    tight_share: float = 0.4  # of the speed, where the body barely fits
    comfort_m: float = 0.20  # clearance beyond the body from which on nothing slows
    look_ahead_m: float = 0.35  # along the descent path
    turn_gain: float = 2.0  # yaw rate per heading error, 1/s
    turn_on_spot_rad: float = 0.7  # heading error from which on the robot does not drive
    facing_rad: float = 0.1  # heading error at which something counts as faced
    look_radps: float = key(
        0.6, "Yaw rate of the look around at the start.", "rad/s", positive=True
    )
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
