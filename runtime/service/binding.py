"""Where the frame that places, zones and the remembered map are in lies in the map of now: a
restart begins a new odometry, and until somebody or something has told, nobody knows."""

import threading
from dataclasses import dataclass
from typing import Final

from runtime.core.types import Pose

ORIGIN = Pose(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Bound:
    """`transform`: the saved frame's own pose in the map of now; `by`: how that came to be known;
    `at_s`: monotonic, when. `sure`: what is seen agrees, or there is nothing to compare."""

    transform: Pose
    by: str
    at_s: float
    sure: bool = True


BEGUN_HERE: Final = Bound(ORIGIN, "", 0.0)
"""The frame of now is the one that things are saved in."""


class Binding:
    """Of one process; any thread may ask. Where nothing was saved the frame of now is the one that
    things are saved in."""

    def __init__(self, saved: bool) -> None:
        self._lock = threading.Lock()
        self._bound: Bound | None = None
        self._why = "this odometry began with the process"
        if not saved:
            self.bind(BEGUN_HERE)

    def bound(self) -> Bound | None:
        with self._lock:
            return self._bound

    def transform(self) -> Pose | None:
        """The saved frame's pose in the map of now; None while that is not known."""
        bound = self.bound()
        return bound.transform if bound else None

    def sure(self) -> bool:
        """Whether it is known, and what is seen agrees."""
        bound = self.bound()
        return bound is not None and bound.sure

    def bind(self, bound: Bound) -> None:
        with self._lock:
            self._bound, self._why = bound, ""

    def unbind(self, why: str) -> None:
        """What is saved is not used until it is bound again."""
        with self._lock:
            self._bound, self._why = None, why

    def in_words(self) -> str:
        """As `rfnav/status` has it."""
        with self._lock:
            if self._bound is None:
                return f"unbound: {self._why}"
            if not self._bound.by:
                return "none: it begins here"
            return f"bound by {self._bound.by}" + ("" if self._bound.sure else ", not seen yet")
