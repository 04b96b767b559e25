"""A body that touches something halts, backs off the way it came, and waits to be told better."""

import math
from dataclasses import replace

import pytest

from runtime.core.motion.contact import (
    BACK_M,
    BACK_MPS,
    REST_S,
    STUCK_S,
    Contact,
    ContactResponse,
    Met,
    Touch,
)
from runtime.core.motion.courses import STILL
from runtime.core.motion.safety import HaltKind, Odometry
from runtime.core.types import Pose, Twist

DT_S = 0.05
FRONT, SIDE, BEHIND = 0.0, 0.6, math.pi


class Robot:
    """Obeys to the letter, sees ten frames a second, and plans at once."""

    def __init__(self, yaw_rad: float = 0.0) -> None:
        self.response, self.now_s = ContactResponse(), 100.0
        self.pose = Pose(0.0, 0.0, yaw_rad)
        self.contacts: tuple[Contact, ...] = ()
        self.met: list[Met] = []
        self.plans_s = math.inf  # frames come until then
        self.stuck = False  # it does not back off

    def drive(self, twist: Twist, ticks: int = 1, plan: bool = True) -> None:
        """Ticks of a plan that wants this velocity."""
        for _ in range(ticks):
            halt, instead = self.tick(plan)
            self.obey(instead if halt else self.response.allowed(twist, self.pose))

    def tick(self, plan: bool = True):
        self.now_s += DT_S
        odometry = Odometry(self.pose, round(self.now_s * 1e9), self.now_s)
        self.met += self.response.watch(self.now_s, odometry, self.contacts, plan)
        return self.response.judge(self.now_s, self.pose, min(self.now_s, self.plans_s))

    def obey(self, twist: Twist) -> None:
        if self.stuck and twist.v_mps < 0:
            return
        p, way_m = self.pose, twist.v_mps * DT_S
        yaw = p.yaw_rad + twist.w_radps * DT_S
        self.pose = Pose(p.x_m + way_m * math.cos(yaw), p.y_m + way_m * math.sin(yaw), yaw)

    def touch(self, bearing_rad: float = FRONT, touch: Touch = Touch.BUMPER) -> None:
        self.contacts = (Contact(touch, "sensor", bearing_rad, self.now_s, True),)

    def let_go(self) -> None:
        self.contacts = tuple(replace(c, held=False) for c in self.contacts)

    def held(self) -> str:
        halt, _ = self.tick()
        return halt.kind if halt else ""


AHEAD = Twist(0.3, 0.0)
BACK_TICKS = round((REST_S + BACK_M / BACK_MPS) / DT_S) + 2


def test_what_is_touched_halts_at_once_is_backed_off_from_and_is_told_where():
    robot = Robot()
    robot.drive(AHEAD, 20)
    there = robot.pose
    robot.touch(SIDE)
    halt, instead = robot.tick()
    assert halt is not None
    assert (halt.kind, halt.reason, instead) == (HaltKind.BUMPER, "sensor touches something", STILL)
    assert robot.met == [Met(Touch.BUMPER, there, SIDE)]
    robot.drive(AHEAD, round(REST_S / DT_S) - 2)
    assert robot.pose == there
    robot.plans_s = robot.now_s  # no frame comes while it backs off
    robot.drive(AHEAD, BACK_TICKS)
    robot.let_go()
    assert math.dist((robot.pose.x_m, robot.pose.y_m), (there.x_m, there.y_m)) == pytest.approx(
        BACK_M, abs=0.02
    )
    assert robot.held() == "bumper"  # until there is a plan of a later frame
    robot.plans_s = math.inf
    assert robot.held() == ""
    assert len(robot.met) == 1


def test_it_backs_off_only_as_far_as_it_came():
    robot = Robot()
    robot.drive(AHEAD, 4)  # 6 cm
    robot.touch()
    robot.plans_s = robot.now_s
    robot.drive(AHEAD, 2 * BACK_TICKS)
    assert robot.pose.x_m == pytest.approx(0.0, abs=0.015)


def test_what_it_turned_away_from_on_the_spot_is_not_the_way_it_came():
    robot = Robot()
    robot.drive(AHEAD, 20)
    robot.drive(Twist(0.0, 1.0), 40)
    here = robot.pose
    robot.touch()
    robot.drive(AHEAD, 2 * BACK_TICKS)
    assert (robot.pose.x_m, robot.pose.y_m) == (here.x_m, here.y_m)


def test_a_curve_is_backed_off_along():
    robot = Robot()
    robot.drive(Twist(0.3, 1.0), 20)
    places = []
    robot.touch()
    for _ in range(BACK_TICKS):
        robot.drive(AHEAD)
        places.append(robot.pose)
    radius_m = 0.3
    off_m = [abs(math.hypot(p.x_m, p.y_m - radius_m) - radius_m) for p in places]
    assert max(off_m) < 0.02


def test_what_is_met_behind_is_not_backed_into():
    robot = Robot()
    robot.drive(AHEAD, 20)
    here = robot.pose
    robot.touch(BEHIND)
    robot.plans_s = robot.now_s
    robot.drive(AHEAD, BACK_TICKS)
    assert robot.pose == here
    assert robot.met[0].bearing_rad == BEHIND


