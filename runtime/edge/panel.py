"""DEFA's experts in threads: one worker each, one call in flight each, judged at one deadline.

A Python thread cannot be killed. An expert that has not answered at the deadline is "late" and what
it returns later is dropped; if it still runs when the next question comes, it is "busy" for that
one. So nothing stacks up: threads and memory stay constant whatever the experts do.
"""

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Self

from runtime.core.types import Ballot, Brief, Missing, Vote
from runtime.edge.clock import Clock, Deadline

Expert = Callable[[Brief, Deadline], Vote | Missing]


@dataclass
class _Seat:
    """One expert's place at the table. Guarded by the panel's condition."""

    name: str
    expert: Expert
    question: tuple[int, Brief, Deadline] | None = None  # waiting for the worker
    running: bool = False


@dataclass(frozen=True)
class _Answer:
    outcome: Vote | Missing
    latency_s: float


class Panel:
    """Asks every expert at once and collects the ballot.

    `clock` measures latencies and must be the one the deadlines were made with.
    """

    def __init__(self, experts: Mapping[str, Expert], clock: Clock) -> None:
        self._clock = clock
        self._condition = threading.Condition()
        self._seats = [_Seat(name, experts[name]) for name in sorted(experts)]
        self._round = 0
        self._open = False  # is the current round still collecting?
        self._answers: dict[str, _Answer] = {}
        self._closed = False
        self._threads = [
            threading.Thread(
                target=self._work, args=(seat,), name=f"expert-{seat.name}", daemon=True
            )
            for seat in self._seats
        ]
        for thread in self._threads:
            thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def ask(self, brief: Brief, by: Deadline) -> Ballot:
        """Put `brief` to every idle expert and wait until all have answered or `by` has passed."""
        missing: list[Missing] = []
        with self._condition:
            self._round += 1
            self._open = True
            self._answers = {}
            asked: list[str] = []
            for seat in self._seats:
                if seat.running:
                    missing.append(Missing(seat.name, "busy"))
                else:
                    seat.question = (self._round, brief, by)
                    asked.append(seat.name)
            self._condition.notify_all()
            while len(self._answers) < len(asked) and not by.passed():
                self._clock.wait(self._condition, by.at_s)
            self._open = False
            answers = self._answers
            for seat in self._seats:
                seat.question = None  # one that was never picked up is not asked any more
        missing += [Missing(name, "late") for name in asked if name not in answers]
        return _ballot(brief, answers, missing)

    def close(self) -> None:
        """Let the workers end. One that hangs in its expert is left behind as a daemon thread."""
        with self._condition:
            self._closed = True
            self._condition.notify_all()
        for thread in self._threads:
            thread.join(timeout=0.1)

    def _work(self, seat: _Seat) -> None:
        while True:
            with self._condition:
                while seat.question is None and not self._closed:
                    self._condition.wait()
                if self._closed or seat.question is None:
                    return
                number, brief, by = seat.question
                seat.question = None
                seat.running = True
            began_s = self._clock.now_s()
            outcome = _call(seat, brief, by)
            latency_s = self._clock.now_s() - began_s
            with self._condition:
                seat.running = False
                # A round that was closed keeps its votes: what comes after is dropped here.
                if self._open and number == self._round and not by.passed():
                    self._answers[seat.name] = _Answer(outcome, latency_s)
                self._condition.notify_all()


def _call(seat: _Seat, brief: Brief, by: Deadline) -> Vote | Missing:
    try:
        outcome = seat.expert(brief, by)
    except Exception as error:  # noqa: BLE001 -- it must not take the robot along
        cause = " ".join(str(error).split()) or type(error).__name__
        return Missing(seat.name, f"error: {cause[:200]}")
    if isinstance(outcome, Missing):
        return replace(outcome, expert=seat.name)
    if isinstance(outcome, Vote):
        return replace(outcome, expert=seat.name)
    return Missing(seat.name, f"error: returned {type(outcome).__name__}, not a vote")


def _ballot(brief: Brief, answers: Mapping[str, _Answer], missing: list[Missing]) -> Ballot:
    """Keep what refers to the frontiers that were asked about; sort by name."""
    known = {frontier.id for frontier in brief.frontiers}
    votes: list[Vote] = []
    for name in sorted(answers):
        outcome = answers[name].outcome
        if isinstance(outcome, Vote):
            outcome = _checked(outcome, known)
        if isinstance(outcome, Vote):
            votes.append(outcome)
        else:
            missing.append(outcome)
    return Ballot(
        votes=tuple(votes),
        missing=tuple(sorted(missing, key=lambda absent: absent.expert)),
        latency_s={name: answers[name].latency_s for name in sorted(answers)},
    )


def _checked(vote: Vote, known: set[int]) -> Vote | Missing:
    """A vote for a frontier that was not on the brief is nonsense as a whole."""
    strangers = sorted(set(vote.frontiers) - known)
    if strangers:
        ids = ", ".join(str(number) for number in strangers)
        return Missing(vote.expert, f"nonsense: voted for unknown frontier {ids}")
    if not vote.frontiers:
        return Missing(vote.expert, "nonsense: voted for no frontier")
    return replace(
        vote,
        frontiers=tuple(sorted(set(vote.frontiers))),
        probabilities=tuple(sorted(pair for pair in vote.probabilities if pair[0] in known)),
    )
