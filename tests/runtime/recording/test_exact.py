"""What goes through JSON comes back to the last bit."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from runtime.core.types import Absence, Ballot, Detections, Missing, Pose, Vote
from runtime.recording.exact import as_json, exact, read, read_array


@given(st.floats(), st.floats(width=32))
def test_floats(wide: float, narrow: float):
    told = json.loads(as_json([wide, np.float32(narrow)]))
    back = float(told[0]), np.float32(told[1])
    assert np.array([back[0]]).tobytes() == np.array([wide]).tobytes() or math.isnan(wide)
    assert back[1] == np.float32(narrow) or math.isnan(narrow)


@given(arrays(np.float32, st.tuples(st.integers(0, 40), st.integers(0, 4))))
def test_arrays_short_and_long(array: np.ndarray):
    back = read_array(json.loads(as_json(array)))
    assert back.dtype == array.dtype
    assert np.array_equal(back, array, equal_nan=True)


def test_detections_and_a_ballot():
    rng = np.random.default_rng(3)
    seen = Detections(
        rng.random((30, 4), np.float32),
        rng.random(30, np.float32),
        rng.integers(0, 9, 30).astype(np.int32),
        rng.random((30, 384), np.float32),
        np.zeros(0, np.float32),
    )
    back = read(json.loads(as_json(seen)), Detections)
    for name in ("boxes_px", "scores", "labels", "embeddings", "rooms", "scene", "depths_m"):
        mine, theirs = getattr(seen, name), getattr(back, name)
        assert mine.dtype == theirs.dtype
        assert mine.tobytes() == theirs.tobytes()
        assert mine.shape == theirs.shape
    ballot = Ballot(
        (Vote("o2f", (2, 5), ((2, 0.1), (5, 1 / 3)), "a sink", reasons=((2, "sink"),)),),
        (Missing("sle", Absence.NO_TIME, "0.1 s"),),
        {"o2f": 0.1 + 0.2},
    )
    assert read(json.loads(as_json(ballot)), Ballot) == ballot


def test_what_cannot_be_told_is_refused():
    with pytest.raises(TypeError, match="a object is not recorded"):
        exact(object())
    with pytest.raises(ValueError, match="not a Pose"):
        read({"x_m": 1.0}, Pose)
    assert exact({"image": b"12345", "why": Absence.LATE}) == {"image": 5, "why": "late"}
