"""Models that are run again are compared with a tolerance."""

from dataclasses import replace

import numpy as np
import pytest
from fake_models import FakeModels, broken
from lockstep_double import home

from runtime.config import load
from runtime.core.types import Absence, Ballot, Brief, Detections, FrontierBrief, Missing, Vote
from runtime.replay.models_again import SAME_SCORE, WEAK, Agreement, ModelsAgain

NONE = np.zeros((0, 0), np.float32)
SEEN = Detections(
    np.array([[10, 10, 50, 50], [100, 20, 160, 90]], np.float32),
    np.array([0.8, 0.5], np.float32),
    np.array([0, 3], np.int32),
    NONE,
    np.zeros(0, np.float32),
)


def looked(now: Detections) -> Agreement:
    models = FakeModels(home())
    models.detect = lambda rgb, window=None: now  # type: ignore[method-assign]
    again = ModelsAgain(models)
    again.look(4, np.zeros((8, 8, 3), np.uint8), lambda: None, SEEN)
    return again.detections


@pytest.mark.parametrize(
    ("now", "same"),
    [
        (SEEN, 4),
        (replace(SEEN, boxes_px=SEEN.boxes_px + 4), 4),
        (replace(SEEN, boxes_px=SEEN.boxes_px + 30), 0),
        (replace(SEEN, labels=np.array([0, 2], np.int32)), 2),
        (replace(SEEN, scores=SEEN.scores - SAME_SCORE * np.float32(0.9)), 4),
        (replace(SEEN, scores=np.array([0.8, 0.5 - 2 * SAME_SCORE], np.float32)), 2),
    ],
)
def test_a_detection_has_a_counterpart_or_not(now: Detections, same: int):
    found = looked(now)
    assert found.same == same
    assert bool(found.first) == (same < found.of)


def test_what_is_weak_is_not_compared():
    weak = replace(SEEN, scores=np.array([0.8, WEAK / 2], np.float32))
    models = FakeModels(home())
    models.detect = (
        lambda rgb, window=None: replace(  # type: ignore[method-assign]
            SEEN, boxes_px=SEEN.boxes_px[:1], scores=SEEN.scores[:1], labels=SEEN.labels[:1]
        )
    )
    again = ModelsAgain(models)
    again.look(4, np.zeros((8, 8, 3), np.uint8), lambda: None, weak)
    assert (again.detections.same, again.detections.of) == (2, 2)


def test_votes_are_compared_but_for_races():
    both = Vote("", (1, 2), ((1, 0.5), (2, 0.5)), "now")
    models = FakeModels(home(), o2f=lambda brief, by: both, sle=broken)
    again = ModelsAgain(models)
    again.accept("toilet", load(None))
    votes = (Vote("o2f", (1, 2), ((1, 0.6), (2, 0.4)), "then"), Vote("sle", (1,), (), "then"))
    brief = Brief("toilet", 0, tuple(FrontierBrief(n, 1.0, (), ()) for n in (1, 2)))
    again.ask(3, brief, Ballot(votes, (Missing("r2f", Absence.LATE),)))
    models.panel.close()
    assert (again.votes.same, again.votes.of) == (1, 2)
    assert again.votes.first == "sle in turn 3"
    assert not again.votes.enough
    assert "1 of 2 votes come out alike; first not so: sle" in again.votes.in_words("votes")


def test_nothing_compared_is_not_alike():
    models = FakeModels(home())
    models.detect = lambda rgb, window=None: SEEN  # type: ignore[method-assign]
    again = ModelsAgain(models)
    assert not again.alike
    assert again.votes.in_words("votes") == "models: no votes were compared"
    again.look(4, np.zeros((8, 8, 3), np.uint8), lambda: None, SEEN)
    assert again.alike
    again.votes.note(0, 3, "o2f in turn 5")
    assert not again.alike
