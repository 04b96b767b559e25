"""What systemd is told of the process: that goals are taken, how it stands, and that it is alive.
Its watchdog is fed by the control loop's own turns, and by them only as long as whoever serves
goals turns, too: a process of which either hangs is killed and started again."""

import math
import os
from collections.abc import Callable, Mapping
from typing import Final, Self

from runtime.clock import Clock
from runtime.guard import tell_systemd

SHARE: Final = 4  # signs in the time after which the watchdog bites
SILENT_S: Final = 60.0  # longer than whatever serves goals ever takes for one turn
STATUS_S: Final = 1.0  # between two looks at how it stands


class Systemd:
    """Tells nothing where systemd did not start the process with Type=notify."""

    def __init__(self, clock: Clock, given: Mapping[str, str] = os.environ) -> None:
        self._clock, self._told, self._taken = clock, "", False
        self._asked_s, self._turned_s = -math.inf, clock.now_s()
        watched = given.get("WATCHDOG_PID", str(os.getpid())) == str(os.getpid())
        limit = given.get("WATCHDOG_USEC", "")
        self._due_s = -math.inf if watched and limit.isdigit() else math.inf
        self._period_s = int(limit) / 1e6 / SHARE if limit.isdigit() else math.inf

    def __enter__(self) -> Self:
        self._stands("starting: models load")
        return self

    def __exit__(self, _: object, error: BaseException | None, __: object) -> None:
        tell_systemd("STOPPING=1")
        if error is not None:
            self._stands(f"ends: {error}")

    def fed(self, beat: Callable[[bool], str]) -> Callable[[bool], str]:
        """`beat`, for the control loop to call in every turn: it feeds the watchdog, too."""

        def turn(moving: bool) -> str:
            self._feed()
            return beat(moving)

        return turn

    def served(self, until: Callable[[], bool], standing: Callable[[], str]) -> Callable[[], bool]:
        """`until`, for who serves goals to ask before every turn; from the first time on goals are
        taken. `standing`: how it stands, in words."""

        def turn() -> bool:
            self._turned_s = now_s = self._clock.now_s()
            if until():
                tell_systemd("STOPPING=1")
                return True
            if not self._taken:
                self._taken = True
                tell_systemd("READY=1")
            if now_s - self._asked_s >= STATUS_S:
                self._asked_s = now_s
                self._stands(standing())
            return False

        return turn

    def _feed(self) -> None:
        """In the control loop's thread."""
        now_s = self._clock.now_s()
        hangs = self._taken and now_s - self._turned_s > SILENT_S
        if now_s >= self._due_s and not hangs:
            self._due_s = now_s + self._period_s
            tell_systemd("WATCHDOG=1")

    def _stands(self, words: str) -> None:
        """One line of `systemctl status`."""
        line = " ".join(words.split())
        if line != self._told:
            self._told = line
            tell_systemd(f"STATUS={line}")
