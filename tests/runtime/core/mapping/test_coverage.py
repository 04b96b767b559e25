"""What was looked at from near, and what was not."""

import numpy as np
from open_floor import floor

from runtime.core.mapping.coverage import look, overlooked


def test_what_is_out_of_near_range_stays_overlooked():
    grid = floor()
    looked = np.zeros(grid.frame.shape, bool)
    outline = np.array([[-2.0, 0.0], [2.9, -1.0], [2.9, 1.0]])  # from the left, nearly 5 m deep
    look(looked, grid.frame, outline)
    left = overlooked(grid, looked, np.zeros(grid.frame.shape, bool))
    near, far = grid.frame.cell(-0.5, 0.0), grid.frame.cell(1.5, 0.0)
    assert looked[near]
    assert not left[near]
    assert left[far]
