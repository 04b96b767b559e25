"""A new goal is asked of what was seen before."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.core.geometry import GridFrame
from runtime.core.objects.candidates import ranked
from runtime.core.objects.instances import Evidence, Instance, reject, weigh
from runtime.core.objects.recall import RECALL_LOG_ODDS, embedded, recall
from runtime.core.objects.semantic_map import SemanticMap
from runtime.core.objects.verdict import confirmed
from runtime.core.types import Pose

NAMES = ("chair", "beanbag", "bed")
VIEWS = [Pose(0, 0, 0), Pose(0, 2, 0), Pose(3, 0, 0)]


def thing(id: int, name: str, odds: float, embedding: tuple[float, ...] = (1.0, 0.0)) -> Instance:
    row = np.array(embedding, np.float32)
    cells = np.array([[2.0 + id, 1.0]])
    return Instance(
        id,
        {name: Evidence(odds)},
        (2.0 + id, 1.0),
        0.4,
        cells,
        embedding_sum=row,
        views=list(VIEWS),
    )


def remembering(*things: Instance) -> SemanticMap:
    semantic = SemanticMap.empty(NAMES, (), GridFrame(0, 0, 0.05, 4, 4))
    semantic.instances = {t.id: t for t in things}
    return semantic


def near(instance: Instance) -> float:
    """All are as near."""
    return 1.0


def test_what_the_new_words_fit_best_becomes_a_candidate_that_must_be_seen_again():
    memory = remembering(thing(1, "chair", 4.0), thing(2, "bed", 4.0))
    likeness = np.array([[0.3, 0.95, 0.01], [0.02, 0.1, 0.97]], np.float32)
    assert recall(memory, "beanbag", NAMES, likeness) == (1,)
    (found,) = ranked(memory, "beanbag", near)
    assert found is memory.instances[1]
    assert found.name == "beanbag"
    assert not confirmed(found, "beanbag")
    assert memory.instances[2].name == "bed"


def test_what_was_called_that_already_needs_no_embedding_but_a_new_look():
    memory = remembering(thing(1, "bed", 5.0, ()))
    assert embedded(memory)[0] == ()
    assert recall(memory, "bed", NAMES, np.zeros((0, 3), np.float32)) == ()
    (found,) = ranked(memory, "bed", near)
    assert not confirmed(found, "bed")
    weigh(found, "bed", 0.1, VIEWS[0])
    assert not confirmed(found, "bed")  # of this search there is one view
    weigh(found, "bed", 0.1, VIEWS[1])
    assert confirmed(found, "bed")


def test_what_was_rejected_as_this_goal_stays_rejected_and_may_be_another():
    memory = remembering(thing(1, "chair", 4.0))
    sure = np.array([[0.1, 0.9, 0.0]], np.float32)
    recall(memory, "beanbag", NAMES, sure)
    reject(memory.instances[1], "beanbag", -1.0)
    assert recall(memory, "beanbag", NAMES, sure) == ()
    assert ranked(memory, "beanbag", near, least=-1.0) == []
    assert recall(memory, "chair", NAMES, np.array([[0.9, 0.1, 0.0]], np.float32)) == (1,)
    assert ranked(memory, "chair", near) == [memory.instances[1]]


@given(st.floats(-3, 8), st.lists(st.floats(0, 1), min_size=3, max_size=3))
def test_memory_alone_never_confirms_and_no_thing_is_made_up(odds: float, row: list[float]):
    memory = remembering(thing(1, "chair", odds))
    found = recall(memory, "beanbag", NAMES, np.array([row], np.float32))
    instance = memory.instances[1]
    assert not confirmed(instance, "beanbag")
    if found:
        assert instance.odds_of("beanbag") <= RECALL_LOG_ODDS
        assert instance.confidence_of("beanbag") <= max(row) + 1e-3
        assert instance.name == "beanbag"
    else:
        assert instance.evidence == {"chair": Evidence(odds)}


def test_as_many_rows_of_likeness_as_things_are_asked_for():
    with pytest.raises(ValueError, match="zip"):
        recall(remembering(thing(1, "bed", 1.0)), "bed", NAMES, np.zeros((2, 3), np.float32))
