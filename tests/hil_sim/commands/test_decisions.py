"""`hil-sim decisions`: made-up maps, faults on purpose, and a table that says what was missed."""

import threading

import pytest

from hil_sim.commands.decisions import (
    FRONTIERS,
    OBJECTS,
    Faulty,
    LatencyFigure,
    _with_faults,
    lines,
    made_up,
)
from runtime.clock import Deadline, SystemClock
from runtime.config import Config, load
from runtime.core.types import Brief, Missing, Vote

NAMES = [f"thing {n}" for n in range(OBJECTS)]
BRIEF = made_up("toilet", NAMES, ("kitchen", "bathroom"), "0")


def first(brief: Brief, by: Deadline) -> Vote | Missing:
    return Vote("", (brief.frontiers[0].id,), (), "the first")


class FakeModels:
    def seated(self, config: Config):
        return {"a": first, "b": first, "c": first}


def test_a_made_up_map_is_what_it_says_and_repeats() -> None:
    assert len(BRIEF.frontiers) == FRONTIERS
    assert {o.name for f in BRIEF.frontiers for o in f.objects} == set(NAMES)
    assert all(sum(p for _, p in f.rooms) == pytest.approx(1.0) for f in BRIEF.frontiers)
    assert made_up("toilet", NAMES, ("kitchen", "bathroom"), "0") == BRIEF
    assert made_up("toilet", NAMES, ("kitchen", "bathroom"), "1") != BRIEF


def test_a_third_of_the_calls_are_at_fault() -> None:
    faulty, outcomes = Faulty(first, 0.0, "seed"), []
    for _ in range(300):
        try:
            outcomes.append(faulty(BRIEF, Deadline.never(SystemClock())))
        except RuntimeError:
            outcomes.append(None)
    good = sum(isinstance(o, Vote) and o.reason == "the first" for o in outcomes)
    assert good == 300 - sum(faulty.faults.values())
    assert 80 <= sum(faulty.faults.values()) <= 120
    assert all(faulty.faults.values())


@pytest.mark.slow
def test_every_decision_is_made_and_nothing_is_left_over() -> None:
    config = load(None, ["panel.decide_budget_s=0.1"])
    figures, told = _with_faults(FakeModels(), [BRIEF], config, 40, 0)  # type: ignore[arg-type]
    assert sum(told["voters"].values()) == 40  # type: ignore[attr-defined]
    assert sum(c["hang"] + c["error"] + c["nonsense"] for c in told["calls"].values()) > 0  # type: ignore[attr-defined]
    by_name = {f.what.strip(): f.value for f in figures}
    assert by_name["threads more at the end"] == 0
    for thread in threading.enumerate():
        if thread.name.startswith("expert-"):
            thread.join(5.0)  # one may still hang, and ends by itself
            assert not thread.is_alive()


def test_the_table_says_what_was_missed() -> None:
    table = lines([LatencyFigure("quick", 0.05, "s", 0.1), LatencyFigure("slow", 3.0, "s", 2.0)])
    assert not table[1].endswith("MISSED")
    assert table[2].endswith("MISSED")
    assert LatencyFigure("never", float("inf"), "s", 2.0).missed
    assert LatencyFigure("unknown", float("nan"), "s", 2.0).missed


@pytest.mark.slow
def test_the_command_runs_on_the_embedded_models(tmp_path) -> None:
    import json

    from click.testing import CliRunner

    from hil_sim.commands.decisions import decisions_command

    file = tmp_path / "speed.json"
    arguments = ["--count", "20", "--budget", "0.3", "--json", str(file)]
    result = CliRunner().invoke(decisions_command, arguments)
    assert result.exit_code in (0, 1), result.output  # how fast this machine is, is not tested
    told = json.loads(file.read_text())
    assert sum(told["voters"].values()) == 20
