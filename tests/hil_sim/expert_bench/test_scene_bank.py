"""Experts that see, in a bank whose answers are known: how often they vote, what their evidence
knows, and what is left of it when pictures are mixed up."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from asked import moment
from hypothesis import given
from hypothesis import strategies as st
from manual_clock import ManualClock

from hil_sim.expert_bench.bank import CLEAN, Bank, BankHome, questions_of
from hil_sim.expert_bench.scene_bank import (
    GATE,
    SceneRows,
    judge_scene,
    mixed_up,
    prior_insight,
    shuffled,
)
from hil_sim.expert_bench.voting import Votes
from runtime.clock import Deadline
from runtime.config import Config
from runtime.core.types import Absence, Brief, FrontierBrief, Missing, Sight, Vote
from runtime.core.voting.likelihood_experts import recommend
from runtime.core.voting.sight_experts import vote_sights
from runtime.experts.panel import EXPERTS

Sees = Callable[[FrontierBrief], float]


class Electors:
    """SLE has the evidence that a function sees in a frontier that it has a view of; R2F's is the
    number of the frontier. Both weigh it as the runtime's experts do, SLE as on its rung."""

    def __init__(self, sees: Sees, rung: str = "local") -> None:
        self._sees, self._rung = sees, rung

    def asked(self, config: Config, questions: Sequence[object]) -> Votes:
        def sle(brief: Brief, by: Deadline) -> Vote | Missing:
            nats = {f.id: self._sees(f) for f in brief.frontiers if f.view.size}
            vote = vote_sights(brief, nats if len(nats) > 1 else {}, config.experts, self._rung)
            return replace(vote, rung=self._rung) if isinstance(vote, Vote) else vote

        def r2f(brief: Brief, by: Deadline) -> Vote | Missing:
            nats = {f.id: float(f.id) for f in brief.frontiers}
            return recommend("r2f", brief, nats, dict.fromkeys(nats, "counted"), config.experts)

        table = {e: (lambda brief, by: Missing("", Absence.NO_EVIDENCE)) for e in EXPERTS}
        return Votes({**table, "sle": sle, "r2f": r2f}, questions, Deadline.never(ManualClock()))

    def check(self) -> None: ...


def frontier(id: int, picture: int, unknown_m2: float = 1.0) -> FrontierBrief:
    """Its picture has that number in it; 0: it has none."""
    if not picture:
        return FrontierBrief(id, float(id), (), (), unknown_m2=unknown_m2)
    view, parts = np.full(2, picture, np.float32), np.full((1, 1, 1), picture, np.float16)
    sight = Sight(parts, parts, id / 10, float(id))
    return FrontierBrief(id, float(id), (), (), view, unknown_m2=unknown_m2, sight=sight)


def bank(pictures: Sequence[int] = (1, 2, 3), areas: Sequence[float] = (1, 1, 1)) -> Bank:
    """Frontiers 1, 2, 3 m away, the goal 9, 4 and 1 m behind them."""
    found = []
    for n in range(4):
        one = moment(f"train-{100000 + n}")
        frontiers = tuple(map(frontier, (1, 2, 3), pictures, areas))
        briefs = {CLEAN: Brief("", 1_000_000_000 + n, frontiers)}
        places, costs_m = ((1.0, 0.0), (2.0, 0.0), (3.0, 0.0)), {"toilet": (10.0, 6.0, 4.0)}
        one = replace(one, briefs=briefs, order=(2, 1, 3), ids=(1, 2, 3), goal_xy=places,
                      costs_m=costs_m)  # fmt: skip
        found += list(questions_of(BankHome(one.home, (one,), {}, "e")))
    return Bank(tuple(found))


def picture(f: FrontierBrief) -> float:
    return float(f.view[0])


def judged(sees: Sees = picture, of: Bank | None = None, rung: str = "local") -> SceneRows:
    return judge_scene(of or bank(), (), Electors(sees, rung))


