"""One clock for all streams: odometry's. Stamps that are none are made of arrivals, and those of
another clock are taken to this one. No clock, no lock: times are arguments, monotonic seconds."""

import math
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Final

from runtime.log import say
from runtime.robot.sync import CLOCK_BACK_NS, RawMessage

WINDOW_S: Final = 10.0  # over which the least delay of a stream is taken for its clock's offset
STREAMS: Final = ("odom", "depth", "color")
# An image that is older than odometry by less than that is late, and one by more of another clock;
# one that is younger than odometry cannot be late, but odometry can.
LATE_S: Final = 10.0
AHEAD_S: Final = 10.0
ONE_CLOCK_S: Final = 1.0  # two cameras' offsets differ by less: they have one
SURE: Final = 5  # messages on end that say so: where all clocks are set, one stream is first
WANDERED_S: Final = 0.05  # from where an offset was taken for another: it is taken anew


class StampAge:
    """How late the messages of a stream come. A stamp and an arrival are of two clocks: their least
    difference of the last WINDOW_S is taken for the clocks' own, and what is beyond it, for age."""

    def __init__(self) -> None:
        self.offset_s = math.inf
        self.stands_still = False  # its stamps do not: then there is no age by them
        self._least: deque[tuple[float, float]] = deque()  # rising offsets, by arrival
        self._last_ns: int | None = None

    def late_s(self, stamp_ns: int, arrival_s: float, other_s: float = math.inf) -> float:
        """Seconds >= 0 of a message that has just come. `other_s`: the offset of another stream of
        the same clock, which a stream that is late from its beginning is known by."""
        last_ns, self._last_ns = self._last_ns, stamp_ns
        self.stands_still = stamp_ns == 0 or stamp_ns == last_ns
        if self.stands_still:
            return 0.0
        if last_ns is not None and stamp_ns < last_ns - CLOCK_BACK_NS:
            self._least.clear()
        offset_s = arrival_s - stamp_ns / 1e9
        while self._least and self._least[-1][1] >= offset_s:
            self._least.pop()
        self._least.append((arrival_s, offset_s))
        while self._least[0][0] < arrival_s - WINDOW_S:
            self._least.popleft()
        self.offset_s = self._least[0][1]
        return max(0.0, offset_s - min(self.offset_s, other_s))


class StreamClocks:
    """Of one robot in real time."""

    def __init__(self, tell: Callable[[str], None] = say) -> None:
        self._tell, self._told = tell, set[str]()
        self._ages = {name: StampAge() for name in STREAMS}
        self._strange: dict[str, int] = {}  # messages by another clock, on end
        self._shifts_s: dict[str, float] = {}  # that stamps of another clock are moved by
        self.unstamped: set[str] = set()

    def restamped(self, stream: str, raw: RawMessage, topic: str) -> RawMessage:
        """A message of `STREAMS` that has just come, by odometry's clock."""
        if raw.stamp_ns == 0:
            self.unstamped.add(stream)
            self._say_once(f"{topic}: header.stamp is 0: arrival is taken; let the driver fill it")
            return replace(raw, stamp_ns=round((raw.arrival_s - self._offset_s()) * 1e9))
        self.unstamped.discard(stream)
        self._ages[stream].late_s(raw.stamp_ns, raw.arrival_s)
        shift_s = self._shift_s(stream, topic) if stream != "odom" else 0.0
        if not shift_s:
            return raw
        return replace(raw, stamp_ns=raw.stamp_ns + round(shift_s * 1e9))

    def _offset_s(self) -> float:
        """Of arrivals to the clock that the stamps are of, of which there is one."""
        offsets = (self._ages[name].offset_s for name in STREAMS)
        return next((offset_s for offset_s in offsets if math.isfinite(offset_s)), 0.0)

    def _shift_s(self, stream: str, topic: str) -> float:
        own_s, base_s = self._ages[stream].offset_s, self._ages["odom"].offset_s
        apart_s = own_s - base_s
        if not math.isfinite(apart_s) or -AHEAD_S < apart_s < LATE_S:
            self._shifts_s.pop(stream, None)
            self._strange[stream] = 0
            return 0.0
        self._strange[stream] = self._strange.get(stream, 0) + 1
        if self._strange[stream] < SURE:
            return 0.0
        where = "behind" if apart_s > 0 else "ahead of"
        what = f"stamps are {abs(apart_s):.0f} s {where} odometry's: of another clock"
        self._say_once(f"{topic}: {what}: arrivals relate them; synchronise the clocks")
        if stream == "color" and abs(own_s - self._ages["depth"].offset_s) < ONE_CLOCK_S:
            return self._shifts_s.get("depth", apart_s)  # its stamps tell which are a pair
        if abs(apart_s - self._shifts_s.get(stream, math.inf)) > WANDERED_S:
            self._shifts_s[stream] = apart_s
        return self._shifts_s[stream]

    def _say_once(self, what: str) -> None:
        topic = what.partition(":")[0]
        if topic not in self._told:
            self._told.add(topic)
            self._tell(what)
