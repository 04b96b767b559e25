"""A round of the panel: appeals when the first votes do not agree, an early end when nothing can
change any more."""

import threading
from collections.abc import Callable

import pytest
from manual_clock import ManualClock

from runtime.clock import Deadline, SystemClock
from runtime.core.types import Absence, Ballot, Brief, FrontierBrief, Missing, Vote
from runtime.core.voting import consensus
from runtime.core.voting.consensus import ConsensusConfig
from runtime.experts.panel import Expert, Panel

BRIEF = Brief("toilet", 0, tuple(FrontierBrief(i, float(i), (), ()) for i in (1, 2, 3)))
PATIENCE_S = 20.0  # of the tests, never reached when they pass
STRICT = ConsensusConfig(mode="strict")


def says(*ids: int, rung: str = "local") -> Expert:
    return lambda brief, by: Vote("", ids, tuple((i, 0.5) for i in ids), "because", rung)


def silent(brief: Brief, by: Deadline) -> Missing:
    return Missing("", Absence.NO_EVIDENCE)


def agreed(ballot: Ballot) -> bool:
    return consensus.agreed(ballot, STRICT)


def settled(votes, pending, brief: Brief) -> bool:
    return consensus.settled(votes, pending, brief.frontiers, STRICT)


class Gate:
    """An expert that answers when it is let go."""

    def __init__(self, then: Expert) -> None:
        self.called, self.go, self.then = threading.Event(), threading.Event(), then

    def __call__(self, brief: Brief, by: Deadline) -> Vote | Missing:
        self.called.set()
        assert self.go.wait(PATIENCE_S)
        return self.then(brief, by)


def counted(expert: Expert, calls: list[str]) -> Expert:
    def call(brief: Brief, by: Deadline) -> Vote | Missing:
        calls.append("asked")
        return expert(brief, by)

    return call


def beside(panel: Panel, by: Deadline) -> tuple[threading.Thread, list[Ballot]]:
    got: list[Ballot] = []
    thread = threading.Thread(target=lambda: got.append(panel.ask(BRIEF, by)))
    thread.start()
    return thread, got


def wait(panel: Panel, until: Callable[[], bool]) -> None:
    with panel._condition:
        assert panel._condition.wait_for(until, PATIENCE_S)


def sets(ballot: Ballot) -> dict[str, tuple[int, ...]]:
    return {vote.expert: vote.frontiers for vote in ballot.votes}


def test_nobody_appeals_when_the_first_votes_agree() -> None:
    calls: list[str] = []
    clock = SystemClock()
    experts = {"o2f": says(1, 2), "r2f": says(2), "sle": silent}
    appeals = {"o2f": counted(says(3), calls)}
    with Panel(experts, clock, appeals, agreed) as panel:
        ballot = panel.ask(BRIEF, Deadline.never(clock))
    assert calls == []
    assert sets(ballot) == {"o2f": (1, 2), "r2f": (2,)}


def test_an_appeal_replaces_a_vote_or_an_absence_and_one_in_vain_changes_nothing() -> None:
    clock = SystemClock()
    experts = {"o2f": says(1), "r2f": silent, "sle": says(3)}
    appeals = {"o2f": says(2, rung="cloud"), "r2f": says(2, rung="cloud"), "sle": silent}
    with Panel(experts, clock, appeals, agreed) as panel:
        ballot = panel.ask(BRIEF, Deadline.never(clock))
    assert sets(ballot) == {"o2f": (2,), "r2f": (2,), "sle": (3,)}
    assert [vote.rung for vote in ballot.votes] == ["cloud", "cloud", "local"]
    assert ballot.missing == ()
    assert sorted(ballot.latency_s) == ["o2f", "r2f", "sle"]


def test_a_nonsensical_appeal_changes_nothing() -> None:
    clock = SystemClock()
    with Panel({"o2f": says(1)}, clock, {"o2f": says(77)}, agreed) as panel:
        ballot = panel.ask(BRIEF, Deadline.never(clock))
    assert sets(ballot) == {"o2f": (1,)}
    assert ballot.missing == ()


