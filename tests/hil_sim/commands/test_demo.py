"""hil-sim demo: what is told of a decision and at the end, and where results go."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from hil_sim.commands.demo import METHOD, default_dir, final_lines, vote_lines
from hil_sim.driving.episode_result import End, Ended, EpisodeResult
from hil_sim.ground_truth.witness import Claim

FAILED = EpisodeResult(
    episode="cedar-chair-0", scene="cedar", goal="chair", method="rfnav", protocol="hm3d",
    success=False, ended=Ended(End.STOP), steps=44, collisions=0, decisions=7,
    shortest_path_m=2.88, path_m=2.5, distance_m=2.172, spl=0.0, soft_spl=0.25,
    reason="found chair 7 (p 1.00)", claim=Claim.FALSE,
)  # fmt: skip
DECISION: dict[str, Any] = {
    "why": "frontier 39 is gone", "frontier": 5, "closest": 45, "rule": "prior", "order": [5, 45],
    "taken": {"in_words": "3.2 m on foot, first of 2 in the planned order"},
    "votes": [
        {"expert": "o2f", "frontiers": [4, 5], "probabilities": [[4, 0.3], [5, 0.23]],
         "reason": "4: bath; 5: sink", "reasons": [[4, "bath"], [5, "sink"]]},
        {"expert": "r2f", "frontiers": [4, 9], "probabilities": [[4, 0.3], [9, 0.3], [5, 0.1]],
         "reason": "", "reasons": [[4, "hallway"], [9, "no room known near it"]]},
    ],
    "missing": [{"expert": "sle", "cause": "no evidence: no view of a frontier yet"}],
}  # fmt: skip


@pytest.mark.parametrize(
    ("stands", "told"),
    [
        (("table",), "where a table stands"),
        (("armchair", "table"), "where an armchair and a table stand"),
        (("other",), "where something without a category stands"),
        ((), "where nothing stands"),
    ],
)
def test_a_find_that_does_not_count_is_told_with_what_truly_stands_there(
    stands: tuple[str, ...], told: str
):
    line = final_lines(replace(FAILED, stands=stands))[0]
    assert line == f"FAILURE: stop: found chair 7 (p 1.00), {told}; 2.17 m from where it counts"


@pytest.mark.parametrize(
    "result",
    [
        replace(FAILED, success=True, claim=Claim.TRUE, stands=("chair",)),
        replace(FAILED, reason="gave up", claim=Claim.NONE),
    ],
)
def test_nothing_is_told_of_a_find_that_counts_nor_of_none(result: EpisodeResult):
    assert f"{result.reason}; 2.17 m from where it counts" in final_lines(result)[0]


def test_a_decision_says_what_took_the_frontier_and_who_said_what():
    assert vote_lines(DECISION) == [
        "      vote (frontier 39 is gone): frontier 5: the thing is found soonest in the mean by "
        "looking there first, by the unknown and what all say; the closest is 45",
        "        what took it: 3.2 m on foot, first of 2 in the planned order",
        "        objects near by (o2f): votes for 4 and 5; for 5 (23 % of its belief): sink",
        "        kind of room (r2f): votes for 4 and 9, not for 5; for 4 (30 % of its belief): "
        "hallway",
        "        look of the view (sle): does not vote: no evidence: no view of a frontier yet",
    ]


def test_where_nobody_was_asked_there_is_no_vote():
    alone = DECISION | {"votes": [], "missing": [], "rule": "closest", "order": [], "closest": 5,
                        "taken": {"in_words": "3.2 m on foot"}}  # fmt: skip
    assert vote_lines(alone) == [
        "      decision (frontier 39 is gone): frontier 5: it is the closest: nobody's word "
        "decided",
        "        what took it: 3.2 m on foot",
    ]
    nowhere = alone | {"frontier": None, "closest": None, "rule": "none", "taken": None}
    assert vote_lines(nowhere) == [
        "      decision (frontier 39 is gone): no frontier can be reached"
    ]


def test_a_reason_of_a_whole_set_is_told_once():
    prose = {"expert": "sle", "frontiers": [5], "probabilities": [], "reason": "it looks so",
             "reasons": []}  # fmt: skip
    told = vote_lines(DECISION | {"votes": [prose], "missing": []})
    assert told[-1] == "        look of the view (sle): votes for 5; for 5: it looks so"


@pytest.mark.parametrize(
    ("method", "name"),
    [
        (METHOD, "maple-tv-monitor-3"),
        ("closest", "maple-tv-monitor-3-closest"),
        ("labels/geometry", "maple-tv-monitor-3-labels-geometry"),
    ],
)
def test_each_method_has_a_folder_of_its_own(method: str, name: str):
    assert default_dir("maple", "tv monitor", 3, method) == Path("out") / name
