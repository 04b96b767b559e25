"""The sticks that a page has: what it holds is told to the base ten times a second, and let go when
the page falls silent, whatever became of it, or somebody stops the robot."""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from runtime.clock import Clock

SPEAKS_S: Final = 0.1
SILENT_S: Final = 0.35  # after which nobody holds them: two messages of a page may be lost
ZEROS: Final = 3  # that are told when they are let go


@dataclass(frozen=True)
class _Held:
    who: int
    v_mps: float
    w_radps: float
    until_s: float


class PageSticks:
    """One hand at a time: who came first has them until he lets go. `tell`: a velocity for the
    base, m/s and rad/s, in a thread of its own; `most`: how fast, forward and round; `barred`: why
    nobody may drive now, "" for nothing."""

    def __init__(
        self,
        tell: Callable[[float, float], None],
        most: tuple[float, float],
        barred: Callable[[], str],
        clock: Clock,
    ) -> None:
        self._tell, self._most, self._barred, self._clock = tell, most, barred, clock
        self._changed = threading.Condition()
        self._held: _Held | None = None
        self._dropped = False  # until all hands have rested
        self._reached_s = -SILENT_S  # when anybody reached for them last
        self._zeros = 0
        self._closed = False
        self._thread: threading.Thread | None = None

    @property
    def who(self) -> int | None:
        """Who holds them."""
        with self._changed:
            return self._held.who if self._held is not None else None

    def hold(self, who: int, v: float, w: float) -> bool:
        """Shares of the most, -1 to 1; whether he has them."""
        v_mps, w_radps = (
            max(-1.0, min(1.0, share)) * most
            for share, most in zip((v, w), self._most, strict=True)
        )
        barred = bool(self._barred())
        with self._changed:
            now_s = self._clock.now_s()
            rested, self._reached_s = now_s >= self._reached_s + SILENT_S, now_s
            self._dropped = barred or (self._dropped and not rested)
            if self._dropped:
                self._end()
            if self._closed or self._dropped or (self._held and self._held.who != who):
                return False
            self._held = _Held(who, v_mps, w_radps, now_s + SILENT_S)
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="sticks", daemon=True)
                self._thread.start()
            self._changed.notify_all()
        return True

    def let_go(self, who: int) -> None:
        """He has gone, or wants no more."""
        with self._changed:
            if self._held is not None and self._held.who == who:
                self._end()

    def drop(self) -> None:
        """Somebody stops the robot: nobody has them any more, until all have let go by themselves.
        Whoever goes on holding his would else drive before the robot has told that it stands."""
        with self._changed:
            self._dropped = True
            self._end()

    def close(self) -> None:
        """Whoever holds them lets go; zero has been told when this returns. Idempotent."""
        with self._changed:
            self._closed = True
            self._end()
            self._changed.notify_all()
        if self._thread is not None:
            self._thread.join(timeout=2.0)

    def _end(self) -> None:
        """Holding the lock: who has them has them no more."""
        if self._held is not None:
            self._held, self._zeros = None, ZEROS
            self._changed.notify_all()

    def _run(self) -> None:
        due_s = self._clock.now_s()
        while True:
            with self._changed:
                while self._held is None and not self._zeros:
                    if self._closed:
                        return
                    self._clock.wait(self._changed, self._clock.now_s() + 1.0)
                while self._clock.now_s() < due_s and not self._closed:
                    self._clock.wait(self._changed, due_s)
                twist = self._next()
            due_s = self._clock.now_s() + SPEAKS_S
            self._tell(*twist)

    def _next(self) -> tuple[float, float]:
        """Holding the lock: what is told now."""
        if self._held is not None and self._clock.now_s() >= self._held.until_s:
            self._end()
        if self._held is not None and self._barred():
            self._dropped = True
            self._end()
        if self._held is None:
            self._zeros -= 1
            return 0.0, 0.0
        return self._held.v_mps, self._held.w_radps