def test_a_hanging_expert_does_not_keep_the_appeals_from_being_asked() -> None:
    clock = ManualClock()
    first, appeal = Gate(says(1)), Gate(says(2))
    with Panel({"o2f": first, "r2f": says(2)}, clock, {"o2f": appeal}, agreed) as panel:
        thread, got = beside(panel, Deadline.after(2.0, clock))
        assert first.called.wait(PATIENCE_S)
        wait(panel, lambda: "r2f" in panel._answers)
        assert not appeal.called.is_set()
        clock.advance(1.0)  # half of the time is gone
        assert appeal.called.wait(PATIENCE_S)
        appeal.go.set()
        thread.join(PATIENCE_S)
        first.go.set()
    assert sets(got[0]) == {"o2f": (2,), "r2f": (2,)}


def test_an_appeal_that_hangs_is_left_at_the_deadline_and_is_not_asked_twice() -> None:
    clock, calls = ManualClock(), []
    hanging = Gate(says(2))
    experts = {"o2f": says(1), "r2f": says(2)}
    with Panel(experts, clock, {"o2f": counted(hanging, calls)}, agreed) as panel:
        threads = threading.active_count()
        thread, got = beside(panel, Deadline.after(2.0, clock))
        assert hanging.called.wait(PATIENCE_S)
        clock.advance(2.0)
        thread.join(PATIENCE_S)
        assert sets(got[0]) == {"o2f": (1,), "r2f": (2,)}
        for _ in range(50):
            ballot = panel.ask(BRIEF, Deadline.never(clock))
            assert sets(ballot) == {"o2f": (1,), "r2f": (2,)}
        assert calls == ["asked"]
        assert threading.active_count() == threads
        hanging.go.set()


def test_a_round_ends_when_no_vote_that_is_out_can_change_the_winner() -> None:
    clock, slow = ManualClock(), Gate(says(3))
    experts = {"o2f": says(1), "r2f": says(1), "sle": slow}  # 1 is the closest: none ranks before
    with Panel(experts, clock, settled=settled) as panel:
        ballot = panel.ask(BRIEF, Deadline.after(2.0, clock))  # time stands still
        slow.go.set()
    assert sets(ballot) == {"o2f": (1,), "r2f": (1,)}
    assert ballot.missing == (Missing("sle", Absence.SETTLED),)


def test_a_round_goes_on_while_a_vote_that_is_out_can_change_the_winner() -> None:
    clock, slow = ManualClock(), Gate(says(1))
    experts = {"o2f": says(1, 2), "r2f": says(2), "sle": slow}  # the slow one can make 1 a pair
    with Panel(experts, clock, settled=settled) as panel:
        thread, got = beside(panel, Deadline.after(2.0, clock))
        wait(panel, lambda: len(panel._answers) == 2)
        assert got == []
        slow.go.set()
        thread.join(PATIENCE_S)
    assert sets(got[0]) == {"o2f": (1, 2), "r2f": (2,), "sle": (1,)}


def test_a_round_without_a_deadline_waits_for_everyone() -> None:
    clock, slow = ManualClock(), Gate(says(3))
    experts = {"o2f": says(1), "r2f": says(1), "sle": slow}
    with Panel(experts, clock, settled=settled) as panel:
        thread, got = beside(panel, Deadline.never(clock))
        wait(panel, lambda: len(panel._answers) == 2)
        assert got == []
        slow.go.set()
        thread.join(PATIENCE_S)
    assert len(got[0].votes) == 3


def test_what_cannot_be_an_appeal_is_refused() -> None:
    with pytest.raises(ValueError, match="not among the experts"):
        Panel({"o2f": silent}, SystemClock(), {"r2f": silent}, agreed)
    with pytest.raises(ValueError, match="agreed"):
        Panel({"o2f": silent}, SystemClock(), {"o2f": silent})
