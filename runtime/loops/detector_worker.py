"""The detectors beside the drive: the map does not wait for them. They look at one image after the
other, chosen by what it shows that is new; what they saw is placed by the pose and the depth of its
own image."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from runtime.clock import Clock
from runtime.core.mapping.attention import WORTH, Attention, View
from runtime.core.types import F64, Detections, Observation
from runtime.loops.worker_thread import WorkerThread
from runtime.tracing.stages import Stage
from runtime.tracing.tracer import Tracer


@dataclass(frozen=True)
class Surveyed:
    """An image whose depth is on the map: `outline` (V, 2) m is its view's, `frame_s` when it
    arrived; `asker` is whose it is, for an answer that comes too late."""

    asker: object
    obs: Observation
    outline: F64
    frame_s: float


@dataclass(frozen=True)
class Look:
    """What the detectors saw in it; how long that took, s; whether the image showed something
    new."""

    of: Surveyed
    detections: Detections
    took_s: float
    new: bool = False


class DetectorWorker:
    """A thread that looks. Only the thread that owns the world calls it. `look` gives None where
    nothing can be said of an image."""

    def __init__(
        self,
        look: Callable[[Surveyed], Detections | None],
        tracer: Tracer,
        clock: Clock,
        nice: int = 0,
    ) -> None:
        self._look, self._tracer, self._clock = look, tracer, clock
        self._thread = WorkerThread("detector", self._work, nice)
        self._changed = self._thread.changed
        self._attention: Attention[Surveyed] = Attention()
        self._at_once = False  # the newest is wanted, whatever else is new
        self._looking = False
        self._new = False  # whether what is looked at shows something new
        self._looks: list[Look] = []  # not taken yet
        self._paused = False
        self._rests_until_s = 0.0
        self.rest = 0.0  # after each look, in lengths of it
        self._thread.start()

    def offer(self, surveyed: Surveyed, view: View, at_once: bool) -> None:
        """One more image that may be looked at. `at_once`: the newest is what matters now."""
        with self._changed:
            self._attention.offer(surveyed, view)
            self._at_once = at_once
            self._changed.notify_all()

    def take(self) -> list[Look]:
        """What was seen meanwhile; raises what went wrong in looking."""
        with self._changed:
            self._thread.check()
            looks, self._looks = self._looks, []
            return looks

    def behind(self) -> bool:
        """Whether something new was not looked at yet, or what was seen in it was not taken. Looks
        at what is known do not count: one is always under way."""
        with self._changed:
            looking = self._looking and self._new
            return looking or any(look.new for look in self._looks) or self._attention.news()

    @contextmanager
    def paused(self) -> Iterator[None]:
        """No look is under way meanwhile; what waits goes on waiting."""
        with self._changed:
            self._paused = True
            self._changed.wait_for(lambda: not self._looking)
        try:
            yield
        finally:
            with self._changed:
                self._paused = False
                self._changed.notify_all()

    def begin(self, newest_only: bool) -> None:
        """Forget all that waits and what was looked at; when this returns no look is under way."""
        with self._changed:
            self._attention = Attention(newest_only)
            self._changed.wait_for(lambda: not self._looking)
            self._looks = []

    def close(self) -> None:
        """Let the thread end; a look under way is left to itself."""
        self._thread.close(2.0)

    def _work(self) -> None:
        while (surveyed := self._next()) is not None:
            began_s, seen = self._clock.now_s(), None
            try:
                with self._tracer.stage(Stage.DETECT):
                    seen = self._look(surveyed)
            finally:
                now_s = self._clock.now_s()
                with self._changed:
                    self._looking = False
                    if seen is not None:
                        self._looks.append(Look(surveyed, seen, now_s - began_s, self._new))
                    self._rests_until_s = now_s + self.rest * (now_s - began_s)
                    self._changed.notify_all()

    def _next(self) -> Surveyed | None:
        """The image to look at, when it is time and there is one; None at the end."""
        with self._changed:
            while not self._thread.closed:
                if self._paused:
                    self._changed.wait()
                    continue
                if self._clock.now_s() < self._rests_until_s:
                    self._clock.wait(self._changed, self._rests_until_s)
                    continue
                attention = self._attention
                news = [w.item for w in attention.waiting if attention.novelty(w.view) >= WORTH]
                surveyed = attention.take(self._at_once)
                if surveyed is not None:
                    self._looking = True
                    self._new = any(item is surveyed for item in news)
                    return surveyed
                self._changed.wait()
            return None
