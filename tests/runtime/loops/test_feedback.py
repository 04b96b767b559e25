"""What is told of a search to whoever asked for it."""

import math
from types import SimpleNamespace

import pytest

from runtime.core.types import Pose, SearchState
from runtime.loops.feedback import FEEDBACK_S, Feedback
from runtime.service.limits import GoalLimits


class Listener:
    def __init__(self) -> None:
        self.heard: list[dict[str, object]] = []

    def publish_feedback(self, feedback: dict[str, object]) -> None:
        self.heard.append(feedback)


def test_the_way_is_summed_up_piece_by_piece():
    track: list[tuple[float, float]] = []
    shut, open_ = SimpleNamespace(distance_m=math.inf), SimpleNamespace(distance_m=2.0)
    body = SimpleNamespace(last=None, visited_xy=track)
    search = SimpleNamespace(
        order=SimpleNamespace(id="a1", limits=GoalLimits(time_s=60.0)),
        goal=SimpleNamespace(text="bed"),
        world=SimpleNamespace(
            body=body, frontiers=(shut, open_, open_), pose=Pose(4.0, 5.0, math.pi / 2)
        ),
        decisions=0,
        in_words="frontier 2, by distance",
    )
    feedback, listener = Feedback.of(search, 0.0), Listener()
    told = []
    for second, new in enumerate(([], [(0.0, 0.0)], [(3.0, 4.0), (3.0, 5.0)], [], [(4.0, 5.0)])):
        track += new
        feedback.tell(listener, SearchState.SEARCHING, "", second * FEEDBACK_S)
        told.append(listener.heard[-1]["driven_m"])
    assert told == pytest.approx([0.0, 0.0, 6.0, 6.0, 7.0])
    feedback.tell(listener, SearchState.SEARCHING, "", 4 * FEEDBACK_S)
    assert len(listener.heard) == 5  # nothing changed, and it is not time
    last = listener.heard[-1]
    assert (last["id"], last["vote"], last["frontiers"]) == ("a1", "frontier 2, by distance", 2)
    assert last["limits"] == {"time_s": 60.0}
    assert last["pose"] == [4.0, 5.0, 1.571]
    feedback.tell(listener, SearchState.FOUND, "", 4 * FEEDBACK_S, True, {"result": "found"})
    assert listener.heard[-1]["result"] == "found"


def test_a_way_that_was_driven_for_another_goal_is_none_of_this_ones():
    body = SimpleNamespace(last=None, visited_xy=[(0.0, 0.0), (3.0, 4.0)])
    feedback = Feedback.of(SimpleNamespace(world=SimpleNamespace(body=body)), 0.0)
    assert feedback.way_m() == 0.0
    body.visited_xy.append((3.0, 6.0))
    assert feedback.way_m() == pytest.approx(2.0)
