"""The control loop while a hand has the sticks, and when the body meets something."""

import math
from dataclasses import replace

import pytest
from manual_clock import ManualClock

from runtime.config import RealtimeConfig
from runtime.core.motion.caution import FREE, Caution
from runtime.core.motion.contact import BACK_M, BACK_MPS, NOTHING, REST_S, Contact, Felt, Met, Touch
from runtime.core.motion.courses import STILL, ControlConfig, Spin
from runtime.core.motion.safety import Halt, SafetyConfig
from runtime.core.types import Pose, SearchState, Twist
from runtime.loops.control_loop import ControlLoop
from runtime.loops.plans import Plan, Tick
from runtime.robot.base import WELL, BaseCondition, DriveOrder, Sent
from runtime.robot.wire import Stamped
from runtime.tracing.budgets import read_budgets
from runtime.tracing.tracer import Tracer

RATES = RealtimeConfig()
TICK_S = 1 / RATES.control_hz
HAND = BaseCondition(hand="cmd_vel_teleop")


class Body:
    """A base that goes where it is told, at once, and is silent while a hand has the sticks; and
    the senses of it."""

    def __init__(self, clock: ManualClock) -> None:
        self.clock, self.at = clock, Pose(0.0, 0.0, 0.0)
        self.said, self.feels = WELL, NOTHING
        self.sent: list[Twist] = []
        self.states: list[dict] = []

    def pose(self):
        now_s = self.clock.now_s()
        return Stamped(round(now_s * 1e9), self.at), now_s

    def frame_arrival_s(self) -> float:
        return self.clock.now_s()

    def felt(self) -> Felt:
        return self.feels

    def doubt(self, sent: Twist) -> Halt | None:
        return None

    def caution(self, twist: Twist) -> Caution:
        return FREE

    def condition(self) -> BaseCondition:
        return self.said

    def drive(self, order: DriveOrder) -> Sent:
        if self.said.hand:
            return Sent(None, "a hand")
        self.sent.append(order.twist)
        return Sent(order.twist)

    def publish_state(self, state) -> None:
        self.states.append(dict(state))


class Loop:
    """The loop, ticked by hand."""

    def __init__(self) -> None:
        self.clock = ManualClock(100.0)
        self.body, self.told = Body(self.clock), []
        tracer = Tracer(read_budgets(), self.clock.now_s)
        config = SafetyConfig(), RATES, tracer
        take = lambda kind, value: self.told.append((kind, value))  # noqa: E731
        self.control = ControlLoop(self.body, self.body, self.clock, *config, record=take)

    def plan(self) -> None:
        self.control.follow(Plan(Spin(0.5), self.clock.now_s(), 0.18, ControlConfig()))

    def tick(self, n: int = 1) -> None:
        for _ in range(n):
            self.control.tick()
            self.clock.advance(TICK_S)

    def ticks(self) -> list[Tick]:
        return [value for kind, value in self.told if kind == "tick"]

    def came(self, way_m: float) -> None:
        """Have the robot come straight ahead, as if driven by somebody."""
        for n in range(math.ceil(way_m / 0.02)):
            self.body.at = Pose(-way_m + 0.02 * (n + 1), 0.0, 0.0)
            self.tick()


@pytest.fixture
def loop() -> Loop:
    return Loop()


# -- a hand ----------------------------------------------------------------------------------------


def test_while_a_hand_speaks_nothing_is_sent_not_even_zero(loop: Loop):
    loop.plan()
    loop.tick(5)
    assert loop.body.sent[-1] != STILL
    before, loop.body.said = len(loop.body.sent), HAND
    loop.tick(10)
    loop.control.rest(SearchState.CANCELLED, {})
    loop.tick(10)
    loop.control.close()  # as SIGTERM has it
    assert len(loop.body.sent) == before
    assert {tick.sent for tick in loop.ticks()[5:]} == {None}


def test_the_state_says_who_has_the_sticks_and_it_is_one_halt(loop: Loop):
    loop.plan()
    loop.tick(5)
    loop.body.said = HAND
    loop.tick(10)
    state = loop.body.states[-1]
    assert state["halt"] == "a hand has the sticks: cmd_vel_teleop"
    assert state["base"]["hand"] == "cmd_vel_teleop"
    assert state["halts"] == {"hand": 1}


def test_after_a_hand_only_a_plan_of_where_it_left_the_robot_is_driven(loop: Loop):
    loop.plan()
    loop.tick(5)
    loop.body.said = HAND
    loop.tick(4)
    loop.body.said = WELL
    loop.tick(4)
    assert loop.body.sent[-1] == STILL
    loop.plan()
    loop.tick(3)
    assert loop.body.sent[-1].w_radps > 0


