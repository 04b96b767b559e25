"""Votes of the harness's: by the truth, in the scene's frame; or at random, by seed."""

import math
import random
from typing import Any

import numpy as np
import pytest

from hil_sim.driving.told_votes import HarnessVotes, drawn_vote, known_vote
from hil_sim.ground_truth.oracle_votes import AskedFrontier

QUESTION = {
    "stamp_ns": 5,
    "goal": "bed",
    "experts": ["r2f", "sle"],
    "frontiers": [
        {"id": 3, "goal_xy": [1.0, 0.0], "cells_xy": [[1.0, 0.0], [1.1, 0.0]], "distance_m": 1.0},
        {"id": 7, "goal_xy": [2.0, 1.0], "cells_xy": [[2.0, 1.0]], "distance_m": 2.5},
        {"id": 8, "goal_xy": [9.0, 1.0], "cells_xy": [[9.0, 1.0]], "distance_m": 9.5},
    ],
}


class Knows:
    """Evidence is how far right a frontier lies, of ten metres, and is asked about one thing."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, list[AskedFrontier]]] = []

    def evidence(self, kind: str, frontiers: list[AskedFrontier]) -> dict[int, float]:
        self.asked.append((kind, frontiers))
        return {f.id: f.goal_xy[0] / 100 for f in frontiers}


def answered(voter: HarnessVotes) -> dict[str, Any]:
    return voter.answer(QUESTION, lambda x, y: (x + 80.0, y))


def test_what_is_known_is_voted_for_and_told_in_the_scenes_frame() -> None:
    known = Knows()
    told = answered(HarnessVotes((("r2f", "rooms"), ("sle", "random")), known, "e1", 0))
    ((kind, frontiers),) = known.asked
    assert kind == "rooms"
    assert frontiers[0].cells_xy.tolist() == [[81.0, 0.0], [81.1, 0.0]]
    assert told["stamp_ns"] == 5
    rooms, drawn = told["votes"]
    assert (rooms["expert"], rooms["frontiers"], rooms["reason"]) == (
        "r2f",
        [3, 7, 8],
        "rooms known",
    )
    assert (drawn["expert"], drawn["reason"]) == ("sle", "at random")
    assert set(drawn["frontiers"]) <= {3, 7, 8}


def test_of_no_frontiers_there_is_no_vote() -> None:
    """The runtime asks although none is left, before its last resorts."""
    voter = HarnessVotes((("r2f", "beyond"), ("sle", "random")), Knows(), "e1", 0)
    told = voter.answer(QUESTION | {"frontiers": []}, lambda x, y: (x, y))
    assert told == {"stamp_ns": 5, "votes": []}


def test_a_random_vote_is_the_same_again_and_another_in_another_episode() -> None:
    def drawn(episode: str, seed: int) -> str:
        return str(
            answered(HarnessVotes((("r2f", "random"), ("sle", "random")), Knows(), episode, seed))
        )

    assert drawn("e1", 0) == drawn("e1", 0)
    assert len({drawn(f"e{n}", 0) for n in range(8)} | {drawn("e1", 1)}) > 4


def test_where_all_are_alike_nobody_votes() -> None:
    assert known_vote("r2f", {1: 0.5, 2: 0.5, 3: 0.48}, "rooms") is None
    assert known_vote("r2f", {}, "rooms") is None
    vote = known_vote("r2f", {1: 0.0, 2: 1.0, 3: 0.6, 4: 0.2}, "rooms")
    assert vote is not None
    assert vote.frontiers == (2, 3)
    assert np.isclose(sum(p for _, p in vote.probabilities), 1.0, atol=1e-3)
    assert all(p > 0 for _, p in vote.probabilities)  # it may be wrong where nothing speaks
    nats = dict(vote.nats)
    assert nats[2] - nats[3] == pytest.approx(math.log(1.0 / 0.6), abs=2e-3)
    assert nats[1] < nats[4] < 0 < nats[3]


def test_a_drawn_vote_is_for_one_or_two() -> None:
    sets = [drawn_vote("r2f", [4, 2, 9], random.Random(n)).frontiers for n in range(30)]
    assert {len(chosen) for chosen in sets} == {1, 2}
    assert {id for chosen in sets for id in chosen} == {2, 4, 9}
    assert drawn_vote("r2f", [4], random.Random(0)).probabilities == ((4, 1.0),)
