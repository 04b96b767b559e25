"""DEFA's experts in threads: one worker each, one call in flight each, judged at one deadline.

A Python thread cannot be killed. An expert that has not answered at the deadline is "late" and what
it returns later is dropped; if it still runs when the next question comes, it is "busy" for that
one. So nothing stacks up: threads and memory stay constant whatever the experts do.

A rehearsal puts a question that may yet come, so that slow experts have an answer when it does. It
never stands in the way: a question that comes waits behind it in the worker, and ends it.

Experts may have an appeal, a slower or dearer one of the same name, that is asked in the same round
when the first votes do not agree. Each appeal is a worker of its own.
"""

import math
import threading
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, Self, get_args

from runtime.clock import Clock, Deadline
from runtime.core.keys import key
from runtime.core.types import Absence, Ballot, Brief, Missing, Vote

Expert = Callable[[Brief, Deadline], Vote | Missing]
Settled = Callable[[Sequence[Vote], Collection[str], Brief], bool]
"""Votes in hand, experts still out, the brief -> whether waiting for those is in vain."""

ExpertName = Literal["o2f", "r2f", "sle", "both"]
EXPERTS: tuple[ExpertName, ...] = get_args(ExpertName)
"""`both`: one expert asked about objects and rooms together, to compare with."""
SEATED: tuple[ExpertName, ...] = ("o2f", "r2f", "sle")
RESERVE_S = 0.1  # of a decision's time, for the election and a thread that wakes late; half at most
APPEAL_SHARE = 0.5
"""Of the time that a round has: first votes that are out for longer no longer hold up the
appeals."""


@dataclass(frozen=True)
class PanelConfig:
    """[panel]: who votes and how long the vote may take."""

    experts: tuple[ExpertName, ...] = key(
        SEATED, 'Who votes: "o2f" by objects, "r2f" by rooms, "sle" by views.'
    )
    decide_budget_s: float = key(
        2.0,
        "How long a decision may take; votes that come later are dropped.",
        "s",
        within=(0.01, 600.0),
    )
    told: tuple[ExpertName, ...] = key(
        (),
        "Experts whose votes come over the bus in lockstep, from a harness; else they are silent.",
        research="told_experts",
    )
    budget_in_lockstep: bool = key(
        False,
        "Whether a decision's budget counts in lockstep; else experts run to completion.",
        research="budget_in_lockstep",
    )

    @property
    def seated(self) -> tuple[ExpertName, ...]:
        """Those that are asked here."""
        return tuple(name for name in self.experts if name not in self.told)

    @property
    def votes_s(self) -> float:
        """How long votes are waited for, so that the decision is made within its budget."""
        return max(self.decide_budget_s - RESERVE_S, self.decide_budget_s / 2)


@dataclass
class _Seat:
    """One expert's place at the table. Guarded by the panel's condition."""

    name: str
    expert: Expert
    answers: "dict[str, _Answer]"  # where what it says is put, by name
    question: "_Question | None" = None  # waiting for the worker
    running: bool = False
    rehearsing: bool = False  # what runs is of a rehearsal


@dataclass(frozen=True)
class _Question:
    round: int
    brief: Brief
    by: Deadline
    asked_s: float
    rehearsal: bool = False


@dataclass(frozen=True)
class _Answer:
    outcome: Vote | Missing
    latency_s: float  # since the round began


@dataclass
class _Round:
    """What is under way in one `ask`: who was asked, first and on appeal."""

    question: _Question
    busy: list[str]
    asked: list[str]
    appealed: list[str] | None = None  # None: not yet


