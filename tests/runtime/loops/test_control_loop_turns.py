"""What a turn of the control loop asks, is told, sends and tells, value by value."""

import math
import threading
from dataclasses import astuple, replace
from types import SimpleNamespace
from typing import Any

import pytest
from manual_clock import ManualClock

from runtime.config import RealtimeConfig
from runtime.core.motion.caution import FREE, Caution
from runtime.core.motion.contact import NOTHING, Contact, Felt, Met, Touch
from runtime.core.motion.courses import STILL, ControlConfig, Spin
from runtime.core.motion.safety import Halt, HaltKind, Odometry, SafetyConfig
from runtime.core.types import Pose, SearchState, Twist
from runtime.errors import BusError
from runtime.loops import control_loop
from runtime.loops.control_loop import LONGEST_DT_S, METS, ControlLoop
from runtime.loops.plans import Plan, Tick, told_plan
from runtime.robot.base import ORDER_S, WELL, BaseCondition, DriveOrder, Sent
from runtime.robot.wire import Stamped
from runtime.tracing.budgets import read_budgets
from runtime.tracing.stages import Stage
from runtime.tracing.tracer import Tracer

RATES = RealtimeConfig()
TICK_S = 1 / RATES.control_hz
AT, STAMP_NS = Pose(1.0, 2.0, 0.5), 77
SPIN, LIMITS = Spin(0.5), ControlConfig()
LAST = DriveOrder(STILL, 0, math.inf, last=True)  # which a full wire is waited for with
LEG = Caution(HaltKind.OBSTACLE, "something 0.10 m ahead", 0.0)


class Robot:
    """Base and senses, which say what a test has them say."""

    def __init__(self, clock: Any) -> None:
        self.clock = clock
        self.stamp_ns, self.at, self.lost = STAMP_NS, AT, False
        self.frame_s: float | None = None
        self.said, self.feels, self.doubted, self.cautious = WELL, NOTHING, None, FREE
        self.asked_doubt: list[Twist] = []
        self.asked_caution: list[Twist] = []
        self.orders: list[DriveOrder] = []
        self.answer = lambda order: Sent(order.twist)
        self.states: list[dict[str, Any]] = []

    def pose(self) -> tuple[Stamped[Pose], float] | None:
        if self.lost:
            return None
        return Stamped(self.stamp_ns, self.at), self.clock.now_s() - 0.01

    def frame_arrival_s(self) -> float | None:
        return self.clock.now_s() - 0.02 if self.frame_s is None else self.frame_s

    def felt(self) -> Felt:
        return self.feels

    def doubt(self, sent: Twist) -> Halt | None:
        self.asked_doubt.append(sent)
        return self.doubted

    def caution(self, twist: Twist) -> Caution:
        self.asked_caution.append(twist)
        return self.cautious

    def condition(self) -> BaseCondition:
        return self.said

    def drive(self, order: DriveOrder) -> Sent:
        self.orders.append(order)
        return self.answer(order)

    def publish_state(self, state: Any) -> None:
        self.states.append(dict(state))


class Loop:
    """The loop of a robot, ticked by hand; `told` is what a recorder gets."""

    def __init__(self, clock: Any = None, **more: Any) -> None:
        self.clock = clock or ManualClock(100.0)
        self.robot, self.told, self.beats = Robot(self.clock), [], []
        self.unguarded = ""
        self.tracer = Tracer(read_budgets(), self.clock.now_s)
        more.setdefault("beat", self.beat)
        self.control = ControlLoop(
            self.robot, self.robot, self.clock, SafetyConfig(), RATES, self.tracer,
            record=lambda kind, value: self.told.append((kind, value)), **more,
        )  # fmt: skip

    def beat(self, moving: bool) -> str:
        self.beats.append(moving)
        return self.unguarded

    def plan(self, course: Any = SPIN, **report: object) -> Plan:
        plan = Plan(course, self.clock.now_s(), 0.18, LIMITS, report)
        self.control.follow(plan)
        return plan

    def tick(self, n: int = 1) -> Any:
        for _ in range(n):
            self.control.tick()
            self.clock.advance(TICK_S)
        return self.robot.states[-1] if self.robot.states else None

    def kinds(self, kind: str) -> list[Any]:
        return [value for told, value in self.told if told == kind]


@pytest.fixture
def loop() -> Loop:
    return Loop()


