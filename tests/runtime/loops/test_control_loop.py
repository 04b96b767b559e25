"""The control loop on a clock that stands still between ticks."""

import math
import threading
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from manual_clock import ManualClock

from runtime.clock import SystemClock
from runtime.config import RealtimeConfig
from runtime.core.distances.planner import Field
from runtime.core.distances.terrain import Terrain
from runtime.core.geometry import GridFrame
from runtime.core.motion.caution import FREE, Caution
from runtime.core.motion.contact import NOTHING
from runtime.core.motion.courses import STILL, Along, ControlConfig, Spin
from runtime.core.motion.pace import BETWEEN_M, LONGEST_S
from runtime.core.motion.safety import Halt, HaltKind, SafetyConfig
from runtime.core.motion.velocity_policy import FRESH_S, HOLD_S
from runtime.core.types import Pose, SearchState, Twist
from runtime.errors import BusError
from runtime.loops.control_loop import ControlLoop
from runtime.loops.plans import Plan
from runtime.robot.base import ORDER_S, WELL, BaseCondition, DriveOrder, Sent
from runtime.robot.wire import Stamped
from runtime.tracing.budgets import read_budgets
from runtime.tracing.stages import Stage
from runtime.tracing.tracer import Tracer

RATES = RealtimeConfig()
TICK_S = 1 / RATES.control_hz


class FakeBase:
    """Odometry and frames are as fresh as `now`, until a test says otherwise."""

    def __init__(self, clock) -> None:
        self.clock = clock
        self.at = Pose(0.0, 0.0, 0.0)
        self.odom_s: float | None = None  # None: always now
        self.back_s = 0.0  # how far its clock was set back
        self.frame_s: float | None = None
        self.twists: list[tuple[float, float]] = []
        self.states: list[dict] = []
        self.broken = False
        self.orders: list[DriveOrder] = []
        self.answer = lambda order: Sent(order.twist)
        self.said, self.doubted, self.cautious = WELL, None, FREE

    def pose(self):
        arrival_s = self.clock.now_s() if self.odom_s is None else self.odom_s
        return Stamped(round((arrival_s - self.back_s) * 1e9), self.at), arrival_s

    def frame_arrival_s(self):
        return self.clock.now_s() if self.frame_s is None else self.frame_s

    def felt(self):
        return NOTHING

    def doubt(self, sent):
        return self.doubted

    def caution(self, twist):
        return self.cautious

    def drive(self, order):
        if self.broken:
            raise BusError("cmd_vel: cannot be published: gone")
        self.orders.append(order)
        sent = self.answer(order)
        if sent.twist is not None:
            self.twists.append((sent.twist.v_mps, sent.twist.w_radps))
        return sent

    def condition(self):
        return self.said

    def publish_state(self, state):
        self.states.append(dict(state))


def open_floor() -> Along:
    """A field that leads far along x, over free ground."""
    frame = GridFrame(-2.0, -2.025, 0.05, 81, 400)
    shape = frame.shape
    rows, cols = np.indices(shape)
    away = np.hypot(rows - 40, cols - 400) * 0.05
    terrain = Terrain(
        frame,
        np.full(shape, 2.0, np.float32),
        np.ones(shape, bool),
        np.ones(shape, np.float32),
    )
    return Along(terrain, Field(frame, away))


def looped(base, clock, *stopping) -> ControlLoop:
    return ControlLoop(base, base, clock, SafetyConfig(), RATES, traced(clock), *stopping)


def traced(clock) -> Tracer:
    return Tracer(read_budgets(), clock.now_s)


@pytest.fixture
def parts():
    clock = ManualClock(100.0)
    base = FakeBase(clock)
    return clock, base, looped(base, clock)


def told(beats: list[bool]) -> Callable[[bool], str]:
    def beat(moving: bool) -> str:
        beats.append(moving)
        return ""

    return beat


def plan(clock, course=None) -> Plan:
    return Plan(course or open_floor(), clock.now_s(), 0.18, ControlConfig(), {"mode": "frontier"})