def test_something_behind_ends_the_backing_off():
    robot = Robot()
    robot.drive(AHEAD, 20)
    robot.touch()
    robot.drive(AHEAD, round(REST_S / DT_S) + 5)
    here = robot.pose
    robot.contacts += (Contact(Touch.BUMPER, "rear", BEHIND, robot.now_s, True),)
    robot.plans_s = robot.now_s
    robot.drive(AHEAD, BACK_TICKS)
    assert robot.pose == here


@pytest.mark.parametrize(
    ("touch", "bearing_rad"),
    [(Touch.BUMPER, BEHIND), (Touch.CLIFF, BEHIND), (Touch.WHEEL, FRONT)],
)
def test_it_does_not_back_off_while_there_is_something_behind(touch: Touch, bearing_rad: float):
    """Nor while a wheel hangs: somebody may hold the robot, and touch its bumper."""
    robot = Robot()
    robot.drive(AHEAD, 20)
    here = robot.pose
    robot.contacts = (Contact(touch, "first", bearing_rad, robot.now_s, True),)
    robot.plans_s = robot.now_s
    robot.drive(AHEAD, 20)
    robot.contacts += (Contact(Touch.BUMPER, "front", FRONT, robot.now_s, True),)
    robot.drive(AHEAD, BACK_TICKS)
    assert robot.pose == here


def test_a_second_sensor_of_the_front_does_not_keep_it_from_backing_off():
    robot = Robot()
    robot.drive(AHEAD, 20)
    there = robot.pose
    robot.touch()
    robot.drive(AHEAD, 2)
    robot.contacts += (Contact(Touch.BUMPER, "other", SIDE, robot.now_s, True),)
    robot.drive(AHEAD, BACK_TICKS - 2)
    assert there.x_m - robot.pose.x_m > BACK_M - 0.02
    assert len(robot.met) == 2


def test_a_base_that_does_not_back_off_is_left_alone_after_a_while():
    robot = Robot()
    robot.drive(AHEAD, 20)
    robot.stuck = True
    robot.touch()
    robot.drive(AHEAD, 1)
    robot.let_go()
    robot.drive(STILL, round(STUCK_S / DT_S) + BACK_TICKS)
    assert robot.held() == ""


def test_a_bumper_that_stays_pressed_forbids_only_what_pushes_on():
    robot = Robot()
    robot.drive(AHEAD, 20)
    robot.touch()
    robot.drive(STILL, BACK_TICKS + 2)
    assert robot.held() == ""
    assert robot.response.allowed(Twist(0.3, 0.5), robot.pose) == Twist(0.0, 0.5)
    robot.drive(Twist(0.3, 1.0), 30)  # so it turns, and may go when it faces another way
    assert robot.response.allowed(AHEAD, robot.pose) == AHEAD
    robot.let_go()
    robot.tick()
    assert robot.response.allowed(AHEAD, Pose(0.0, 0.0, 0.0)) == AHEAD


@pytest.mark.parametrize("touch", [Touch.CLIFF, Touch.WHEEL])
def test_without_floor_it_is_held_for_as_long_as_that_lasts(touch: Touch):
    robot = Robot()
    robot.touch(touch=touch)
    robot.drive(AHEAD, 200)
    assert robot.pose == Pose(0.0, 0.0, 0.0)
    robot.let_go()
    robot.plans_s = robot.now_s
    assert robot.held() == touch.value
    robot.plans_s = math.inf
    robot.tick()
    assert robot.held() == ""
    assert [met.touch for met in robot.met] == ([Touch.CLIFF] if touch is Touch.CLIFF else [])


def test_a_cliff_is_backed_off_from():
    robot = Robot()
    robot.drive(AHEAD, 20)
    there = robot.pose
    robot.touch(touch=Touch.CLIFF)
    robot.drive(AHEAD, 8)
    robot.let_go()
    robot.drive(STILL, BACK_TICKS)
    assert there.x_m - robot.pose.x_m > BACK_M - 0.02


def test_it_does_nothing_by_itself_where_no_plan_drives_it():
    robot = Robot()
    robot.drive(AHEAD, 20)
    robot.touch()
    here = robot.pose
    for _ in range(50):
        assert robot.tick(plan=False)[1] == STILL
    assert robot.pose == here
    assert len(robot.met) == 1


def test_a_hand_that_takes_over_ends_the_backing_off():
    robot = Robot()
    robot.drive(AHEAD, 20)
    robot.touch()
    robot.drive(AHEAD, round(REST_S / DT_S) + 3)
    robot.tick(plan=False)
    assert robot.tick()[1] == STILL


def test_a_jump_of_odometry_is_no_way_that_was_driven():
    robot = Robot()
    robot.drive(AHEAD, 20)
    robot.pose = Pose(5.0, 5.0, 0.0)
    robot.drive(STILL, 2)
    robot.touch()
    robot.drive(AHEAD, BACK_TICKS)
    assert robot.pose == Pose(5.0, 5.0, 0.0)
