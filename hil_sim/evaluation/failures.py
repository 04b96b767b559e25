"""Why an episode failed: in the eyes, in the feet or in where it looked. Decided from the log.

The rule, for an episode that is no success; the first that holds:
1. error: it ended in an error of the runtime or of the harness;
2. detection: it stopped for something that is no instance of the goal (`claim` "false");
3. planning: it stopped for an instance (`claim` "true") outside of where that counts, or made for
   one on the way (`believed_at`) and did not end there;
4. detection: the goal was in view (`seen_at`) and never made for;
5. exploration: the goal was never in view.
In view is 200 pixels of a 640x480 frame within 5 m, by the true segmentation.
"""

from collections import Counter
from collections.abc import Sequence
from typing import Protocol

from hil_sim.driving.episode_result import Ended

CAUSES = ("detection", "planning", "exploration", "error")


class Log(Protocol):
    """What the rule reads of an episode's result."""

    @property
    def success(self) -> bool: ...
    @property
    def ended(self) -> Ended: ...
    @property
    def claim(self) -> str: ...
    @property
    def believed_at(self) -> int | None: ...
    @property
    def seen_at(self) -> int | None: ...


def cause(log: Log) -> str | None:
    """One of CAUSES; None for a success."""
    if log.success:
        return None
    if log.ended.failed:
        return "error"
    if log.claim == "false":
        return "detection"
    if log.claim == "true" or log.believed_at is not None:
        return "planning"
    return "exploration" if log.seen_at is None else "detection"


def split(logs: Sequence[Log]) -> dict[str, int]:
    """Failures by cause, all causes named."""
    count = Counter(cause(log) for log in logs)
    return {name: count[name] for name in CAUSES}


def false_finds(logs: Sequence[Log], frames: int) -> float:
    """How often, in 1,000 frames looked at, something was confirmed from several views and stopped
    for that is no instance of the goal; `frames` is how many these episodes had together."""
    return 1000.0 * sum(log.claim == "false" for log in logs) / max(frames, 1)