def test_who_knows_the_way_by_the_picture() -> None:
    rows = judged()
    assert rows.votes.tolist() == [1.0] * 4
    assert rows.insight.own.tolist() == rows.insight.voted.tolist() == [pytest.approx(1.0)] * 4
    assert (rows.shuffled.own < 0.6).all()  # of three that are moved on, two go down one place
    assert rows.kept.own.tolist() == rows.insight.own.tolist()
    assert rows.rungs == {"local": 4}
    assert set(rows.regret_m) == set(GATE)
    assert rows.regret_m["sle"].tolist() == [0.0] * 4


def test_who_goes_by_the_place_is_not_found_out_by_other_pictures_alone() -> None:
    rows = judged(lambda f: f.sight.range_m if f.sight else 0.0)
    assert rows.shuffled.own.tolist() == [pytest.approx(1.0)] * 4


@pytest.mark.parametrize("rung", ["head", "language"])
def test_own_evidence_is_without_the_prior(rung: str) -> None:
    rows = judged(lambda f: 0.0, bank(areas=(1, 4, 9)), rung)
    assert np.isnan(rows.insight.own).all()  # it knows nothing
    assert rows.insight.voted.tolist() == [pytest.approx(1.0)] * 4
    against = judged(lambda f: -0.1 * picture(f), bank(areas=(1, 4, 9)), rung)
    assert against.insight.own.tolist() == [pytest.approx(-1.0)] * 4
    assert against.insight.voted.tolist() == [pytest.approx(1.0)] * 4
    assert prior_insight(bank(areas=(1, 4, 9))).tolist() == [pytest.approx(1.0)] * 4
    assert np.isnan(prior_insight(bank())).all()


def test_where_fewer_than_two_have_a_view_nothing_is_asked_of_it() -> None:
    rows = judged(of=bank(pictures=(1, 0, 0)))
    assert np.isnan(rows.votes).all()
    assert np.isnan(rows.shuffled.own).all()
    silent = judged(lambda f: 0.0)
    assert silent.votes.tolist() == [0.0] * 4  # views it has, and no preference


def test_one_picture_of_all_cannot_be_mixed_up() -> None:
    rows = judged(lambda f: float(f.id), bank(pictures=(7, 7, 3)))
    assert np.isnan(rows.shuffled.own).all()
    assert rows.insight.own.tolist() == [pytest.approx(1.0)] * 4


@given(st.lists(st.integers(0, 3), min_size=1, max_size=8), st.text("ab", max_size=3))
def test_each_gets_anothers_picture_where_it_can(pictures: list[int], place: str) -> None:
    brief = Brief("", 0, tuple(frontier(n, p) for n, p in enumerate(pictures, 1)))
    mixed = mixed_up(brief, place)
    assert mixed_up(brief, place) == mixed
    shown = [int(f.view[0]) if f.view.size else 0 for f in mixed.frontiers]
    assert sorted(shown) == sorted(pictures)
    counts = [pictures.count(p) for p in {*pictures} - {0}]
    stays = [a == b for a, b in zip(shown, pictures, strict=True) if b]
    assert any(stays) == (bool(counts) and max(counts) > sum(counts) / 2)
    for old, new in zip(brief.frontiers, mixed.frontiers, strict=True):
        assert (new.id, new.unknown_m2, new.distance_m) == (old.id, old.unknown_m2, old.distance_m)
        if old.sight is not None:
            assert new.sight is not None
            assert (new.sight.column, new.sight.range_m) == (old.sight.column, old.sight.range_m)
            assert new.sight.features.ravel()[0] == new.view[0]


def test_all_goals_of_a_moment_are_mixed_alike() -> None:
    question = bank().questions[0]
    one, other = (shuffled(replace(question, goal=goal), 0) for goal in ("bed", "mug"))
    assert [picture(f) for f in one.brief().frontiers] == [
        picture(f) for f in other.brief().frontiers
    ]
    orders = {tuple(picture(f) for f in shuffled(question, s).brief().frontiers) for s in range(20)}
    assert orders == {(2.0, 3.0, 1.0), (3.0, 1.0, 2.0)}  # no picture ever stays
    assert not any(math.isclose(a, b) for o in orders for a, b in zip(o, (1, 2, 3), strict=True))
