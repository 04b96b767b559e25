"""One expert on several rungs: which one answers, and what is said when none can."""

import math

from manual_clock import ManualClock

from runtime.clock import Deadline
from runtime.core.types import Absence, Brief, FrontierBrief, Missing, Vote
from runtime.experts.fallback import Rung, with_fallback
from runtime.experts.panel import Expert

BRIEF = Brief("toilet", 0, tuple(FrontierBrief(i, float(i), (), ()) for i in (1, 2)))


def says(outcome: Vote | Missing, asked: list[float] | None = None) -> Expert:
    def expert(brief: Brief, by: Deadline) -> Vote | Missing:
        if asked is not None:
            asked.append(by.left_s())
        return outcome

    return expert


def vote(*ids: int) -> Vote:
    return Vote("", ids, tuple((i, 0.5) for i in ids), "because")


def never() -> Deadline:
    return Deadline.never(ManualClock())


def test_the_first_rung_that_answers_is_named() -> None:
    asked: list[float] = []
    expert = with_fallback(
        "o2f",
        [
            Rung("local", says(Missing("", Absence.LATE))),
            Rung("cloud", says(vote(2))),
            Rung("embedding", says(vote(1), asked)),
        ],
    )
    assert expert(BRIEF, never()) == Vote("o2f", (2,), ((2, 0.5),), "because", "cloud")
    assert asked == []


def test_an_abstention_is_an_answer() -> None:
    for cause in (Absence.NO_EVIDENCE, Absence.NO_PREFERENCE, Absence.ABSTAINS):
        expert = with_fallback(
            "o2f", [Rung("a", says(Missing("x", cause, "x"))), Rung("b", says(vote(1)))]
        )
        assert expert(BRIEF, never()) == Missing("o2f", cause, "x")


def test_who_abstains_says_why_those_above_could_not() -> None:
    above = [
        Rung("a", says(Missing("", Absence.LATE))),
        Rung("b", says(vote(1)), ready=lambda by: False),
    ]
    for detail, told in (("", "a: late; b: not ready"), ("x", "a: late; b: not ready; x")):
        below = Rung("c", says(Missing("", Absence.NO_EVIDENCE, detail)))
        outcome = with_fallback("sle", [*above, below])(BRIEF, never())
        assert outcome == Missing("sle", Absence.NO_EVIDENCE, told)


def test_every_rung_says_why_it_could_not() -> None:
    def falls_over(brief: Brief, by: Deadline) -> Vote:
        raise RuntimeError("out\nof memory")

    expert = with_fallback(
        "sle",
        [
            Rung("local", falls_over),
            Rung("cloud", says(vote(1)), ready=lambda by: False),
            Rung("embedding", says(Missing("", Absence.NONSENSE, "x"))),
        ],
    )
    causes = (
        "the model on the robot: out of memory; the model in the cloud: not ready; the likeness of "
        "words, without a language model: nonsense: x"
    )
    assert expert(BRIEF, never()) == Missing("sle", Absence.NO_MODEL, causes)
    assert with_fallback("sle", [])(BRIEF, never()) == Missing("sle", Absence.NO_MODEL)


def test_time_is_left_for_the_rungs_below() -> None:
    clock, asked = ManualClock(), list[float]()
    expert = with_fallback(
        "o2f",
        [
            Rung("local", says(Missing("", Absence.LATE), asked), share=0.4),
            Rung("cloud", says(Missing("", Absence.LATE), asked), share=0.9),
            Rung("embedding", says(vote(1), asked), share=0.1),
        ],
    )
    expert(BRIEF, Deadline.after(2.0, clock))
    assert [round(left, 6) for left in asked] == [0.8, 1.8, 2.0]
    asked.clear()
    expert(BRIEF, Deadline.never(clock))
    assert asked == [math.inf] * 3


def test_people_are_told_of_models_by_what_they_are() -> None:
    above = [
        Rung("local", says(Missing("", Absence.LATE))),
        Rung("head", says(Missing("", Absence.NO_IMAGES, "no view of a frontier yet"))),
    ]
    below = Rung("embedding", says(Missing("", Absence.NO_EVIDENCE)))
    told = "the model on the robot: late; no view of a frontier yet"
    assert with_fallback("sle", [*above, below])(BRIEF, never()) == Missing(
        "sle", Absence.NO_EVIDENCE, told
    )