def ticks(clock, control, n: int, then=lambda: None) -> None:
    for _ in range(n):
        control.tick()
        then()
        clock.advance(TICK_S)


def test_a_fresh_plan_is_driven_up_to_speed(parts):
    clock, base, control = parts
    control.follow(plan(clock))
    ticks(clock, control, 30, lambda: control.follow(plan(clock)))
    speeds = [v for v, _ in base.twists]
    assert speeds == sorted(speeds)
    assert speeds[-1] == pytest.approx(ControlConfig().max_speed_mps)
    steps = np.diff([0.0, *speeds])
    assert steps.max() <= ControlConfig().max_accel_mps2 * TICK_S + 1e-9
    assert control.asked_mps() == speeds[0]
    assert base.states[-1]["v_mps"] > 0
    assert base.states[-1]["mode"] == "frontier"


@pytest.mark.parametrize(
    ("kind", "stop"),
    [
        ("odometry", lambda base, now: setattr(base, "odom_s", now)),
        ("frame", lambda base, now: setattr(base, "frame_s", now)),
        ("plan", lambda base, now: None),  # nobody makes a new one
        ("jump", lambda base, now: setattr(base, "at", Pose(0.7, 0.0, 0.0))),
    ],
)
def test_what_goes_stale_stops_the_base_and_a_fresh_plan_resumes(parts, kind, stop):
    clock, base, control = parts
    control.follow(plan(clock))
    ticks(clock, control, 20)
    assert base.twists[-1][0] > 0.2
    stop(base, clock.now_s())
    ticks(clock, control, 45)
    assert base.twists[-1] == (0.0, 0.0)
    assert base.states[-1]["halt"]
    assert control.halted()
    assert kind in base.states[-1]["halts"]
    base.odom_s = base.frame_s = None
    control.follow(plan(clock))
    ticks(clock, control, 20)
    assert base.twists[-1][0] > 0.2
    assert not control.halted()
    assert control.status()["halts"] == {kind: 1}


def test_odometry_stale_stops_within_its_limit(parts):
    clock, base, control = parts
    control.follow(plan(clock))
    ticks(clock, control, 20)
    base.odom_s = clock.now_s() - TICK_S
    while clock.now_s() - base.odom_s <= SafetyConfig().odom_stale_s + 1e-9:
        assert base.twists[-1] != (0.0, 0.0)
        ticks(clock, control, 1)
    control.tick()
    assert base.twists[-1] == (0.0, 0.0)


def test_the_older_what_it_knows_the_slower_it_drives_and_never_faster_than_it_can_halt(parts):
    clock, base, control = parts
    cfg = ControlConfig()
    control.follow(plan(clock))
    ticks(clock, control, 20, lambda: control.follow(plan(clock)))
    allowed_m = cfg.max_speed_mps * (FRESH_S + HOLD_S) + cfg.max_speed_mps**2 / 2 / cfg.brake_mps2
    seen_s, ages, speeds = clock.now_s(), [], []
    control.follow(plan(clock))
    while clock.now_s() - seen_s < SafetyConfig().plan_stale_s - TICK_S:
        ages.append(clock.now_s() - seen_s)
        control.tick()
        speeds.append(base.twists[-1][0])
        clock.advance(TICK_S)
    assert speeds == sorted(speeds, reverse=True)
    assert np.diff(speeds).min() > -0.4 * TICK_S  # it falls, and does not jump
    assert speeds[ages.index(max(a for a in ages if a <= FRESH_S))] == cfg.max_speed_mps
    assert 0.1 < speeds[-1] < 0.25
    needed = [
        v * (a + HOLD_S) + v**2 / 2 / cfg.brake_mps2 for v, a in zip(speeds, ages, strict=True)
    ]
    assert max(needed) <= allowed_m + 0.002


