"""Going back to where the search began, for it must end."""

import math

import numpy as np

from runtime.core import progress
from runtime.core.local_policy import local_policy
from runtime.core.settings import NavigateConfig
from runtime.core.types import Action, SearchState
from runtime.core.world import Aim, AimKind, Command, Mode, World, toward

ARRIVED_M = 0.25


def go_back(world: World, why: str, start_xy: tuple[float, float], cfg: NavigateConfig) -> Command:
    """The step back along the map; a stop, with `why`, there or where the robot comes no nearer."""
    pose, policy = world.pose, local_policy(cfg)
    if math.dist((pose.x_m, pose.y_m), start_xy) <= ARRIVED_M:
        return _stop(f"{why}; it is back where it began", start_xy, SearchState.ARRIVED)
    goal = world.terrain.frame.cells(np.array([start_xy]))
    field = world.plan.toward(world.terrain, goal, pose)
    if progress.stalled(world, Aim(AimKind.START, 0), field, cfg):
        lost = f"{why}; there is no way back to where it began"
        return _stop(lost, start_xy, SearchState.UNREACHABLE)
    action, course = policy.drive(world, field)
    reason = f"{why}: drive back to where it began"
    return toward(field, pose, Command(action, Mode.RETURN, start_xy, reason, course=course))


def _stop(why: str, at_xy: tuple[float, float], ended: SearchState) -> Command:
    return Command(Action.STOP, Mode.STOP, at_xy, why, ended=ended)
