"""Where time enters: a monotonic clock that tests may replace; deadlines that only tighten."""

import math
import threading
import time
from dataclasses import dataclass
from typing import Protocol


class Clock(Protocol):
    """Monotonic seconds, and waiting measured by the same clock."""

    def now_s(self) -> float: ...

    def wait(self, condition: threading.Condition, until_s: float) -> None:
        """Wait on a held `condition` until it is notified or `until_s` comes; may wake early."""
        ...


class SystemClock:
    """The machine's monotonic clock."""

    def now_s(self) -> float:
        return time.monotonic()

    def wait(self, condition: threading.Condition, until_s: float) -> None:
        # Waits are cut into a second each: a lone endless Condition.wait() cannot be interrupted
        # by Ctrl-C on every platform, and callers re-check anyway.
        condition.wait(min(1.0, max(0.0, until_s - self.now_s())))


@dataclass(frozen=True, slots=True)
class Deadline:
    """An absolute point on a clock. Callees may tighten it, never loosen it."""

    at_s: float
    clock: Clock

    @classmethod
    def after(cls, seconds: float, clock: Clock) -> "Deadline":
        return cls(clock.now_s() + seconds, clock)

    @classmethod
    def never(cls, clock: Clock) -> "Deadline":
        return cls(math.inf, clock)

    def left_s(self) -> float:
        """Seconds until the deadline, 0 when it has passed, inf when there is none."""
        return max(0.0, self.at_s - self.clock.now_s())

    def passed(self) -> bool:
        return self.clock.now_s() >= self.at_s

    def tightened(self, seconds: float) -> "Deadline":
        """The earlier of this deadline and `seconds` from now."""
        return Deadline(min(self.at_s, self.clock.now_s() + seconds), self.clock)