def test_what_the_velocity_is_made_of(loop: Loop, monkeypatch):
    """The course, where the base is, what it was sent and when, its limits, the frame's age."""
    asked = []

    def steer(*given: object) -> Twist:
        asked.append(given)
        return Twist(0.1 * len(asked), 0.2)

    monkeypatch.setattr(control_loop, "steer", steer)
    plan = loop.plan()
    loop.robot.feels = Felt(cliffs_watched=True)
    loop.tick()
    loop.clock.advance(0.05)
    loop.robot.answer = lambda order: Sent(Twist(0.15, 0.1))
    loop.tick()
    loop.robot.feels = NOTHING
    loop.clock.advance(0.2)
    loop.tick()
    assert asked[0] == (SPIN, AT, STILL, 0.0, 0.18, LIMITS, 0.0, True)
    assert asked[1] == pytest.approx(
        (SPIN, AT, Twist(0.1, 0.2), 0.1, 0.18, LIMITS, 100.1 - plan.frame_s, True)
    )
    assert asked[2][2:4] == (Twist(0.15, 0.1), LONGEST_DT_S)
    assert asked[2][7] is False
    assert loop.robot.asked_doubt == [STILL, Twist(0.1, 0.2), Twist(0.15, 0.1)]
    asked_mps = [twist.v_mps for twist in loop.robot.asked_caution]
    assert asked_mps == pytest.approx([0.1, 0.2, 0.3])


def test_an_order_has_the_stamp_of_what_it_was_made_of_its_end_and_whether_a_search_is_on(loop):
    loop.tick()
    loop.plan()
    loop.tick()
    loop.robot.lost = True
    loop.tick()
    at_s = loop.clock.now_s()
    loop.control.rest(SearchState.FOUND, {})
    loop.control.close()
    twist = loop.robot.orders[1].twist
    assert twist.w_radps > 0
    assert loop.robot.orders == [
        DriveOrder(STILL, STAMP_NS, 100.0 + ORDER_S, False),
        DriveOrder(twist, STAMP_NS, pytest.approx(100.05 + ORDER_S), True),
        DriveOrder(STILL, 0, pytest.approx(100.1 + ORDER_S), True),
        DriveOrder(STILL, 0, at_s + ORDER_S, False),
        LAST,
    ]


def test_a_turn_as_a_recorder_is_told_it(loop: Loop):
    plan = loop.plan(mode="look")
    loop.robot.feels = Felt(cliffs_watched=True)
    loop.robot.cautious = replace(FREE, most_mps=1.0)
    loop.tick()
    loop.robot.doubted = Halt(HaltKind.STOP, "by hand")
    loop.tick()
    loop.control.rest(SearchState.FOUND, {})
    loop.robot.lost, loop.robot.doubted = True, None
    loop.tick()
    sent = loop.robot.orders[0].twist
    at = lambda now_s: Odometry(AT, STAMP_NS, now_s - 0.01)  # noqa: E731
    rest = loop.robot.feels, None, loop.robot.cautious
    assert loop.told == [
        ("plan", told_plan(1, plan)),
        ("tick", Tick(100.0, 0.0, at(100.0), 99.98, 1, False, False, sent, "", sent, WELL, *rest)),
        ("halt", {"kind": "stop", "reason": "by hand", "driving": True}),
        (
            "tick",
            Tick(
                100.05, 0.0, at(100.05), pytest.approx(100.03), 1, False, False, STILL, "stop",
                STILL, WELL, rest[0], Halt(HaltKind.STOP, "by hand"), rest[2],
            ),
        ),
        ("rest", {"state": SearchState.FOUND}),
        ("halt", {"kind": "", "reason": "", "driving": False}),
        (
            "tick",
            Tick(
                100.1, 0.0, None, pytest.approx(100.08), 0, False, False, STILL, "", STILL, WELL,
                *rest,
            ),
        ),
    ]  # fmt: skip


def test_a_turn_at_the_end_says_so_and_is_zero():
    ending = threading.Event()
    loop = Loop(stopping=ending.is_set)
    loop.plan()
    loop.tick(3)
    ending.set()
    loop.tick()
    (*_, last) = loop.kinds("tick")
    assert (last.stopping, last.asked, last.plan) == (True, STILL, 1)
    assert loop.beats == [False, True, True, False]  # it begins at rest


