"""Why an episode failed: in detection, in planning or in exploration. Decided from the log.

The rule, for an episode that is no success; the first that holds:
1. error: it ended in an error of the runtime or of the harness;
2. detection: it stopped for something that is no instance of the goal (`claim` "false");
3. planning: it fell, or it stopped for an instance (`claim` "true") outside of where that counts,
   or made for one on the way (`believed_at`) and did not end there;
4. detection: the goal was in view (`seen_at`) and never made for;
5. exploration: the goal was never in view.
In view is 200 pixels of a 640x480 frame within 5 m, by the true segmentation.
"""

from collections import Counter
from collections.abc import Sequence
from enum import StrEnum
from typing import Protocol

from hil_sim.driving.episode_result import End, Ended
from hil_sim.ground_truth.witness import Claim


class Cause(StrEnum):
    """What a failure is put down to."""

    DETECTION = "detection"
    PLANNING = "planning"
    EXPLORATION = "exploration"
    ERROR = "error"


class Log(Protocol):
    """What the rule reads of an episode's result."""

    @property
    def success(self) -> bool: ...
    @property
    def ended(self) -> Ended: ...
    @property
    def claim(self) -> Claim: ...
    @property
    def believed_at(self) -> int | None: ...
    @property
    def seen_at(self) -> int | None: ...


def cause(log: Log) -> Cause | None:
    """By the rule above; None for a success."""
    if log.success:
        return None
    if log.ended.failed:
        return Cause.ERROR
    if log.ended.end is End.FELL:
        return Cause.PLANNING
    if log.claim is Claim.FALSE:
        return Cause.DETECTION
    if log.claim is Claim.TRUE or log.believed_at is not None:
        return Cause.PLANNING
    return Cause.EXPLORATION if log.seen_at is None else Cause.DETECTION


def split(logs: Sequence[Log]) -> dict[Cause, int]:
    """Failures by cause, all causes named."""
    count = Counter(cause(log) for log in logs)
    return {name: count[name] for name in Cause}


def false_finds(logs: Sequence[Log], frames: int) -> float:
    """How often, in 1,000 frames looked at, something was confirmed from several views and stopped
    for that is no instance of the goal; `frames` is how many these episodes had together."""
    return 1000.0 * sum(log.claim is Claim.FALSE for log in logs) / max(frames, 1)
