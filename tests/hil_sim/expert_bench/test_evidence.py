"""What kinds of evidence are worth where they decide, with voters whose votes are given."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from asked import moment
from manual_clock import ManualClock

from hil_sim.expert_bench import evidence_report
from hil_sim.expert_bench.bank import CLEAN, Bank, BankHome, BenchQuestion, questions_of
from hil_sim.expert_bench.evidence import ROWS, RULES, KindRow, weigh
from hil_sim.expert_bench.voting import Votes
from runtime.clock import Deadline
from runtime.config import Config
from runtime.core.types import Absence, Brief, FrontierBrief, Missing, Vote
from runtime.experts.panel import EXPERTS

Cast = Callable[[str, str, bool], Vote | Missing]


class Told:
    """Votes by expert, what it goes by, and whether it may name every frontier."""

    def __init__(self, cast: Cast) -> None:
        self._cast = cast

    def asked(self, config: Config, questions: Sequence[BenchQuestion]) -> Votes:
        words, every = config.experts.words, config.experts.bar == 0.0
        return self._votes(questions, every, lambda e: config.experts.scene_layout if e == "sle"
                           else words)  # fmt: skip

    def guessing(self, config: Config, questions: Sequence[BenchQuestion]) -> Votes:
        return self._votes(questions, config.experts.bar == 0.0, lambda e: "guessed")

    def check(self) -> None: ...

    def _votes(
        self, questions: Sequence[BenchQuestion], every: bool, by: Callable[[str], str]
    ) -> Votes:
        def ask(expert: str, brief: Brief) -> Vote | Missing:
            return self._cast(expert, by(expert), every)

        table = {e: (lambda brief, left, e=e: ask(e, brief)) for e in EXPERTS}
        return Votes(table, questions, Deadline.never(ManualClock()))


def bank(homes: int = 3) -> Bank:
    """In each home three frontiers at 1, 2 and 3 m, whose costs are 10, 6 and 4 m; information gain
    would have the second."""
    found: list[BenchQuestion] = []
    for n in range(homes):
        one = moment(f"train-{100000 + n}")
        frontiers = tuple(FrontierBrief(id, float(id), (), (), unknown_m2=1.0) for id in (1, 2, 3))
        one = replace(
            one,
            briefs={CLEAN: Brief("", 1_000_000_000 + n, frontiers)},
            order=(2, 1, 3),
            ids=(1, 2, 3),
            goal_xy=((1.0, 0.0), (2.0, 0.0), (3.0, 0.0)),
            costs_m={"toilet": (10.0, 6.0, 4.0)},
        )
        found += questions_of(BankHome(one.home, (one,), {}, "e"))
    return Bank(tuple(found))


def vote(expert: str, ids: Sequence[int], p: Sequence[float] = (0.1, 0.2, 0.7)) -> Vote:
    return Vote(expert, tuple(ids), tuple(zip((1, 2, 3), p, strict=True)), "given")


def weighed(cast: Cast) -> dict[str, KindRow]:
    return weigh(bank(), (), Told(cast))


def everything(expert: str, by: str, every: bool) -> Vote | Missing:
    """Counts know the way, likelihoods have it wrong, views have no set."""
    if every:
        p = (0.1, 0.2, 0.7) if by in ("counts", "both") else (0.7, 0.2, 0.1)
        return vote(expert, (1, 2, 3), p)
    if expert == "sle":
        return Missing(expert, Absence.NO_PREFERENCE)
    return vote(expert, [3] if by in ("counts", "both") else [1])


def test_one_voter_decides_and_is_held_against_what_is_fallen_back_on() -> None:
    rows = weighed(everything)
    counts = rows["o2f, counts"].rules
    assert counts["paper"].decided.tolist() == [1.0] * 3
    assert counts["paper"].regret_m.tolist() == [0.0] * 3
    assert counts["paper"].fallback_m.tolist() == [6.0] * 3, "the closest"
    assert counts["sets"].fallback_m.tolist() == [2.0] * 3, "by information gain"
    assert counts["paper"].gained_m.tolist() == [-6.0] * 3
    assert rows["o2f, language"].rules["sets"].gained_m.tolist() == [4.0] * 3


def test_evidence_is_weighed_with_unknown_area_and_way() -> None:
    def sure(expert: str, by: str, every: bool) -> Vote | Missing:
        nats = tuple((id, 4.0 * (id == 2)) for id in (1, 2, 3))
        return replace(vote(expert, [2]), nats=nats)

    weighs = weighed(sure)["o2f and r2f, counts"].rules["prior"]
    assert weighs.decided.tolist() == [1.0] * 3
    assert weighs.regret_m.tolist() == [2.0] * 3, "of equal areas the second, as both say so"
    assert weighs.fallback_m.tolist() == [6.0] * 3, "else the nearest"
    alone = weighed(everything)["o2f, counts"].rules["prior"]
    assert alone.regret_m.tolist() == [6.0] * 3, "one alone does not outweigh 2 m of way"


def test_who_has_no_set_decides_nothing_and_gains_nothing() -> None:
    row = weighed(everything)["sle, head"]
    assert row.voted.tolist() == [0.0] * 3
    assert np.isnan(row.rules["paper"].regret_m).all()
    assert row.rules["paper"].gained_m.tolist() == [0.0] * 3


def test_two_must_agree() -> None:
    def apart(expert: str, by: str, every: bool) -> Vote | Missing:
        return vote(expert, [3] if expert == "o2f" else [2])

    rows = weighed(apart)
    assert rows["r2f, counts"].rules["paper"].decided.all()
    assert not rows["o2f and r2f, counts"].rules["paper"].decided.any()
    assert rows["all three, counts and head"].rules["paper"].decided.all(), "r2f and sle agree"
    assert rows["sle, embedding and head"].rules["paper"].decided.all()


def test_evidence_that_knows_the_way_correlates_with_it() -> None:
    rows = weighed(everything)
    assert rows["o2f, counts"].way.tolist() == pytest.approx([1.0] * 3)
    assert rows["o2f, counts"].own.tolist() == pytest.approx([1.0] * 3)
    assert rows["o2f, language"].own.tolist() == pytest.approx([-1.0] * 3)


def test_as_if_never_counted_is_asked_otherwise() -> None:
    rows = weighed(everything)
    assert rows["o2f, guessed"].own.tolist() == pytest.approx([-1.0] * 3)


def test_tables_have_a_row_for_each_kind_under_each_rule() -> None:
    rows = weighed(everything)
    text = evidence_report.section(bank(), rows, "fit", ["a=b"], 0)
    assert text.startswith("## Evidence, side `fit`: 3 questions, 3 homes of 3 layouts, with `a=b`")
    for kind in ROWS:
        assert text.count(f"\n| {kind.name} |") == 1 + len(RULES)
    assert "| **-6.00 [-6.00, -6.00]** |" in text
    data = evidence_report.figures(bank(), rows, 0)
    assert data["rows"]["o2f, counts"]["rules"]["paper"]["minus_fallback_m"]["mean"] == -6.0
