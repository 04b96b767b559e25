"""When the base must stand still, whatever the other threads are doing. No clock, no thread: times
are arguments, monotonic seconds of arrival."""

import math
from collections import Counter
from dataclasses import dataclass
from enum import StrEnum

from runtime.core.geometry import wrap_angle
from runtime.core.keys import key
from runtime.core.motion.pace import Pace
from runtime.core.types import Pose

OVERRUN_S = 0.3  # between two turns of control: orders have expired meanwhile


@dataclass(frozen=True)
class SafetyConfig:
    """[safety]: what a moving robot does not drive on without."""

    odom_stale_s: float = key(
        0.3,
        "Without newer odometry for so long the base is held, until there is some; where it comes "
        "less than 6 times a second, for 1.8 of its intervals, 0.72 s at most.",
        "s",
        within=(0.05, 2.0),
    )
    depth_stale_s: float = key(
        0.5,
        "The same without a depth image, which keeps it from driving into things. At least two and "
        "a half of the camera's periods.",
        "s",
        within=(0.1, 2.0),
    )
    frame_stale_s: float = key(
        1.0, "The same without colour and depth that match.", "s", within=(0.05, 5.0)
    )
    plan_stale_s: float = key(
        2.0,
        "The same so long after the frame that the followed plan was made of.",
        "s",
        within=(0.1, 10.0),
    )
    odom_jump_m: float = key(
        0.3,
        "Two odometry messages that are further apart are a jump, which holds the base.",
        "m",
        within=(0.02, 5.0),
    )
    odom_jump_rad: float = key(
        0.8, "The same when they are turned further from each other.", "rad", within=(0.02, 3.2)
    )
    area_m: float = key(
        0.0,
        "Further than that from where it was started the base is held; 0 is anywhere.",
        "m",
        within=(0.0, 10_000.0),
    )


@dataclass(frozen=True)
class Odometry:
    """A pose of the base, its stamp, and when it arrived."""

    pose: Pose
    stamp_ns: int
    arrival_s: float


class HaltKind(StrEnum):
    """What is stale or broken."""

    ODOMETRY = "odometry"  # none, or none that is new
    CLOCK = "clock"  # odometry's went back
    JUMP = "jump"  # of odometry
    FRAME = "frame"  # none, or none that is new
    PLAN = "plan"  # of too old a frame
    BASE = "base"  # says that it cannot be driven
    HAND = "hand"  # somebody else drives
    BUMPER = "bumper"  # touches something
    CLIFF = "cliff"  # no floor under the rim
    WHEEL = "wheel"  # one hangs in the air
    STOP = "stop"  # asked for, and not released yet
    CANCEL = "cancel"  # waits to be answered
    OVERRUN = "overrun"  # of control itself: it came too late
    TILT = "tilt"  # the base leans
    AREA = "area"  # left
    OBSTACLE = "obstacle"  # inside the halting distance
    FLOOR = "floor"  # missing there


IN_THE_WAY = (HaltKind.BUMPER, HaltKind.CLIFF, HaltKind.OBSTACLE, HaltKind.FLOOR)
"""What is no fault but the way's: an aim that leads there is given up."""


@dataclass(frozen=True)
class Halt:
    """Why the base is held: the kind is counted, the reason is for people."""

    kind: HaltKind
    reason: str


