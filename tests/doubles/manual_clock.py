"""A clock that a test sets by hand."""

import threading


class ManualClock:
    """A clock that moves only when a test says so; waiters wake when it does."""

    def __init__(self, now_s: float = 0.0) -> None:
        self._lock = threading.Lock()
        self._now_s = now_s
        self._waiting: list[threading.Condition] = []

    def now_s(self) -> float:
        with self._lock:
            return self._now_s

    def advance(self, seconds: float) -> None:
        """Move time forward and wake everyone who waits on this clock."""
        if seconds < 0:
            raise ValueError(f"a monotonic clock cannot go back by {-seconds} s")
        with self._lock:
            self._now_s += seconds
            waiting = list(self._waiting)
        for condition in waiting:
            with condition:
                condition.notify_all()

    def wait(self, condition: threading.Condition, until_s: float) -> None:
        with self._lock:
            if self._now_s >= until_s:
                return
            self._waiting.append(condition)
        # `advance` needs the condition's lock to notify, and it is ours until wait() lets go of it:
        # no wake-up is lost between the check above and the wait below.
        condition.wait()
        with self._lock:
            self._waiting.remove(condition)