def test_a_plan_that_was_taken_away_again_during_a_turn_is_not_driven_either():
    meanwhile: list[Any] = []
    loop = Loop(stopping=lambda: bool([call() for call in meanwhile]) and False)
    loop.control.rest(SearchState.CANCELLED, {})
    loop.plan()
    loop.tick(3)
    meanwhile += [lambda: loop.control.rest(SearchState.CANCELLED, {}), loop.plan]
    loop.tick()
    (*_, last) = loop.kinds("tick")
    assert (last.withdrawn, last.asked, last.plan) == (True, STILL, 1)
    meanwhile.clear()
    loop.tick()
    (*_, last) = loop.kinds("tick")
    assert (last.withdrawn, last.plan) == (False, 2)


def test_what_an_older_loop_asks_is_recorded_with_its_answer(loop: Loop):
    loop.plan()
    loop.tick(2)
    sent = loop.control.sent()
    assert sent == loop.robot.orders[-1].twist
    assert loop.control.asked_mps() == 0.0
    assert loop.kinds("heard") == [
        {"name": "sent", "value": sent}, {"name": "asked_mps", "value": 0.0}
    ]  # fmt: skip


def test_a_base_that_was_held_is_recorded_and_one_that_drives_is_told_nowhere(loop: Loop):
    loop.plan()
    loop.tick(2)
    assert not loop.control.held()
    loop.robot.doubted = Halt(HaltKind.STOP, "by hand")
    loop.tick()
    assert not loop.control.held()  # it drove, too
    assert loop.kinds("heard") == []
    loop.tick()
    assert loop.control.held()
    assert loop.kinds("heard") == [{"name": "held", "value": True}]


def test_the_least_speed_that_was_asked_since_the_last_time(loop: Loop, monkeypatch):
    speeds = iter((0.3, 0.1, 0.2, 0.4))
    monkeypatch.setattr(control_loop, "steer", lambda *_: Twist(next(speeds), 0.0))
    assert loop.control.asked_mps() == 0.0
    loop.plan()
    loop.tick(3)
    assert loop.control.asked_mps() == 0.1
    assert loop.control.asked_mps() == 0.2  # what it is at
    loop.tick()
    assert loop.control.asked_mps() == 0.4
    loop.robot.answer = lambda order: Sent(None, "too late")
    monkeypatch.setattr(control_loop, "steer", lambda *_: Twist(0.4, 0.0))
    loop.tick()
    assert loop.control.asked_mps() == 0.0


def test_without_a_search_zero_is_said_for_a_second_and_then_nothing(loop: Loop):
    loop.tick(25)
    assert len(loop.robot.orders) == RATES.control_hz
    assert [(tick.asked, tick.sent) for tick in loop.kinds("tick")[19:21]] == [
        (STILL, STILL), (None, None)
    ]  # fmt: skip
    loop.control.rest(SearchState.FOUND, {})
    loop.tick(25)
    assert len(loop.robot.orders) == 2 * RATES.control_hz + 1


def test_when_nothing_is_said_any_more_the_base_is_taken_to_stand(loop: Loop):
    """Whatever it did of what was sent last: its own time is over."""
    loop.plan()
    loop.tick(5)
    loop.robot.answer = lambda order: Sent(Twist(0.0, 0.4))
    loop.control.rest(SearchState.FOUND, {})
    loop.tick(20)
    assert loop.control.sent() == Twist(0.0, 0.4)
    loop.tick()
    assert loop.control.sent() == STILL
    assert loop.control.asked_mps() == 0.0
    loop.tick()
    assert loop.control.asked_mps() == 0.0  # nor since then


def test_zero_that_was_not_sent_is_taken_for_zero_and_another_velocity_is_not(loop: Loop):
    loop.plan()
    loop.tick(3)
    before = loop.control.sent()
    loop.robot.answer = lambda order: Sent(None, "no link")
    loop.tick()
    assert loop.control.sent() == before
    loop.robot.doubted = Halt(HaltKind.STOP, "by hand")
    loop.tick()
    assert loop.control.sent() == STILL


def test_only_what_is_asked_to_drive_counts_as_held(loop: Loop):
    loop.plan(course=None)
    loop.robot.said = BaseCondition(held="not armed")
    loop.tick(2)
    assert loop.control.halts() == {}
    assert loop.control.halted() == "base: not armed"
    assert loop.kinds("halt") == [{"kind": "base", "reason": "base: not armed", "driving": False}]
    loop.plan()
    loop.tick()
    assert loop.control.halts() == {"base": 1}