class Panel:
    """Asks every expert at once and collects the ballot.

    `clock` measures latencies and must be the one the deadlines were made with. `appeals` are asked
    when the first votes are in and `agreed` says that they do not agree. `settled` lets a round
    with a deadline end early; one without waits for everyone, so that what it returns repeats.
    """

    def __init__(
        self,
        experts: Mapping[str, Expert],
        clock: Clock,
        appeals: Mapping[str, Expert] | None = None,
        agreed: Callable[[Ballot], bool] | None = None,
        settled: Settled | None = None,
    ) -> None:
        appeals = appeals or {}
        strangers = sorted(set(appeals) - set(experts))
        if strangers:
            raise ValueError(f"an appeal of {strangers[0]}, which is not among the experts")
        if appeals and agreed is None:
            raise ValueError("appeals need `agreed`, which says when they are asked")
        self._clock, self._agreed, self._settled = clock, agreed, settled
        self._condition = threading.Condition()
        self._answers: dict[str, _Answer] = {}
        self._second: dict[str, _Answer] = {}  # the appeals'
        self._seats = [_Seat(name, experts[name], self._answers) for name in sorted(experts)]
        self._appeals = [_Seat(name, appeals[name], self._second) for name in sorted(appeals)]
        self._number = 0
        self._nudges = 0
        self._open = False  # is the current round still collecting?
        self._closed = False
        self._threads = [
            threading.Thread(
                target=self._work, args=(seat,), name=f"{kind}-{seat.name}", daemon=True
            )
            for kind, seats in (("expert", self._seats), ("appeal", self._appeals))
            for seat in seats
        ]
        for thread in self._threads:
            thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def ask(self, brief: Brief, by: Deadline) -> Ballot:
        """Put `brief` to every idle expert and wait until all have answered, nothing can change
        any more, or `by` has passed."""
        appeal_s = self._clock.now_s() + APPEAL_SHARE * by.left_s()
        with self._condition:
            now = self._begin(brief, by)
            while not by.passed() and not self._done(now, appeal_s):
                until_s = appeal_s if self._appeals and now.appealed is None else by.at_s
                self._clock.wait(self._condition, until_s)
            self._end()
            return self._ballot(now, Absence.LATE if by.passed() else Absence.SETTLED)

    def rehearse(self, brief: Brief, by: Deadline, wanted: Callable[[], bool]) -> Ballot | None:
        """Ask everyone, without appeals, and wait for everyone until `by`; None once it is not
        `wanted` any more, which is looked at when somebody answers and at every `nudge`: without
        the lock, as that may take long."""
        with self._condition:
            now = self._begin(brief, by, rehearsal=True)
        while True:
            with self._condition:
                nudges = self._nudges
            wants = wanted()
            with self._condition:
                if not wants or by.passed() or all(n in self._answers for n in now.asked):
                    self._end()
                    return self._ballot(now, Absence.LATE) if wants else None
                if nudges == self._nudges:
                    self._clock.wait(self._condition, by.at_s)

    def nudge(self) -> None:
        """Have a rehearsal look again whether it is wanted."""
        with self._condition:
            self._nudges += 1
            self._condition.notify_all()

    def _begin(self, brief: Brief, by: Deadline, rehearsal: bool = False) -> _Round:
        self._number += 1
        self._open = True
        self._answers.clear()
        self._second.clear()
        question = _Question(self._number, brief, by, self._clock.now_s(), rehearsal)
        asked = self._put(self._seats, question)
        busy = [seat.name for seat in self._seats if seat.name not in asked]
        return _Round(question, busy, asked)

    def _end(self) -> None:
        self._open = False
        for seat in (*self._seats, *self._appeals):
            seat.question = None  # one that was never picked up is not asked any more

    def close(self) -> None:
        """Let the workers end. One that hangs in its expert is left behind as a daemon thread."""
        with self._condition:
            self._closed = True
            self._condition.notify_all()
        for thread in self._threads:
            thread.join(timeout=0.1)

    def _put(self, seats: Sequence[_Seat], question: _Question) -> list[str]:
        """Ask the idle ones, and those that will be when a rehearsal is over; their names."""
        waits = not question.rehearsal
        idle = [seat for seat in seats if not seat.running or (seat.rehearsing and waits)]
        for seat in idle:
            seat.question = question
        self._condition.notify_all()
        return [seat.name for seat in idle]

    def _done(self, now: _Round, appeal_s: float) -> bool:
        """Whether the round can end before its deadline; asks the appeals when they are due."""
        out = [name for name in now.asked if name not in self._answers]
        ballot = self._ballot(now, Absence.OUT)
        if self._appeals and now.appealed is None:
            agreed = self._agreed is not None and self._agreed(ballot)
            if not agreed and (not out or self._clock.now_s() >= appeal_s):
                now.appealed = self._put(self._appeals, now.question)
            elif not agreed:
                return False
        appealed = [name for name in now.appealed or () if name not in self._second]
        still = {*out, *appealed} - self._replaced().keys()
        if not still:
            return True
        if self._settled is None or math.isinf(now.question.by.at_s):
            return False
        # A vote that may yet be replaced counts as not given: settled then, settled with it.
        sure = [vote for vote in ballot.votes if vote.expert not in still]
        return self._settled(sure, still, now.question.brief)

    def _ballot(self, now: _Round, why: Absence) -> Ballot:
        """The votes as they stand; `why` those that have not answered are missing."""
        heard = {**self._answers, **self._replaced()}
        outcomes = [heard[name].outcome for name in sorted(heard)]
        missing = [o for o in outcomes if isinstance(o, Missing)]
        missing += [Missing(name, Absence.BUSY) for name in now.busy if name not in heard]
        missing += [Missing(name, why) for name in now.asked if name not in heard]
        return Ballot(
            votes=tuple(o for o in outcomes if isinstance(o, Vote)),
            missing=tuple(sorted(missing, key=lambda absent: absent.expert)),
            latency_s={name: heard[name].latency_s for name in sorted(heard)},
        )

    def _replaced(self) -> dict[str, _Answer]:
        """What appeals brought: votes; one that brought none changes nothing."""
        return {n: a for n, a in self._second.items() if isinstance(a.outcome, Vote)}

    def _work(self, seat: _Seat) -> None:
        while True:
            with self._condition:
                while seat.question is None and not self._closed:
                    self._condition.wait()
                if self._closed or seat.question is None:
                    return
                question, seat.question = seat.question, None
                seat.running, seat.rehearsing = True, question.rehearsal
            outcome = checked(_call(seat, question.brief, question.by), question.brief)
            latency_s = self._clock.now_s() - question.asked_s
            with self._condition:
                seat.running = seat.rehearsing = False
                # A round that was closed keeps its votes: what comes after is dropped here.
                if self._open and question.round == self._number and not question.by.passed():
                    seat.answers[seat.name] = _Answer(outcome, latency_s)
                self._condition.notify_all()


