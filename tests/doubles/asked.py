"""A moment that tests ask about."""

from dataclasses import replace

import numpy as np
from sighted import sight

from hil_sim.expert_bench.bank import CLEAN, Moment
from runtime.core.types import Brief, FrontierBrief, NearbyObject


def moment(home: str = "train-100000", step: int = 12) -> Moment:
    """Two frontiers, 1 m and 2 m away; a goal that is behind the further one."""
    sofa, view = NearbyObject("sofa", 0.913, 1.25), np.array([0.5, -0.25], np.float32)
    rooms = (("kitchen", 0.75), ("hallway", 0.25))
    frontiers = (
        FrontierBrief(3, 1.0, (sofa,), rooms, view, doorway=True, sight=sight(0.25)),
        FrontierBrief(7, 2.0, (), ()),
    )
    told = Brief("", 6_500_000_000, frontiers)
    thin = replace(told, frontiers=(replace(frontiers[0], objects=()), frontiers[1]))
    briefs = {CLEAN: told, "missing objects": thin}
    costs_m = {"toilet": (9.0, 4.0)}
    places = ((1.0, 0.0), (0.0, 2.0))
    return Moment(home, 0, step, "first decision", briefs, (7, 3), (3, 7), places, costs_m)
