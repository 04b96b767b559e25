"""What the kernels of the semantic map cannot be given is told, with the argument's name."""

import math

import numpy as np
import pytest

from runtime.core.kernels import objects as kernels
from runtime.core.objects.depth_segments import RULES
from runtime.core.objects.footprints import STRAYS

CORNER = -6.0, -5.0, 0.05
PLACES, XY = np.zeros((7, 3)), (0.0, 0.0)
SOME, ROW = np.zeros((2, 2)), np.zeros(4, np.float32)
NOTHING, LOST = np.zeros((1, 6)), np.array([[0.0, 0.0], [0.0, math.nan], [1.0, 1.0]])
DEPTH, RAYS = np.ones((8, 8), np.float32), (np.ones((2, 2), np.float32),) * 3


def things(depth_m=DEPTH, stride=4, asked=NOTHING, place=(0.0,) * 7, rules=RULES):
    """Arguments of that kernel, which are right but for what is given."""
    return depth_m, RAYS, stride, asked, place, CORNER, rules


@pytest.mark.parametrize(
    ("call", "args", "error", "told"),
    [
        ("things", things(asked=np.zeros((1, 5))), ValueError, "boxes"),
        ("things", things(stride=2), ValueError, "rays"),
        ("things", things(stride=0), ValueError, "stride"),
        ("things", things(asked=-np.ones((1, 6))), ValueError, "before"),
        ("things", things(place=(0.0,) * 6), TypeError, "place"),
        ("things", things(rules=()), TypeError, "rules"),
        ("things", things(depth_m=SOME), TypeError, "depth_m"),
        ("things", things(rules=(*RULES[:4], 1.5, *RULES[5:])), ValueError, "rules"),
        *[
            ("things", things(rules=(*RULES[:-3], rim, *STRAYS)), ValueError, "rules")
            for rim in (0, 1, 2, 2.9, 1e9, math.inf, math.nan)
        ],
        ("things", things(rules=(*RULES[:-1], -0.1)), ValueError, "rules"),
        ("things", things(rules=("far", *RULES[1:])), TypeError, "rules"),
        ("things", things(place=(math.nan, *(0.0,) * 6)), ValueError, "place"),
        ("things", things(stride="4"), TypeError, "str"),
        ("things", things(stride=2**80), OverflowError, "index-sized"),
        ("joined_cells", (SOME, SOME, (0.0, 0.0, -0.05), STRAYS, False), ValueError, "no size"),
        ("joined_cells", (SOME, SOME, CORNER, (math.nan, 0.1), False), ValueError, "strays"),
        *[
            ("joined_cells", (SOME, SOME, CORNER, strays, False), ValueError, "strays")
            for strays in ((2.4, math.nan), (2.4, -0.1), (0.9, 0.1))
        ],
        ("joined_cells", (SOME, SOME, (0.0, 0.0, math.inf), STRAYS, False), ValueError, "frame"),
        ("joined_cells", (SOME, SOME, ("west", 0.0, 0.05), STRAYS, False), TypeError, "frame"),
        ("joined_cells", (SOME[:0], SOME, CORNER, STRAYS, False), ValueError, "cells"),
        ("joined_cells", (SOME, LOST, CORNER, STRAYS, False), ValueError, "nowhere"),
        ("joined_cells", (SOME, LOST.T, CORNER, STRAYS, False), ValueError, "others"),
        ("cells_gap", (SOME, XY, SOME[:, :1], XY), ValueError, "other_cells"),
        ("cells_extent", (SOME.astype(np.float32),), TypeError, "cells"),
        ("put_place", (PLACES, 3, XY, 0.0, SOME), IndexError, "column"),
        ("put_place", (PLACES[:6], 0, XY, 0.0, SOME), ValueError, "places"),
        ("near_places", (PLACES, [1, 2, 3, 4], XY, SOME, 1.0), ValueError, "names"),
        ("near_places", (PLACES, (1, 2), XY, SOME, 1.0), TypeError, "names"),
        ("in_plain_view", (PLACES, [1], DEPTH, (1.0,)), TypeError, "lens"),
        ("in_plain_view", (PLACES, [1], DEPTH, (-1.0,) * 26), ValueError, "margin"),
        ("cosine", (ROW, ROW.astype(float)), ValueError, "other"),
        ("add_where", (DEPTH, np.ones((8, 7), bool), 1.0), ValueError, "not the shape"),
        ("shortened", (SOME[:0], 1.0), ValueError, "outline"),
        ("sharpness", (np.zeros((10, 48), np.uint8), 4, 4), ValueError, "whole number"),
        ("sharpness", (np.zeros((1, 3 << 21), np.uint8), 1, 1 << 21), ValueError, "too large"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_told(call, args, error, told):
    with pytest.raises(error, match=told):
        getattr(kernels, call)(*args)