def test_odometry_from_a_clock_that_was_set_back_holds_the_base_until_there_is_a_plan_of_its_time(
    parts,
):
    clock, base, control = parts
    control.follow(plan(clock))
    ticks(clock, control, 20, lambda: control.follow(plan(clock)))
    base.back_s = 3600.0
    control.tick()
    assert base.twists[-1] == (0.0, 0.0)
    assert control.halts() == {"clock": 1}
    clock.advance(TICK_S)
    ticks(clock, control, 20, lambda: control.follow(plan(clock)))
    assert base.twists[-1][0] > 0.2
    assert control.halts() == {"clock": 1}


def test_ticks_are_traced_from_the_odometry_to_the_command(parts):
    clock, base, _ = parts
    tracer = traced(clock)
    control = ControlLoop(base, base, clock, SafetyConfig(), RATES, tracer)
    put, say = base.drive, base.publish_state

    def slowly(order):
        clock.advance(0.01)
        return put(order)

    def told(state):
        clock.advance(5.0)  # what is only said to people delays no command
        say(state)

    base.drive, base.publish_state = slowly, told
    control.follow(plan(clock))
    control.tick()
    tick = tracer.told()[Stage.TICK]
    assert (tick["n"], tick["max_ms"]) == (1, pytest.approx(10.0))


def test_rest_commands_zero_at_once_then_leaves_the_base_to_others(parts):
    clock, base, control = parts
    control.follow(plan(clock))
    ticks(clock, control, 20)
    control.rest("found", {"reason": "found mug 1"})
    assert base.twists[-1] == (0.0, 0.0)
    before = len(base.twists)
    ticks(clock, control, 100)
    assert set(base.twists[before:]) == {(0.0, 0.0)}
    assert len(base.twists) - before == RATES.control_hz  # for a second
    assert base.states[-1]["state"] == "found"
    assert base.states[-1]["reason"] == "found mug 1"


def test_a_plan_taken_away_during_a_tick_is_not_driven(parts):
    clock, base, control = parts
    control.follow(plan(clock))
    ticks(clock, control, 20)
    ask = base.frame_arrival_s

    def cancelled_meanwhile():
        control.rest("cancelled", {})
        return ask()

    base.frame_arrival_s = cancelled_meanwhile
    control.tick()
    assert base.twists[-1] == (0.0, 0.0)


def test_a_plan_taken_away_for_another_during_a_tick_is_not_driven():
    clock = ManualClock(100.0)
    base, told = FakeBase(clock), []

    def record(kind, value):
        if kind == "tick":
            told.append(value)

    def replaced_meanwhile():  # asked when the plan was read, and its velocity is not sent yet
        if len(told) == 20:
            control.rest("preempted", {})
            control.follow(plan(clock, Spin(0.6)))
        return False

    rates = SafetyConfig(), RATES
    control = ControlLoop(
        base, base, clock, *rates, traced(clock), replaced_meanwhile, record=record
    )
    control.follow(plan(clock))
    ticks(clock, control, 21)
    assert base.twists[19][0] > 0.2
    assert base.twists[20:] == [(0.0, 0.0), (0.0, 0.0)]  # by `rest`, and by the tick
    assert (told[20].plan, told[20].withdrawn, told[20].sent) == (1, True, STILL)
    ticks(clock, control, 1)
    assert base.twists[-1][1] > 0.0  # the other is followed
    assert (told[21].plan, told[21].withdrawn) == (2, False)


def test_the_state_is_told_five_times_a_second_and_at_changes(parts):
    clock, base, control = parts
    control.follow(plan(clock))
    ticks(clock, control, 40)
    told = len(base.states)
    assert 9 <= told <= 12  # two seconds
    control.follow(plan(clock, Spin(0.6)))
    control.rest("cancelled", {})
    control.tick()
    assert base.states[-1]["state"] == "cancelled"
    assert len(base.states) == told + 1


def test_stopping_commands_zero_whatever_the_plan():
    clock, ending = ManualClock(100.0), threading.Event()
    base = FakeBase(clock)
    control = looped(base, clock, ending.is_set)
    control.follow(plan(clock))
    ticks(clock, control, 20)
    ending.set()
    control.tick()
    assert base.twists[-1] == (0.0, 0.0)


