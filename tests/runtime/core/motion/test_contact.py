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
HERE = Pose(0.0, 0.0, 0.0)


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


# -- to the number ---------------------------------------------------------------------------------


class Told:
    """What a robot that a test puts anywhere, at any time, answers."""

    def __init__(self) -> None:
        self.response, self.contacts = ContactResponse(), ()

    def at(self, pose: Pose, now_s: float = 0.0, driving: bool = True):
        return self.response.watch(now_s, Odometry(pose, 0, now_s), self.contacts, driving)

    def came(self, *poses: Pose) -> None:
        for pose in poses:
            self.at(pose)

    def meets(self, *contacts: Contact) -> None:
        self.contacts = contacts

    def asked(self, pose: Pose, now_s: float, plan_s: float = -1.0) -> Twist:
        """Watched and judged."""
        self.at(pose, now_s)
        return self.response.judge(now_s, pose, plan_s)[1]


def front(since_s: float = 1.0, held: bool = True, name: str = "front") -> Contact:
    return Contact(Touch.BUMPER, name, 0.0, since_s, held)


def line(
    to_m: float, yaw_rad: float = 0.0, begin: Pose = HERE, step_m: float = 0.048
) -> list[Pose]:
    """Poses straight ahead, from `begin` to so far from it."""
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    ways = [step_m * n for n in range(round(to_m / step_m) + 1)]
    return [Pose(begin.x_m + c * w, begin.y_m + s * w, yaw_rad) for w in ways]


def backed_off_m(told: Told, end: Pose, now_s: float = 1.0) -> float:
    """From `end`, where it has met something, until it leaves that be: as it is told, 20 times a
    second. 0 where it is told nothing."""
    pose, backed_m = end, 0.0
    for n in range(100):
        twist = told.asked(pose, now_s + DT_S * n)
        if n * DT_S < REST_S - 1e-9:
            assert twist == STILL
        backed_m -= twist.v_mps * DT_S
        way_m, yaw = twist.v_mps * DT_S, pose.yaw_rad + twist.w_radps * DT_S
        pose = Pose(pose.x_m + way_m * math.cos(yaw), pose.y_m + way_m * math.sin(yaw), yaw)
    return backed_m


@pytest.mark.parametrize("yaw_rad", [0.0, 2.0, -1.3])
def test_the_way_it_came_is_known_wherever_it_is(yaw_rad: float):
    told, came = Told(), line(0.4, yaw_rad, Pose(3.0, -4.0, 0.0))
    told.came(*came)
    told.meets(front())
    assert backed_off_m(told, came[-1]) == pytest.approx(3 * 0.048, abs=DT_S * BACK_MPS + 1e-6)


def test_what_it_went_back_by_itself_is_no_way_any_more():
    """A hand, say, that drove it back for two steps of eight."""
    told, came = Told(), line(0.4)
    told.came(*came, *reversed(line(0.4)[6:]))
    told.meets(front())
    trail = told.response._trail.poses
    assert [round(m, 6) for m, _ in trail] == [round(0.048 * n, 6) for n in range(7)]
    assert backed_off_m(told, came[6]) == pytest.approx(3 * 0.048, abs=DT_S * BACK_MPS + 1e-6)


def test_who_goes_back_beyond_where_it_began_begins_anew():
    told = Told()
    told.came(*line(0.1), Pose(0.0, 0.0, 0.0), Pose(-0.1, 0.0, 0.0))
    assert list(told.response._trail.poses) == [(0.0, Pose(-0.1, 0.0, 0.0))]
    told.meets(front())
    assert backed_off_m(told, Pose(-0.1, 0.0, 0.0)) == 0.0


def test_a_step_back_of_less_than_it_goes_keeps_the_way_up_to_there():
    told = Told()
    told.came(*line(0.1), Pose(0.08, 0.0, 0.0))
    assert [round(m, 6) for m, _ in told.response._trail.poses] == [0.0, 0.048]


def test_who_goes_back_to_where_it_was_has_come_as_far_as_that():
    told = Told()
    told.came(*line(0.25, step_m=0.125), Pose(0.125, 0.0, 0.0))
    assert [m for m, _ in told.response._trail.poses] == [0.0, 0.125]
    told.came(Pose(0.05, 0.0, 0.0))
    assert list(told.response._trail.poses) == [(0.0, HERE)]


