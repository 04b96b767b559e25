"""What a base follows until it is told otherwise, and the limits that it keeps to."""

from dataclasses import dataclass
from typing import Literal

from runtime.core.distances.planner import Field
from runtime.core.distances.terrain import Terrain
from runtime.core.keys import key
from runtime.core.motion.footing import Footing
from runtime.core.types import Twist

STILL = Twist()
MARGIN_M = 0.01  # added to the body's radius along a step or a curve


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
    max_speed_mps: float = key(
        0.4, "The fastest that the robot drives forward.", "m/s", within=(0.01, 3.0)
    )
    max_turn_radps: float = key(1.0, "The fastest that it turns.", "rad/s", within=(0.05, 6.0))
    max_accel_mps2: float = key(
        0.5, "How fast its forward speed may change.", "m/s^2", within=(0.01, 10.0)
    )
    max_turn_accel_radps2: float = key(
        3.0, "How fast its yaw rate may change.", "rad/s^2", within=(0.05, 50.0)
    )
    brake_mps2: float = key(
        0.5, "What the base can surely brake with.", "m/s^2", within=(0.05, 10.0)
    )
    look_radps: float = key(
        0.6, "Yaw rate of the look around at the start.", "rad/s", within=(0.05, 6.0)
    )


@dataclass(frozen=True)
class Along:
    """Drive down a field to its sources. The footing is what a base that halts anywhere keeps to;
    one of whole steps keeps to the terrain alone."""

    terrain: Terrain
    field: Field
    footing: Footing | None = None


@dataclass(frozen=True)
class Toward:
    """Turn on the spot until a point, m in the map frame, lies ahead."""

    xy: tuple[float, float]


@dataclass(frozen=True)
class Spin:
    """Turn on the spot at a rate."""

    w_radps: float


Course = Along | Toward | Spin  # what a velocity controller follows until it is given another
