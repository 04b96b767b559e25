"""What is noticed of the sensors as they come, of every message: how old it is by its stamp, and
what cannot be true. No clock, no lock: times are arguments, monotonic seconds."""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from runtime.core.geometry import wrap_angle
from runtime.core.motion.pace import Pace
from runtime.core.motion.safety import Halt, HaltKind, SafetyConfig
from runtime.core.types import F32, Pose, Twist
from runtime.log import say
from runtime.robot import wire
from runtime.robot.images.raw import DEPTHS
from runtime.robot.odometry import BaseOdometry, Told
from runtime.robot.stamps import StampAge
from runtime.robot.sync import RawMessage

NOTED_S: Final = 0.5  # how long one message that cannot be true is doubted after
REPEATS_S: Final = 0.5  # a sensor that says the same for so long, although it must not
FORGIVEN_S: Final = 10.0  # odometry of a base that does not move at all may be true, after all
# After that a depth image is another; odometry that comes a little later than the image of where
# the base came to rest is within it.
MOVED_M, MOVED_RAD = 0.1, 0.1
LEAST_MPS, LEAST_RADPS = 0.05, 0.1  # told less, a base may stand
TILT_RAD: Final = 0.35  # 20 degrees: a wheel is off the floor, or somebody lifts it
SAMPLES: Final = 2000  # of a depth image
ANOTHER, ANOTHER_OF = 0.05, 0.25  # readings that differ by that share, in that share of the image
STILL_STAMPS: Final = 5  # on end, that are one: a message may come twice
_STAMPED: Final = 12  # bytes of a message before what is not its stamp
_TOLD: Final = 200  # and within which its encoding stands, and then whether it is big-endian
_ENCODING: Final = re.compile(rb"(%s)\0(.)" % "|".join(DEPTHS).encode(), re.DOTALL)


@dataclass
class _Depth:
    """The depth image that was another than the one before: its bytes, when it came, where the base
    was then; how often it has come again since, and in how many colours, of which one may be of the
    same moment."""

    content: bytes = b""
    since_s: float = -math.inf
    pose: Pose | None = None
    again: int = 0
    colours: int = 0


@dataclass
class _Odometry:
    """Odometry that was another than the one before: its bytes, when it came, and since then: when
    the base was first told to move, what the camera saw first, and when it saw something else."""

    content: bytes = b""
    since_s: float = -math.inf
    told_s: float = math.inf
    sight: F32 | None = None
    else_s: float | None = None


