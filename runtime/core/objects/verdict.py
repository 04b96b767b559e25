"""Whether a candidate is believed to be the goal: evidence and a look in, a verdict out."""

import math
from dataclasses import dataclass
from enum import Enum, auto

from runtime.core.geometry import bearing, wrap_angle
from runtime.core.objects import instances
from runtime.core.objects.instances import Instance
from runtime.core.types import Pose


@dataclass(frozen=True)
class TargetConfig:
    """[target]"""

    inspect_log_odds: float = 0.8  # worth a detour to look again
    keep_log_odds: float = 0.0  # enough to go on for, once on the way
    confirm_log_odds: float = 1.6  # believed, when seen from enough views
    confirm_views: int = 2  # at least, of which two must differ
    second_side_rad: float = math.radians(20.0)  # in bearing by this,
    second_nearer: float = 1.4  # or in range by this factor
    rejection_log_odds: float = -1.0  # what is left of the evidence after a look from close by
    stop_m: float = 0.70  # from the nearest seen cell of the target
    low_m: float = 0.90  # the same at most, where the camera looks over what is nearer
    seen_m: float = 1.8  # a target is stopped at only when it was seen from as near as this
    reach_m: float = 1.3  # an approach that ends further away is no arrival
    view_cone_rad: float = math.radians(80.0)  # stand where it was seen from, not behind its wall
    detour_m: float = 10.0  # what going to something else costs
    keep_m: float = 1.0  # by so much must another be better to be gone to instead
    rival_share: float = 0.5  # of footprint and height, shared with what is more surely another
    rival_cosine: float = 0.6  # and that alike, or of one size
    rival_size: float = 0.5  # of the longer side, the shorter's share
    apart_confidence: float = 0.9  # from which on something else keeps its cells to itself,
    apart_size: float = 1.2  # unless it is so much larger than the target


class Reached(Enum):
    """How far the robot has come with a candidate."""

    ON_THE_WAY = auto()
    FACED = auto()  # it stands before it and faces it
    HELD_UP = auto()  # it comes no nearer
    NO_OTHER_SIDE = auto()  # there is no place to look at it from another side


class Verdict(Enum):
    """What follows from that."""

    APPROACH = auto()  # go to where it can be faced
    OTHER_SIDE = auto()  # go to where it is seen from another side
    FOUND = auto()
    REJECT = auto()


def verdict(instance: Instance, goal: str, reached: Reached, cfg: TargetConfig) -> Verdict:
    """What to do about a candidate. What is not believed at the first look is looked at from
    another side while something speaks for it, and after that rejected; where there is no other
    side, the evidence of the first has to do."""
    believed = confirmed(instance, goal, cfg)
    near = instance.evidence[goal].near_m <= cfg.seen_m
    undecided = len(instance.looks) == 1 and not (believed and near)
    match reached:
        case Reached.ON_THE_WAY:
            return Verdict.OTHER_SIDE if undecided else Verdict.APPROACH
        case Reached.FACED:
            sole = len(instance.looks) > 1 and supported(instance, goal, cfg)
            if near and (sole or believed):
                return Verdict.FOUND
            again = not instance.looks and instance.odds_of(goal) >= cfg.inspect_log_odds
            return Verdict.OTHER_SIDE if again else Verdict.REJECT
        case Reached.HELD_UP if not undecided:
            return Verdict.REJECT
        case _:
            return Verdict.APPROACH if supported(instance, goal, cfg) else Verdict.REJECT


def settle(instance: Instance, goal: str, outcome: Verdict, pose: Pose, cfg: TargetConfig) -> None:
    """Book that a look from `pose` led to this verdict."""
    if outcome is Verdict.REJECT:
        instances.reject(instance, goal, cfg.rejection_log_odds)
    elif outcome is not Verdict.FOUND:
        instance.looks.append(pose)


def confirmed(instance: Instance, goal: str, cfg: TargetConfig) -> bool:
    """Whether the instance is believed to be the goal: enough evidence, from two directions."""
    return supported(instance, goal, cfg) and from_two_sides(instance, goal, cfg)


def supported(instance: Instance, goal: str, cfg: TargetConfig) -> bool:
    """Whether the evidence would do, wherever it was seen from: some of it is of this search."""
    enough = instance.odds_of(goal) >= cfg.confirm_log_odds
    return enough and bool(instance.evidence[goal].backing)


def from_two_sides(instance: Instance, goal: str, cfg: TargetConfig) -> bool:
    """Whether two views that spoke for it truly differ: in bearing, or one is much nearer than the
    other. What looks like the goal by chance seldom does so twice."""
    views = instance.evidence[goal].backing
    if len(views) < cfg.confirm_views:
        return False
    ranges = [math.dist(view.xy, instance.xy) for view in views]
    if min(ranges) * cfg.second_nearer <= max(ranges):
        return True
    bearings = [bearing(instance.xy, (view.x_m, view.y_m)) for view in views]
    widest = max(abs(wrap_angle(a - b)) for a in bearings for b in bearings)
    return widest >= cfg.second_side_rad
