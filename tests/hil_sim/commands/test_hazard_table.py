"""The table of `hil-sim hazards`, and the file of its trials."""

from pathlib import Path

import pytest

from hil_sim.commands.hazard_table import HEADER, TrialsFile, Tried, line, table
from hil_sim.driving.hazard_trials import HazardTrial
from runtime.errors import ConfigError


def trial(kind="box", ahead_m=1.0, v_mps=0.4, **other):
    return HazardTrial(kind, ahead_m, 0.9, v_mps, **({"pixels": 5000, "gap_m": 0.2} | other))


SEEN = trial(zero_s=0.5, shown_zero_s=0.3, slow_s=0.0, resumed_s=0.1)
HIT = trial(ahead_m=0.6, touched=True, touch_mps=0.2, pushed_s=0.7, zero_s=0.9, slow_s=0.6)
LOW = trial(pixels=0, touched=True)
NEAR = trial("leg", 0.1, due=True, shown_zero_s=0.05, slow_s=0.05)


def test_what_could_be_avoided_and_what_not_are_counted_apart():
    lines = list(table([Tried("this", "level", 0.5, [SEEN, LOW, NEAR, HIT])]))
    assert lines[: len(HEADER)] == list(HEADER)
    assert lines[len(HEADER) :] == [
        "| this | box | level | 3 | 2 | 1 | 1 | 1 | 0.70 s | 0.30, 0.60 s | 0: - | 0.10, 0.10 s |",
        "| this | leg | level | 1 | 0 | 0 | 1 | 0 | 0.00 s | 0.05, 0.05 s | 1: 0.05, 0.05 s | - |",
    ]
    assert list(table([])) == list(HEADER)


def test_what_was_touched_but_could_not_be_avoided_is_no_failure():
    assert Tried("this", "level", 0.5, [SEEN, HIT]).hit()
    assert not Tried("this", "level", 0.5, [SEEN, LOW, NEAR]).hit()


def test_a_trial_in_a_line():
    assert "0.60 m ahead at 0.40 m/s" in line(HIT)
    assert "touched at 0.20 m/s, driven on for 0.70 s" in line(HIT)
    assert "no zero, not touched" in line(NEAR)


def test_what_is_kept_goes_on_where_it_stopped(tmp_path: Path):
    path, how = tmp_path / "trials.json", {"ahead": (0.5, 1.5), "seed": 0}
    file = TrialsFile(path, how)
    assert file.of("this") == []
    file.keep("this", [SEEN])
    file.keep("a4db551", [HIT, LOW])
    file.keep("this", [NEAR])
    again = TrialsFile(path, how)
    assert again.of("this") == [SEEN, NEAR]
    assert again.of("a4db551") == [HIT, LOW]
    with pytest.raises(ConfigError, match="holds other trials"):
        TrialsFile(path, how | {"seed": 1})


def test_without_a_file_nothing_is_kept():
    file = TrialsFile(None, {})
    file.keep("this", [SEEN])
    assert file.of("this") == [SEEN]
