"""What was measured beside what it may be."""

import math
from dataclasses import replace

import numpy as np
import pytest

from runtime.bench.measure import Measured
from runtime.bench.verdict import GROWN_S, ratios, rows, table
from runtime.tracing.budgets import read_budgets
from runtime.tracing.histogram import Histogram
from runtime.tracing.stages import Stage

BUDGETS = read_budgets()


def told(ms: float, n: int = 100) -> dict[str, float]:
    histogram = Histogram()
    for _ in range(n):
        histogram.add(ms / 1e3)
    return histogram.told()


GOOD = Measured(
    stages={stage.value: told(b.median_ms / 2) for stage, b in BUDGETS.stages.items()},
    sleeper=told(1.0),
    seconds=10.0,
    ready_s=2.0,
    first_command_s=0.2,
    memory_mb=500.0,
    grown_mb=1.0,
    halts={},
    decisions=3,
)


def broken(run: Measured) -> set[str]:
    return {row.name for row in rows(run, BUDGETS) if row.broken}


def test_what_is_within_its_budgets_breaks_none():
    assert broken(GOOD) == set()
    assert "BROKEN" not in table(rows(GOOD, BUDGETS))


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"ready_s": 5.1}, "start to ready"),
        ({"first_command_s": None}, "goal to first command"),
        ({"memory_mb": 701.0}, "memory"),
        ({"seconds": 30.0}, "detector"),  # as many looks in three times the time
    ],
)
def test_each_figure_of_the_loop_breaks_its_own(change, name):
    assert broken(replace(GOOD, **change)) == {name}
    (line,) = (
        line
        for line in table(rows(replace(GOOD, **change), BUDGETS)).splitlines()
        if "BROKEN" in line
    )
    assert line.startswith(name)


def test_growth_is_judged_in_long_runs_by_the_hour():
    def grown(seconds: float, mb: float) -> set[str]:
        looks = GOOD.stages["detect"] | {"n": seconds * BUDGETS.loop.detector_hz}
        stages = GOOD.stages | {"detect": looks}
        return broken(replace(GOOD, stages=stages, seconds=seconds, grown_mb=mb))

    assert grown(600.0, 1.5) == set()  # 18 MB an hour
    assert grown(600.0, 2.0) == {"growth in an hour"}
    assert grown(GROWN_S, 50.0) == set()  # half of it is too short


def test_a_slow_stage_breaks_its_own_and_few_of_it_say_nothing_of_the_99th():
    slow = BUDGETS.stages[Stage.SURVEY].p99_ms * 1.2
    stages = GOOD.stages | {"survey": told(slow)}
    assert broken(replace(GOOD, stages=stages)) == {"survey median", "survey p99"}
    few = replace(GOOD, stages=GOOD.stages | {"survey": told(slow, n=5)})
    assert broken(few) == {"survey median"}


def test_lateness_is_judged_above_that_of_a_process_that_only_sleeps():
    late = replace(GOOD, stages=GOOD.stages | {"late": told(4.0)}, sleeper=told(0.1))
    assert broken(late) == set()
    later = replace(GOOD, stages=GOOD.stages | {"late": told(29.0)}, sleeper=told(0.1))
    assert "late above a sleeper p99" in broken(later)
    busy = replace(later, sleeper=told(28.0))
    assert "late above a sleeper p99" not in broken(busy)


def test_ratios_are_of_pairs_with_an_interval_that_holds_what_is_so():
    random = np.random.default_rng(3)

    def run(factor: float) -> Measured:
        noise = 1 + 0.02 * random.standard_normal()
        return replace(GOOD, stages={"survey": told(10 * factor * noise), "act": told(1.0)})

    ours, theirs = [run(1.3) for _ in range(8)], [run(1.0) for _ in range(8)]
    survey, act = ratios(ours, theirs)
    assert survey.stage == "survey"
    assert 1.2 < survey.low < survey.ratio < survey.high < 1.4
    assert (act.low, act.ratio, act.high) == (1.0, 1.0, 1.0)
    assert ratios([replace(GOOD, stages={})], [GOOD]) == []


def test_the_interval_holds_the_ratio_as_often_as_it_says_with_three_pairs():
    random, held = np.random.default_rng(7), 0
    for _ in range(400):
        logs = random.normal(math.log(11), 0.25, 3)  # much more than the histogram's buckets
        ours = [replace(GOOD, stages={"act": told(math.exp(at))}) for at in logs]
        theirs = [replace(GOOD, stages={"act": told(1.0)})] * 3
        (act,) = ratios(ours, theirs)
        held += act.low <= 11 <= act.high
    assert 0.92 <= held / 400 <= 0.98


def test_experts_at_work_are_judged_where_goals_came_one_after_the_other():
    idle = replace(GOOD, stages=GOOD.stages | {"score": told(1.0) | {"total_s": 1.0}})
    assert broken(idle) == set()
    assert broken(replace(idle, goals=2)) == {"experts at work"}
    busy = idle.stages | {"score": told(1.0) | {"total_s": idle.seconds}}
    assert broken(replace(idle, goals=2, stages=busy)) == set()
