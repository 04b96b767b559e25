"""What is said of a search to whoever asked for it: on `rfnav/feedback`, at changes and every now
and then."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Protocol

from runtime.core.types import SearchState
from runtime.loops.search import Search

FEEDBACK_S = 1.0  # between messages, where nothing changes


class Listener(Protocol):
    """Who hears it."""

    def publish_feedback(self, feedback: dict[str, object]) -> None: ...


@dataclass
class Feedback:
    """Of one search. `began_s` and `now_s` are monotonic seconds."""

    search: Search
    began_s: float
    told_s: float = -1e9  # when something was published last
    told: tuple[object, ...] = field(default=())  # and what of it a change is worth a message
    driven_m: float = 0.0
    counted: int = 0  # poses of the track that are in it
    led_s: float = 0.0  # for so long somebody else drove: no time of the search

    def elapsed_s(self, now_s: float) -> float:
        """How long the search has taken."""
        return now_s - self.began_s - self.led_s

    def tell(
        self,
        listener: Listener,
        state: SearchState,
        reason: str,
        now_s: float,
        always: bool = False,
    ) -> None:
        """Publish, where something changed or it is time to."""
        world = self.search.world
        command = world.body.last if world else None
        told = state, command.mode if command else ""
        if not (always or now_s - self.told_s >= FEEDBACK_S or told != self.told):
            return
        self.told, self.told_s = told, now_s
        self._drive_on(world.body.visited_xy if world else [])
        listener.publish_feedback(
            {
                "goal": self.search.goal.text,
                "state": state,
                "mode": told[1],
                "reason": reason,
                "toward_xy": command.toward_xy if command else None,
                "elapsed_s": round(self.elapsed_s(now_s), 3),
                "driven_m": round(self.driven_m, 3),
                "decisions": self.search.decisions,
            }
        )

    def _drive_on(self, track: Sequence[tuple[float, float]]) -> None:
        """Add what is new of the way; the track only grows."""
        new = track[max(0, self.counted - 1) :]
        self.driven_m += sum(math.dist(a, b) for a, b in pairwise(new))
        self.counted = len(track)
