"""Out of a zone that the robot may not be in, and into the area that it must be in."""

import numpy as np

from runtime.core import progress
from runtime.core.distances.terrain import MARGIN_M
from runtime.core.local_policy import local_policy
from runtime.core.mapping.windows import Window
from runtime.core.mapping.zones import Zone
from runtime.core.settings import NavigateConfig
from runtime.core.types import Action, Mask, SearchState
from runtime.core.world import Aim, AimKind, Command, Mode, World, toward

TOUCH_M = 0.06  # more than this of the body's room lost, it is in the zone


def leave(world: World, cfg: NavigateConfig) -> Command | None:
    """The step out of the zones that the body is in, the nearest way; a stop where it comes no
    nearer to that; None where it is in none, or where no way out is known."""
    zones, clear_m = world.map.zones, cfg.robot.radius_m + MARGIN_M
    openings = zones.openings(world.map.frame, world.pose, clear_m)
    deep = [opening for opening in openings if opening.lacks_m > TOUCH_M]
    if not deep:
        return None
    out = np.argwhere(_outside(world, clear_m)).astype(np.int32)
    if not len(out):
        return None
    field = world.plan.toward(world.terrain, out, world.pose)
    why = " and ".join(_in_words(opening.zone) for opening in deep)
    if progress.stalled(world, Aim(AimKind.OUT, 0), field, cfg):
        why = f"the robot does not get {why}"
        return Command(Action.STOP, Mode.STOP, None, why, ended=SearchState.UNREACHABLE)
    action, course = local_policy(cfg).drive(world, field)
    return toward(field, world.pose, Command(action, Mode.LEAVE, None, why, course=course))


def _outside(world: World, clear_m: float) -> Mask:
    """(r, c) of the terrain: where the robot can get to, out of all zones."""
    true_m, _ = world.map.zones.clearance(world.map.frame, _window(world))
    return np.isfinite(world.reach.arrival_m) & (true_m >= clear_m)


def _window(world: World) -> Window:
    """The terrain's, of the map."""
    part = world.terrain.frame
    (x, y), frame = part.centres(np.zeros(2, np.int32)).tolist(), world.map.frame
    top, left = frame.cell(x, y)
    return slice(top, top + part.rows), slice(left, left + part.cols)


def _in_words(zone: Zone) -> str:
    if zone.area:
        return "back into the area of the search"
    return f"out of {zone.name}, which is kept out of"
