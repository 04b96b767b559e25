"""One screen: what is wrong comes first, then all that a person would ask."""

from typing import Any

import pytest

from runtime.commands.status_screen import screen, wrong
from runtime.core.types import Pose
from runtime.loops.standing import RunState
from runtime.service.zones import Surroundings, Zones
from runtime.tracing.budgets import Budgets, LoopBudget, StageBudget
from runtime.tracing.stages import Stage

NEEDED = ("color", "odom")
LOOP = LoopBudget(1, 1, 1, 1, 1, 1, 1, 1, 1)
BUDGETS = Budgets({Stage.SURVEY: StageBudget(20.0, 45.0)}, LOOP)


def health(received: int, arrival_s: float | None, bad: int = 0) -> dict[str, Any]:
    return {"received": received, "bad": bad, "last_error": "", "arrival_s": arrival_s}


def status(**other: Any) -> dict[str, Any]:
    return {
        "state": "searching", "runtime": {"state": "searching", "cause": ""}, "halt": "",
        "halts": {}, "base": {"battery_percent": None}, "goal": "a mug", "elapsed_s": 34.2,
        "driven_m": 12.34, "decisions": 5, "does": "look at mug 7 (0.61)", "rung": "smollm2-135m",
        "models": {"rungs": {"o2f": "local", "r2f": "cloud"}, "errors": []},
        "streams": {"color": health(100, 9.9), "odom": health(200, 9.99), "scan": health(0, None)},
        "stages": {"survey": {"p50_ms": 12.1, "p99_ms": 30.24, "over": 2}, "odd": {}},
        "journal_lost": "", "journal": "/var/lib/rf-nav/decisions.jsonl", "now_s": 10.0,
        "up_s": 7300.0, "memory_mb": 512.4, "refuses": "", "memory": "bound by the dock",
    } | other  # fmt: skip


def test_all_is_well_and_told():
    streams = {"color": health(90, 8.9), "odom": health(180, 8.9), "scan": health(0, None)}
    before = status(now_s=9.0, streams=streams)
    assert screen(status(), before, NEEDED, BUDGETS) == [
        "state    searching",
        'goal     "a mug", 34 s, 12.3 m, 5 decisions',
        "does     look at mug 7 (0.61)",
        "home     bound by the dock",
        "halts    none",
        "models   smollm2-135m answers; o2f local, r2f cloud",
        "stream                                         per s   age s    bad",
        "  color                                         10.0     0.1      0",
        "  odom                                          20.0     0.0      0",
        "  scan                                           0.0   never      0",
        "stage, ms       p50      p99   budget   over",
        "  survey       12.1     30.2       45      2",
        "  odd           0.0      0.0               0",
        "memory   512 MB, up 2.0 h",
        "journal  /var/lib/rf-nav/decisions.jsonl",
    ]
    assert wrong(status(), NEEDED) == []


def test_whether_the_home_is_known_is_told_where_one_is_remembered():
    told = "unbound: nothing seen so far tells where it is"
    assert f"home     {told}" in screen(status(memory=told), status(), NEEDED, BUDGETS)
    assert not [
        line for line in screen(status(memory="none"), status(), NEEDED, BUDGETS) if "home" in line
    ]


def test_what_is_wrong_comes_first():
    told = status(
        runtime={"state": "held", "cause": "odometry: no odometry for 3.0 s"},
        streams={"color": health(0, None), "odom": health(9, 7.0)},
        models={"errors": ["it fell over\x1b[31m"], "cloud": {"error": "no network"}},
        journal_lost="decisions.jsonl: cannot be written", refuses="zones: where are they?",
        halts={"odometry": 2, "plan": 1}, halt="no odometry for 3.0 s",
    )  # fmt: skip
    found = wrong(told, NEEDED)
    assert found == [
        "held: odometry: no odometry for 3.0 s",
        "no goal is taken: zones: where are they?",
        "color: nothing has come",
        "odom: silent for 3 s",
        "model: it fell over [31m",
        "cloud: no network",
        "decisions.jsonl: cannot be written",
    ]
    lines = screen(told, told, NEEDED, BUDGETS)
    assert lines[: len(found)] == [f"WRONG    {line}" for line in found]
    assert "halts    odometry 2, plan 1; now: no odometry for 3.0 s" in lines
    assert "  color                                            ?   never      0" in lines


@pytest.mark.parametrize("state", list(RunState))
def test_how_it_stands_is_wrong_where_it_does_not_do_what_it_is_asked(state: RunState):
    is_well = state in (RunState.SEARCHING, RunState.READY, RunState.STARTING, RunState.PAUSED)
    assert bool(wrong(status(runtime={"state": state.value, "cause": ""}), NEEDED)) is not is_well


def test_what_nobody_needs_may_be_silent_and_what_is_not_there_is_not_missed():
    streams = {"color": health(9, 9.9), "scan": health(9, 1.0)}
    assert wrong(status(streams=streams), NEEDED) == []


def test_without_a_search_and_with_what_waits_and_was():
    told = status(
        goal=None, queue=[{"goal": "a chair", "id": "g3"}, "a lamp"],
        last={"sentence": '"mug" was found at (1.0, 2.0)', "result": "found"},
        base={"battery_percent": 42.4}, up_s=30.0,
        models={"cloud": {"goal_usd": 0.0123, "day_usd": 0.2, "calls": 12, "model": "gpt"}},
    )  # fmt: skip
    lines = screen(told, told, NEEDED, BUDGETS)
    assert "goal     none" in lines
    assert "queue    a chair, a lamp" in lines
    assert 'last     "mug" was found at (1.0, 2.0)' in lines
    assert "battery  42 %" in lines
    assert "money    0.0123 USD for this goal, 0.2000 today, 12 calls of gpt" in lines
    assert "models   smollm2-135m answers" in lines
    assert "memory   512 MB, up 30 s" in lines


def test_why_no_goal_is_taken_is_told_with_the_remedy_which_is_at_its_end():
    lost = Surroundings(lambda: None, lambda: (0.0, 0.0), binding=lambda: Pose(0.0, 0.0, 0.0))
    zones = Zones(None, lost)
    zones.answer({"add": "stairs", "polygon": [[0, 0], [1, 0], [1, 1]]})
    zones.bind(lambda: None, lambda name: None, lambda: False)
    assert wrong(status(refuses=zones.unbound()), NEEDED)[0].endswith("(rfnav/zones)")


def test_how_many_come_a_second_is_not_told_of_one_answer():
    lines = screen(status(), {}, NEEDED, BUDGETS)
    assert "  color                                            ?     0.1      0" in lines


def test_of_a_loop_that_tells_little_little_is_shown():
    assert screen({"state": "ready"}, {}, NEEDED, BUDGETS) == [
        "state    unknown", "goal     none", "halts    none", "models   none answers",
    ]  # fmt: skip


def test_a_screen_is_a_screen():
    topics = {f"topic{n}": health(1, 9.0) for n in range(8)}
    stages = {stage.value: {"p50_ms": 1.0, "p99_ms": 2.0, "over": 0} for stage in Stage}
    lines = screen(status(streams=topics, stages=stages), status(), NEEDED, BUDGETS)
    assert len(lines) < 40
    assert max(map(len, lines)) < 80
