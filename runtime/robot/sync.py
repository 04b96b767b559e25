"""Short rings of undecoded messages, and which of them belong together. No I/O, no clock."""

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

from runtime.core.types import Pose
from runtime.robot.wire import Stamped

IMAGES_KEPT = 10
# Odometry comes at 20-200 Hz and must reach back to the oldest image in its ring.
ODOMETRY_KEPT = 200
ODOMETRY_BEHIND_NS = 300_000_000
CLOCK_BACK_NS = 1_000_000_000  # a stamp this much older than the one before: a clock was set back


@dataclass(frozen=True)
class RawMessage:
    """A message as it came: its header's stamp, its bytes, and when it arrived (monotonic s)."""

    stamp_ns: int
    payload: bytes
    arrival_s: float


@dataclass(frozen=True)
class Match:
    """Colour and depth of one moment, and the odometry on both sides of it (or twice at it)."""

    color: RawMessage
    depth: RawMessage
    before: RawMessage
    after: RawMessage

    @property
    def arrival_s(self) -> float:
        """When both images were there, monotonic."""
        return max(self.color.arrival_s, self.depth.arrival_s)

    @property
    def stamp_ns(self) -> int:
        """The depth image's: it is the geometry that must sit at the right pose."""
        return self.depth.stamp_ns


class Rings:
    """The newest messages of three streams.

    In real time the newest match wins and what is older is forgotten. In lockstep nothing is
    forgotten: matches leave in the order of their stamps, which must be equal in all streams.
    tolerance_ns: between the images of a pair; odometry_gap_ns: that is interpolated over.
    """

    def __init__(self, tolerance_ns: int, odometry_gap_ns: int, lockstep: bool) -> None:
        self.tolerance_ns = 0 if lockstep else tolerance_ns
        self.odometry_gap_ns = odometry_gap_ns
        self._lockstep = lockstep
        self.color: deque[RawMessage] = deque(maxlen=None if lockstep else IMAGES_KEPT)
        self.depth: deque[RawMessage] = deque(maxlen=None if lockstep else IMAGES_KEPT)
        self.odom: deque[RawMessage] = deque(maxlen=None if lockstep else ODOMETRY_KEPT)

    def clear(self) -> None:
        for ring in (self.color, self.depth, self.odom):
            ring.clear()

    def file(self, stream: str, raw: RawMessage) -> bool:
        """Add a message. In real time one from a clock that was set back makes what came before it
        worthless, in all streams; whether it is one."""
        ring: deque[RawMessage] = getattr(self, stream)
        back = bool(ring) and raw.stamp_ns < ring[-1].stamp_ns - CLOCK_BACK_NS
        back = back and not self._lockstep
        if back:
            self.clear()
        ring.append(raw)
        return back

    def peek(self) -> Match | None:
        """The next match, left in place."""
        return next(self._matches(), None)

    def take(self) -> Match | None:
        """The next match; its images and everything older leave the rings."""
        match = self.peek()
        if match is not None:
            _forget(self.color, match.color.stamp_ns)
            _forget(self.depth, match.depth.stamp_ns)
            # The odometry just before may be needed again for the next image, and what is a little
            # older for a scan that was taken before this one.
            behind_ns = 0 if self._lockstep else ODOMETRY_BEHIND_NS
            _forget(self.odom, match.before.stamp_ns - 1 - behind_ns)
        return match

    def _matches(self) -> Iterator[Match]:
        for color in self.color if self._lockstep else reversed(self.color):
            depth = min(
                self.depth, key=lambda raw: abs(raw.stamp_ns - color.stamp_ns), default=None
            )
            if depth is None or abs(depth.stamp_ns - color.stamp_ns) > self.tolerance_ns:
                continue
            sides = self.around(depth.stamp_ns)
            if sides is not None:
                yield Match(color, depth, *sides)

    def around(self, stamp_ns: int) -> tuple[RawMessage, RawMessage] | None:
        """The odometry just before and after a moment, twice that of the moment itself; None where
        that is too far away."""
        before = max(
            (raw for raw in self.odom if raw.stamp_ns <= stamp_ns),
            key=lambda raw: raw.stamp_ns,
            default=None,
        )
        if before is None:
            return None
        if before.stamp_ns == stamp_ns:
            return before, before
        if self._lockstep:
            return None
        after = min(
            (raw for raw in self.odom if raw.stamp_ns > stamp_ns),
            key=lambda raw: raw.stamp_ns,
            default=None,
        )
        if after is None or after.stamp_ns - before.stamp_ns > self.odometry_gap_ns:
            return None
        return before, after


def interpolate(before: Stamped[Pose], after: Stamped[Pose], stamp_ns: int) -> Pose:
    """The pose at `stamp_ns` between two others: a straight line, and the shorter way round."""
    span_ns = after.stamp_ns - before.stamp_ns
    if span_ns <= 0:
        return before.value
    share = (stamp_ns - before.stamp_ns) / span_ns
    a, b = before.value, after.value
    turn = math.remainder(b.yaw_rad - a.yaw_rad, math.tau)
    yaw = math.remainder(a.yaw_rad + share * turn, math.tau)
    return Pose(
        a.x_m + share * (b.x_m - a.x_m),
        a.y_m + share * (b.y_m - a.y_m),
        math.pi if yaw == -math.pi else yaw,
    )


def _forget(ring: deque[RawMessage], up_to_ns: int) -> None:
    """Remove what is not newer than `up_to_ns`, whatever order it arrived in."""
    kept = [raw for raw in ring if raw.stamp_ns > up_to_ns]
    ring.clear()
    ring.extend(kept)
