"""Experts that go by counts: at once, and with names that others stand in for."""

import random
from collections.abc import Mapping

from runtime.clock import Deadline, SystemClock
from runtime.core.types import Absence, Brief, FrontierBrief, Missing, NearbyObject, Vote
from runtime.core.voting.counts import Count, CountTable
from runtime.core.voting.likelihood_experts import ExpertConfig
from runtime.experts.counts import LEARNT, CountExperts

COUNT = Count(
    rooms={"kitchen": 50, "bedroom": 50},
    holding={name: {"kitchen": 45, "bedroom": 5} for name in ("mug", "stove")}
    | {"bed": {"kitchen": 0, "bedroom": 50}},
    things={"mug": 50, "stove": 50, "bed": 50},
    beside={"mug": {"stove": 40}, "stove": {"mug": 40}, "bed": {"mug": 1}},
    doors={"kitchen": {"bedroom": 1}, "bedroom": {"kitchen": 1}},
)
ALIKE = {"cup": {"mug": 0.9}, "cooker": {"stove": 0.9}, "unicorn": {"mug": 0.1}}
NEVER = Deadline.never(SystemClock())


def experts(asked: list[str] | None = None) -> CountExperts:
    def likeness(name: str) -> Mapping[str, float]:
        if asked is not None:
            asked.append(name)
        return ALIKE.get(name, {})

    return CountExperts(CountTable.of([COUNT]), likeness)


def brief(goal: str, *near: str) -> Brief:
    told = tuple(
        FrontierBrief(n, float(n), (NearbyObject(name, 0.9, 0.3),), ((room, 1.0),), unknown_m2=1.0)
        for n, (name, room) in enumerate(zip(near, ("kitchen", "bedroom"), strict=True), 1)
    )
    return Brief(goal, 0, told)


def chosen(counts: CountExperts, expert: str, asked: Brief) -> tuple[int, ...]:
    outcome = counts.experts(ExpertConfig(bar=1.2))[expert](asked, NEVER)
    assert isinstance(outcome, Vote), outcome
    return outcome.frontiers


def test_all_three_vote_for_what_is_likely() -> None:
    counts = experts()
    for name in ("o2f", "r2f", "both"):
        assert chosen(counts, name, brief("mug", "stove", "bed")) == (1,)


def test_names_that_were_counted_need_no_likeness() -> None:
    asked: list[str] = []
    chosen(experts(asked), "o2f", brief("mug", "stove", "bed"))
    assert asked == []


def test_another_name_stands_in_for_a_goal_and_for_what_is_near() -> None:
    asked: list[str] = []
    counts = experts(asked)
    assert chosen(counts, "r2f", brief("cup", "stove", "bed")) == (1,)
    assert chosen(counts, "o2f", brief("cup", "cooker", "bed")) == (1,)
    chosen(counts, "o2f", brief("cup", "cooker", "bed"))
    assert asked == ["cup", "cooker"], "each is compared once"


def test_a_goal_is_compared_before_it_is_asked_about() -> None:
    asked: list[str] = []
    counts = experts(asked)
    counts.begin("cup")
    assert asked == ["cup"]
    chosen(counts, "r2f", brief("cup", "stove", "bed"))
    assert asked == ["cup"]


def test_nothing_alike_leaves_it_to_the_rung_below() -> None:
    outcome = experts().experts(ExpertConfig())["o2f"](brief("unicorn", "stove", "bed"), NEVER)
    assert outcome == Missing("", Absence.NO_MODEL, "never counted: unicorn")


def test_as_if_a_goal_had_never_been_counted() -> None:
    counts = experts().without("mug")
    outcome = counts.experts(ExpertConfig())["r2f"](brief("mug", "stove", "bed"), NEVER)
    assert isinstance(outcome, Missing)


def test_what_is_remembered_of_names_is_bounded() -> None:
    asked: list[str] = []
    counts = experts(asked)
    for n in range(LEARNT + 2):
        counts.evidence(brief("mug", f"thing {n}", "bed"))
    counts.evidence(brief("mug", "thing 0", "bed"))
    assert asked.count("thing 0") == 2
    assert asked.count("thing 2") == 1


def test_what_was_asked_before_changes_nothing() -> None:
    """Not the last bit: a search after others decides as one that is the first."""
    names = ["mug", "stove", "bed"]

    def likeness(name: str) -> Mapping[str, float]:
        rng = random.Random(name)
        return {each: rng.uniform(0.5, 0.7) for each in names}

    told = {}
    for n in range(20):
        first, later = (CountExperts(CountTable.of([COUNT]), likeness) for _ in range(2))
        later.evidence(brief(f"thing {n}", "stove", "bed"))
        asked = brief(f"goal {n}", f"thing {n}", "bed")
        told[n] = first.evidence(asked), later.evidence(asked)
    assert all(one is not None and one == other for one, other in told.values())


def test_what_is_asked_about_now_is_known_when_all_else_is_forgotten() -> None:
    counts = experts()
    counts.begin("cup")
    told = [counts.evidence(brief("cup", f"thing {n}", "bed")) for n in range(LEARNT + 2)]
    assert all(one is not None and one[1] for one in told)