def test_an_error_in_the_loop_commands_zero_and_is_raised_to_who_asks():
    clock = SystemClock()
    base = FakeBase(clock)
    control = looped(base, clock)
    failed = threading.Event()

    def broken():
        failed.set()
        raise ZeroDivisionError("in the loop")

    base.frame_arrival_s = broken
    control.follow(plan(clock))
    control.start()
    assert failed.wait(10)
    control.close()
    assert base.twists[-1] == (0.0, 0.0)
    with pytest.raises(ZeroDivisionError):
        control.check()


def test_close_commands_zero_and_a_broken_bus_does_not_keep_it_from_ending():
    clock = SystemClock()
    base = FakeBase(clock)
    control = looped(base, clock)
    control.follow(plan(clock))
    control.start()
    control.close()
    assert base.twists[-1] == (0.0, 0.0)
    base.broken = True
    control.close()


def test_ticks_that_come_late_do_not_jerk(parts):
    clock, base, control = parts
    control.follow(plan(clock))
    control.tick()
    clock.advance(0.9)
    control.tick()
    assert base.twists[-1][0] <= ControlConfig().max_accel_mps2 * 0.2 + 1e-9
    assert math.isfinite(control.asked_mps())


def test_an_order_expires_and_says_whether_a_search_wants_to_drive(parts):
    clock, base, control = parts
    control.tick()
    control.follow(plan(clock))
    control.tick()
    control.rest("found", {})
    assert [order.searching for order in base.orders] == [False, True, False]
    worth_s = [order.expires_s - clock.now_s() for order in base.orders]
    assert worth_s == pytest.approx([ORDER_S] * 3)


def test_what_the_base_really_sent_is_what_is_slewed_from_told_and_recorded(parts):
    clock, base, _ = parts
    told = []
    control = ControlLoop(
        base, base, clock, SafetyConfig(), RATES, traced(clock),
        record=lambda kind, value: told.append(value) if kind == "tick" else None,
    )  # fmt: skip
    base.answer = lambda order: Sent(Twist(min(order.twist.v_mps, 0.1), order.twist.w_radps))
    control.follow(plan(clock))
    ticks(clock, control, 20, lambda: control.follow(plan(clock)))
    step = ControlConfig().max_accel_mps2 * TICK_S
    assert control.sent().v_mps == 0.1
    assert base.orders[-1].twist.v_mps == pytest.approx(0.1 + step)
    assert base.states[-1]["v_mps"] <= 0.1
    assert (told[-1].asked, told[-1].sent.v_mps) == (base.orders[-1].twist, 0.1)


def test_an_order_that_the_base_did_not_send_is_not_taken_for_driven(parts):
    clock, base, control = parts
    control.follow(plan(clock))
    ticks(clock, control, 20)
    control.asked_mps()
    before = control.sent()
    base.answer = lambda order: Sent(None, "too late")
    ticks(clock, control, 2)
    assert control.sent() == before  # it still does what it did
    assert control.asked_mps() == 0.0


@pytest.mark.parametrize(
    ("said", "kind", "reason"),
    [
        (BaseCondition(held="not armed"), "base", "base: not armed"),
        (BaseCondition(hand="mode MANUAL"), "hand", "a hand has the sticks: mode MANUAL"),
    ],
)
def test_a_base_that_cannot_be_driven_halts_until_there_is_a_plan_of_a_later_frame(
    parts, said, kind, reason
):
    clock, base, control = parts
    control.follow(plan(clock))
    ticks(clock, control, 20)
    base.said = said
    ticks(clock, control, 5)
    assert base.orders[-1].twist == STILL
    assert control.halted() == reason
    assert control.halts() == {kind: 1}
    assert base.states[-1]["base"] == vars(said)
    base.said = WELL
    ticks(clock, control, 2)
    assert base.orders[-1].twist == STILL  # the old plan lies elsewhere
    control.follow(plan(clock))
    ticks(clock, control, 5)
    assert base.orders[-1].twist.v_mps > 0
    assert not control.halted()
    assert control.status()["base"] == vars(WELL)