def test_what_a_hand_moves_is_no_jump(loop: Loop):
    loop.plan()
    loop.body.said = HAND
    loop.tick(2)
    loop.body.at = Pose(1.0, 1.0, 2.0)
    loop.tick(2)
    loop.body.said = WELL
    loop.plan()
    loop.tick(3)
    assert loop.control.halts() == {"hand": 1}
    loop.body.at = Pose(0.0, 0.0, 0.0)
    loop.tick(1)
    assert loop.control.halts() == {"hand": 1, "jump": 1}


def test_what_a_hand_moved_is_no_jump_to_a_plan_of_just_before_either(loop: Loop):
    loop.body.said = HAND
    loop.tick()
    before_s = loop.clock.now_s() - TICK_S / 2
    loop.body.at = Pose(1.0, 1.0, 2.0)
    loop.tick()
    loop.body.said = WELL
    loop.control.follow(Plan(Spin(0.5), before_s, 0.18, ControlConfig()))
    loop.tick()
    assert loop.control.halted() == ""
    assert loop.body.sent[-1].w_radps > 0


def test_a_hand_that_has_let_go_is_told_once_to_who_plans(loop: Loop):
    loop.body.said = HAND
    loop.tick(2)
    loop.body.said = WELL
    loop.tick(2)
    assert loop.control.condition() == HAND
    assert loop.control.condition() == WELL
    assert [v for k, v in loop.told if k == "heard"] == [{"name": "condition", "value": HAND}]


# -- the body --------------------------------------------------------------------------------------


def touching(loop: Loop, touch: Touch = Touch.BUMPER) -> Contact:
    contact = Contact(touch, "bumper", 0.0, loop.clock.now_s(), True)
    loop.body.feels = Felt((contact,))
    return contact


def test_a_touch_stops_the_base_in_the_tick_that_feels_it_then_backs_off(loop: Loop):
    loop.plan()
    loop.came(0.4)
    contact = touching(loop)
    loop.tick()
    assert loop.body.sent[-1] == STILL
    assert loop.body.states[-1]["halt"] == "bumper touches something"
    assert loop.control.met() == (Met(Touch.BUMPER, loop.body.at, 0.0),)
    assert loop.control.met() == ()
    loop.tick(round(REST_S / TICK_S) + 1)
    assert loop.body.sent[-1] == Twist(-BACK_MPS, 0.0)
    loop.body.at = Pose(loop.body.at.x_m - BACK_M, 0.0, 0.0)
    loop.body.feels = Felt((replace(contact, held=False),))
    loop.tick(2)
    assert loop.body.sent[-1] == STILL
    loop.plan()
    loop.tick(3)
    assert loop.body.sent[-1].w_radps > 0
    assert loop.control.halts() == {"bumper": 1}


def test_it_backs_off_for_no_search_and_against_no_order_to_stop(loop: Loop):
    loop.came(0.4)
    touching(loop)
    loop.tick(20)
    assert {(t.v_mps, t.w_radps) for t in loop.body.sent} == {(0.0, 0.0)}


def test_what_a_hand_drove_against_is_not_backed_off_from_when_it_lets_go(loop: Loop):
    loop.plan()
    loop.came(0.4)
    loop.body.said = HAND
    touching(loop)
    loop.tick(2)
    loop.body.said = WELL
    before = len(loop.body.sent)
    for _ in range(round(REST_S / TICK_S) + 5):
        loop.plan()
        loop.tick()
    assert {twist.v_mps for twist in loop.body.sent[before:]} == {0.0}
    assert loop.body.sent[-1].w_radps > 0


def test_stale_odometry_ends_the_backing_off(loop: Loop):
    loop.plan()
    loop.came(0.4)
    touching(loop)
    loop.tick(round(REST_S / TICK_S) + 3)
    assert loop.body.sent[-1].v_mps < 0
    newest = loop.body.pose()
    loop.body.pose = lambda: newest
    loop.tick(8)
    assert loop.body.sent[-1] == STILL
    assert "odometry" in loop.control.halts()


@pytest.mark.parametrize("touch", list(Touch))
def test_what_is_felt_is_in_the_ticks_of_a_recording(loop: Loop, touch: Touch):
    loop.plan()
    loop.tick(2)
    contact = touching(loop, touch)
    loop.tick(2)
    assert loop.ticks()[-1].felt == Felt((contact,))
    assert loop.ticks()[-1].halt == touch.value
    assert loop.ticks()[0].felt is NOTHING