class Vigilance:
    """Of one robot in real time. `doubt` says what the base is held for. `read`: how odometry is
    read. `packed`: depth is compressed; what it shows is told by `looked`. `unstamped`: topics of
    which the stamps stand still, of which `tell` is told."""

    def __init__(
        self,
        config: SafetyConfig,
        read: Callable[[RawMessage], Told] | None = None,
        packed: bool = False,
        tell: Callable[[str], None] = say,
    ) -> None:
        self._config, self._packed, self._tell = config, packed, tell
        self.read = read or BaseOdometry().read
        self._ages = {name: StampAge() for name in ("odom", "depth", "color")}
        self._late: dict[str, tuple[float, float]] = {}  # by stream: how late, when it came
        self._noted: dict[HaltKind, tuple[Halt, float]] = {}  # until when
        self._last: wire.Stamped[Pose] | None = None
        self._start: Pose | None = None
        self._depth, self._odometry, self._color = _Depth(), _Odometry(), b""
        self._pace = Pace()  # of odometry: that which comes seldom says the same for longer
        self.unstamped: set[str] = set()
        self._still: dict[str, int] = {}  # by topic: messages on end with one stamp
        self._told: set[str] = set()  # topics

    # -- in the bus's threads --------------------------------------------------------------------

    def take(self, stream: str, raw: RawMessage, topic: str) -> RawMessage:
        """A message of odom, depth or color that has just come: as old as its stamp says. Others
        are left alone. SensorError for odometry that cannot be read."""
        if stream not in self._ages:
            return raw
        now_s, content = raw.arrival_s, raw.payload[_STAMPED:]
        if stream == "odom":
            self._moved(raw, content, now_s)
        elif stream == "depth":
            self._looked(raw.payload, content, now_s)
        elif content and content != self._color:
            self._color = content
            self._depth.colours += 1
        age = self._ages[stream]
        other_s = self._ages["odom"].offset_s if stream != "odom" else math.inf
        late_s = age.late_s(raw.stamp_ns, now_s, other_s)
        dated = raw.stamp_ns != 0 and not any(raw.payload[4:_STAMPED])  # by who has said so
        if dated:
            self._told.add(topic)
        self._stamped(topic, age.stands_still or dated)
        self._late[stream] = late_s, now_s
        return replace(raw, arrival_s=now_s - late_s)

    def _stamped(self, topic: str, still: bool) -> None:
        """Whether a message has the stamp of the one before, or none. It is told once a topic."""
        count = self._still[topic] = self._still.get(topic, 0) + 1 if still else 0
        if not still:
            self.unstamped.discard(topic)
        elif count >= STILL_STAMPS:
            self.unstamped.add(topic)
            if topic not in self._told:
                self._told.add(topic)
                what = f"{topic}: stamps stand still: its age is told by its arrival alone"
                self._tell(f"{what}; let the driver fill in header.stamp")

    def _looked(self, payload: bytes, content: bytes, now_s: float) -> None:
        if content == self._depth.content:
            self._depth.again += 1
        else:
            here = self._last.value if self._last else None
            self._depth = _Depth(content, now_s, here)
        if not self._packed:
            self._saw(_sight(payload), now_s)

    def _saw(self, sight: F32, now_s: float) -> None:
        """What the newest depth image shows."""
        # One without a difference in it is no place: nothing in range, or too near.
        if sight.size == 0 or float(sight.min()) == float(sight.max()):
            self._depth.pose = None
        told = self._odometry
        if told.sight is None:
            told.sight = sight
        elif told.else_s is None and now_s >= told.told_s and _differ(told.sight, sight):
            told.else_s = now_s

    def _moved(self, raw: RawMessage, content: bytes, now_s: float) -> None:
        told, tilt_rad = self.read(raw)
        last, self._last = self._last, told
        self._pace.note(now_s)
        pose = told.value
        start = self._start = self._start or pose
        if last is not None:
            self._jumps(last, told, now_s)
        if tilt_rad > TILT_RAD:
            what = f"the base leans by {math.degrees(tilt_rad):.0f} degrees"
            self._note(Halt(HaltKind.TILT, what), now_s)
        away_m = math.hypot(pose.x_m - start.x_m, pose.y_m - start.y_m)
        if away_m > self._config.area_m > 0:
            what = f"{away_m:.1f} m from where it began, {self._config.area_m:g} m are its area"
            self._note(Halt(HaltKind.AREA, f"{what}: bring it back"), now_s)
        if content != self._odometry.content:
            if self._odometry.else_s is not None:
                self._elsewhere(pose)
            self._odometry = _Odometry(content, now_s)

    def _elsewhere(self, pose: Pose) -> None:
        """Odometry tells of another place, and not because the base was driven there since the last
        depth image: what the camera shows need not differ."""
        if self._depth.pose is not None:
            self._depth.pose = pose

    def _jumps(self, last: wire.Stamped[Pose], told: wire.Stamped[Pose], now_s: float) -> None:
        a, b, cfg = last.value, told.value, self._config
        moved_m = math.hypot(b.x_m - a.x_m, b.y_m - a.y_m)
        turned_rad = abs(wrap_angle(b.yaw_rad - a.yaw_rad))
        jumped = moved_m > cfg.odom_jump_m or turned_rad > cfg.odom_jump_rad
        if jumped:
            self._elsewhere(b)
        if told.stamp_ns < last.stamp_ns:
            back_s = (last.stamp_ns - told.stamp_ns) / 1e9
            what = f"odometry's clock went back by {back_s:.2f} s"
            self._note(Halt(HaltKind.CLOCK, what), now_s)
        elif jumped:
            what = f"odometry jumped by {moved_m:.2f} m, {turned_rad:.2f} rad"
            self._note(Halt(HaltKind.JUMP, what), now_s)

    def _note(self, halt: Halt, now_s: float) -> None:
        self._noted[halt.kind] = halt, now_s + NOTED_S

    # -- in the thread that decodes ---------------------------------------------------------------

    def looked(self, depth_m: F32, arrival_s: float) -> None:
        """What a depth image shows that came compressed, of those that somebody decodes."""
        if self._packed:
            readings = depth_m.ravel()
            self._saw(readings[:: max(1, readings.size // SAMPLES)], arrival_s)

    # -- in the control thread -------------------------------------------------------------------

    def doubt(self, now_s: float, sent: Twist) -> Halt | None:
        """What cannot be true of what came, as a reason to stand. `sent`: to the base last."""
        noted = [(until_s, halt) for halt, until_s in self._noted.values() if now_s <= until_s]
        if noted:
            return max(noted, key=lambda note: note[0])[1]
        late = self._lateness(now_s)
        return late or self._repeating_depth(now_s) or self._repeating_odometry(now_s, sent)

    def _lateness(self, now_s: float) -> Halt | None:
        """What came, but too late: what did not come at all is told by who waits for it."""
        cfg = self._config
        bounds = {"odom": (HaltKind.ODOMETRY, cfg.odom_stale_s)}
        for stream in ("depth", "color"):
            bounds[stream] = HaltKind.FRAME, cfg.frame_stale_s
        for stream, (kind, most_s) in bounds.items():
            late_s, arrival_s = self._late.get(stream, (0.0, -math.inf))
            if late_s > most_s and now_s - arrival_s <= most_s:
                return Halt(kind, f"{stream} comes {late_s:.1f} s late by its stamps")
        return None

    def _repeating_depth(self, now_s: float) -> Halt | None:
        """A camera whose depth stands still, while its colour lives and the base has moved."""
        depth, since_s = self._depth, now_s - self._depth.since_s
        live = depth.again and depth.colours > 1
        if since_s < REPEATS_S or not live or depth.pose is None or self._last is None:
            return None
        a, b = depth.pose, self._last.value
        moved = math.hypot(b.x_m - a.x_m, b.y_m - a.y_m) >= MOVED_M
        if not moved and abs(wrap_angle(b.yaw_rad - a.yaw_rad)) < MOVED_RAD:
            return None
        return Halt(HaltKind.FRAME, f"depth repeats itself for {since_s:.1f} s, while colour lives")

    def _repeating_odometry(self, now_s: float, sent: Twist) -> Halt | None:
        """Odometry that says the same, bit for bit, although the base is told to move and the
        camera sees something else. It is believed again when it changes: a base that stands has no
        other way to be believed than by hand, or by time."""
        told = self._odometry
        if abs(sent.v_mps) >= LEAST_MPS or abs(sent.w_radps) >= LEAST_RADPS:
            told.told_s = min(told.told_s, now_s)
        if told.else_s is None or now_s - told.told_s < self._pace.patience_s(REPEATS_S):
            return None
        if now_s - told.else_s > FORGIVEN_S:
            told.told_s, told.sight, told.else_s = math.inf, None, None
            return None
        what = f"odometry repeats itself for {now_s - told.since_s:.1f} s, while the camera moves"
        return Halt(HaltKind.ODOMETRY, what)


def _sight(payload: bytes) -> F32:
    """About SAMPLES readings of a depth image, in its own unit, 0 where there is none; whatever the
    bytes are."""
    told = _ENCODING.search(payload, 0, _TOLD)
    kind = np.dtype(DEPTHS[told[1].decode()] if told else np.uint16)
    kind = kind.newbyteorder(">" if told and told[2] != b"\0" else "<")
    body = payload[_TOLD + (len(payload) - _TOLD) % kind.itemsize :]
    readings = np.frombuffer(body, kind)
    sight: F32 = readings[:: max(1, readings.size // SAMPLES)].astype(np.float32)
    return np.where(np.isfinite(sight), sight, np.float32(0))


def _differ(before: F32, now: F32) -> bool:
    """Whether two sights are of different places, or of one that has changed much."""
    if before.shape != now.shape:
        return True
    seen = (before > 0) & (now > 0)
    apart = np.abs(now - before) > ANOTHER * before
    return int((apart & seen).sum()) > ANOTHER_OF * max(1, int(seen.sum()))