def test_steps_to_the_centimetre():
    for ahead_m, way in ((0.01, [0.0, 0.01]), (0.0099, [0.0])):
        told = Told()
        told.came(HERE, Pose(ahead_m, 0.0, 0.0))
        assert [m for m, _ in told.response._trail.poses] == way
    told = Told()
    told.came(Pose(-0.01, 0.0, 0.0), HERE, Pose(-0.01, 0.0, 0.0))
    assert [m for m, _ in told.response._trail.poses] == [0.0]
    told = Told()
    told.came(HERE, Pose(-0.0099, 0.0, 0.0))
    assert [pose for _, pose in told.response._trail.poses] == [HERE]


def test_a_turn_keeps_the_way_up_to_a_bound_and_what_is_aside_is_no_way():
    told = Told()
    told.came(*line(0.3, 2.0), replace(line(0.3, 2.0)[-1], yaw_rad=2.3))
    assert len(told.response._trail.poses) == 7
    told.came(replace(line(0.3, 2.0)[-1], yaw_rad=2.31))
    assert len(told.response._trail.poses) == 1
    told = Told()
    told.came(HERE, Pose(0.0, 0.2, 0.0))
    assert len(told.response._trail.poses) == 1


@pytest.mark.parametrize("yaw_rad", [0.0, math.pi / 2])
def test_a_jump_is_how_far_two_messages_are_apart(yaw_rad: float):
    told, begin = Told(), Pose(1.0, 2.0, yaw_rad)
    told.came(begin, line(0.25, yaw_rad, begin, 0.25)[1])
    assert len(told.response._trail.poses) == 2
    told.came(line(0.51, yaw_rad, begin, 0.51)[1])
    assert len(told.response._trail.poses) == 1


def test_no_more_of_the_way_is_kept_than_half_a_metre():
    told = Told()
    told.came(*line(2.0, step_m=0.125))
    assert [m for m, _ in told.response._trail.poses] == [1.5, 1.625, 1.75, 1.875, 2.0]


def test_a_way_of_a_centimetre_is_backed_off_and_over_when_it_is_gone():
    told = Told()
    told.came(HERE, Pose(0.01, 0.0, 0.0))
    told.meets(front())
    assert told.asked(Pose(0.01, 0.0, 0.0), 1.0) == STILL
    assert told.asked(Pose(0.01, 0.0, 0.0), 1.29) == STILL
    assert told.asked(Pose(0.01, 0.0, 0.0), 1.0 + REST_S) == Twist(-BACK_MPS, 0.0)
    assert told.asked(HERE, 1.4) == STILL
    assert told.asked(Pose(0.01, 0.0, 0.0), 1.45) == STILL


def test_a_way_of_just_as_much_as_it_backs_off_is_one():
    told, end = Told(), Pose(BACK_M, 0.0, 0.0)
    told.came(HERE, end)
    told.meets(front())
    told.asked(end, 1.0)
    assert told.asked(end, 1.0 + REST_S) == Twist(-BACK_MPS, 0.0)


def test_a_turn_that_comes_late_backs_off_from_where_it_was_met():
    told, came = Told(), line(0.4)
    told.came(*came)
    told.meets(front())
    told.at(came[-1], 1.0)
    assert told.asked(came[-1], 1.0 + 2 * REST_S) == Twist(-BACK_MPS, 0.0)


def test_what_still_rolls_backs_off_from_where_it_stood():
    told, came = Told(), line(0.4)
    told.came(*came)
    told.meets(front())
    told.asked(came[-1], 1.0)
    told.asked(Pose(0.45, 0.0, 0.0), 1.2)
    assert told.asked(Pose(0.45, 0.0, 0.0), 1.35) == Twist(-BACK_MPS, 0.0)
    assert told.asked(Pose(0.31, 0.0, 0.0), 2.0) == Twist(-BACK_MPS, 0.0)
    assert told.asked(Pose(0.299, 0.0, 0.0), 2.05) == STILL


