"""What is told of a search to whoever asked for it."""

from types import SimpleNamespace

import pytest

from runtime.core.types import SearchState
from runtime.loops.feedback import FEEDBACK_S, Feedback


class Listener:
    def __init__(self) -> None:
        self.heard: list[dict[str, object]] = []

    def publish_feedback(self, feedback: dict[str, object]) -> None:
        self.heard.append(feedback)


def test_the_way_is_summed_up_piece_by_piece():
    track: list[tuple[float, float]] = []
    search = SimpleNamespace(
        goal=SimpleNamespace(text="bed"),
        world=SimpleNamespace(body=SimpleNamespace(last=None, visited_xy=track)),
        decisions=0,
    )
    feedback, listener = Feedback(search, 0.0), Listener()
    told = []
    for second, new in enumerate(([], [(0.0, 0.0)], [(3.0, 4.0), (3.0, 5.0)], [], [(4.0, 5.0)])):
        track += new
        feedback.tell(listener, SearchState.SEARCHING, "", second * FEEDBACK_S)
        told.append(listener.heard[-1]["driven_m"])
    assert told == pytest.approx([0.0, 0.0, 6.0, 6.0, 7.0])
    feedback.tell(listener, SearchState.SEARCHING, "", 4 * FEEDBACK_S)
    assert len(listener.heard) == 5  # nothing changed, and it is not time
