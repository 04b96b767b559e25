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
from dataclasses import replace

from runtime.clock import Clock
from runtime.config import RealtimeConfig
from runtime.core.motion.caution import FREE, Caution
from runtime.core.motion.contact import ContactResponse, Felt, Met
from runtime.core.motion.courses import STILL
from runtime.core.motion.safety import Guard, Halt, HaltKind, Odometry, SafetyConfig
from runtime.core.motion.velocity_policy import steer
from runtime.core.types import SearchState, Twist
from runtime.errors import RfNavError
from runtime.loops.plans import Plan, Tick, told_plan
from runtime.loops.ports import RobotSenses
from runtime.loops.standing import Change, Changes, Occasion, forbids, late_told, stands, told_state
from runtime.record import Record, unrecorded
from runtime.robot.base import ORDER_S, WELL, Base, BaseCondition, DriveOrder
from runtime.tracing.stages import Stage
from runtime.tracing.tracer import Tracer

ZEROS_S = 1.0  # how long a base at rest is still told so; then others may drive it
METS = 32  # what the body met that nobody has asked for yet
LONGEST_DT_S = 0.2  # a tick that comes late does not make up for it in acceleration


class ControlLoop:
    """Drives the base in a thread of its own, which calls `at_start` first. `stopping` ends all
    motion at once. `beat` is called in every turn, in that thread: whether the base was told to
    move; it returns why nobody watches over the loop, "" where somebody does."""

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
        beat: Callable[[bool], str] = lambda moving: "",
    ) -> None:
        self._beat, self._hurried, self._started = beat, False, False
        self._unguarded = self._fault = ""
        self._changes, self._caution = Changes(), FREE
        self._record, self._plans, self._rests = record, 0, 0
        self._base, self._senses = base, senses
        self._clock, self._rates, self._stopping = clock, rates, stopping
        self._tracer, self._at_start = tracer, at_start
        self._guard, self._response = Guard(safety), ContactResponse()
        self._met: deque[Met] = deque(maxlen=METS)
        self._changed = threading.Condition()
        self._plan: Plan | None = None
        self._state, self._report = SearchState.READY, dict[str, object]()
        self._zeros = round(ZEROS_S * rates.control_hz)  # still to be published at rest
        self._twist = STILL
        self._least_mps = math.inf  # asked for since `asked_mps` was called last
        self._ticked_s: float | None = None
        self._occasion = Occasion(rates.control_hz / rates.state_hz)
        self._halt: Halt | None = None
        self._stopped: Halt | None = None  # by hand
        self._condition, self._hand = WELL, ""  # of a hand also that has let go since it was asked
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

    def condition(self, forget: bool = True) -> BaseCondition:
        """What the base said of itself last; a hand that has let go counts until it's forgotten."""
        with self._changed:
            told = replace(self._condition, hand=self._condition.hand or self._hand)
            self._hand = "" if forget else self._hand
        if told != WELL:
            self._record("heard", {"name": "condition", "value": told})
        return told

    def met(self) -> tuple[Met, ...]:
        """What the body has met since the last call."""
        with self._changed:
            met = tuple(self._met)
            self._met.clear()
        if met:
            self._record("heard", {"name": "met", "value": met})
        return met

    def halted(self) -> str:
        """Why the base is held; "" when it is not."""
        with self._changed:
            return self._halt.reason if self._halt else ""

    def halts(self) -> dict[str, int]:
        """How often the base was held, by kind."""
        with self._changed:
            return self._guard.told()

    def held(self) -> bool:
        """Whether the base was held ever since the last call, and not by what is in its way."""
        with self._changed:
            if held := self._guard.held():
                self._record("heard", {"name": "held", "value": held})
        return held

    def hurry(self) -> None:
        """Have the next turn at once. Any thread may ask."""
        with self._changed:
            self._hurried = True
            self._changed.notify_all()

    def started(self) -> None:
        """The models are loaded: goals are taken."""
        with self._changed:
            self._started = True

    def fault(self, reason: str) -> None:
        """The process ends for that: the base stands, and the state says so."""
        with self._changed:
            self._fault, self._plan, self._zeros = reason, None, max(1, self._zeros)
        self._say(None)

    def changes(self) -> tuple[Change, ...]:
        """How the runtime's standing has changed since the last call."""
        with self._changed:
            return self._changes.take()

    def check(self) -> None:
        """Raise what ended the control loop, if anything did."""
        if self._error is not None:
            raise self._error

    def status(self) -> dict[str, object]:
        """Halts by kind, why the base is held now, and how late ticks were."""
        with self._changed:
            status: dict[str, object] = {
                "state": self._state,
                "runtime": vars(self._changes.now),
                "halt": self._halt.reason if self._halt else "",
                "halts": self._guard.told(),
                "base": vars(self._condition),
            }
            late_s = tuple(self._late_s)
        return status | late_told(late_s)

    def close(self) -> None:
        """End the loop and command zero, whatever state it is in. Idempotent."""
        with self._changed:
            self._ending, self._plan, self._zeros = True, None, max(1, self._zeros)
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
                    while not (self._ending or self._hurried) and self._clock.now_s() < due_s:
                        self._clock.wait(self._changed, due_s)
                    if self._hurried:
                        self._hurried, due_s = False, min(due_s, self._clock.now_s())
        except BaseException as error:  # noqa: BLE001 -- raised again by `check`
            self._error = error
        finally:
            self._zero()

    def tick(self) -> None:
        """One turn of the loop: judge, steer, command, say."""
        with self._tracer.stage(Stage.TICK):
            odometry = self._drive()
        self._unguarded = self._beat(self._twist != STILL)
        self._say(odometry)

    def _drive(self) -> Odometry | None:
        """The newest odometry, and the command that follows from it on the wire."""
        now_s = self._clock.now_s()
        newest, condition, felt = self._senses.pose(), self._base.condition(), self._senses.felt()
        odometry = Odometry(newest[0].value, newest[0].stamp_ns, newest[1]) if newest else None
        frame_s, doubt = self._senses.frame_arrival_s(), self._senses.doubt(self._twist)
        dt_s = min(LONGEST_DT_S, now_s - self._ticked_s) if self._ticked_s is not None else 0.0
        self._ticked_s = now_s
        with self._changed:
            plan, number = self._plan, self._plans if self._plan is not None else 0
            rests = self._rests
            halt, twist = self._judge(now_s, odometry, frame_s, condition, felt, doubt)
        stopping = self._stopping()
        if stopping:
            twist = STILL
        elif plan is not None and odometry is not None and halt is None:
            here = self._guard.pace.here(odometry.pose, self._twist, now_s - odometry.arrival_s)
            known = plan.radius_m, plan.control, now_s - plan.frame_s, felt.cliffs_watched
            twist = steer(plan.course, here, self._twist, dt_s, *known)
            twist = self._guard.pace.allowed(self._response.allowed(twist, here))
        caution = self._senses.caution(twist)
        with self._changed:
            halt, twist = self._careful(caution, twist, halt)
            withdrawn = plan is not None and (self._plan is None or self._rests != rests)
            if withdrawn:
                twist = STILL  # whether or not another has come since
            self._note(halt, condition, plan)
            asked, sent = self._command(twist, odometry, now_s)
            late_s = self._late_s[-1] if self._late_s else 0.0
            given = now_s, late_s, odometry, frame_s, number, stopping, withdrawn
            told = halt.kind.value if halt else "", asked, condition, felt, doubt, caution
            self._record("tick", Tick(*given, sent, *told))
        return odometry

    def _judge(
        self,
        now_s: float,
        odometry: Odometry | None,
        frame_s: float | None,
        condition: BaseCondition,
        felt: Felt,
        doubt: Halt | None,
    ) -> tuple[Halt | None, Twist]:
        """Holding the lock: why the plan is not driven, and what the base does instead."""
        plan, body, instead = self._plan, None, STILL
        driving, by_hand = plan is not None and plan.drives, bool(condition.hand)
        self._guard.turn(now_s)
        self._stopped = doubt if doubt is not None and doubt.kind is HaltKind.STOP else None
        if odometry is not None:
            self._guard.watch(odometry, by_hand)
            ours = driving and not by_hand
            self._met.extend(self._response.watch(now_s, odometry, felt.contacts, ours))
        if plan is None:
            return None, STILL
        if odometry is not None:
            body, instead = self._response.judge(now_s, odometry.pose, plan.frame_s)
        known = now_s, odometry, frame_s, plan.frame_s
        halt = self._guard.check(*known, driving, forbids(condition), body, doubt or plan.doubt)
        return halt, instead if halt is body else STILL

    def _careful(
        self, caution: Caution, twist: Twist, halt: Halt | None
    ) -> tuple[Halt | None, Twist]:
        """Holding the lock: what the depth image leaves of a command, and whether that holds the
        base."""
        self._caution, allowed = caution, caution.allowed(twist)
        if caution.kind is not None and allowed == STILL != twist and halt is None:
            halt = Halt(caution.kind, caution.reason)
            self._guard.caution(halt)
        return halt, allowed

    def _note(self, halt: Halt | None, condition: BaseCondition, plan: Plan | None) -> None:
        """Holding the lock: what is told of the tick."""
        kind, reason = (halt.kind.value, halt.reason) if halt else ("", "")
        if kind != (self._halt.kind if self._halt else ""):
            driving = plan is not None and plan.drives
            self._record("halt", {"kind": kind, "reason": reason, "driving": driving})
        self._halt, self._condition = halt, condition
        self._hand = condition.hand or self._hand

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
            self._base.drive(DriveOrder(STILL, 0, math.inf, last=True))

    def _say(self, odometry: Odometry | None) -> None:
        """Publish the state, when it changed and a few times a second."""
        with self._changed:
            state, report, halt, twist = self._state, self._report, self._halt, self._twist
            base, caution = self._condition, self._caution
            known = self._stopped, base, halt, state, report, self._started, self._unguarded
            standing = stands(self._fault, *known)
            self._changes.note(self._clock.now_s(), standing)
        kind, of = halt.kind if halt else "", (report.get("mode"), report.get("frontier"))
        if not self._occasion.comes(state, standing.state, *of, kind, base.held, base.hand):
            return
        told = told_state(state, standing, halt, twist, odometry, base, caution)
        self._senses.publish_state({**report, **told, "halts": self._guard.told()})
