"""What a recording drew, read back."""

import numpy as np

from runtime.core.geometry import GridFrame
from runtime.recording.pictures import GREEN, ORANGE, Mark, Picture, drawn
from runtime.view.scenes import planned, scene_marks


def test_marks_are_frontiers_or_things_by_what_is_written_above_them():
    marks = (
        Mark((1.0, 2.0), "7", GREEN), Mark((3.0, 4.5), "tv stand 0.87", ORANGE),
        Mark((0.0, 0.0), "room 12 1.00", ORANGE),
    )  # fmt: skip
    frame, none = GridFrame(0.0, 0.0, 0.05, 2, 2), np.zeros((2, 2), bool)
    picture = Picture(5, frame, none, none, np.array([[0.0, 0.0], [1.004, 2.0]]), marks)
    by_topic = {topic: payload for topic, _, payload in drawn(picture, "odom")}
    told = scene_marks(by_topic["scene"])
    assert [(one["id"], one["xy"]) for one in told["frontiers"]] == [(7, [1.0, 2.0])]
    names = [(one["name"], one["confidence"], one["xy"]) for one in told["things"]]
    assert names == [("tv stand", 0.87, [3.0, 4.5]), ("room 12", 1.0, [0.0, 0.0])]
    assert planned(by_topic["path"]) == [[0.0, 0.0], [1.0, 2.0]]
