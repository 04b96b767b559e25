"""Decisions in a worker: rehearsals are used when they fit, and never stand in the way."""

import threading
from dataclasses import dataclass, field

import numpy as np
import pytest
from manual_clock import ManualClock

from runtime.clock import Deadline
from runtime.core.types import Absence, Brief, Frontier, FrontierBrief, Missing, Vote
from runtime.core.voting.consensus import ConsensusConfig, ConsensusMode
from runtime.core.world import Snapshot
from runtime.experts.panel import Panel
from runtime.loops.decision_worker import DecisionReply, DecisionRequest, DecisionWorker
from runtime.navigate import NavigateConfig

PATIENCE_S = 20.0  # of the tests, never reached when they pass
CFG = NavigateConfig(consensus=ConsensusConfig(mode="strict"))


def snapshot(distances: dict[int, float]) -> Snapshot:
    told = tuple(FrontierBrief(i, d, (), ()) for i, d in distances.items())
    places = tuple(Frontier(i, np.zeros((1, 2)), (0.0, 0.0), d) for i, d in distances.items())
    return Snapshot(Brief("toilet", 0, told), places, 0, "a test")


@dataclass
class Expert:
    """Votes for 2 and 3, or what it names of them; waits for `go` where it is to."""

    waits: bool = False
    names: tuple[int, ...] = (2, 3)
    go: threading.Event = field(default_factory=threading.Event)
    begun: threading.Semaphore = field(default_factory=lambda: threading.Semaphore(0))
    briefs: list[Brief] = field(default_factory=list)

    def __call__(self, brief: Brief, by: Deadline) -> Vote | Missing:
        self.briefs.append(brief)
        self.begun.release()
        if self.waits:
            assert self.go.wait(PATIENCE_S)
        ids = tuple(f.id for f in brief.frontiers if f.id in self.names)
        return Vote("", ids, (), "") if ids else Missing("", Absence.NO_EVIDENCE)


class Table:
    """A worker and a panel of two, of which the second may be slow."""

    def __init__(self, waits: bool = False) -> None:
        self.clock = ManualClock()
        self.quick, self.slow = Expert(), Expert(waits)
        self.panel = Panel({"o2f": self.quick, "r2f": self.slow}, self.clock)
        self.worker = DecisionWorker()
        self.asker = object()

    def __enter__(self) -> "Table":
        return self

    def __exit__(self, *_: object) -> None:
        self.slow.go.set()
        self.worker.close()
        self.panel.close()

    def question(
        self, distances: dict[int, float], without: int | None = None, cfg: NavigateConfig = CFG
    ) -> DecisionRequest:
        by = Deadline.after(2.0, self.clock)
        snap = snapshot(distances)
        return DecisionRequest(self.asker, snap, self.panel, by, cfg, without=without)

    def answer(self) -> DecisionReply:
        until = threading.Event()
        for _ in range(int(PATIENCE_S / 0.01)):
            found = self.worker.take()
            if found is not None:
                return found
            until.wait(0.01)
        raise AssertionError("no answer")

    def rehearsed(self) -> None:
        with self.worker._changed:
            done = self.worker._changed.wait_for(lambda: self.worker._rehearsal is None, PATIENCE_S)
        assert done


def test_a_rehearsal_that_fits_is_used_at_the_distances_of_now() -> None:
    with Table() as table:
        table.worker.rehearse(table.question({1: 1.0, 2: 2.0, 3: 3.0}, without=1))
        table.rehearsed()
        assert table.worker.idle
        table.worker.ask(table.question({2: 9.0, 3: 3.0}))  # it has driven to 1: 3 is nearer now
        answer = table.answer()
        assert answer.rehearsal == "used"
        assert (answer.decision.frontier, answer.decision.rule) == (3, "all")
        assert len(table.quick.briefs) == len(table.slow.briefs) == 1  # nobody was asked again


@pytest.mark.parametrize(("mode", "rehearsal"), [("strict", "no agreement"), ("prior", "used")])
def test_a_rehearsal_stands_where_somebodys_word_decides(
    mode: ConsensusMode, rehearsal: str
) -> None:
    cfg = NavigateConfig(consensus=ConsensusConfig(mode=mode))
    with Table() as table:
        table.quick.names, table.slow.names = (2,), (3,)
        table.worker.rehearse(table.question({1: 1.0, 2: 2.0, 3: 3.0}, without=1, cfg=cfg))
        table.rehearsed()
        table.worker.ask(table.question({2: 2.0, 3: 3.0}, cfg=cfg))
        assert table.answer().rehearsal == rehearsal


def test_a_rehearsal_of_something_else_is_named_and_asked_anew() -> None:
    with Table() as table:
        table.worker.rehearse(table.question({1: 1.0, 2: 2.0, 3: 3.0}, without=1))
        table.rehearsed()
        table.worker.ask(table.question({2: 2.0, 3: 3.0, 4: 1.0}))
        answer = table.answer()
        assert answer.rehearsal == "frontier 4 is new"
        assert answer.decision.frontier == 2
        assert len(table.quick.briefs) == 2
        table.worker.ask(table.question({2: 2.0, 3: 3.0}))
        assert table.answer().rehearsal == ""  # it was used up


