"""The control loop of real time: newest odometry and plan in, a velocity out, 20 times a second.

It shares nothing with the other threads but the plan, which is immutable. What it lives on is
watched by `safety.Guard`: when that is stale or contradicts itself, the base is held until it is
fresh again.
"""

import math
import threading
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from runtime.clock import Clock
from runtime.config import RealtimeConfig
from runtime.core.motion.courses import STILL, Along, ControlConfig, Course
from runtime.core.motion.safety import Guard, Halt, HaltKind, Odometry, SafetyConfig
from runtime.core.motion.velocity_policy import steer
from runtime.core.types import Pose, SearchState, Twist
from runtime.errors import RfNavError
from runtime.record import Record, unrecorded
from runtime.robot.base import ORDER_S, WELL, Base, BaseCondition, DriveOrder
from runtime.robot.wire import Stamped
from runtime.tracing.stages import Stage
from runtime.tracing.tracer import Tracer

ZEROS_S = 1.0  # how long a base at rest is still told so; then others may drive it
LONGEST_DT_S = 0.2  # a tick that comes late does not make up for it in acceleration


class RobotSenses(Protocol):
    """The bus, as the control loop needs it. Every method may be called from any thread."""

    def pose(self) -> tuple[Stamped[Pose], float] | None: ...

    def frame_arrival_s(self) -> float | None: ...

    def publish_state(self, state: Mapping[str, object]) -> None: ...


@dataclass(frozen=True)
class Plan:
    """What to follow until the next plan comes. `frame_s`: when the frame arrived that it was made
    of; its age is the plan's. `report`: what is known of it to those who watch."""

    course: Course | None
    frame_s: float
    radius_m: float
    control: ControlConfig
    report: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True)
class Tick:
    """A turn of the loop, for a recorder: what it knew, and what it made of that. `plan`: how
    many plans came before and with the one that it followed, 0 for none; `withdrawn`: that was
    taken away meanwhile; `asked`: of the base, None when nothing was; `sent`: what the base sent of
    that, None when nothing; `base`: what it said of itself."""

    now_s: float
    late_s: float
    odometry: Odometry | None
    frame_s: float | None
    plan: int
    stopping: bool
    withdrawn: bool
    sent: Twist | None
    halt: str
    asked: Twist | None
    base: BaseCondition