def test_a_held_base_stands_and_without_a_plan_nothing_holds_it(loop: Loop):
    loop.robot.frame_s = 90.05
    loop.tick()
    assert loop.control.halted() == ""
    loop.plan()
    state = loop.tick()
    assert state["halt"] == "no matched colour and depth for 10.0 s"
    assert loop.robot.orders[-1].twist == STILL


def test_a_command_of_which_nothing_is_left_holds_the_base_once(loop: Loop):
    loop.robot.cautious = replace(LEG, most_radps=0.0)
    loop.plan()
    loop.tick(3)
    assert loop.control.halted() == "something 0.10 m ahead"
    assert loop.control.halts() == {"obstacle": 1}
    assert {order.twist for order in loop.robot.orders} == {STILL}


def test_a_command_of_which_something_is_left_or_that_is_zero_holds_nothing(loop: Loop):
    loop.robot.cautious = LEG
    loop.plan()
    loop.tick(2)  # it turns on the spot
    assert (loop.control.halted(), loop.control.halts()) == ("", {})
    loop.plan(course=None)
    loop.robot.cautious = replace(LEG, most_radps=0.0)
    loop.tick(10)
    loop.plan(course=None)
    loop.tick()
    assert loop.robot.asked_caution[-1] == STILL
    assert loop.control.halted() == ""
    loop.robot.doubted = Halt(HaltKind.STOP, "by hand")
    loop.plan()
    loop.tick()
    assert loop.control.halted() == "by hand"  # and not what is ahead as well


def test_what_limits_without_a_reason_is_no_halt(loop: Loop):
    loop.robot.cautious = Caution(None, "", 0.0, 0.0)
    loop.plan()
    loop.tick()
    assert loop.robot.orders[-1].twist == STILL
    assert loop.control.halted() == ""


def test_what_the_bumper_still_touches_is_not_pushed_on_against(loop: Loop, monkeypatch):
    monkeypatch.setattr(control_loop, "steer", lambda *_: Twist(0.2, 0.3))
    loop.robot.feels = Felt((Contact(Touch.BUMPER, "bumper", 0.0, 99.0, True),))
    loop.tick()
    loop.clock.advance(1.0)
    loop.control.tick()  # the overrun
    for _ in range(2):
        loop.clock.advance(0.1)
        loop.plan()  # the second knows of the bumper
        loop.tick()
    assert loop.robot.orders[-1].twist == Twist(0.0, 0.3)


def test_who_has_the_sticks_moves_the_robot_as_he_likes_and_is_no_contact_of_ours(loop: Loop):
    loop.robot.said = BaseCondition(hand="sticks")
    loop.tick()
    loop.robot.at = Pose(4.0, 2.0, 0.5)
    loop.plan()
    loop.tick()
    assert loop.control.halts() == {"hand": 1}
    assert loop.control.halted() == "a hand has the sticks: sticks"


def test_no_more_of_what_was_met_is_kept_than_anybody_asks_for(loop: Loop):
    made = [Contact(Touch.CLIFF, "cliff", 0.1, 99.0 + 0.001 * n, False) for n in range(METS + 8)]
    loop.robot.feels = Felt(tuple(made))
    loop.tick()
    met = loop.control.met()
    assert met == (Met(Touch.CLIFF, AT, 0.1),) * METS
    assert loop.control.met() == ()
    assert loop.kinds("heard") == [{"name": "met", "value": met}]


def test_between_two_messages_it_steers_from_where_its_command_has_led(loop: Loop, monkeypatch):
    asked: list[Pose] = []
    monkeypatch.setattr(
        control_loop, "steer", lambda course, here, *_: asked.append(here) or Twist(0.2, 0.0)
    )
    for _ in range(6):
        came = Stamped(round(loop.clock.now_s() * 1e9), AT), loop.clock.now_s()
        loop.robot.pose = lambda came=came: came
        for _ in range(8):  # 2.5 times a second
            loop.plan()
            loop.tick()
    ahead_m = 0.2 * 7 * TICK_S
    x, y = 1.0 + ahead_m * math.cos(0.5), 2.0 + ahead_m * math.sin(0.5)
    assert astuple(asked[-1]) == pytest.approx((x, y, 0.5))


# -- what is told ----------------------------------------------------------------------------------


