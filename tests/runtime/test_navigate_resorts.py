"""What was seen only from afar, or doubted, is gone to before the search ends."""

import numpy as np
import pytest
from open_floor import POSE, RADIUS_M, floor

from runtime import navigate
from runtime.core.approach import TRIES
from runtime.core.exploration import with_frontiers
from runtime.core.objects.instances import Evidence, Instance
from runtime.core.resorts import LastLooks, Resort
from runtime.core.settings import NavigateConfig, SearchConfig
from runtime.core.types import SearchState
from runtime.core.world import World

OTHERS = {"afar": Resort.CLOSER, "closer": Resort.AFAR}


@pytest.mark.parametrize("looks", ["afar", "closer"])
def test_at_the_very_last_what_was_faintly_like_it_is_looked_at(looks: LastLooks):
    """It is worth no detour before everything else was tried."""
    cfg = NavigateConfig(search=SearchConfig(last_looks=looks))
    world = World.begin("vase", ("vase",), (), POSE, RADIUS_M, 0)
    world.map = floor()
    faint = Instance(
        1, {"vase": Evidence(-2.0)}, (1.5, 0.0), 0.9, np.array([[1.525, 0.025]]), views=[POSE]
    )
    world.semantic.instances[1] = faint
    world.explored.given_up[:] = True  # no frontier is left,
    if looks == "closer":
        fineness = world.explored.closer.fineness
        fineness.fit(world.map.frame)
        fineness.fine[:], fineness.sides[:] = 255, 255  # and nothing to look at more closely
    with_frontiers(world, cfg)
    said = []
    while not said or said[-1].mode == "look":
        said.append(navigate._finish(world, cfg))
        world.explored.given_up[:] = True
        with_frontiers(world, cfg)
    assert [command.reason for command in said[:-1]] == [
        r.reason for r in Resort if r not in (Resort.NONE, OTHERS[looks])
    ]
    assert said[-1].reason.startswith("inspect vase 1")
    faint.evidence["vase"].odds = -9.0  # not even for that
    world.held_up[1] = [POSE] * TRIES
    shut = navigate._finish(world, cfg)
    assert (shut.ended, shut.toward_xy) == (SearchState.UNREACHABLE, faint.xy)
    assert shut.reason == "vase 1 was seen at (1.5, 0.0), and no way leads there"
    world.semantic.instances.clear()
    over = navigate._finish(world, cfg)
    assert (over.mode, over.ended) == ("stop", SearchState.NOT_FOUND)
