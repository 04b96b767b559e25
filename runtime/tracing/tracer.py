"""Where the time goes: every stage of every tick, timed against its deadline.

A stage belongs to one thread, so that nothing here is locked and nobody waits for anybody: the
control loop is traced too. What it costs is counted in tests/latency.
"""

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType

from runtime.tracing.budgets import Budgets
from runtime.tracing.histogram import Histogram
from runtime.tracing.stages import Stage

OVERRUNS_KEPT = 64  # that nobody has asked for yet


@dataclass(frozen=True)
class Beside:
    """What another thread was at, and since when, s."""

    thread: str
    stage: str
    since_s: float


@dataclass(frozen=True)
class Overrun:
    """A stage that took longer than its deadline. `beside`: what was running when it ended."""

    stage: Stage
    took_ms: float
    deadline_ms: float
    beside: tuple[Beside, ...]


class Tracer:
    """Times stages on `now_s`, monotonic seconds."""

    def __init__(self, budgets: Budgets, now_s: Callable[[], float]) -> None:
        self._now_s = now_s
        self._deadlines_s = {s: b.p99_ms / 1e3 for s, b in budgets.stages.items()}
        self._histograms = {stage: Histogram() for stage in Stage}
        self._running: dict[int, tuple[str, float]] = {}  # by thread
        self._names: dict[int, str] = {}
        self._notes: dict[str, tuple[str, float]] = {}
        self._overruns: deque[Overrun] = deque(maxlen=OVERRUNS_KEPT)

    def stage(self, stage: Stage) -> "StageSpan":
        """A context manager that times what is done in it."""
        return StageSpan(self, stage)

    def begin(self, stage: str) -> tuple[str, float] | None:
        """This thread is at a stage from now on; returns what it was at, for `end`."""
        me = threading.get_ident()
        if me not in self._names:
            self._names[me] = threading.current_thread().name
        outer = self._running.get(me)
        self._running[me] = stage, self._now_s()
        return outer

    def end(self, outer: tuple[str, float] | None) -> float:
        """It is done with it; returns how long it took, s."""
        me = threading.get_ident()
        _, began_s = self._running.pop(me)
        if outer is not None:
            self._running[me] = outer
        return self._now_s() - began_s

    def book(self, stage: Stage, seconds: float) -> None:
        """Count a stage that took so long."""
        histogram, deadline_s = self._histograms[stage], self._deadlines_s.get(stage)
        histogram.add(seconds)
        if deadline_s is not None and seconds > deadline_s:
            histogram.over += 1
            took_ms, deadline_ms = round(seconds * 1e3, 2), round(deadline_s * 1e3, 2)
            self._overruns.append(Overrun(stage, took_ms, deadline_ms, self._beside()))

    def note(self, thread: str, doing: str) -> None:
        """What a thread that times nothing itself is at; "" when it rests."""
        if not doing:
            self._notes.pop(thread, None)
        elif self._notes.get(thread, ("",))[0] != doing:
            self._notes[thread] = doing, self._now_s()

    def overruns(self) -> list[Overrun]:
        """Those since this was asked last, the newest OVERRUNS_KEPT of them. One thread asks."""
        return [self._overruns.popleft() for _ in range(len(self._overruns))]

    def clear(self) -> None:
        """Count anew; what is under way is booked to what is new."""
        self._histograms = {stage: Histogram() for stage in Stage}
        self._overruns.clear()

    def histograms(self) -> dict[Stage, Histogram]:
        """By stage, of those that ran; they go on counting. Any thread may ask."""
        return {stage: h for stage, h in self._histograms.items() if h.n}

    def told(self) -> dict[str, dict[str, float]]:
        """Percentiles by stage, of those that ran."""
        return {s.value: h.told() for s, h in self._histograms.items() if h.n}

    def _beside(self) -> tuple[Beside, ...]:
        me, now_s = threading.get_ident(), self._now_s()
        running = {self._names[t]: r for t, r in self._running.copy().items() if t != me}
        return tuple(
            Beside(thread, stage, round(now_s - began_s, 4))
            for thread, (stage, began_s) in (running | self._notes.copy()).items()
        )


class StageSpan:
    """A stage under way; see `Tracer.stage`."""

    __slots__ = ("_outer", "_stage", "_tracer")

    def __init__(self, tracer: Tracer, stage: Stage) -> None:
        self._tracer, self._stage = tracer, stage
        self._outer: tuple[str, float] | None = None

    def __enter__(self) -> None:
        self._outer = self._tracer.begin(self._stage)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._tracer.book(self._stage, self._tracer.end(self._outer))
