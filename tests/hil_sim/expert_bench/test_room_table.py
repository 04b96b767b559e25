"""A table of things by room type, counted by hand."""

import math

import numpy as np
import pytest

from hil_sim.expert_bench.room_table import RoomTable
from hil_sim.expert_bench.view_questions import SightRows, ViewQuestions


def questions(
    rooms: list[list[float]], asked: list[list[int]], true: list[list[int]]
) -> ViewQuestions:
    none = np.zeros((0, 0))
    sights = SightRows(none, none, none, np.array(rooms), none, none, ("a",) * len(rooms))
    return ViewQuestions(sights, np.array(asked, bool), np.array(true, bool))


KITCHEN, BATH = [1.0, 0.0], [0.0, 1.0]


def test_shares_are_counted_by_room() -> None:
    rooms, true = [KITCHEN] * 3 + [BATH] * 2, [[1], [1], [0], [0], [0]]
    table = RoomTable.fit(questions(rooms, [[1]] * 5, true))
    # one answer of each kind is counted already: (2 + 1) / (3 + 2), (0 + 1) / (2 + 2)
    assert table.share[:, 0] == pytest.approx([0.6, 0.25], abs=1e-5)
    nats = table.score(np.array([[0.5, 0.5]]), np.array([0]))
    assert nats == pytest.approx(math.log(0.425), abs=1e-4)


def test_what_was_not_asked_is_not_counted() -> None:
    table = RoomTable.fit(questions([KITCHEN] * 2, [[1], [0]], [[1], [1]]))
    assert table.share[0, 0] == pytest.approx(2 / 3, abs=1e-5)


def test_a_room_that_is_not_sure_counts_in_part() -> None:
    table = RoomTable.fit(questions([[0.25, 0.75]], [[1]], [[1]]))
    assert table.share[:, 0] == pytest.approx([1.25 / 2.25, 1.75 / 2.75], abs=1e-5)


def test_who_never_counted_a_name_guesses_by_names_alike() -> None:
    names = np.array(
        [[1.0, 0.0], [0.0, 1.0], [0.995, 0.0998]]
    )  # the third is called like the first
    table = RoomTable(np.array([[0.9, 0.1, 0.4], [0.2, 0.7, 0.4]]))
    guessed = table.guessing([2], names)
    assert guessed.share[:, 2] == pytest.approx([0.9, 0.2], abs=1e-3)
    assert (guessed.share[:, :2] == table.share[:, :2]).all()
    assert table.share[0, 2] == 0.4
