"""What is wrong with a robot's streams, as a reason to stand that names topic, what came, and the
remedy. Whoever holds the base tells it: `rfnav/state`, the log and the journal have it alike. No
clock, no lock: times are arguments, monotonic seconds."""

from collections.abc import Mapping
from itertools import pairwise
from typing import Final

from runtime.core.motion.safety import Halt, HaltKind
from runtime.errors import SensorError
from runtime.robot.messages import StreamHealth
from runtime.robot.sync import Rings
from runtime.robot.transforms import TF

PATIENCE_S: Final = 1.0  # bad messages without a good one between them: before that, damage
SILENCE_S: Final = 5.0
FAR_NS: Final = 500_000_000  # so far apart are clocks, not images
UNMATCHED_S: Final = 2.0  # images and odometry come, and no set of them belongs together


class Troubles:
    """Of one robot in real time. `topics`: by stream; what is no color, depth, camera_info, odom
    or tf may be missing or bad without anybody's standing still for it. Without `odometry` that
    comes by another wire, whose silence is told by whoever holds it."""

    def __init__(self, topics: Mapping[str, str], began_s: float, odometry: bool = True) -> None:
        self._topics, self._began_s = topics, began_s
        self._awaited = ("color", "depth", "camera_info", *(["odom"] if odometry else []))
        images = (topics[stream] for stream in ("color", "depth", "camera_info"))
        self._kinds = dict.fromkeys((*images, TF), HaltKind.FRAME)
        self._kinds[topics["odom"]] = HaltKind.ODOMETRY
        # By topic: the newest; since when; and when that came.
        self._noted: dict[str, tuple[str, float, float]] = {}
        self._unmatched_s: float | None = None  # since when

    def note(self, topic: str, error: SensorError, now_s: float) -> None:
        """Something of a topic cannot be used."""
        if topic in self._kinds:
            _, since_s, _ = self._noted.get(topic, ("", now_s, now_s))
            self._noted[topic] = str(error), since_s, now_s

    def over(self, *topics: str) -> None:
        """What was wrong with them is so no more."""
        for topic in topics:
            self._noted.pop(topic, None)

    def seen(self) -> None:
        """A frame could be used: nothing is wrong with what it is made of."""
        self.over(*(topic for topic, kind in self._kinds.items() if kind is HaltKind.FRAME))

    def matched(self) -> None:
        """A set of messages that belong together was taken."""
        self._unmatched_s = None

    def halt(
        self, now_s: float, health: Mapping[str, StreamHealth], rings: Rings, seeing: bool
    ) -> Halt | None:
        """Why nothing may be driven now. `seeing`: the camera's intrinsics are known."""
        return (
            self._silence(now_s, health, seeing)
            or self._badness(now_s)
            or self._apartness(now_s, rings, seeing)
        )

    def _silence(
        self, now_s: float, health: Mapping[str, StreamHealth], seeing: bool
    ) -> Halt | None:
        """Topics on which nothing comes, all in one line."""
        silent = []
        for stream in self._awaited:
            topic = self._topics[stream]
            if topic in self._noted:
                continue  # something comes, of another type
            last_s = health[topic].arrival_s
            once = stream == "camera_info" and (seeing or last_s is not None)  # suffices
            if not once and now_s - (self._began_s if last_s is None else last_s) >= SILENCE_S:
                silent.append(topic)
        if not silent:
            return None
        what = f"{', '.join(silent)}: nothing received in {SILENCE_S:g} s"
        where = "bus.topics and bus.prefix to where it is (rfnav doctor lists what there is)"
        return Halt(self._kinds[silent[0]], f"{what}: publish it, or set {where}")

    def _badness(self, now_s: float) -> Halt | None:
        """What was wrong for the longest time; before that what still is, where another topic was
        found wrong since: the first may be mended, and no frame says so."""
        newest_s = max((last_s for _, _, last_s in self._noted.values()), default=now_s)
        lasting = [
            (newest_s - last_s >= PATIENCE_S, since_s, topic)
            for topic, (_, since_s, last_s) in self._noted.items()
            if now_s - since_s >= PATIENCE_S
        ]
        if not lasting:
            return None
        topic = min(lasting)[2]
        return Halt(self._kinds[topic], self._noted[topic][0])

    def _apartness(self, now_s: float, rings: Rings, seeing: bool) -> Halt | None:
        """Messages that do not belong together by their stamps."""
        all_come = rings.color and rings.depth and rings.odom
        if not (seeing and all_come) or rings.peek() is not None:
            self._unmatched_s = None
        elif self._unmatched_s is None:
            self._unmatched_s = now_s
        elif now_s - self._unmatched_s >= UNMATCHED_S:
            return Halt(HaltKind.FRAME, _apart(rings, self._topics))
        return None


def _apart(rings: Rings, topics: Mapping[str, str]) -> str:
    """Why the messages that wait are no set."""
    pairs = ((one.stamp_ns - two.stamp_ns, two) for one in rings.color for two in rings.depth)
    apart_ns, depth = min(pairs, key=lambda pair: (abs(pair[0]), -pair[1].stamp_ns))
    if abs(apart_ns) <= rings.tolerance_ns:
        return _odometry_apart(rings, topics, depth.stamp_ns)
    if abs(apart_ns) > FAR_NS:  # the nearest are the end of one ring and the beginning of another
        apart_ns = rings.color[-1].stamp_ns - rings.depth[-1].stamp_ns
    what = f"{topics['color']} is {_off(apart_ns)} {topics['depth']} by its stamps"
    return f"{what}: stamp both as one moment, {rings.tolerance_ns / 1e9:g} s apart at most"


def _odometry_apart(rings: Rings, topics: Mapping[str, str], depth_ns: int) -> str:
    late_ns, early_ns = (end.stamp_ns - depth_ns for end in (rings.odom[-1], rings.odom[0]))
    gap_ns = max((b.stamp_ns - a.stamp_ns for a, b in pairwise(rings.odom)), default=0)
    most_ns = rings.odometry_gap_ns
    if gap_ns > most_ns and -2 * gap_ns <= late_ns and early_ns <= 0:
        what = f"{topics['odom']} comes {gap_ns / 1e9:.2f} s apart, at most {most_ns / 1e9:g} s"
        return f"{what}: publish it at {2e9 / most_ns:g} Hz or more"
    off = _off(early_ns if early_ns > 0 else late_ns)
    what = f"{topics['odom']} is {off} {topics['depth']} by its stamps"
    return f"{what}: synchronise the clocks of the base and the camera's computer"


def _off(apart_ns: int) -> str:
    return f"{abs(apart_ns) / 1e9:.2g} s {'behind' if apart_ns < 0 else 'ahead of'}"
