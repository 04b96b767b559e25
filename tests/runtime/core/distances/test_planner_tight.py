"""Places too tight for the body: a wedged robot gets out, and no more than it can fit through."""

import numpy as np
from open_floor import POSE, RADIUS_M, axes, floor

from runtime.core.distances.planner import look_around, march_from
from runtime.core.distances.terrain import survey
from runtime.core.mapping.grid import NavigationMap


def walled_in(gap_m: float) -> NavigationMap:
    """A ring of obstacles 0.5 m around the robot, with one gap ahead of it."""
    grid = floor()
    x, y = axes(grid)
    ring = (np.hypot(x, y) > 0.5) & (np.hypot(x, y) < 0.62) & ~((x > 0) & (np.abs(y) < gap_m / 2))
    grid.evidence[ring] = 10
    grid.changed()
    return grid


def area_m2(arrival: np.ndarray) -> float:
    return float(np.isfinite(arrival).sum()) * 0.05**2


def test_a_wedged_robot_is_let_through_a_gap_a_cell_too_tight():
    grid = walled_in(0.34)
    plain = march_from(survey(grid, POSE, RADIUS_M), POSE.xy, unhurried=False)
    assert area_m2(plain.arrival_m) < 1.5
    _, reach = look_around(grid, POSE, RADIUS_M)
    assert area_m2(reach.arrival_m) > 10.0


def test_as_a_last_resort_gaps_may_be_a_little_too_tight_everywhere():
    """In a wall 2 m ahead of a robot that is not wedged; it is 0.36 m wide."""
    for gap_m, let_through in ((0.39, True), (0.29, False)):
        grid = floor()
        x, y = axes(grid)
        grid.evidence[(np.abs(x - 2.0) < 0.06) & ~(np.abs(y) < gap_m / 2)] = 10
        grid.changed()
        beyond_m2 = []
        for tight in (False, True):
            terrain, reach = look_around(grid, POSE, RADIUS_M, tight)
            xs = terrain.frame.x0_m + (np.arange(terrain.frame.cols) + 0.5) * 0.05
            beyond_m2.append(area_m2(reach.arrival_m[:, xs > 2.1]))
        assert beyond_m2[0] == 0.0
        assert (beyond_m2[1] > 2.0) is let_through


def test_it_is_not_let_through_a_gap_it_cannot_fit():
    _, reach = look_around(walled_in(0.15), POSE, RADIUS_M)
    assert area_m2(reach.arrival_m) < 1.5


def test_free_ground_is_planned_over_as_always():
    grid = floor()
    terrain, reach = look_around(grid, POSE, RADIUS_M)
    plain = survey(grid, POSE, RADIUS_M)
    assert terrain.speed.tolist() == plain.speed.tolist()
    assert area_m2(reach.arrival_m) > 20.0
