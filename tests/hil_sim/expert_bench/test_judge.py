"""What choices cost, on questions whose answers are known, with experts whose votes are given."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from asked import moment
from manual_clock import ManualClock

from hil_sim.expert_bench import report
from hil_sim.expert_bench.bank import CLEAN, Bank, BankHome, BenchQuestion, questions_of
from hil_sim.expert_bench.judge import CONDITIONS, METHODS, NEAR, RANDOM, Table, judge
from hil_sim.expert_bench.statistics import Resampling
from hil_sim.expert_bench.voting import Votes, at_random
from runtime.clock import Deadline
from runtime.config import Config
from runtime.core.types import Absence, Brief, FrontierBrief, Missing, NearbyObject, Vote
from runtime.errors import ConfigError
from runtime.experts.panel import EXPERTS

Cast = Callable[[str, Brief], Vote | Missing]


class Given:
    """Voters whose votes a function gives; the bar is kept as the experts keep it."""

    def __init__(self, cast: Cast) -> None:
        self._cast, self.asked_for = cast, list[float]()

    def asked(self, config: Config, questions: Sequence[BenchQuestion]) -> Votes:
        self.asked_for.append(config.experts.bar)
        table = {e: (lambda brief, by, e=e: self._cast(e, brief)) for e in EXPERTS}
        return Votes(table, questions, Deadline.never(ManualClock()))

    def check(self) -> None: ...


def bank(homes: int = 4) -> Bank:
    """In each home three frontiers at 1, 2 and 3 m; the goal is 1 m behind the last one, and 9 m
    and 4 m behind the others: costs 10, 6, 4."""
    found = []
    for n in range(homes):
        one = moment(f"train-{100000 + n}")
        frontiers = tuple(
            FrontierBrief(id, float(id), (NearbyObject("sofa", 0.9, 1.0),), ()) for id in (1, 2, 3)
        )
        told = Brief("", 1_000_000_000 + n, frontiers)
        briefs = {CLEAN: told, "wrong labels": told, "missing objects": told}
        places, order = ((1.0, 0.0), (2.0, 0.0), (3.0, 0.0)), (2, 1, 3)
        costs_m = {"toilet": (10.0, 6.0, 4.0)}
        one = replace(
            one, briefs=briefs, order=order, ids=(1, 2, 3), goal_xy=places, costs_m=costs_m
        )
        found += list(questions_of(BankHome(one.home, (one,), {}, "e")))
    return Bank(tuple(found))


def vote(expert: str, ids: Sequence[int], p: Sequence[float] = (0.1, 0.2, 0.7)) -> Vote:
    return Vote(expert, tuple(ids), tuple(zip((1, 2, 3), p, strict=True)), "given")


def judged(
    cast: Cast, conditions: Sequence[str] = (CLEAN,), seed: int = 0, homes: int = 4
) -> Table:
    return judge(bank(homes), (), Given(cast), conditions, seed)


def regret(table: Table, method: str, condition: str = CLEAN) -> float:
    return float(table.rows[method][condition].regret_m.mean())


def test_who_asks_nobody_goes_by_distance_or_by_gain() -> None:
    table = judged(lambda expert, brief: vote(expert, [3]))
    closest = table.rows["closest"][CLEAN]
    assert closest.regret_m.tolist() == [6.0] * 4
    assert closest.worst.tolist() == [1.0] * 4
    assert np.isnan(closest.voted).all()
    assert regret(table, "geometry") == 2.0
    assert regret(table, RANDOM) == pytest.approx((6 + 2 + 0) / 3)
    assert table.rows[RANDOM][CLEAN].worst.tolist() == pytest.approx([1 / 3] * 4)


def test_experts_that_know_the_way_lose_nothing() -> None:
    table = judged(lambda expert, brief: vote(expert, [3]))
    assert regret(table, NEAR) == 6.0  # 3 is too far away for it
    for method in set(METHODS) - {NEAR, "closest", "geometry", "majority-k3", "majority-k5"}:
        row = table.rows[method][CLEAN]
        assert row.regret_m.tolist() == [0.0] * 4, method
        assert row.right.tolist() == row.voted.tolist() == [1.0] * 4
        assert row.worst.tolist() == [0.0] * 4


def test_one_voice_counts_only_where_it_may() -> None:
    def only_o2f(expert: str, brief: Brief) -> Vote | Missing:
        return vote(expert, [3]) if expert == "o2f" else Missing(expert, Absence.NO_EVIDENCE)

    table = judged(only_o2f)
    assert [regret(table, m) for m in ("o2f", "lenient", "consensus", "o2f+r2f", "r2f")] == [
        0.0, 0.0, 6.0, 6.0, 6.0]  # fmt: skip
    assert table.votes["r2f"] == {"no evidence": pytest.approx(1.0)}
    assert table.rows["consensus"][CLEAN].voted.tolist() == [0.0] * 4


def test_an_expert_is_absent_in_its_turn() -> None:
    def two_know(expert: str, brief: Brief) -> Vote | Missing:
        return Missing(expert, Absence.NO_EVIDENCE) if expert == "sle" else vote(expert, [3])

    table = judged(two_know, CONDITIONS)
    costs = {e: float(row.regret_m.mean()) for e, row in table.spoilt["one absent"].items()}
    assert costs == {"o2f": 6.0, "r2f": 6.0, "sle": 0.0}  # one voice is no agreement
    assert regret(table, "consensus", "one absent") == pytest.approx(4.0)
    assert regret(table, "o2f", "one absent") == 6.0
    assert regret(table, "o2f+sle", "one absent") == 6.0
    assert regret(table, "closest", "one absent") == regret(table, "closest") == 6.0


def test_one_at_random_cannot_turn_two_that_agree() -> None:
    table = judged(lambda expert, brief: vote(expert, [3]), CONDITIONS, homes=40)
    spoilt = table.spoilt["one at random"]
    assert all(row.regret_m.max() == 0.0 for row in spoilt.values())
    assert 1.0 < regret(table, "o2f", "one at random") < 4.0  # about that of a random frontier


def test_random_votes_are_the_seeds() -> None:
    question = bank(1).questions[0]
    votes = [at_random("o2f", replace(question, goal=f"g{n}"), 0) for n in range(200)]
    assert votes[0] == at_random("o2f", replace(question, goal="g0"), 0)
    assert any(
        at_random("o2f", replace(question, goal=f"g{n}"), 1) != v for n, v in enumerate(votes)
    )
    counts = [sum(id in v.frontiers for v in votes) for id in (1, 2, 3)]
    assert all(70 < count < 130 for count in counts)  # 100 expected: sets of one and of two
    assert {len(v.frontiers) for v in votes} == {1, 2}


def test_evidence_is_compared_with_the_way_on() -> None:
    def cast(expert: str, brief: Brief) -> Vote | Missing:
        if expert == "sle":
            return vote(expert, [1], (0.7, 0.2, 0.1))
        return vote(expert, [3])

    table = judged(cast)
    assert table.insight["o2f"].tolist() == [pytest.approx(1.0)] * 4  # ways on: 9, 4, 1 m
    assert table.insight["sle"].tolist() == [pytest.approx(-1.0)] * 4
    same, other = table.likeness["o2f", "r2f"], table.likeness["o2f", "sle"]
    assert same.overlap.tolist() == [1.0] * 4
    assert same.by_chance.tolist() == [pytest.approx(1 / 3)] * 4
    assert other.overlap.tolist() == [0.0] * 4
    assert other.correlation.tolist() == [pytest.approx(-1.0)] * 4


def test_settings_reach_the_experts_and_unknown_ones_are_refused() -> None:
    given = Given(lambda expert, brief: vote(expert, [3]))
    judge(bank(), ("research.experts_bar=1.3",), given)
    assert set(given.asked_for) == {1.3, 0.0}
    with pytest.raises(ConfigError, match=r"experts_baar: unknown; did you mean experts_bar"):
        judge(bank(), ("research.experts_baar=1.3",), given)


def test_the_report_says_what_the_table_holds() -> None:
    table = judged(lambda expert, brief: vote(expert, [3]), CONDITIONS)
    plan = {"wrong": 0.2, "missing": 0.3}
    text = report.section(bank(), table, "test", ("research.experts_bar=1.3",), plan, 0)
    assert "Side `test`: 4 questions, 4 homes of 4 layouts, with `research.experts_bar=1.3`" in text
    line = next(row for row in text.splitlines() if row.startswith("| closest |"))
    assert line == (
        "| closest | 6.00 [6.00, 6.00] | **6.00 [6.00, 6.00]** | 0.0 [0.0, 0.0] | "
        "100.0 [100.0, 100.0] | – |"
    )
    assert "with probability 0.2" in text
    tables = [list(rows) for rows in _tables(text)]
    assert all(a.count("|") == b.count("|") for rows in tables for a, b in pairwise(rows))
    data = report.figures(bank(), table, 0)
    assert data["methods"]["closest"][CLEAN]["regret_m"]["mean"] == 6.0
    assert data["spoilt"]["one absent"]["o2f"]["minus_consensus_m"]["mean"] == 0.0
    assert Resampling(table.layouts, 0).mean(table.rows["o2f"][CLEAN].right).mean == 1.0


def _tables(text: str) -> list[list[str]]:
    parts = text.split("\n\n")
    return [part.splitlines() for part in parts if part.startswith("|")]


def test_evidence_is_weighed_where_there_are_weights() -> None:
    given = Given(lambda expert, brief: vote(expert, [3]))
    assert "weighted" not in judge(bank(), (), given).rows
    costs = []
    for metres in (0.5, 5.0):
        table = judge(bank(), (f'research.consensus_weights=[["o2f", {metres}]]',), given)
        costs.append(regret(table, "weighted"))
    # log 0.7 - log 0.1 is 1.9 nats: 2 m further on is worth it at 5 m a nat, not at 0.5
    assert costs == [6.0, 0.0]
