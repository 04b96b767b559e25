"""Decisions beside the drive: one at a time, in a worker, on a snapshot that nobody changes. While
none is asked for, the next may be rehearsed."""

from dataclasses import dataclass

from runtime import navigate
from runtime.clock import Deadline
from runtime.core.outlook import Outlook
from runtime.core.types import Ballot, Brief, Decision
from runtime.core.voting import consensus
from runtime.core.voting import rehearsal as rehearsing
from runtime.core.world import Snapshot
from runtime.experts.panel import Panel
from runtime.loops.worker_thread import WorkerThread
from runtime.navigate import NavigateConfig
from runtime.record import Record, unrecorded


@dataclass(frozen=True)
class DecisionRequest:
    """What is to be decided; `asker` is whose it is, for an answer that comes too late."""

    asker: object
    snapshot: Snapshot | Outlook
    panel: Panel
    by: Deadline
    cfg: NavigateConfig
    without: int | None = None  # of a rehearsal: the frontier that is taken to be explored

    @property
    def brief(self) -> Brief:
        """What the experts are told; worked out when it is asked for first, which takes a while."""
        brief = self.snapshot.brief
        return brief if self.without is None else rehearsing.expected(brief, self.without)


@dataclass(frozen=True)
class DecisionReply:
    """A decision, and what became of the rehearsal before it: "used", why it could not be, or ""
    when there was none."""

    question: DecisionRequest
    decision: Decision
    rehearsal: str = ""


class DecisionWorker:
    """A thread that decides. Only the thread that owns the world calls it."""

    def __init__(self, nice: int = 0, record: Record = unrecorded) -> None:
        self._record = record
        self._thread = WorkerThread("decisions", self._work, nice)
        self._changed = self._thread.changed
        self._question: DecisionRequest | None = None
        self._answer: DecisionReply | None = None
        self._rehearsal: DecisionRequest | None = None  # to come, or under way
        self._prepared: tuple[DecisionRequest, Ballot] | None = None  # one that is done
        self._thread.start()

    @property
    def busy(self) -> bool:
        """Whether a question is open, or its answer was not taken yet."""
        with self._changed:
            busy = self._question is not None or self._answer is not None
        self._record("heard", {"name": "busy", "value": busy})
        return busy

    @property
    def idle(self) -> bool:
        """Whether there is nothing to do, not even to rehearse."""
        with self._changed:
            busy = self._question is not None or self._answer is not None
            return not busy and self._rehearsal is None

    def ask(self, question: DecisionRequest) -> None:
        """Begin to decide; must not be busy. A rehearsal of something else ends."""
        with self._changed:
            assert self._question is None
            self._question = question
            rehearsal = self._rehearsal
            self._changed.notify_all()
        if rehearsal is not None:
            rehearsal.panel.nudge()

    def rehearse(self, question: DecisionRequest) -> None:
        """Prepare for a question that may come; must be idle. What is prepared already is kept."""
        with self._changed:
            self._rehearsal = question
            self._changed.notify_all()

    def take(self) -> DecisionReply | None:
        """The decision that was made meanwhile; raises what went wrong in making it."""
        with self._changed:
            self._thread.check()
            answer, self._answer = self._answer, None
        if answer is not None:
            snap = answer.question.snapshot  # its brief was worked out by now
            self._record("question", {"why": snap.why, "brief": snap.brief})
            self._record("ballot", (answer.decision.ballot, answer.rehearsal))
        return answer

    def close(self) -> None:
        """Let the thread end; one that still waits for its panel is left to its deadline."""
        self._thread.close(0.5)

    def _work(self) -> None:
        while True:
            with self._changed:
                while not self._something_to_do():
                    self._changed.wait()
                if self._thread.closed:
                    return
                question, rehearsal = self._question, self._rehearsal
            if rehearsal is not None:
                self._try_out(rehearsal)
            elif question is not None:
                self._decide(question)

    def _something_to_do(self) -> bool:
        return self._thread.closed or self._question is not None or self._rehearsal is not None

    def _try_out(self, rehearsal: DecisionRequest) -> None:
        prepared = self._prepared
        if prepared is not None and (
            _apart(prepared[0], rehearsal) or _unfit(prepared[1], rehearsal)
        ):
            prepared = None

        def wanted() -> bool:
            """Nothing is asked yet, or just this."""
            with self._changed:
                question, closed = self._question, self._thread.closed
            return not closed and (question is None or not _apart(rehearsal, question))

        if prepared is None and len(rehearsal.brief.frontiers) > 1:  # else nothing to choose
            ballot = rehearsal.panel.rehearse(rehearsal.brief, rehearsal.by, wanted)
            prepared = (rehearsal, ballot) if ballot is not None else None
        with self._changed:
            self._rehearsal, self._prepared = None, prepared
            self._changed.notify_all()

    def _decide(self, question: DecisionRequest) -> None:
        prepared, told = self._prepared, ""
        early = prepared is not None and _early(prepared[0], question)
        if prepared is not None and not early:
            told = _apart(prepared[0], question) or _unfit(prepared[1], question)
        if prepared is not None and not early and not told:
            told, snap = "used", question.snapshot
            decision = consensus.elect(
                prepared[1],
                snap.frontiers,
                question.cfg.consensus,
                snap.stamp_ns,
                snap.why,
                snap.brief.order,
                snap.brief.ahead,
            )
        else:
            decision = navigate.decide(question.snapshot, question.panel, question.by, question.cfg)
        with self._changed:
            if not early:
                self._prepared = None
            self._question, self._answer = None, DecisionReply(question, decision, told)


def _early(rehearsal: DecisionRequest, question: DecisionRequest) -> bool:
    """Whether the frontier that the rehearsal is without is still there: its time may come."""
    there = rehearsal.without in {f.id for f in question.brief.frontiers}
    return there and rehearsal.asker is question.asker


def _apart(rehearsal: DecisionRequest, question: DecisionRequest) -> str:
    """Why a rehearsal was not of this question; "" when it was."""
    if rehearsal.asker is not question.asker or rehearsal.panel is not question.panel:
        return "another search"
    return rehearsing.differs(rehearsal.brief, question.brief)


def _unfit(ballot: Ballot, question: DecisionRequest) -> str:
    """Why a rehearsed ballot cannot stand for one that is asked for; "" when it can."""
    if not rehearsing.complete(ballot):
        return "an expert was late"
    return "" if consensus.decides(ballot, question.cfg.consensus) else "no agreement"
