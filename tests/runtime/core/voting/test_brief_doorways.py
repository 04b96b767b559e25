"""A frontier that fills a gap between obstacles is a doorway."""

import numpy as np
import pytest

from runtime.core.mapping.grid import NavigationMap
from runtime.core.types import Pose
from runtime.core.voting.brief import doorway


def wall_with_gap(width_m: float) -> tuple[NavigationMap, np.ndarray]:
    """A wall at x = 2 m with a gap around y = 0, and the gap's cells."""
    grid = NavigationMap.around(Pose(0, 0, 0), 0.18)
    grid.grow(np.array([0.0, 0.0]), 6.0)
    y = np.arange(-3, 3, 0.05) + 0.025
    line = np.stack([np.full(len(y), 2.025), y], axis=1)
    wall = np.abs(y) > width_m / 2
    rows, cols = grid.frame.cells(line[wall]).T
    grid.evidence[rows, cols] = 10
    grid.changed()
    return grid, line[~wall]


@pytest.mark.parametrize(("width_m", "is_one"), [(0.9, True), (0.3, False), (2.0, False)])
def test_by_its_width(width_m: float, is_one: bool) -> None:
    grid, gap = wall_with_gap(width_m)
    assert doorway(gap, grid) is is_one


def test_not_in_the_open() -> None:
    grid, gap = wall_with_gap(0.9)
    assert not doorway(gap - (1.0, 0.0), grid)


def test_a_single_cell_is_none() -> None:
    grid, gap = wall_with_gap(0.9)
    assert not doorway(gap[:1], grid)