def test_a_rehearsal_whose_time_has_not_come_is_kept() -> None:
    with Table() as table:
        table.worker.rehearse(table.question({1: 1.0, 2: 2.0, 3: 3.0}, without=1))
        table.rehearsed()
        table.worker.ask(table.question({1: 0.5, 2: 2.0, 3: 3.0}))  # new evidence on the way
        assert table.answer().rehearsal == ""
        table.worker.ask(table.question({2: 2.0, 3: 3.0}))
        assert table.answer().rehearsal == "used"
        assert len(table.quick.briefs) == 2  # the rehearsal and the first question


def test_a_question_ends_the_rehearsal_of_another_and_waits_behind_it() -> None:
    with Table(waits=True) as table:
        table.worker.rehearse(table.question({1: 1.0, 2: 2.0, 3: 3.0}, without=1))
        for expert in (table.slow, table.quick):  # one that has not begun would not be asked
            assert expert.begun.acquire(timeout=PATIENCE_S)
        assert not table.worker.idle
        assert not table.worker.busy
        table.worker.ask(table.question({2: 2.0, 3: 3.0, 4: 1.0}))
        assert table.quick.begun.acquire(timeout=PATIENCE_S)  # time stood still meanwhile
        table.slow.go.set()
        answer = table.answer()
        assert answer.rehearsal == ""  # it came to nothing
        assert answer.decision.ballot.missing == ()  # the slow one answered both
        assert answer.decision.rule == "all"


def test_a_question_that_is_being_rehearsed_gets_its_answer() -> None:
    with Table(waits=True) as table:
        table.worker.rehearse(table.question({1: 1.0, 2: 2.0, 3: 3.0}, without=1))
        assert table.slow.begun.acquire(timeout=PATIENCE_S)
        table.worker.ask(table.question({2: 2.0, 3: 3.0}))
        table.slow.go.set()
        answer = table.answer()
        assert answer.rehearsal == "used"
        assert len(table.slow.briefs) == 1


def test_a_rehearsal_with_a_late_expert_does_not_stand() -> None:
    with Table(waits=True) as table:
        table.worker.rehearse(table.question({1: 1.0, 2: 2.0, 3: 3.0}, without=1))
        assert table.slow.begun.acquire(timeout=PATIENCE_S)
        with table.panel._condition:
            assert table.panel._condition.wait_for(
                lambda: "o2f" in table.panel._answers, PATIENCE_S
            )
        table.clock.advance(2.0)
        table.rehearsed()
        table.slow.go.set()
        table.worker.ask(table.question({2: 2.0, 3: 3.0}))
        answer = table.answer()
        assert answer.rehearsal == "an expert was late"
        assert answer.decision.rule == "all"
        assert answer.decision.ballot.missing == ()


def test_what_is_prepared_is_not_prepared_again() -> None:
    with Table() as table:
        for _ in range(3):
            table.worker.rehearse(table.question({1: 1.0, 2: 2.0, 3: 3.0}, without=1))
            table.rehearsed()
        assert len(table.quick.briefs) == 1


def test_an_appeal_is_not_rehearsed() -> None:
    clock, asked = ManualClock(), []

    def appeal(brief: Brief, by: Deadline) -> Vote | Missing:
        asked.append(brief)
        return Missing("", Absence.NO_EVIDENCE)

    with Panel({"o2f": Expert()}, clock, {"o2f": appeal}, lambda ballot: False) as panel:
        brief = snapshot({2: 1.0, 3: 2.0}).brief
        ballot = panel.rehearse(brief, Deadline.after(2.0, clock), lambda: True)
    assert ballot is not None
    assert [vote.expert for vote in ballot.votes] == ["o2f"]
    assert asked == []


def test_what_the_experts_are_told_is_worked_out_in_the_worker_and_holds_up_no_panel() -> None:
    class Seen:
        """An outlook; its brief takes until `ready`."""

        def __init__(self, distances: dict[int, float]) -> None:
            self.made = snapshot(distances)
            self.ready, self.threads = threading.Event(), []

        def __getattr__(self, name: str) -> object:
            self.threads.append(threading.current_thread().name)
            assert self.ready.wait(PATIENCE_S)
            return getattr(self.made, name)

    def request(table: Table, seen: Seen, without: int | None = None) -> DecisionRequest:
        by = Deadline.after(2.0, table.clock)
        return DecisionRequest(table.asker, seen, table.panel, by, CFG, without)

    before, now = Seen({1: 1.0, 2: 2.0, 3: 3.0}), Seen({2: 2.0, 3: 3.0})
    with Table(waits=True) as table:
        table.worker.rehearse(request(table, before, without=1))
        table.worker.rehearse(request(table, before, without=1))  # compared by the worker, too
        before.ready.set()
        assert table.slow.begun.acquire(timeout=PATIENCE_S)
        table.worker.ask(request(table, now))
        for _ in range(1000):
            if now.threads:
                break
            threading.Event().wait(0.005)
        assert table.panel._condition.acquire(timeout=PATIENCE_S)  # while it is worked out
        table.panel._condition.release()
        now.ready.set()
        table.slow.go.set()
        assert table.answer().rehearsal == "used"
    assert set(before.threads) == {"decisions"}
    assert now.threads[0] == "decisions"


def test_nothing_is_rehearsed_where_there_is_nothing_to_choose() -> None:
    with Table() as table:
        table.worker.rehearse(table.question({1: 1.0, 2: 2.0}, without=1))
        table.rehearsed()
        assert table.worker.idle
        table.worker.ask(table.question({2: 2.0, 3: 3.0}))
        assert table.answer().rehearsal == ""
        assert len(table.quick.briefs) == 1
