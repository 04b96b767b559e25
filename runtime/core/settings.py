"""The core's configuration, its tables gathered."""

from dataclasses import dataclass, field

from runtime.core.keys import key
from runtime.core.mapping.grid import MapConfig
from runtime.core.mapping.keyframes import KeyframeConfig
from runtime.core.motion.courses import ControlConfig
from runtime.core.resorts import LastLooks
from runtime.core.voting.consensus import ConsensusConfig


@dataclass(frozen=True)
class RobotConfig:
    """[robot]"""

    radius_m: float = key(0.18, "Radius of the robot's body, a disc.", "m", within=(0.03, 1.5))
    height_m: float = key(
        1.0, "Its height: what is higher does not block it.", "m", within=(0.05, 3.0)
    )


@dataclass(frozen=True)
class SearchConfig:
    """What a search does when no frontier is left."""

    last_looks: LastLooks = key(
        "afar",
        'What is looked at again when nothing is left to explore: "afar": floor that was seen from '
        'no nearer than 2.2 m; "closer": surfaces where, by the size of the goal, it may have been '
        "missed (docs/searching.md).",
        research="last_looks",
    )


@dataclass(frozen=True)
class NavigateConfig:
    """The core's part of the configuration."""

    robot: RobotConfig = field(default_factory=RobotConfig)
    map: MapConfig = field(default_factory=MapConfig)
    keyframes: KeyframeConfig = field(default_factory=KeyframeConfig)
    consensus: ConsensusConfig = field(default_factory=ConsensusConfig)
    search: SearchConfig = field(default_factory=SearchConfig)
    control: ControlConfig = field(default_factory=ControlConfig)