def test_the_state_has_the_report_how_it_stands_and_the_halts_by_kind(loop: Loop):
    loop.control.started()
    loop.plan(mode="frontier", frontier=4, rung="smollm2")
    loop.robot.said = BaseCondition(held="not armed")
    state = loop.tick()
    assert state == {
        "mode": "frontier",
        "frontier": 4,
        "rung": "smollm2",
        "state": SearchState.SEARCHING,
        "runtime": {"state": "held", "cause": "base: base: not armed"},
        "halt": "base: not armed",
        "v_mps": 0.0,
        "w_radps": 0.0,
        "pose": [1.0, 2.0, 0.5],
        "odom_stamp_ns": STAMP_NS,
        "base": vars(loop.robot.said),
        "caution": None,
        "halts": {"base": 1},
    }


def test_before_it_is_said_to_have_started_it_is_starting_and_no_hand_was_there(loop: Loop):
    assert loop.tick()["runtime"] == {"state": "starting", "cause": ""}
    assert loop.control.condition() == WELL


def test_how_late_turns_were_is_kept_of_the_last_few_thousand(loop: Loop):
    loop.control._late_s.extend([0.5, *[0.0] * 4000])
    told = loop.control.status()["tick_late_ms"]
    assert told == {"p50": 0.0, "p99": 0.0, "max": 0.0, "ticks": 4000}


def test_what_changes_in_the_state_is_told_in_that_turn(loop: Loop):
    loop.plan(mode="frontier", frontier=4)
    loop.tick()
    changes = [
        lambda: loop.plan(mode="target", frontier=4),
        lambda: loop.plan(mode="target", frontier=5),
        lambda: setattr(loop.robot, "said", BaseCondition(held="no link")),
        lambda: setattr(loop.robot, "said", BaseCondition(held="not armed")),
        lambda: setattr(loop.robot, "said", BaseCondition(hand="sticks")),
        lambda: setattr(loop.robot, "said", BaseCondition(hand="other sticks")),
        lambda: setattr(loop, "unguarded", "no guard") or setattr(loop.robot, "said", WELL),
        lambda: loop.plan(mode="target", frontier=5),
        lambda: setattr(loop.robot, "doubted", Halt(HaltKind.JUMP, "far")),
        lambda: setattr(loop.robot, "doubted", Halt(HaltKind.TILT, "it leans")),
        lambda: loop.control.rest(SearchState.FOUND, {"mode": "target", "frontier": 5}),
        lambda: loop.control.rest(SearchState.CANCELLED, {"mode": "target", "frontier": 5}),
    ]
    for n, change in enumerate(changes):
        before = len(loop.robot.states)
        change()
        loop.tick()
        assert len(loop.robot.states) == before + 1, n
    before = len(loop.robot.states)
    loop.tick()
    assert len(loop.robot.states) == before


def test_the_status_says_how_it_stands_and_how_late_turns_were():
    loop = Loop()
    loop.control.started()
    assert loop.control.status() == {
        "state": SearchState.READY,
        "runtime": {"state": "starting", "cause": ""},
        "halt": "",
        "halts": {},
        "base": vars(WELL),
    }
    loop.plan()
    loop.robot.said = BaseCondition(held="not armed")
    loop.tick()
    loop.robot.lost, loop.robot.said = True, WELL
    loop.tick()
    assert loop.control.status() == {
        "state": SearchState.SEARCHING,
        "runtime": {"state": "held", "cause": "odometry: no odometry yet"},
        "halt": "no odometry yet",
        "halts": {"base": 1, "odometry": 1},
        "base": vars(WELL),
    }
    assert list(loop.control.halts()) == ["base", "odometry"]


def test_halts_are_told_in_one_order(loop: Loop):
    loop.plan()
    loop.robot.lost = True
    loop.tick()
    loop.robot.lost, loop.robot.said = False, BaseCondition(held="not armed")
    state = loop.tick()
    for told in (loop.control.halts(), loop.control.status()["halts"], state["halts"]):
        assert list(told.items()) == [("base", 1), ("odometry", 1)]


def test_a_stop_is_how_it_stands_and_other_doubts_are_not(loop: Loop):
    loop.control.started()
    loop.robot.doubted = Halt(HaltKind.TILT, "the base leans")
    assert loop.tick()["runtime"] == {"state": "ready", "cause": ""}
    loop.robot.doubted = Halt(HaltKind.STOP, "by hand")
    assert loop.tick()["runtime"] == {"state": "stopped", "cause": "by hand"}
    loop.robot.doubted = None
    assert loop.tick()["runtime"] == {"state": "ready", "cause": ""}
    assert [(c.now_s, c.after.state) for c in loop.control.changes()] == [
        (100.0, "ready"), (pytest.approx(100.05), "stopped"), (pytest.approx(100.1), "ready"),
    ]  # fmt: skip
    assert loop.control.changes() == ()