def test_a_base_that_is_stuck_is_told_to_back_off_until_its_time_is_over():
    told, came = Told(), line(0.25, step_m=0.125)
    told.came(*came)
    told.meets(front(0.0))
    assert told.asked(came[-1], 0.0) == STILL
    over_s = 0.0 + REST_S + 0.125 / BACK_MPS + STUCK_S
    assert told.asked(came[-1], over_s) == Twist(-BACK_MPS, 0.0)
    assert told.asked(came[-1], over_s + 1e-6) == STILL
    assert told.asked(came[-1], over_s - 0.5) == STILL  # once and for all


@pytest.mark.parametrize(
    ("yaw_rad", "w_radps"), [(0.2, -0.1), (-0.2, 0.1), (2.0, -0.5), (-2.0, 0.5)]
)
def test_a_curve_is_backed_off_along_by_what_is_left_of_it(yaw_rad: float, w_radps: float):
    """From the heading at its end to the one a tenth of a metre before; 2 rad are too much."""
    told, end = Told(), Pose(0.1, 0.0, yaw_rad)
    told.came(Pose(0.0, 0.0, yaw_rad / 2), end)
    way_m = 0.1 * math.cos(yaw_rad / 2)
    told.meets(front())
    told.asked(end, 1.0)
    expected = -yaw_rad / 2 * BACK_MPS / way_m
    bounded = max(-0.5, min(0.5, expected))
    assert bounded == pytest.approx(w_radps, abs=0.01)
    assert told.asked(end, 1.0 + REST_S).w_radps == pytest.approx(bounded)


def test_the_last_bit_of_a_curve_is_not_turned_for_sharply():
    told, end = Told(), Pose(0.1, 0.0, 0.02)
    told.came(HERE, end)
    told.meets(front())
    told.asked(end, 1.0)
    told.asked(end, 1.0 + REST_S)
    assert told.asked(Pose(0.002, 0.0, 0.02), 2.0).w_radps == pytest.approx(-0.02 * 0.1 / 0.01)


def test_a_plan_of_just_that_moment_does_not_know_of_it_yet():
    told = Told()
    told.came(HERE)
    told.meets(front(1.0))
    told.at(HERE, 1.0)
    halt, _ = told.response.judge(1.0, HERE, 1.0)
    assert halt is not None
    assert halt.reason == "front touches something"
    assert told.response.judge(1.0, HERE, 1.01) == (None, STILL)
    assert told.response.judge(1.0, HERE, -5.0) == (None, STILL)  # it was known of once


@pytest.mark.parametrize(
    ("touch", "words"), [(Touch.CLIFF, "has no floor under it"), (Touch.WHEEL, "hangs in the air")]
)
def test_what_lasts_is_what_is_said_and_its_end_is_what_a_plan_has_to_know(touch, words):
    told = Told()
    told.came(HERE)
    lasting = Contact(touch, "left", 0.3, 1.0, True)
    told.meets(front(1.0), lasting)
    for now_s in (1.0, 2.0, 3.0):
        told.at(HERE, now_s)
        halt, twist = told.response.judge(now_s, HERE, now_s)
        assert halt is not None
        assert (halt.kind, halt.reason, twist) == (touch.value, f"left {words}", STILL)
    told.meets(replace(lasting, held=False))
    told.at(HERE, 3.1)
    assert told.response.judge(3.1, HERE, 3.0)[0] is not None
    assert told.response.judge(3.1, HERE, 3.05) == (None, STILL)


def test_of_what_is_met_at_once_the_gravest_is_said_and_the_map_is_told_of_all_but_wheels():
    told, pose = Told(), Pose(1.0, 2.0, 0.5)
    bumper, cliff = front(1.0), Contact(Touch.CLIFF, "cliff", 0.4, 1.0, False)
    wheel = Contact(Touch.WHEEL, "wheel", 0.0, 1.0, False)
    told.meets(bumper, cliff, wheel)
    assert told.at(pose, 1.0) == (Met(Touch.BUMPER, pose, 0.0), Met(Touch.CLIFF, pose, 0.4))
    halt, _ = told.response.judge(1.0, pose, 0.5)
    assert halt is not None
    assert halt.kind is HaltKind.WHEEL
    told = Told()
    told.meets(bumper, cliff)
    told.at(pose, 1.0)
    halt, _ = told.response.judge(1.0, pose, 0.5)
    assert halt is not None
    assert halt.kind is HaltKind.CLIFF


