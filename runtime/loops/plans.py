"""What the control loop is given to follow, and what it tells of a turn."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from runtime.core.motion.caution import FREE, Caution
from runtime.core.motion.contact import NOTHING, Felt
from runtime.core.motion.courses import Along, ControlConfig, Course
from runtime.core.motion.safety import Halt, Odometry
from runtime.core.types import Twist
from runtime.robot.base import BaseCondition


@dataclass(frozen=True)
class Plan:
    """What to follow until the next plan comes. `frame_s`: when the frame arrived that it was made
    of; its age is the plan's. `report`: what is known of it to those who watch. `doubt`: why it has
    no course, of a robot that would drive on."""

    course: Course | None
    frame_s: float
    radius_m: float
    control: ControlConfig
    report: Mapping[str, object] = field(default_factory=dict)
    doubt: Halt | None = None

    @property
    def drives(self) -> bool:
        """Whether it moves the base, or would if nothing were in doubt."""
        return self.course is not None or self.doubt is not None


@dataclass(frozen=True)
class Tick:
    """A turn of the loop, for a recorder: what it knew, and what it made of that. `plan`: how
    many plans came before and with the one that it followed, 0 for none; `withdrawn`: that was
    taken away meanwhile; `asked`: of the base, None when nothing was; `sent`: what the base sent of
    that, None when nothing; `base`: what it said of itself; `felt`: what the body did; `doubt`: why
    nothing was to be driven; `caution`: what the depth image allowed."""

    now_s: float
    late_s: float
    odometry: Odometry | None
    frame_s: float | None
    plan: int
    stopping: bool
    withdrawn: bool
    sent: Twist | None
    halt: str
    asked: Twist | None
    base: BaseCondition
    felt: Felt = NOTHING
    doubt: Halt | None = None
    caution: Caution = FREE


def told_plan(number: int, plan: Plan) -> dict[str, object]:
    """A plan, for a recorder: without the field that its course may be."""
    course = type(plan.course).__name__.lower() if plan.course is not None else "none"
    toward = None if isinstance(plan.course, Along) else plan.course
    doubt = {"doubt": plan.doubt} if plan.doubt is not None else {}
    return doubt | {
        "number": number,
        "course": course,
        "toward": toward,
        "frame_s": plan.frame_s,
        "radius_m": plan.radius_m,
        "limits": plan.control,
    }
