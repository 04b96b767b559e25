"""The computer, as it might be, and as it is."""

from dataclasses import replace
from pathlib import Path

import pytest

from runtime.config import Config, load
from runtime.doctor.diagnosis import Diagnosis, Grade
from runtime.doctor.machine import MachineState, available_mb, judge_machine, machine
from runtime.tracing.budgets import read_budgets

BUDGET = read_budgets().loop
GOOD = MachineState(4, ("performance",), 4000.0, Path("/var/lib/rf-nav"), 9000.0, "", "", "")


def found(state: MachineState, config: Config | None = None) -> dict[str, Diagnosis]:
    return {one.about: one for one in judge_machine(state, config or Config(), BUDGET)}


def test_a_good_one():
    assert {one.grade for one in found(GOOD).values()} == {Grade.OK}


@pytest.mark.parametrize(
    ("change", "about", "remedy"),
    [
        ({"cores": 1}, "processor", "CPUAffinity"),
        ({"governors": ("powersave", "performance")}, "governor", "cpupower"),
        ({"memory_mb": 300.0}, "memory", "[models]"),
        ({"free_mb": 20.0}, "disk", "make room"),
        ({"refused": "/var: Permission denied"}, "disk", "XDG_STATE_HOME"),
        ({"fifo": "control: no SCHED_FIFO"}, "real time", "LimitRTPRIO"),
        ({"locked": "memory: not locked"}, "memory lock", "LimitMEMLOCK"),
    ],
)
def test_what_is_less_is_warned_of_with_its_remedy(change: dict, about: str, remedy: str):
    told = found(replace(GOOD, **change))
    assert told[about].grade is Grade.WARNING
    assert remedy in told[about].remedy
    assert sum(one.grade is not Grade.OK for one in told.values()) == 1


def test_what_a_system_does_not_tell_is_not_known():
    told = found(replace(GOOD, governors=(), memory_mb=None))
    assert told["governor"].grade is told["memory"].grade is Grade.UNKNOWN


def test_models_with_more_threads_than_there_are_cores():
    told = found(replace(GOOD, cores=2), load(None, ["models.threads=4"]))["processor"]
    assert told.settings == (("models.threads", "2"),)


def test_this_one_can_be_looked_at(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    state = machine()
    assert state.cores >= 1
    assert state.state.is_relative_to(tmp_path)
    assert state.free_mb > 0
    assert not any(tmp_path.iterdir())  # nothing is left behind


def test_memory_is_what_the_group_may_take_where_that_is_less(tmp_path: Path):
    meminfo = tmp_path / "meminfo"
    meminfo.write_text("MemTotal: 8000000 kB\nMemAvailable:    2000000 kB\n")
    assert available_mb(meminfo, tmp_path) == pytest.approx(2048.0)
    (tmp_path / "memory.max").write_text("1000000000\n")
    (tmp_path / "memory.current").write_text("400000000\n")
    assert available_mb(meminfo, tmp_path) == pytest.approx(600.0)
    (tmp_path / "memory.max").write_text("max\n")
    assert available_mb(meminfo, tmp_path) == pytest.approx(2048.0)
    assert available_mb(tmp_path / "none", tmp_path / "none") is None