def test_nobody_who_watches_is_degraded(loop: Loop):
    loop.plan()
    loop.unguarded = "the guard is gone"
    assert loop.tick()["runtime"] == {"state": "degraded", "cause": "the guard is gone"}


def test_a_fault_drives_no_plan_any_more(loop: Loop):
    loop.plan()
    loop.tick(3)
    loop.control.fault("a bug")
    assert loop.robot.states[-1]["runtime"] == {"state": "fault", "cause": "a bug"}
    assert loop.robot.states[-1]["pose"] is None
    loop.tick()
    assert loop.robot.orders[-1].twist == STILL
    assert not loop.robot.orders[-1].searching


def test_a_base_that_moves_is_not_told_to_stand_by_a_fault_before_zero_was_sent(loop: Loop):
    """Else the watchdog would be told so, and leave a base alone that nobody has stopped."""
    loop.tick(40)  # all the zeros of before are said
    loop.plan()
    loop.tick(2)
    assert loop.beats[-1]
    said = len(loop.robot.orders)
    loop.control.fault("a bug")
    loop.tick(3)
    assert [order.twist for order in loop.robot.orders[said:]] == [STILL]
    assert not loop.beats[-1]


def test_a_turn_that_close_overtakes_sends_zero():
    meanwhile: list[Any] = []
    loop = Loop(stopping=lambda: bool([call() for call in meanwhile]) and False)
    loop.tick(40)
    loop.plan()
    loop.tick(2)
    said = len(loop.robot.orders)
    meanwhile.append(loop.control.close)
    loop.tick()
    meanwhile.clear()
    loop.tick(2)
    assert [order.twist for order in loop.robot.orders[said:]] == [STILL, STILL]  # one is close's
    assert not loop.beats[-1]


@pytest.mark.parametrize("ended", [lambda c: c.fault("a bug"), lambda c: c.close()])
def test_one_turn_more_says_zero_after_all_were_said(loop: Loop, ended):
    loop.tick(25)
    ended(loop.control)
    before = len(loop.robot.orders)
    loop.tick(3)
    assert [order.twist for order in loop.robot.orders[before:]] == [STILL]


def test_a_hand_that_has_let_go_is_told_of_once_with_what_the_base_says_now(loop: Loop):
    loop.robot.said = BaseCondition(hand="sticks")
    loop.tick()
    loop.robot.said = BaseCondition(held="not armed")
    loop.tick()
    both = BaseCondition(held="not armed", hand="sticks")
    assert loop.control.condition(forget=False) == both
    assert loop.control.condition() == both
    assert loop.control.condition() == BaseCondition(held="not armed")
    assert loop.kinds("heard") == [
        {"name": "condition", "value": both},
        {"name": "condition", "value": both},
        {"name": "condition", "value": BaseCondition(held="not armed")},
    ]
    loop.robot.said = WELL
    loop.tick()
    assert loop.control.condition() == WELL
    assert len(loop.kinds("heard")) == 3


# -- its thread, run here --------------------------------------------------------------------------


class Waiting:
    """A clock on which whoever waits has waited, unless a test has somebody call meanwhile."""

    def __init__(self) -> None:
        self.at_s = 100.0
        self.meanwhile: list[Any] = []

    def now_s(self) -> float:
        return self.at_s

    def advance(self, seconds: float) -> None:
        self.at_s += seconds

    def wait(self, condition: threading.Condition, until_s: float) -> None:
        assert until_s > self.at_s
        condition.notify_all()  # a mistake, where it is not held
        if self.meanwhile:
            at_s, call = self.meanwhile.pop(0)
            self.at_s = max(self.at_s, at_s)
            call()
        else:
            self.at_s = until_s


class Run:
    """Turns of the loop, each of which does what a test has it do, and then its end."""

    def __init__(self, *turns: Any) -> None:
        self.clock, self.turns, self.began_s = Waiting(), list(turns), list[float]()
        self.order: list[str] = []
        self.loop = Loop(self.clock, beat=self.beat, at_start=lambda: self.order.append("start"))
        self.control = self.loop.control
        self.control._run()

    def beat(self, moving: bool) -> str:
        self.began_s.append(round(self.clock.at_s - 100.0, 6))
        self.order.append("turn")
        turn = self.turns.pop(0) if self.turns else self.end
        turn(self)
        return ""

    @staticmethod
    def end(run: "Run") -> None:
        run.loop.control.close()


