"""Through a tight place in whole steps: which turns and steps, one after the other, lead on where
no single step does."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from runtime.core.distances.planner import Field
from runtime.core.distances.terrain import SLOWEST, Terrain
from runtime.core.kernels.steps import Berth, steps_clear, whole_steps
from runtime.core.motion.courses import MARGIN_M
from runtime.core.motion.discrete_policy import FORWARD_M, SAMPLES, TURN_RAD, whole_turns
from runtime.core.types import F64, Action, Pose

STEPS = 10  # at most, one after the other
REACH_M = 1.2  # from the robot, within which a way is looked for
BEYOND_M = REACH_M / SLOWEST  # of arrival, that so much way can take
SAME_M = 0.03  # places nearer to each other count as one
GAIN_M = 0.2  # of arrival, that the way must win
SLACK_M = 1e-6  # by so much less is rounding


@dataclass(frozen=True)
class Way:
    """What leads through, nothing where there is no way; and the place, (x, y) m in the map frame,
    nearest to the field's sources that whole steps reach."""

    actions: tuple[Action, ...]
    nearest_xy: tuple[float, float]


def through(terrain: Terrain, field: Field, pose: Pose, radius_m: float, best_m: float) -> Way:
    """The fewest steps, and of those with the fewest turns, to where the arrival is below `best_m`
    by GAIN_M, or to the sources. Breadth first over all places that steps of FORWARD_M at
    headings TURN_RAD apart reach; the clearance is read between the cells' centres, as a
    finger's breadth decides."""
    turns = whole_turns()
    widest = STEPS * max(turns[-1], -turns[0])
    facing = np.arange(-widest, widest + 1, dtype=np.float64)
    found, end_xy = whole_steps(
        terrain.clearance_m, terrain.frame.place, field.arrival_m, field.frame.place,
        (pose.x_m, pose.y_m), _step(pose.yaw_rad + facing * TURN_RAD),
        _berth(radius_m), reach_m=REACH_M, same_m=SAME_M, best_m=max(0.0, best_m - GAIN_M),
        most_steps=STEPS, turns=turns,
    )  # fmt: skip
    actions: list[Action] = []
    for turned in found:
        actions += [Action.TURN_LEFT if turned > 0 else Action.TURN_RIGHT] * abs(turned)
        actions.append(Action.MOVE_FORWARD)
    return Way(tuple(actions), end_xy)


def clear(terrain: Terrain, pose: Pose, actions: Sequence[Action], radius_m: float) -> bool:
    """Whether the body keeps its clearance along all these actions."""
    for action in actions:
        if action is not Action.MOVE_FORWARD:
            turn = TURN_RAD if action is Action.TURN_LEFT else -TURN_RAD
            pose = replace(pose, yaw_rad=pose.yaw_rad + turn)
            continue
        step, place = _step(np.array([pose.yaw_rad])), terrain.frame.place
        if not steps_clear(terrain.clearance_m, place, pose.xy[None], step, _berth(radius_m))[0]:
            return False
        x_m, y_m = (pose.xy + step[0]).tolist()
        pose = replace(pose, x_m=x_m, y_m=y_m)
    return True


def _step(heading_rad: F64) -> F64:
    """(...) -> (..., 2) m of one step."""
    ahead: F64 = FORWARD_M * np.stack([np.cos(heading_rad), np.sin(heading_rad)], axis=-1)
    return ahead


def _berth(radius_m: float) -> Berth:
    return Berth(radius_m + MARGIN_M, SLACK_M, SAMPLES)