def _call(seat: _Seat, brief: Brief, by: Deadline) -> Vote | Missing:
    try:
        outcome = seat.expert(brief, by)
    except Exception as error:  # noqa: BLE001 -- it must not take the robot along
        cause = " ".join(str(error).split()) or type(error).__name__
        return Missing(seat.name, Absence.ERROR, cause[:200])
    if isinstance(outcome, Missing):
        return replace(outcome, expert=seat.name)
    if isinstance(outcome, Vote):
        return replace(outcome, expert=seat.name)
    return Missing(seat.name, Absence.ERROR, f"returned {type(outcome).__name__}, not a vote")


def checked(outcome: Vote | Missing, brief: Brief) -> Vote | Missing:
    """Keep what refers to the frontiers that were asked about. A vote for one that was not on the
    brief is nonsense as a whole; evidence that is no number is none."""
    known = {frontier.id for frontier in brief.frontiers}
    nats = sorted((id, x) for id, x in outcome.nats if id in known and math.isfinite(x))
    outcome = replace(outcome, nats=tuple(nats))
    if isinstance(outcome, Missing):
        return outcome
    strangers = sorted(set(outcome.frontiers) - known)
    if strangers:
        ids = ", ".join(str(number) for number in strangers)
        return Missing(outcome.expert, Absence.NONSENSE, f"voted for unknown frontier {ids}")
    if not outcome.frontiers:
        return Missing(outcome.expert, Absence.NONSENSE, "voted for no frontier")
    return replace(
        outcome,
        frontiers=tuple(sorted(set(outcome.frontiers))),
        probabilities=tuple(sorted(pair for pair in outcome.probabilities if pair[0] in known)),
        against=tuple(sorted(known.intersection(outcome.against))),
        reasons=tuple(sorted(pair for pair in outcome.reasons if pair[0] in known)),
    )
