"""Names that nobody was taught are in two lists."""

from pathlib import Path

import pytest

from hil_sim.expert_bench.never_taught import never_taught
from hil_sim.ground_truth.labels import LABELLED
from runtime.errors import RfNavError


def test_names_that_nobody_was_taught_are_in_two_lists(tmp_path: Path) -> None:
    (tmp_path / "names.toml").write_text('[held_out]\nsafe = ["safe"]\n')
    with pytest.raises(RfNavError, match="no lists of names that were never taught"):
        never_taught(tmp_path)
    (tmp_path / "beyond.toml").write_text('never_trained = ["mirror"]\n')
    assert never_taught(tmp_path) == {"safe", "mirror"}


def test_ours_are_things_that_homes_have() -> None:
    assert {"mirror", "safe"} <= never_taught() <= set(LABELLED)