def late(seconds: float) -> Any:
    return lambda run: run.clock.advance(seconds)


def nothing(run: Run) -> None:
    """A turn like any other."""


def test_turns_come_at_their_rate_and_at_the_end_zero_is_commanded():
    run = Run(nothing, nothing, late(0.01), nothing)
    assert run.order == ["start", *["turn"] * 5]
    assert run.began_s == pytest.approx([0.0, 0.05, 0.1, 0.15, 0.2])
    assert run.loop.robot.orders[-1] == LAST
    assert len(run.loop.robot.orders) == 7  # one a turn, by `close`, and at the end
    told = run.loop.tracer.told()[Stage.LATE]
    assert (told["n"], told["max_ms"]) == (5, pytest.approx(0.0, abs=1e-6))


def test_a_turn_that_took_long_is_followed_at_once_by_one_and_no_more():
    """How long it took is another stage: late is what comes no more than a period after it."""
    run = Run(late(0.32), nothing, nothing)
    assert run.began_s == pytest.approx([0.0, 0.32, 0.32, 0.37])
    assert run.control.status()["tick_late_ms"] == {
        "p50": 0.0, "p99": 48.5, "max": 50.0, "ticks": 4,
    }  # fmt: skip
    assert [round(tick.late_s, 3) for tick in run.loop.kinds("tick")] == [0.0, 0.05, 0.0, 0.0]
    assert run.loop.tracer.told()[Stage.LATE]["max_ms"] == pytest.approx(50.0)


def test_a_turn_that_took_a_little_longer_is_made_up_for():
    run = Run(late(0.07), nothing, nothing)
    assert run.began_s == pytest.approx([0.0, 0.07, 0.1, 0.15])


def test_a_turn_that_is_wanted_at_once_comes_then_and_the_next_a_period_later():
    def hurried(run: Run) -> None:
        run.clock.meanwhile.append((100.02, run.control.hurry))

    run = Run(hurried, nothing)
    assert run.began_s == pytest.approx([0.0, 0.02, 0.07])
    assert run.control.status()["tick_late_ms"]["max"] == 0.0


def test_an_end_that_comes_while_it_waits_is_heard_at_once():
    def ended(run: Run) -> None:
        run.clock.meanwhile.append((100.01, run.control.close))

    run = Run(ended)
    assert run.began_s == [0.0]
    assert run.clock.at_s == 100.01


def test_a_wake_up_for_nothing_is_no_turn():
    def woken(run: Run) -> None:
        run.clock.meanwhile += [(100.01, lambda: None), (100.02, lambda: None)]

    assert Run(woken).began_s == pytest.approx([0.0, 0.05])


def test_a_mistake_before_the_first_turn_is_raised_to_who_asks_and_zero_is_commanded():
    def mistaken() -> None:
        raise ValueError("mistake")

    loop = Loop(at_start=mistaken)
    loop.control.check()
    loop.control._run()
    assert loop.robot.orders == [LAST]
    with pytest.raises(ValueError, match="mistake"):
        loop.control.check()


def test_a_wire_that_broke_does_not_keep_it_from_ending_and_a_mistake_there_is_told(loop: Loop):
    def broken(order: DriveOrder) -> Sent:
        raise BusError("cmd_vel: cannot be published: gone")

    loop.robot.answer = broken
    loop.control.close()
    loop.robot.answer = lambda order: 1 / 0
    with pytest.raises(ZeroDivisionError):
        loop.control.close()


def test_its_end_is_waited_for_two_seconds_at_most(loop: Loop):
    joined: list[float] = []
    thread: Any = SimpleNamespace(
        is_alive=lambda: True, join=lambda timeout: joined.append(timeout)
    )
    loop.control._thread = thread
    loop.control.close()
    assert joined == [2.0]


def test_its_thread_has_a_name_and_does_not_keep_the_process_alive(loop: Loop):
    assert (loop.control._thread.name, loop.control._thread.daemon) == ("control", True)


def test_what_was_told_to_drive_is_forgotten_at_the_end(loop: Loop):
    loop.plan()
    loop.tick(3)
    loop.control.close()
    loop.tick()
    assert loop.robot.orders[-1].twist == STILL
