"""Nothing is judged in homes that it has learned of."""

import json

import pytest

from hil_sim.expert_bench import plan_counts
from hil_sim.expert_bench.learned_homes import COUNTED, TAUGHT, check_unknown
from hil_sim.importers import standing_counts
from models.words.counts import PATH
from runtime.errors import RfNavError


def test_homes_that_were_learned_of_are_refused() -> None:
    check_unknown(["train-100000", "FloorPlan_Train1_1", "val-900000", "train-899999"])
    for seed in (COUNTED[0], COUNTED[-1], TAUGHT[0]):
        with pytest.raises(RfNavError, match=f"train-{seed}: what is judged has learned"):
            check_unknown(["train-5", f"train-{seed}"])
    check_unknown([f"train-{TAUGHT[0]}"], [COUNTED])


def test_the_seeds_are_those_of_who_learned() -> None:
    _, first, _, last = json.loads(PATH.read_text(encoding="utf-8"))["source"]["generated"].split()
    counted = range(*(int(name.removeprefix("train-")) for name in (first, last)))
    assert set(counted) <= set(COUNTED)
    assert COUNTED.start == standing_counts.FIRST_SEED
    assert TAUGHT.start == plan_counts.FIRST_SEED
