"""How votes are timed: on which views, and that nobody else answers."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from looked import write_homes
from manual_clock import ManualClock

from hil_sim.expert_bench.scene_speed import FRONTIERS, GOALS, VOTES, time_votes
from hil_sim.expert_bench.view_questions import SightRows, load_views
from hil_sim.expert_bench.voting import Votes
from runtime.clock import Deadline
from runtime.config import Config
from runtime.core.types import Absence, Brief, Missing, Vote
from runtime.errors import RfNavError


class Elector:
    """SLE votes as a function does, which takes 0.4 s for the first goal and 0.1 s for the other,
    and once a minute; what it was asked is kept."""

    def __init__(self, vote: Callable[[Brief], Vote | Missing]) -> None:
        self._vote, self.asked_for, self.clock = vote, list[Brief](), ManualClock()

    def asked(self, config: Config, questions: Sequence[object]) -> Votes:
        def sle(brief: Brief, by: Deadline) -> Vote | Missing:
            self.clock.advance(0.4 if brief.goal == GOALS[0] else 0.1)
            self.clock.advance(0.0 if self.asked_for else 60.0)
            self.asked_for.append(brief)
            return self._vote(brief)

        return Votes({"sle": sle}, questions, Deadline.never(self.clock))

    def check(self) -> None: ...


def first(brief: Brief, rung: str = "head") -> Vote:
    return Vote("sle", (0,), tuple((f.id, 0.125) for f in brief.frontiers), "given", rung)


@pytest.fixture
def sights(tmp_path: Path) -> SightRows:
    return load_views(write_homes(tmp_path, homes=3, rows=64)).beyond.sights


def test_each_vote_is_on_eight_views_of_its_own_for_two_goals(sights: SightRows) -> None:
    elector = Elector(first)
    took = time_votes(sights, "head", (), elector, elector.clock)
    assert (took.new_views, took.known_views) == (pytest.approx(0.4), pytest.approx(0.1))
    briefs = elector.asked_for
    assert [b.goal for b in briefs] == list(GOALS) * VOTES
    assert all(len(b.frontiers) == FRONTIERS for b in briefs)
    columns = [f.sight.column for b in briefs[::2] for f in b.frontiers if f.sight is not None]
    assert columns == sights.column[: FRONTIERS * VOTES].tolist()
    shown = briefs[2].frontiers[1]
    assert shown.sight is not None
    assert (shown.sight.features == sights.features[FRONTIERS + 1]).all()
    assert shown.view.dtype == np.float32


def test_a_picture_that_is_looked_at_again_is_not_timed_as_a_new_one(sights: SightRows) -> None:
    twice = [row for row in range(len(sights)) for _ in range(2)]
    again = SightRows(
        *(getattr(sights, name)[twice]
          for name in ("features", "depth", "scene", "rooms", "column", "range_m")),
        tuple(sights.home[row] for row in twice),
    )  # fmt: skip
    elector = Elector(first)
    time_votes(again, "head", (), elector, elector.clock)
    shown = [f.sight for b in elector.asked_for[::2] for f in b.frontiers if f.sight is not None]
    assert len({sight.features.tobytes() for sight in shown}) == len(shown) == FRONTIERS * VOTES


def test_another_kind_must_not_answer(sights: SightRows) -> None:
    with pytest.raises(RfNavError, match="sle, language: voted by head"):
        time_votes(sights, "language", (), Elector(first), ManualClock())
    silent = Elector(lambda brief: Missing("sle", Absence.NO_MODEL, "no such file"))
    with pytest.raises(RfNavError, match="sle, head: no such file"):
        time_votes(sights, "head", (), silent, ManualClock())


def test_too_few_views_are_refused(tmp_path: Path) -> None:
    few = load_views(write_homes(tmp_path, homes=1, rows=64)).beyond.sights
    with pytest.raises(RfNavError, match="32 views; 72 are needed"):
        time_votes(few, "head", (), Elector(first), ManualClock())
