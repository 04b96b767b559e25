"""Maps of looks around, as a camera shows a home against as it is."""

import numpy as np
import pytest

from hil_sim.evaluation.depth_maps import MapCase, MapScore, compare, scored
from runtime.core.mapping.grid import NavigationMap
from runtime.core.types import Pose


def floor() -> NavigationMap:
    grid = NavigationMap.around(Pose(0, 0, 0), 0.18)
    grid.evidence[100:120, 100:120] = -4
    grid.evidence[110, 105:115] = 8
    grid.changed()
    return grid


def test_a_map_against_itself_and_against_a_worse_one() -> None:
    true, made = floor(), floor()
    same = scored(true, made)
    assert same.shares == (1.0, 0.0, 0.0)
    assert same.obstacles == 10
    made.evidence[102, 102] = 8  # in mid-floor
    made.evidence[109, 107] = 8  # a true one is beside it
    made.evidence[110, 110:115] = 0
    made.changed()
    worse = scored(true, made)
    assert (same.kept - worse.kept, worse.false, worse.missed) == (2, 1, 4)
    assert same + worse == MapScore(*np.add(list(vars(same).values()), list(vars(worse).values())))


@pytest.mark.slow
def test_flying_pixels_and_a_mount_that_sways_cost_floor_that_is_won_back() -> None:
    cases = [MapCase("flying=1", drops) for drops in (False, True)]
    (score,) = compare(["maple"], 1, cases, sways=False, seed=0)
    (kept, false, _), (kept_after, false_after, missed_after) = (score[c].shares for c in cases)
    assert kept_after > kept + 0.02
    assert false_after < false / 2
    assert missed_after < 0.02

    cases = [MapCase("none", True, mount) for mount in ("fixed", "floor", "tf")]
    (score,) = compare(["maple"], 1, cases, sways=True, seed=0)
    fixed, by_floor, by_tf = (score[case].shares[0] for case in cases)
    assert fixed < 0.8
    assert by_floor > 0.9
    assert by_tf > 0.99
