"""What is left out where stages overrun, step by step, and taken up again."""

from runtime.loops.shedding import CALM_S, ENOUGH, RESTS, SETTLE_S, Shedding
from runtime.tracing.budgets import read_budgets
from runtime.tracing.stages import Stage
from runtime.tracing.tracer import Overrun

FRAME = Overrun(Stage.FRAME, 200.0, 150.0, ())
DECIDE = Overrun(Stage.DECIDE, 100.0, 60.0, ())
PLACE = Overrun(Stage.PLACE, 100.0, 50.0, ())  # nothing is shed for it


def test_first_looks_of_the_detector_then_what_experts_prepare():
    shedding, now_s, steps = Shedding(read_budgets()), 0.0, []
    for _ in range(6):
        shedding.note([FRAME] * ENOUGH, now_s)
        steps.append((shedding.rest, shedding.experts))
        now_s += SETTLE_S
    assert steps[:3] == [(RESTS[1], False), (RESTS[2], False), (RESTS[2], True)]
    assert set(steps[3:]) == {(RESTS[2], True)}
    assert shedding.steps == 3
    told = "one look of the detectors in 4, nothing prepared for the experts"
    assert shedding.in_words() == f"shed to be in time: {told}"


def test_it_is_taken_up_again_in_calm_in_the_opposite_order():
    shedding, now_s = Shedding(read_budgets()), 0.0
    for _ in range(3):
        shedding.note([FRAME] * ENOUGH, now_s)
        now_s += SETTLE_S
    steps = []
    for _ in range(4):
        now_s += CALM_S
        changed = shedding.note([], now_s)
        steps.append((shedding.rest, shedding.experts, changed))
    assert steps == [
        (RESTS[2], False, True),
        (RESTS[1], False, True),
        (RESTS[0], False, True),
        (RESTS[0], False, False),
    ]


def test_one_overrun_now_and_then_sheds_nothing_nor_does_a_stage_that_says_so():
    shedding = Shedding(read_budgets())
    for second in range(0, 60, 2):
        assert not shedding.note([FRAME, PLACE, PLACE, PLACE], float(second))
    assert (shedding.rest, shedding.experts) == (0.0, False)
    assert shedding.in_words() == ""


def test_a_stage_of_the_experts_sheds_only_what_they_prepare():
    shedding = Shedding(read_budgets())
    assert shedding.note([DECIDE] * ENOUGH, 0.0)
    assert (shedding.rest, shedding.experts) == (0.0, True)
    assert shedding.told() == {"detector_rest": 0.0, "experts": True, "steps": 1}