class ControlLoop:
    """Drives the base in a thread of its own, which calls `at_start` first. `stopping` ends all
    motion at once."""

    def __init__(
        self,
        base: Base,
        senses: RobotSenses,
        clock: Clock,
        safety: SafetyConfig,
        rates: RealtimeConfig,
        tracer: Tracer,
        stopping: Callable[[], bool] = lambda: False,
        at_start: Callable[[], None] = lambda: None,
        record: Record = unrecorded,
    ) -> None:
        self._record, self._plans, self._rests = record, 0, 0
        self._base, self._senses = base, senses
        self._clock, self._rates, self._stopping = clock, rates, stopping
        self._tracer, self._at_start = tracer, at_start
        self._guard = Guard(safety)
        self._changed = threading.Condition()
        self._plan: Plan | None = None
        self._state, self._report = SearchState.READY, dict[str, object]()
        self._zeros = round(ZEROS_S * rates.control_hz)  # still to be published at rest
        self._twist = STILL
        self._least_mps = math.inf  # asked for since `asked_mps` was called last
        self._ticked_s: float | None = None
        self._said: tuple[object, ...] = ()
        self._silent_ticks = 0
        self._halt: Halt | None = None
        self._condition = WELL
        self._late_s: deque[float] = deque(maxlen=4000)
        self._error: BaseException | None = None
        self._ending = False
        self._thread = threading.Thread(target=self._run, name="control", daemon=True)

    # -- for the thread that plans -----------------------------------------------------------------

    def start(self) -> None:
        self._thread.start()

    def follow(self, plan: Plan) -> None:
        """Drive by this plan from now on."""
        with self._changed:
            self._plan, self._state, self._report = plan, SearchState.SEARCHING, dict(plan.report)
            self._plans += 1
            self._record("plan", told_plan(self._plans, plan))

    def rest(self, state: SearchState, report: Mapping[str, object]) -> None:
        """Bring the base to rest and say why; when this returns, zero has been commanded."""
        with self._changed:
            self._plan, self._state, self._report = None, state, dict(report)
            self._rests += 1
            self._zeros = round(ZEROS_S * self._rates.control_hz)
            self._record("rest", {"state": state})
            self._send(STILL, 0, self._clock.now_s())

    def asked_mps(self) -> float:
        """The least forward speed that was asked of the base since the last call."""
        with self._changed:
            least = self._least_mps if math.isfinite(self._least_mps) else self._twist.v_mps
            self._least_mps = math.inf
        self._record("heard", {"name": "asked_mps", "value": least})
        return least

    def sent(self) -> Twist:
        """The velocity that the base was sent last, by its own word."""
        with self._changed:
            twist = self._twist
        self._record("heard", {"name": "sent", "value": twist})
        return twist

    def halted(self) -> str:
        """Why the base is held; "" when it is not."""
        with self._changed:
            return self._halt.reason if self._halt else ""

    def halts(self) -> dict[str, int]:
        """How often the base was held, by kind."""
        with self._changed:
            return dict(sorted(self._guard.halts.items()))

    def check(self) -> None:
        """Raise what ended the control loop, if anything did."""
        if self._error is not None:
            raise self._error

    def status(self) -> dict[str, object]:
        """Halts by kind, why the base is held now, and how late ticks were."""
        with self._changed:
            late_ms = np.array(self._late_s) * 1e3
            status: dict[str, object] = {
                "state": self._state,
                "halt": self._halt.reason if self._halt else "",
                "halts": dict(sorted(self._guard.halts.items())),
                "base": vars(self._condition),
            }
        if late_ms.size:
            p50, p99 = np.percentile(late_ms, [50, 99])
            status["tick_late_ms"] = {
                "p50": round(float(p50), 2),
                "p99": round(float(p99), 2),
                "max": round(float(late_ms.max()), 2),
                "ticks": int(late_ms.size),
            }
        return status

    def close(self) -> None:
        """End the loop and command zero, whatever state it is in. Idempotent."""
        with self._changed:
            self._ending, self._plan = True, None
            self._changed.notify_all()
        if self._thread.is_alive():
            self._thread.join(timeout=2.0)
        self._zero()

    # -- the loop ----------------------------------------------------------------------------------

    def _run(self) -> None:
        period_s = 1.0 / self._rates.control_hz
        try:
            self._at_start()
            due_s = self._clock.now_s()
            while not self._ending:
                late_s = max(0.0, self._clock.now_s() - due_s)
                self._late_s.append(late_s)
                self._tracer.book(Stage.LATE, late_s)
                self.tick()
                due_s = max(due_s + period_s, self._clock.now_s() - period_s)
                with self._changed:
                    while not self._ending and self._clock.now_s() < due_s:
                        self._clock.wait(self._changed, due_s)
        except BaseException as error:  # noqa: BLE001 -- raised again by `check`
            self._error = error
        finally:
            self._zero()

    def tick(self) -> None:
        """One turn of the loop: judge, steer, command, say."""
        with self._tracer.stage(Stage.TICK):
            odometry = self._drive()
        self._say(odometry)

    def _drive(self) -> Odometry | None:
        """The newest odometry, and the command that follows from it on the wire."""
        now_s = self._clock.now_s()
        odometry, condition = self._odometry(), self._base.condition()
        frame_s = self._senses.frame_arrival_s()
        dt_s = min(LONGEST_DT_S, now_s - self._ticked_s) if self._ticked_s is not None else 0.0
        self._ticked_s = now_s
        with self._changed:
            plan, number = self._plan, self._plans if self._plan is not None else 0
            rests = self._rests
            if odometry is not None:
                self._guard.watch(odometry)
            halt = None
            driving = plan is not None and plan.course is not None
            if plan is not None:
                known = now_s, odometry, frame_s, plan.frame_s
                halt = self._guard.check(*known, driving, _forbids(condition))
        twist, stopping = STILL, self._stopping()
        if plan is not None and odometry is not None and halt is None and not stopping:
            here, age_s = (odometry.pose, self._twist, dt_s), now_s - plan.frame_s
            twist = steer(plan.course, *here, plan.radius_m, plan.control, age_s)
        with self._changed:
            withdrawn = plan is not None and (self._plan is None or self._rests != rests)
            if withdrawn:
                twist = STILL  # whether or not another has come since
            kind, reason = (halt.kind.value, halt.reason) if halt else ("", "")
            if kind != (self._halt.kind if self._halt else ""):
                self._record("halt", {"kind": kind, "reason": reason, "driving": driving})
            self._halt, self._condition = halt, condition
            asked, sent = self._command(twist, odometry, now_s)
            late_s = self._late_s[-1] if self._late_s else 0.0
            given = now_s, late_s, odometry, frame_s, number, stopping, withdrawn
            self._record("tick", Tick(*given, sent, kind, asked, condition))
        return odometry

    def _command(
        self, twist: Twist, odometry: Odometry | None, now_s: float
    ) -> tuple[Twist | None, Twist | None]:
        """Holding the lock, so that nothing is sent after `rest` has returned: what was asked of
        the base, and what it sent."""
        if self._plan is None:
            if self._zeros <= 0:
                self._twist = STILL
                self._least_mps = min(self._least_mps, 0.0)
                return None, None
            self._zeros -= 1
        sent = self._send(twist, odometry.stamp_ns if odometry else 0, now_s)
        self._least_mps = min(self._least_mps, sent.v_mps if sent else 0.0)
        return twist, sent

    def _send(self, twist: Twist, stamp_ns: int, now_s: float) -> Twist | None:
        """What of it really went out. Where nothing did, the base does what it did before, until
        its own time is over."""
        order = DriveOrder(twist, stamp_ns, now_s + ORDER_S, self._plan is not None)
        sent = self._base.drive(order).twist
        if sent is not None or twist == STILL:
            self._twist = sent or STILL
        return sent

    def _zero(self) -> None:
        with suppress(RfNavError):  # the wire may be what broke
            self._base.drive(DriveOrder(STILL, 0, self._clock.now_s() + ORDER_S))

    def _odometry(self) -> Odometry | None:
        newest = self._senses.pose()
        if newest is None:
            return None
        stamped, arrival_s = newest
        return Odometry(stamped.value, stamped.stamp_ns, arrival_s)

    def _say(self, odometry: Odometry | None) -> None:
        """Publish the state, when it changed and a few times a second."""
        with self._changed:
            state, report, halt, twist = self._state, self._report, self._halt, self._twist
            base = self._condition
        kind = halt.kind if halt else ""
        now = state, report.get("mode"), report.get("frontier"), kind, base.held, base.hand
        self._silent_ticks += 1
        due = self._silent_ticks * self._rates.state_hz >= self._rates.control_hz
        if now == self._said and not due:
            return
        self._said, self._silent_ticks = now, 0
        pose = odometry.pose if odometry else None
        at = [round(v, 4) for v in (pose.x_m, pose.y_m, pose.yaw_rad)] if pose else None
        self._senses.publish_state(
            {
                **report,
                "state": state,
                "halt": halt.reason if halt else "",
                "halts": dict(sorted(self._guard.halts.items())),
                "v_mps": round(twist.v_mps, 4),
                "w_radps": round(twist.w_radps, 4),
                "pose": at,
                "odom_stamp_ns": odometry.stamp_ns if odometry else None,
                "base": vars(base),
            }
        )


def _forbids(base: BaseCondition) -> Halt | None:
    """What the base says, as a reason not to drive."""
    if base.hand:
        return Halt(HaltKind.HAND, f"a hand has the sticks: {base.hand}")
    return Halt(HaltKind.BASE, f"base: {base.held}") if base.held else None


def told_plan(number: int, plan: Plan) -> dict[str, object]:
    """A plan, for a recorder: without the field that its course may be."""
    course = type(plan.course).__name__.lower() if plan.course is not None else "none"
    toward = None if isinstance(plan.course, Along) else plan.course
    return {
        "number": number,
        "course": course,
        "toward": toward,
        "frame_s": plan.frame_s,
        "radius_m": plan.radius_m,
        "limits": plan.control,
    }