class Guard:
    """Watches what the control loop lives on. After odometry jumped or its clock went back, and
    after the base was somebody else's, only a plan made of a later frame is driven: the old one
    lies elsewhere."""

    def __init__(self, cfg: SafetyConfig) -> None:
        self._cfg = cfg
        self.pace = Pace()  # of odometry
        self._last: Odometry | None = None
        self._broken: Halt | None = None
        self._broken_s = -math.inf
        self._turned_s = -math.inf
        self._overrun: Halt | None = None  # the last, and when it was over
        self._overran_s = -math.inf
        self._standing: HaltKind | None = None
        self._before: HaltKind | None = None  # as it stood when `check` was called last
        self._held = False  # in all turns that were over since `held` was called
        self.halts: Counter[HaltKind] = Counter()

    def watch(self, odometry: Odometry, by_hand: bool = False) -> None:
        """The newest odometry, driving or not; the same may be given again. However far somebody
        else moves the robot between two messages, that is no jump."""
        last, self._last = self._last, odometry
        if odometry == last:
            return
        self.pace.note(odometry.arrival_s)
        if last is None:
            return
        a, b = last.pose, odometry.pose
        moved_m = math.hypot(b.x_m - a.x_m, b.y_m - a.y_m)
        turned_rad = abs(wrap_angle(b.yaw_rad - a.yaw_rad))
        if odometry.stamp_ns < last.stamp_ns:
            back_s = (last.stamp_ns - odometry.stamp_ns) / 1e9
            what = f"odometry's clock went back by {back_s:.2f} s"
            self._break(odometry, Halt(HaltKind.CLOCK, what))
        elif by_hand:
            return
        elif moved_m > self._cfg.odom_jump_m or turned_rad > self._cfg.odom_jump_rad:
            what = f"odometry jumped by {moved_m:.2f} m, {turned_rad:.2f} rad"
            self._break(odometry, Halt(HaltKind.JUMP, what))

    def turn(self, now_s: float) -> None:
        """A turn of control, driving or not. Where none was for too long, as after the process was
        stopped, what was planned before it is not driven on."""
        self._held &= self._withheld
        stood_s, self._turned_s = now_s - self._turned_s, now_s
        if OVERRUN_S < stood_s < math.inf:
            self._overrun = Halt(HaltKind.OVERRUN, f"control stood still for {stood_s:.1f} s")
            self._broken, self._broken_s, self._overran_s = self._overrun, now_s, now_s

    def check(
        self,
        now_s: float,
        odometry: Odometry | None,
        frame_s: float | None,
        plan_s: float,
        driving: bool = True,
        base: Halt | None = None,
        body: Halt | None = None,
        doubt: Halt | None = None,
    ) -> Halt | None:
        """What forbids driving now. `frame_s`: when the newest matched frame was taken. `plan_s`:
        when the frame was that the plan was made of. `base`: what the base itself says; `body`:
        what it has met; `doubt`: what was noticed of the robot's senses, or is asked by hand. Only
        a robot that is driving is halted, as far as the counts go."""
        if doubt is not None and now_s - self._overran_s < OVERRUN_S:
            doubt = self._overrun  # what grew old meanwhile is due to that
        withheld = base or doubt
        if withheld is not None:
            self._broken, self._broken_s = withheld, now_s
        halt = withheld or self._judge(now_s, odometry, frame_s, plan_s, body)
        kind = halt.kind if halt and driving else None
        self._before = self._standing
        if kind is HaltKind.PLAN and self._standing:
            return halt  # what was missing is back, but no plan was made of it yet
        if kind is not None and kind is not self._standing:
            self.halts[kind] += 1
        self._standing = kind
        return halt

    def caution(self, halt: Halt) -> None:
        """After `check` had nothing against it: a command of which nothing was left."""
        if halt.kind is not self._before:
            self.halts[halt.kind] += 1
        self._standing = halt.kind

    def held(self) -> bool:
        """Whether a robot that drives was held in all turns since the last call, and not by what is
        in its way."""
        held, self._held = self._held and self._withheld, self._withheld
        return held

    def told(self) -> dict[str, int]:
        """How often the base was held, by kind."""
        return dict(sorted(self.halts.items()))

    @property
    def _withheld(self) -> bool:
        return self._standing is not None and self._standing not in IN_THE_WAY

    def _break(self, odometry: Odometry, halt: Halt) -> None:
        self._broken, self._broken_s = halt, odometry.arrival_s

    def _judge(
        self,
        now_s: float,
        odometry: Odometry | None,
        frame_s: float | None,
        plan_s: float,
        body: Halt | None,
    ) -> Halt | None:
        cfg = self._cfg
        if odometry is None:
            return Halt(HaltKind.ODOMETRY, "no odometry yet")
        if now_s - odometry.arrival_s > self.pace.patience_s(cfg.odom_stale_s):
            return Halt(HaltKind.ODOMETRY, f"no odometry for {now_s - odometry.arrival_s:.1f} s")
        if self._broken is not None:
            if plan_s <= self._broken_s:
                return self._broken
            self._broken = None
        if body is not None:
            return body
        if frame_s is None:
            return Halt(HaltKind.FRAME, "no matched colour and depth yet")
        if now_s - frame_s > cfg.frame_stale_s:
            return Halt(HaltKind.FRAME, f"no matched colour and depth for {now_s - frame_s:.1f} s")
        if now_s - plan_s > cfg.plan_stale_s:
            return Halt(HaltKind.PLAN, f"the plan is {now_s - plan_s:.1f} s old")
        return None
