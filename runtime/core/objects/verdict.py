"""Whether a candidate is believed to be the goal: evidence and a look in, a verdict out."""

import math
from enum import Enum, auto

from runtime.core.geometry import bearing, wrap_angle
from runtime.core.objects import instances
from runtime.core.objects.instances import Instance
from runtime.core.types import Pose

INSPECT_LOG_ODDS = 0.8  # worth a detour to look again
CONFIRM_LOG_ODDS = 1.6  # believed, when seen from enough views
CONFIRM_VIEWS = 2  # at least, of which two must differ
SECOND_SIDE_RAD = math.radians(20.0)  # in bearing by this,
SECOND_NEARER = 1.4  # or in range by this factor
REJECTION_LOG_ODDS = -1.0  # what is left of the evidence after a look from close by
UNSEEN_LOOKS = 2  # more, at what was not in the image from where it was faced
SEEN_M = 1.8  # a target is stopped at only when it was seen from as near as this


class Reached(Enum):
    """How far the robot has come with a candidate."""

    ON_THE_WAY = auto()
    FACED = auto()  # it stands before it and faces it
    UNSEEN = auto()  # the same, but from there it is not in the image
    HELD_UP = auto()  # it comes no nearer
    NO_OTHER_SIDE = auto()  # there is no place to look at it from another side


class Verdict(Enum):
    """What follows from that."""

    APPROACH = auto()  # go to where it can be faced
    OTHER_SIDE = auto()  # go to where it is seen from another side
    STEP_BACK = auto()  # go to where it is seen from about as near
    FOUND = auto()
    REJECT = auto()


def verdict(instance: Instance, goal: str, reached: Reached) -> Verdict:
    """What to do about a candidate. What is not believed at the first look is looked at from
    another side while something speaks for it, and after that rejected; where there is no other
    side, the evidence of the first has to do."""
    believed = confirmed(instance, goal)
    near = instance.evidence[goal].near_m <= SEEN_M
    undecided = len(instance.looks) == 1 and not (believed and near)
    match reached:
        case Reached.ON_THE_WAY:
            return Verdict.OTHER_SIDE if undecided else Verdict.APPROACH
        case Reached.FACED | Reached.UNSEEN:
            sole = len(instance.looks) > 1 and supported(instance, goal)
            if near and (sole or believed):
                seen = reached is Reached.FACED or len(instance.unseen) >= UNSEEN_LOOKS
                return Verdict.FOUND if seen else Verdict.STEP_BACK
            again = not instance.looks and instance.odds_of(goal) >= INSPECT_LOG_ODDS
            return Verdict.OTHER_SIDE if again else Verdict.REJECT
        case Reached.HELD_UP if not undecided:
            return Verdict.REJECT
        case _:
            return Verdict.APPROACH if supported(instance, goal) else Verdict.REJECT


def settle(instance: Instance, goal: str, outcome: Verdict, pose: Pose) -> None:
    """Book that a look from `pose` led to this verdict."""
    if outcome is Verdict.REJECT:
        instances.reject(instance, goal, REJECTION_LOG_ODDS)
    elif outcome is Verdict.STEP_BACK:
        instance.unseen.append(pose)
    elif outcome is not Verdict.FOUND:
        instance.looks.append(pose)


def confirmed(instance: Instance, goal: str) -> bool:
    """Whether the instance is believed to be the goal: enough evidence, from two directions."""
    return supported(instance, goal) and from_two_sides(instance, goal)


def supported(instance: Instance, goal: str) -> bool:
    """Whether the evidence would do, wherever it was seen from: it is nothing else more surely, and
    some of it is of this search."""
    enough = instance.odds_of(goal) >= CONFIRM_LOG_ODDS and instance.name == goal
    return enough and bool(instance.evidence[goal].backing)


def from_two_sides(instance: Instance, goal: str) -> bool:
    """Whether two views that spoke for it truly differ: in bearing, or one is much nearer than the
    other. What looks like the goal by chance seldom does so twice."""
    views = instance.evidence[goal].backing
    if len(views) < CONFIRM_VIEWS:
        return False
    ranges = [math.dist(view.xy, instance.xy) for view in views]
    if min(ranges) * SECOND_NEARER <= max(ranges):
        return True
    bearings = [bearing(instance.xy, (view.x_m, view.y_m)) for view in views]
    widest = max(abs(wrap_angle(a - b)) for a in bearings for b in bearings)
    return widest >= SECOND_SIDE_RAD
