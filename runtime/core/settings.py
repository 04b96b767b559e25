"""The core's configuration, its tables gathered."""

from dataclasses import dataclass, field

from runtime.core.keys import key
from runtime.core.mapping.grid import MapConfig
from runtime.core.mapping.keyframes import KeyframeConfig
from runtime.core.motion.courses import ControlConfig
from runtime.core.objects.instances import SemanticsConfig
from runtime.core.objects.verdict import TargetConfig
from runtime.core.voting.consensus import ConsensusConfig


@dataclass(frozen=True)
class ExploreConfig:
    """[explore]"""

    first_looks: int = 12  # turns of the look around at the start
    decide_every: int = 5  # steps between decisions that only new evidence asks for
    decide_every_s: float = 1.0  # the same in velocity mode
    worth_m2: float = 0.1  # unknown behind a frontier; those with less are gone to last
    arrived_m: float = 0.25  # from a frontier's goal point
    seen_range_m: float = 2.0  # frontier cells this close were looked at once the robot faced them
    patience: int = 24  # steps without coming closer to an aim before it is given up
    patience_s: float = 12.0  # the same in velocity mode
    returns: int = 8  # so often the robot turns back to an aim in vain, then the same
    blocked_m: float = 0.08  # a step forward that moved less than this was a collision
    blocked_s: float = 0.6  # the same in velocity mode: so long not a quarter of the speed
    blind_share: float = 0.02  # of the depth image; with less of it no velocity leads forward
    weak_log_odds: float = -1.0  # a target worth a look when nothing is left to explore
    faint_log_odds: float = -3.0  # and at the very last


@dataclass(frozen=True)
class RobotConfig:
    """[robot]"""

    radius_m: float = key(0.18, "Radius of the robot's body, a disc.", "m", positive=True)


@dataclass(frozen=True)
class NavigateConfig:
    """The core's part of the configuration."""

    robot: RobotConfig = field(default_factory=RobotConfig)
    map: MapConfig = field(default_factory=MapConfig)
    semantics: SemanticsConfig = field(default_factory=SemanticsConfig)
    keyframes: KeyframeConfig = field(default_factory=KeyframeConfig)
    consensus: ConsensusConfig = field(default_factory=ConsensusConfig)
    control: ControlConfig = field(default_factory=ControlConfig)
    target: TargetConfig = field(default_factory=TargetConfig)
    explore: ExploreConfig = field(default_factory=ExploreConfig)