def test_who_drives_is_told_at_once_also_without_a_search(parts):
    clock, base, control = parts
    ticks(clock, control, 2)
    told = len(base.states)
    base.said = BaseCondition(hand="cmd_vel_teleop")
    control.tick()
    assert len(base.states) == told + 1
    assert base.states[-1]["base"]["hand"] == "cmd_vel_teleop"


def test_a_hand_that_has_let_go_is_told_of_until_somebody_wants_it_forgotten(parts):
    clock, base, control = parts
    base.said = replace(WELL, hand="sticks", battery_percent=60.0)
    ticks(clock, control, 1)
    base.said = replace(WELL, battery_percent=60.0)
    ticks(clock, control, 1)
    assert control.condition(forget=False) == replace(base.said, hand="sticks")
    assert control.condition() == replace(base.said, hand="sticks")
    assert control.condition() == base.said


def test_what_depth_leaves_of_a_command_is_what_is_sent(parts):
    clock, base, control = parts
    control.follow(plan(clock))
    base.cautious = Caution(HaltKind.OBSTACLE, "something 0.5 m ahead", most_mps=0.1)
    ticks(clock, control, 20, lambda: control.follow(plan(clock)))
    assert max(v for v, _ in base.twists) == 0.1
    assert control.halts() == {}
    assert base.states[-1]["caution"]["most_mps"] == 0.1
    base.cautious = Caution(HaltKind.OBSTACLE, "something 0.3 m ahead", 0.0, 0.0)
    ticks(clock, control, 3, lambda: control.follow(plan(clock)))
    assert base.twists[-3:] == [(0.0, 0.0)] * 3
    assert control.halts() == {"obstacle": 1}
    assert base.states[-1]["runtime"]["state"] == "held"
    base.cautious = FREE
    ticks(clock, control, 1)
    assert base.twists[-1][0] > 0


def test_a_stop_is_said_whether_a_search_is_on_or_not(parts):
    clock, base, control = parts
    control.started()
    ticks(clock, control, 1)
    assert base.states[-1]["runtime"]["state"] == "ready"
    base.doubted = Halt(HaltKind.STOP, "by stop")
    ticks(clock, control, 1)
    assert base.states[-1]["runtime"] == {"state": "stopped", "cause": "by stop"}
    control.follow(plan(clock))
    ticks(clock, control, 5)
    assert set(base.twists[-5:]) == {(0.0, 0.0)}
    assert [c.after.state for c in control.changes()] == ["ready", "stopped"]


def test_a_plan_in_doubt_holds_the_base_at_once_until_one_of_a_later_frame(parts):
    clock, base, control = parts
    control.started()
    control.follow(plan(clock))
    ticks(clock, control, 10)
    assert base.twists[-1][0] > 0.2
    blind = Halt(HaltKind.FRAME, "the camera has repeated itself for 0.4 s")
    control.follow(replace(plan(clock), course=None, doubt=blind))
    ticks(clock, control, 3)
    assert base.twists[-3:] == [(0.0, 0.0)] * 3
    assert base.states[-1]["runtime"] == {"state": "held", "cause": f"frame: {blind.reason}"}
    assert control.halts() == {"frame": 1}
    control.follow(plan(clock))
    ticks(clock, control, 3)
    assert base.twists[-1][0] > 0.0
    assert control.halted() == ""


def test_a_tick_that_is_wanted_at_once_does_not_wait_for_its_time(parts):
    _, base, _ = parts
    slow = replace(RATES, control_hz=0.01)
    real = SystemClock()
    base.clock = real
    beats = []
    control = ControlLoop(
        base,
        base,
        real,
        SafetyConfig(),
        slow,
        traced(real),
        beat=told(beats),
    )
    control.start()
    try:
        for n in range(1, 5):
            by_s = time.monotonic() + 50.0  # half of what the next turn is due after
            while len(beats) < n:
                assert time.monotonic() < by_s
                time.sleep(0.01)
            control.hurry()
    finally:
        control.close()


