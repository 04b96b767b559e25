"""Experts that fail, hang, talk nonsense or come back: the ballot says so and nothing stacks up."""

import math
import threading
from collections.abc import Callable

from manual_clock import ManualClock

from runtime.clock import Deadline, SystemClock
from runtime.core.types import Absence, Ballot, Brief, FrontierBrief, Missing, Vote
from runtime.experts.panel import Panel, checked

BRIEF = Brief("toilet", 0, tuple(FrontierBrief(i, float(i), (), ()) for i in (1, 2, 3)))
PATIENCE_S = 20.0  # of the tests, never reached when they pass


def votes_for(*ids: int) -> Callable[[Brief, Deadline], Vote]:
    return lambda brief, by: Vote("", ids, tuple((i, 0.5) for i in ids), "because")


def never(clock: ManualClock | SystemClock) -> Deadline:
    return Deadline.never(clock)


class Hanging:
    """An expert that answers when it is let go."""

    def __init__(self) -> None:
        self.called = threading.Event()
        self.go = threading.Event()
        self.calls = 0

    def __call__(self, brief: Brief, by: Deadline) -> Vote:
        self.calls += 1
        self.called.set()
        assert self.go.wait(PATIENCE_S)
        return Vote("", (1,), (), "at last")


def ask_until_late(panel: Panel, hanging: Hanging, clock: ManualClock) -> Ballot:
    """Ask with 2 s, and let them pass once the hanging expert has been called."""
    got: list[Ballot] = []
    asking = threading.Thread(
        target=lambda: got.append(panel.ask(BRIEF, Deadline.after(2.0, clock)))
    )
    asking.start()
    assert hanging.called.wait(PATIENCE_S)
    # the others answer at once; wait for them, so that only the hanging one is late
    with panel._condition:
        assert panel._condition.wait_for(
            lambda: len(panel._answers) == len(panel._seats) - 1, PATIENCE_S
        )
    clock.advance(2.0)
    asking.join(PATIENCE_S)
    return got[0]


def idle(panel: Panel) -> None:
    with panel._condition:
        assert panel._condition.wait_for(
            lambda: not any(seat.running for seat in panel._seats), PATIENCE_S
        )


def test_votes_come_sorted_by_name_and_carry_it() -> None:
    clock = SystemClock()
    with Panel(
        {"sle": votes_for(2), "o2f": votes_for(3, 1, 3), "r2f": votes_for(2)}, clock
    ) as panel:
        ballot = panel.ask(BRIEF, never(clock))
    assert [vote.expert for vote in ballot.votes] == ["o2f", "r2f", "sle"]
    assert ballot.votes[0].frontiers == (1, 3)
    assert ballot.missing == ()
    assert list(ballot.latency_s) == ["o2f", "r2f", "sle"]
    assert all(0 <= latency < PATIENCE_S for latency in ballot.latency_s.values())


def test_a_failing_expert_abstains_with_the_cause() -> None:
    def fails(brief: Brief, by: Deadline) -> Vote:
        raise RuntimeError("model\nfell over")

    clock = SystemClock()
    with Panel({"o2f": votes_for(1), "r2f": fails}, clock) as panel:
        ballot = panel.ask(BRIEF, never(clock))
        again = panel.ask(BRIEF, never(clock))
    assert [vote.expert for vote in ballot.votes] == ["o2f"]
    assert ballot.missing == (Missing("r2f", Absence.ERROR, "model fell over"),)
    assert again.missing == ballot.missing


def test_an_abstention_keeps_its_cause() -> None:
    clock = SystemClock()
    with Panel({"sle": lambda brief, by: Missing("sle", Absence.NO_MODEL)}, clock) as panel:
        ballot = panel.ask(BRIEF, never(clock))
    assert ballot.votes == ()
    assert ballot.missing == (Missing("sle", Absence.NO_MODEL),)


def test_nonsense_is_dropped_with_the_cause() -> None:
    clock = SystemClock()
    experts = {
        "a": votes_for(1, 77),
        "b": votes_for(),
        "c": lambda brief, by: "2",
        "d": votes_for(2),
    }
    with Panel(experts, clock) as panel:  # type: ignore[arg-type]
        ballot = panel.ask(BRIEF, never(clock))
    assert [vote.expert for vote in ballot.votes] == ["d"]
    assert ballot.missing == (
        Missing("a", Absence.NONSENSE, "voted for unknown frontier 77"),
        Missing("b", Absence.NONSENSE, "voted for no frontier"),
        Missing("c", Absence.ERROR, "returned str, not a vote"),
    )


def test_evidence_is_of_the_frontiers_that_were_asked_about_and_a_number() -> None:
    nats = ((2, 0.5), (77, 9.0), (1, math.nan), (3, -math.inf))
    for said in (
        Vote("a", (2,), (), "", nats=nats),
        Missing("a", Absence.NO_PREFERENCE, nats=nats),
    ):
        assert checked(said, BRIEF).nats == ((2, 0.5),)


def test_late_then_busy_then_back_and_the_late_vote_is_dropped() -> None:
    clock, hanging = ManualClock(), Hanging()
    with Panel({"o2f": votes_for(2), "r2f": hanging}, clock) as panel:
        ballot = ask_until_late(panel, hanging, clock)
        assert [vote.expert for vote in ballot.votes] == ["o2f"]
        assert ballot.missing == (Missing("r2f", Absence.LATE),)

        busy = panel.ask(BRIEF, never(clock))  # waits for the other expert only
        assert [vote.expert for vote in busy.votes] == ["o2f"]
        assert busy.missing == (Missing("r2f", Absence.BUSY),)

        hanging.go.set()
        idle(panel)
        assert "r2f" not in panel._answers  # its late vote went nowhere
        back = panel.ask(BRIEF, never(clock))
        assert [vote.expert for vote in back.votes] == ["o2f", "r2f"]
        assert back.missing == ()
        assert hanging.calls == 2


def test_nothing_grows_however_often_a_stuck_expert_is_asked() -> None:
    clock, hanging = ManualClock(), Hanging()
    with Panel({"o2f": votes_for(2), "r2f": hanging}, clock) as panel:
        ask_until_late(panel, hanging, clock)
        threads = threading.active_count()
        for _ in range(200):
            assert panel.ask(BRIEF, never(clock)).missing == (Missing("r2f", Absence.BUSY),)
        assert threading.active_count() == threads
        assert hanging.calls == 1
        assert len(panel._answers) == 1
        hanging.go.set()


def test_a_deadline_that_has_passed_leaves_everyone_late() -> None:
    clock = ManualClock()
    by = Deadline.after(1.0, clock)
    clock.advance(1.0)
    with Panel({"o2f": votes_for(2)}, clock) as panel:
        assert panel.ask(BRIEF, by).missing == (Missing("o2f", Absence.LATE),)
        idle(panel)
        assert len(panel.ask(BRIEF, never(clock)).votes) == 1


def test_closing_does_not_wait_for_a_hanging_expert() -> None:
    clock, hanging = ManualClock(), Hanging()
    panel = Panel({"r2f": hanging}, clock)
    ask_until_late(panel, hanging, clock)
    began = SystemClock().now_s()
    panel.close()
    assert SystemClock().now_s() - began < 1.0
    hanging.go.set()
