"""Cells of a map, as they are told and read."""

from contextlib import suppress
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.errors import SensorError
from runtime.service.told_map import MOST_CELLS, packed, unpacked

CELLS = np.arange(6, dtype=np.uint8).reshape(2, 3)
TOLD = {"rows": 2, "cols": 3, "cells": packed(CELLS)}
ANYTHING = st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.binary()


def test_what_was_told_is_read():
    assert np.array_equal(unpacked(TOLD, "cells"), CELLS)


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        ({"rows": MOST_CELLS, "cols": 2}, "no map"), ({"rows": -2, "cols": -3}, "no map"),
        ({"rows": 0}, "no map"), ({"rows": "2"}, "whole numbers"),
        ({"rows": 3}, "6 cells in place of 9"),
        ({"rows": 1}, "cells in place of 3"), ({"cells": "bm8gemxpYg=="}, "cannot be read: error"),
        ({"cells": 7}, "cannot be read: TypeError"),
    ],
)  # fmt: skip
def test_what_is_no_map_is_a_line(wrong: dict[str, Any], why: str):
    with pytest.raises(SensorError, match=why):
        unpacked(TOLD | wrong, "cells")


def test_a_map_of_more_cells_than_somebody_wants_is_not_read():
    with pytest.raises(SensorError, match="2 x 3 cells are no map"):
        unpacked(TOLD, "cells", 5)


@given(ANYTHING, ANYTHING, ANYTHING)
def test_anything_is_a_map_or_a_line(rows: object, cols: object, cells: object):
    with suppress(SensorError):
        assert unpacked({"rows": rows, "cols": cols, "cells": cells}, "cells").size
