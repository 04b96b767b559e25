"""The turn, with a bus and a control loop that are stand-ins, on a clock that they move."""

import math

import numpy as np
import pytest
from apartment import INTRINSICS
from manual_clock import ManualClock

from runtime.config import Config
from runtime.core.motion.courses import Spin
from runtime.core.types import Observation, Pose, SearchState, Twist
from runtime.doctor.diagnosis import Grade
from runtime.doctor.spin import BUSY, BY_HAND, STANDS_S, Turned, judge_turn, turn_by
from runtime.loops.plans import Plan

FRAME_S = 0.1
CONFIG = Config()
RATE = CONFIG.navigate.control.look_radps


class Asked:
    def __init__(self, kind: str) -> None:
        self.kind, self.answer = kind, ""

    def reply(self, answer: dict) -> None:
        self.answer = str(answer["state"])

    def refuse(self, why: str) -> None:
        self.answer = why


class Rig:
    """Bus and control loop in one: a base that does as it is told, unless it is `held`."""

    def __init__(self, held: str = "", frames: int = 1000) -> None:
        self.clock, self.held, self.frames = ManualClock(100.0), held, frames
        self.plan: Plan | None = None
        self.plans: list[Plan] = []
        self.asked: list[Asked] = []
        self.rested: list[SearchState] = []

    def next(self, timeout_s: float) -> Observation | None:
        self.clock.advance(FRAME_S)
        if self.frames <= 0:
            return None
        self.frames -= 1
        rgb, depth = np.zeros((12, 16, 3), np.uint8), np.ones((12, 16), np.float32)
        return Observation(1, rgb, depth, Pose(0, 0, 0), INTRINSICS)

    def delivered_s(self) -> float | None:
        return self.clock.now_s()

    def request(self) -> Asked | None:
        return next((one for one in self.asked if not one.answer), None)

    def follow(self, plan: Plan) -> None:
        self.plan = plan
        self.plans.append(plan)

    def sent(self) -> Twist:
        course = self.plan.course if self.plan else None
        moves = isinstance(course, Spin) and not self.held
        return Twist(0.0, course.w_radps) if moves and isinstance(course, Spin) else Twist()

    def halted(self) -> str:
        return self.held

    def check(self) -> None:
        pass

    def rest(self, state: SearchState, report: dict) -> None:
        self.plan = None
        self.rested.append(state)


def turned(rig: Rig, ends_at_s: float = math.inf) -> Turned:
    found = Turned()
    turn_by(rig, rig, CONFIG, rig.clock, lambda: rig.clock.now_s() > ends_at_s, found)
    return found


def test_it_stands_turns_once_to_the_left_and_stands():
    rig = Rig()
    found = turned(rig)
    assert math.tau <= found.sent_rad <= math.tau + 2 * RATE * FRAME_S
    courses = [plan.course for plan in rig.plans]
    stood = courses.index(Spin(RATE))
    assert courses[:stood] == [None] * stood
    assert stood * FRAME_S == pytest.approx(STANDS_S, abs=2 * FRAME_S)
    assert set(courses[stood:]) == {Spin(RATE)}
    assert rig.rested == [SearchState.READY]
    assert len(found.glimpses) > len(courses) + 5  # and it looked on, at rest
    (told,) = judge_turn(found)
    assert told.grade is Grade.OK


def test_a_base_that_is_held_is_given_up_and_the_reason_told():
    rig = Rig(held="no odometry yet")
    found = turned(rig)
    assert found.sent_rad == 0
    (told,) = judge_turn(found)
    assert told.grade is Grade.BAD
    assert told.told.endswith("0% of a turn to the left: held: no odometry yet")
    assert rig.rested == [SearchState.READY]


def test_without_frames_it_does_not_move():
    rig = Rig(frames=0)
    (told,) = judge_turn(turned(rig))
    assert told.grade is Grade.BAD
    assert not rig.plans


def test_it_ends_by_hand_and_by_a_cancel_and_a_goal_has_to_wait():
    rig = Rig()
    found = turned(rig, ends_at_s=105.0)
    assert found.ended == BY_HAND
    assert rig.clock.now_s() < 106.0
    rig = Rig()
    rig.asked = [Asked("goal"), Asked("status"), Asked("cancel")]
    found = turned(rig)
    assert "cancelled" in found.ended
    assert [one.answer for one in rig.asked] == [BUSY, BUSY, "cancelled"]
    assert next(judge_turn(found)).grade is Grade.WARNING
    assert rig.rested == [SearchState.READY]


def test_a_turn_that_was_held_on_the_way_is_warned_of():
    (told,) = judge_turn(Turned(sent_rad=math.tau, held="depth comes 1.2 s late by its stamps"))
    assert told.grade is Grade.WARNING
    assert "1.2 s late" in told.told