def test_the_pulse_tells_in_every_turn_whether_the_base_moves(parts):
    clock, base, _ = parts
    beats = []
    control = ControlLoop(
        base,
        base,
        clock,
        SafetyConfig(),
        RATES,
        traced(clock),
        beat=told(beats),
    )
    ticks(clock, control, 2)
    control.follow(plan(clock))
    ticks(clock, control, 3)
    control.rest(SearchState.CANCELLED, {})
    ticks(clock, control, 1)
    assert beats == [False, False, True, True, True, False]


def test_a_fault_is_said_before_the_process_ends(parts):
    clock, base, control = parts
    control.follow(plan(clock))
    ticks(clock, control, 2)
    control.fault("a bug")
    assert base.states[-1]["runtime"] == {"state": "fault", "cause": "a bug"}


class Told(FakeBase):
    """A base that does what it is told at once, and tells where it is so many times a second."""

    def __init__(self, clock, odom_hz: float) -> None:
        super().__init__(clock)
        self.odom_hz, self.true, self.last_s = odom_hz, Pose(0.0, 0.0, 0.0), clock.now_s()
        self.odom_s, self.at = clock.now_s(), self.true

    def move(self) -> None:
        now_s = self.clock.now_s()
        dt_s, self.last_s = now_s - self.last_s, now_s
        v, w = self.twists[-1] if self.twists else (0.0, 0.0)
        yaw = self.true.yaw_rad + w * dt_s
        x = self.true.x_m + v * dt_s * math.cos(yaw)
        self.true = Pose(x, self.true.y_m + v * dt_s * math.sin(yaw), yaw)
        if now_s - self.odom_s >= 1 / self.odom_hz - 1e-6:
            self.odom_s, self.at = now_s, self.true


def driven(odom_hz: float, seconds: float) -> tuple[Told, list[float], list[str]]:
    """The base, how fast it went in each turn, and why it was held."""
    clock = ManualClock(100.0)
    base = Told(clock, odom_hz)
    control, speeds, held = looped(base, clock), [], []
    for _ in range(round(seconds / TICK_S)):
        control.follow(plan(clock))
        control.tick()
        speeds.append(base.twists[-1][0])
        held.append(control.halted())
        clock.advance(TICK_S)
        base.move()
    return base, speeds, held


@pytest.mark.parametrize("odom_hz", [2.0, 3.0, 4.0])
def test_it_drives_on_and_no_farther_than_agreed_between_two_messages(odom_hz: float):
    _, speeds, held = driven(odom_hz, 12.0)
    assert not any(held[60:])
    assert max(speeds[60:]) / odom_hz <= BETWEEN_M + 1e-9
    assert min(speeds[100:]) > 0.8 * BETWEEN_M * odom_hz


def test_at_20_hz_it_is_as_fast_as_ever():
    _, speeds, held = driven(20.0, 4.0)
    assert not any(held)
    assert speeds[-1] == pytest.approx(ControlConfig().max_speed_mps)


def test_at_one_message_a_second_it_is_held_between_them():
    base, _, held = driven(1.0, 12.0)
    assert any("no odometry for" in why for why in held[100:])
    assert base.true.x_m < 0.5 * ControlConfig().max_speed_mps * 12.0


def test_odometry_that_ends_holds_it_however_seldom_it_came():
    clock = ManualClock(100.0)
    base = Told(clock, 3.0)
    control = looped(base, clock)
    for n in range(300):
        control.follow(plan(clock))
        control.tick()
        clock.advance(TICK_S)
        if n < 240:
            base.move()
            ended_s = base.odom_s
        elif clock.now_s() - ended_s > LONGEST_S + 2 * TICK_S:
            assert base.twists[-1] == (0.0, 0.0)
