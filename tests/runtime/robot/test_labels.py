"""Labels from the bus become detections of the vocabulary, or one clear error."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.errors import SensorError
from runtime.robot.labels import read_labels

NAMES, ROOMS = ("bed", "chair"), ("bedroom", "kitchen", "hallway")


def test_known_names_are_kept_and_the_room_is_told():
    message = {
        "boxes": [[0, 0, 4, 4], [1, 1, 2, 2], [5, 5, 9, 9]],
        "names": ["chair", "ghost", "bed"],
        "scores": [0.9, 0.8, 1.0],
        "room": "kitchen",
    }
    found = read_labels(message, NAMES, ROOMS)
    assert found.labels.tolist() == [1, 0]
    assert found.boxes_px.tolist() == [[0, 0, 4, 4], [5, 5, 9, 9]]
    assert int(found.rooms.argmax()) == 1
    assert found.rooms.sum() == pytest.approx(1.0)


def test_an_unknown_room_says_nothing():
    message = {"boxes": [], "names": [], "scores": [], "room": None}
    assert read_labels(message, NAMES, ROOMS).rooms.size == 0


JSON = st.recursive(
    st.none() | st.booleans() | st.floats(allow_nan=False) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3),
    max_leaves=8,
)


@given(st.dictionaries(st.sampled_from(["boxes", "names", "scores", "room"]), JSON))
def test_nonsense_is_one_error(message: dict):
    try:
        found = read_labels(message, NAMES, ROOMS)
    except SensorError:
        return
    assert len(found.boxes_px) == len(found.scores) == len(found.labels)
    assert np.isin(found.labels, [0, 1]).all()
