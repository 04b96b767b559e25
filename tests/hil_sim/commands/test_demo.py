"""What is told at the end of an episode."""

from dataclasses import replace

import pytest

from hil_sim.commands.demo import final_lines
from hil_sim.driving.episode_result import End, Ended, EpisodeResult
from hil_sim.ground_truth.witness import Claim

FAILED = EpisodeResult(
    episode="cedar-chair-0", scene="cedar", goal="chair", method="rfnav", protocol="hm3d",
    success=False, ended=Ended(End.STOP), steps=44, collisions=0, decisions=7,
    shortest_path_m=2.88, path_m=2.5, distance_m=2.172, spl=0.0, soft_spl=0.25,
    reason="found chair 7 (p 1.00)", claim=Claim.FALSE,
)  # fmt: skip


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