def test_what_was_met_before_is_not_met_again():
    told = Told()
    told.meets(front(1.0))
    assert len(told.at(HERE, 1.0)) == 1
    assert told.at(HERE, 1.1) == ()
    told.meets(front(1.0), front(1.05, name="other"), front(1.1, name="third"))
    assert len(told.at(HERE, 1.2)) == 2
    assert told.at(HERE, 1.3) == ()


def test_what_the_bumper_touches_is_where_it_was_when_it_was_touched():
    told = Told()
    told.meets(replace(front(1.0), bearing_rad=0.5))
    told.at(Pose(0.0, 0.0, 1.0), 1.0)
    ahead, away = Twist(0.2, 0.3), Twist(-0.2, 0.3)
    for yaw_rad, left in (
        (2.4, Twist(0.0, 0.3)),
        (0.6, Twist(0.0, 0.3)),
        (2.5, ahead),
        (0.4, ahead),
    ):
        assert told.response.allowed(ahead, Pose(0.0, 0.0, yaw_rad)) == left
    assert told.response.allowed(away, Pose(0.0, 0.0, 1.5)) is away
    turn = Twist(0.0, 0.3)
    assert told.response.allowed(turn, Pose(0.0, 0.0, 1.5)) is turn
    told.meets(replace(front(1.0), bearing_rad=0.5, held=False))
    told.at(Pose(0.0, 0.0, 1.5), 1.1)
    assert told.response.allowed(ahead, Pose(0.0, 0.0, 1.5)) == ahead


@pytest.mark.parametrize("contact", [front(1.0, held=False), Contact(Touch.CLIFF, "c", 0, 1, True)])
def test_only_a_bumper_that_stays_pressed_forbids_to_push_on(contact: Contact):
    told = Told()
    told.meets(contact)
    told.at(HERE, 1.0)
    assert told.response.allowed(AHEAD, HERE) == AHEAD


@pytest.mark.parametrize(("bearing_rad", "backs"), [(1.75, True), (1.76, False), (-1.76, False)])
def test_what_is_met_more_to_the_side_than_ahead_is_not_backed_off_from(bearing_rad, backs):
    told, came = Told(), line(0.4)
    told.came(*came)
    told.meets(replace(front(), bearing_rad=bearing_rad))
    assert (backed_off_m(told, came[-1]) > 0) is backs


def test_a_contact_that_is_over_behind_it_does_not_keep_it_from_backing_off():
    told, came = Told(), line(0.4)
    told.came(*came)
    told.meets(front(), Contact(Touch.BUMPER, "rear", BEHIND, 0.5, False))
    told.response._known_s = 0.6  # the rear one is an old story
    assert backed_off_m(told, came[-1]) > 0


def test_after_it_has_backed_off_what_it_touched_is_no_way_to_back_off_by():
    told, came = Told(), line(0.4)
    told.came(*came)
    told.meets(front(1.0))
    backed_off_m(told, came[-1])
    told.meets(front(10.0))
    assert backed_off_m(told, Pose(0.24, 0.0, 0.0), 10.0) == 0.0


def test_a_second_touch_while_it_backs_off_leaves_what_is_said():
    told, came = Told(), line(0.4)
    told.came(*came)
    told.meets(front(1.0))
    told.asked(came[-1], 1.0)
    told.meets(front(1.0), front(1.2, name="other"))
    told.asked(came[-1], 1.2)
    halt, twist = told.response.judge(1.35, came[-1], -1.0)
    assert halt is not None
    assert (halt.reason, twist) == ("front touches something", Twist(-BACK_MPS, 0.0))
    told.meets(front(1.0), Contact(Touch.BUMPER, "rear", BEHIND, 1.4, True))
    told.at(came[-1], 1.4)
    halt, twist = told.response.judge(1.4, came[-1], -1.0)
    assert halt is not None
    assert (halt.reason, twist) == ("rear touches something", STILL)
