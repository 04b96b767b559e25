"""What holds the base, and what lets it go again."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.core.motion.safety import (
    IN_THE_WAY,
    OVERRUN_S,
    Guard,
    Halt,
    HaltKind,
    Odometry,
    SafetyConfig,
)
from runtime.core.types import Pose

CFG = SafetyConfig()


def at(x: float, arrival_s: float, stamp_ns: int | None = None, yaw: float = 0.0) -> Odometry:
    stamp = round(arrival_s * 1e9) if stamp_ns is None else stamp_ns
    return Odometry(Pose(x, 0.0, yaw), stamp, arrival_s)


def kinds(guard: Guard, now_s: float, odometry, frame_s, plan_s) -> str:
    if odometry is not None:
        guard.watch(odometry)
    halt = guard.check(now_s, odometry, frame_s, plan_s)
    return halt.kind if halt else ""


def test_everything_fresh_drives():
    assert kinds(Guard(CFG), 10.0, at(0, 9.9), 9.8, 9.5) == ""


@given(
    odom=st.none() | st.floats(0, 5),
    frame=st.none() | st.floats(0, 5),
    plan=st.floats(0, 5),
)
def test_no_age_beyond_its_limit_is_driven_on(odom, frame, plan):
    now = 100.0
    kind = kinds(
        Guard(CFG),
        now,
        None if odom is None else at(0, now - odom),
        None if frame is None else now - frame,
        now - plan,
    )
    bad = {
        "odometry": odom is None or now - (now - odom) > CFG.odom_stale_s,
        "frame": frame is None or now - (now - frame) > CFG.frame_stale_s,
        "plan": now - (now - plan) > CFG.plan_stale_s,
    }
    assert bad.get(kind, False) or (kind == "" and not any(bad.values()))


def test_stale_odometry_is_counted_once_and_forgiven_when_fresh():
    guard = Guard(CFG)
    assert kinds(guard, 1.0, at(0, 1.0), 1.0, 1.0) == ""
    assert kinds(guard, 1.4, at(0, 1.0), 1.3, 1.3) == "odometry"
    assert kinds(guard, 1.5, at(0, 1.0), 1.3, 1.3) == "odometry"
    assert kinds(guard, 1.6, at(0, 1.6), 1.5, 1.5) == ""
    assert kinds(guard, 2.0, at(0, 1.6), 1.9, 1.9) == "odometry"
    assert guard.halts == {"odometry": 2}


def test_odometry_at_3_hz_is_waited_for_and_one_that_stays_away_is_not():
    guard, now = Guard(CFG), 10.0
    held = []
    for n in range(40):
        odometry = at(0.01 * n, now)
        for later in (0.05, 0.15, 0.32):
            held.append(kinds(guard, now + later, odometry, now, now))
        now += 1 / 3
    assert set(held[:12]) == {"", "odometry"}  # until it is known how often it comes
    assert set(held[15:]) == {""}
    assert kinds(guard, now + 0.25, odometry, now, now) == ""
    assert kinds(guard, now + 0.30, odometry, now, now) == "odometry"  # 0.63 s after the last


def test_frames_that_come_back_before_a_plan_are_one_halt():
    guard = Guard(CFG)
    assert kinds(guard, 5.0, at(0, 5.0), 3.0, 3.0) == "frame"
    assert kinds(guard, 5.1, at(0, 5.1), 5.1, 2.9) == "plan"
    assert kinds(guard, 5.2, at(0, 5.2), 5.1, 5.1) == ""
    assert kinds(guard, 7.9, at(0, 7.9), 7.8, 5.1) == "plan"
    assert guard.halts == {"frame": 1, "plan": 1}


def test_after_a_jump_only_a_later_plan_is_driven():
    guard = Guard(CFG)
    assert kinds(guard, 1.0, at(0, 1.0), 1.0, 0.9) == ""
    assert kinds(guard, 1.05, at(0.6, 1.05), 1.0, 0.9) == "jump"
    assert kinds(guard, 1.1, at(0.6, 1.1), 1.08, 1.0) == "jump"  # made before it
    assert kinds(guard, 1.2, at(0.6, 1.2), 1.15, 1.15) == ""
    assert guard.halts == {"jump": 1}


def test_a_turn_no_base_can_make_is_a_jump():
    guard = Guard(CFG)
    assert kinds(guard, 1.0, at(0, 1.0, yaw=3.0), 1.0, 1.0) == ""
    assert kinds(guard, 1.05, at(0, 1.05, yaw=-3.0), 1.0, 1.0) == ""  # the short way round
    assert kinds(guard, 1.1, at(0, 1.1, yaw=0.0), 1.0, 1.0) == "jump"


def test_a_clock_that_went_back_holds_until_a_later_plan():
    guard = Guard(CFG)
    assert kinds(guard, 1.0, at(0, 1.0, 50), 1.0, 1.0) == ""
    assert kinds(guard, 1.05, at(0, 1.05, 40), 1.05, 1.0) == "clock"
    assert kinds(guard, 1.1, at(0, 1.1, 45), 1.1, 1.06) == ""
    assert guard.halts == {"clock": 1}


def test_after_control_stood_still_only_a_later_plan_is_driven():
    guard = Guard(CFG)
    guard.turn(10.0)
    assert kinds(guard, 10.0, at(0, 10.0), 10.0, 10.0) == ""
    guard.turn(10.0 + OVERRUN_S + 0.01)
    now_s = 10.0 + OVERRUN_S + 0.02
    assert kinds(guard, now_s, at(0, now_s), 10.3, 10.2) == "overrun"
    guard.turn(now_s + 0.1)
    assert kinds(guard, now_s + 0.1, at(0, now_s + 0.1), now_s, 10.2) == "overrun"
    assert kinds(guard, now_s + 0.1, at(0, now_s + 0.1), now_s, now_s) == ""
    assert guard.halts == {"overrun": 1}


def test_what_grew_old_while_control_stood_still_is_told_as_that():
    guard, old = Guard(CFG), Halt(HaltKind.FRAME, "the newest depth image is old")
    guard.turn(10.0)
    now_s = 11.0
    guard.turn(now_s)
    told = []
    for n in range(6):
        later_s = now_s + n * OVERRUN_S / 4
        guard.turn(later_s)
        told.append(guard.check(later_s, at(0, later_s), 10.9, 10.2, doubt=old).kind)
    assert told == ["overrun"] * 4 + ["frame"] * 2
    assert guard.halts == {"overrun": 1, "frame": 1}


def test_turns_that_come_in_time_are_no_overrun():
    guard = Guard(CFG)
    for n in range(50):
        now_s = 10.0 + n * 0.99 * OVERRUN_S
        guard.turn(now_s)
        assert kinds(guard, now_s, at(0, now_s), now_s, now_s) == ""


def test_what_is_doubted_holds_until_a_plan_was_made_after_it():
    guard, doubt = Guard(CFG), Halt(HaltKind.JUMP, "odometry is 5 m off")
    guard.watch(at(0, 10.0))
    held = guard.check(10.0, at(0, 10.0), 10.0, 10.0, doubt=doubt)
    assert held == doubt
    assert guard.check(10.1, at(0, 10.1), 10.1, 9.9) == doubt
    assert guard.check(10.2, at(0, 10.2), 10.1, 10.05) is None


def test_a_command_of_which_depth_left_nothing_is_one_halt_as_long_as_it_lasts():
    guard, ahead = Guard(CFG), Halt(HaltKind.OBSTACLE, "a leg")
    for now_s in (10.0, 10.05, 10.1):
        assert kinds(guard, now_s, at(0, now_s), now_s, now_s) == ""
        guard.caution(ahead)
    assert guard.halts == {"obstacle": 1}
    assert kinds(guard, 10.15, at(0, 10.15), 10.1, 10.1) == ""
    assert kinds(guard, 10.2, at(0, 10.2), 10.1, 10.1) == ""
    guard.caution(ahead)
    assert guard.halts == {"obstacle": 2}


def test_each_stale_thing_is_said_with_its_age():
    def said(odometry, frame_s, plan_s) -> str:
        halt = Guard(CFG).check(10.0, odometry, frame_s, plan_s)
        return f"{halt.kind}: {halt.reason}" if halt else ""

    fresh = at(0, 9.9)
    assert said(None, 9.9, 9.9) == "odometry: no odometry yet"
    assert said(at(0, 9.5), 9.9, 9.9) == "odometry: no odometry for 0.5 s"
    assert said(fresh, None, 9.9) == "frame: no matched colour and depth yet"
    assert said(fresh, 8.8, 9.9) == "frame: no matched colour and depth for 1.2 s"
    assert said(fresh, 9.9, 7.5) == "plan: the plan is 2.5 s old"


def test_what_is_just_as_old_as_it_may_be_is_driven_by():
    cfg = SafetyConfig(odom_stale_s=0.5, frame_stale_s=1.0, plan_stale_s=2.0)
    assert Guard(cfg).check(10.0, at(0, 9.5), 9.0, 8.0) is None


def moved(*poses: Pose, by_hand: bool = False, cfg: SafetyConfig = CFG) -> Halt | None:
    """What holds the base after odometry told of these, 0.05 s apart."""
    guard, told = Guard(cfg), at(0, 0)
    for n, pose in enumerate(poses):
        told = Odometry(pose, n, 10.0 + 0.05 * n)
        guard.watch(told, by_hand)
    return guard.check(told.arrival_s, told, told.arrival_s, told.arrival_s)


def test_a_jump_is_how_far_two_messages_are_apart_wherever_the_robot_is():
    assert moved(Pose(5.0, -7.0, 2.0), Pose(5.1, -7.1, 2.2)) is None
    told = moved(Pose(5.0, -7.0, 2.0), Pose(5.3, -6.6, 2.5))
    assert told == Halt(HaltKind.JUMP, "odometry jumped by 0.50 m, 0.50 rad")
    assert moved(Pose(5.0, -7.0, 2.0), Pose(5.0, -6.5, 2.0)) is not None
    assert moved(Pose(5.0, -7.0, 2.0), Pose(5.0, -7.0, 1.0)) is not None


def test_as_far_as_odometry_may_go_is_no_jump():
    cfg = SafetyConfig(odom_jump_m=0.5, odom_jump_rad=0.5)
    assert moved(Pose(0.0, 0.0, 0.0), Pose(0.5, 0.0, 0.0), cfg=cfg) is None
    assert moved(Pose(0.0, 0.0, 0.0), Pose(0.0, 0.0, 0.5), cfg=cfg) is None


def test_what_a_hand_moves_is_no_jump_but_its_clock_may_go_back():
    assert moved(Pose(0.0, 0.0, 0.0), Pose(3.0, 0.0, 2.0), by_hand=True) is None
    guard = Guard(CFG)
    guard.watch(at(0, 10.0, 5_000_000_000), by_hand=True)
    guard.watch(at(0.1, 10.05, 3_500_000_000), by_hand=True)
    halt = guard.check(10.05, at(0.1, 10.05), 10.05, 10.0)
    assert halt == Halt(HaltKind.CLOCK, "odometry's clock went back by 1.50 s")


def test_how_far_a_clock_went_back_is_told_to_the_hundredth_even_of_years():
    guard = Guard(CFG)
    guard.watch(at(0, 10.0, 30_000_000 * 10**9))
    guard.watch(at(0, 10.05, 10_000_000 * 10**9))
    halt = guard.check(10.05, at(0, 10.05), 10.05, 10.0)
    assert halt is not None
    assert halt.reason == "odometry's clock went back by 20000000.00 s"


def test_a_clock_that_stands_still_went_nowhere():
    guard = Guard(CFG)
    guard.watch(at(0, 10.0, 7))
    guard.watch(at(0.1, 10.05, 7))
    assert guard.check(10.05, at(0.1, 10.05), 10.05, 10.0) is None


def test_the_same_message_again_breaks_nothing():
    guard, told = Guard(CFG), at(0.6, 10.05)
    guard.watch(at(0, 10.0))
    guard.watch(told)
    assert guard.check(10.05, told, 10.05, 10.04) is not None
    assert guard.check(10.1, told, 10.1, 10.06) is None
    guard.watch(told)
    assert guard.check(10.1, told, 10.1, 10.05) is None


def test_control_that_comes_just_in_time_is_no_overrun_and_one_that_does_not_says_how_long():
    guard = Guard(CFG)
    guard.turn(0.0)
    guard.turn(OVERRUN_S)
    assert guard.check(0.3, at(0, 0.3), 0.3, 0.1) is None
    guard.turn(1.5)
    halt = guard.check(1.5, at(0, 1.5), 1.5, 1.5)
    assert halt == Halt(HaltKind.OVERRUN, "control stood still for 1.2 s")
    assert guard.check(1.6, at(0, 1.6), 1.6, 1.55) is None


def test_what_the_base_says_goes_before_what_is_doubted_and_both_before_what_is_stale():
    guard = Guard(CFG)
    base, doubt = Halt(HaltKind.BASE, "not armed"), Halt(HaltKind.STOP, "by hand")
    body = Halt(HaltKind.BUMPER, "bumper touches something")
    assert guard.check(10.0, None, None, 0.0, base=base, body=body, doubt=doubt) == base
    assert guard.check(10.0, None, None, 0.0, doubt=doubt, body=body) == doubt
    assert guard.check(10.1, at(0, 10.1), None, 10.1, body=body) == body
    assert guard.halts == {"base": 1, "stop": 1, "bumper": 1}


def test_a_body_that_met_something_waits_for_odometry_first():
    guard, body = Guard(CFG), Halt(HaltKind.BUMPER, "bumper touches something")
    halt = guard.check(10.0, at(0, 9.0), 10.0, 10.0, body=body)
    assert halt is not None
    assert halt.kind is HaltKind.ODOMETRY


def test_a_robot_that_does_not_drive_is_not_halted_as_far_as_the_counts_go():
    guard = Guard(CFG)
    assert guard.check(10.0, None, None, 10.0, driving=False) is not None
    assert guard.halts == {}
    assert guard.check(10.05, None, None, 10.0) is not None
    assert guard.halts == {"odometry": 1}


def test_a_plan_that_is_late_is_a_halt_of_its_own_where_nothing_was_missing_before():
    guard = Guard(CFG)
    assert kinds(guard, 10.0, at(0, 10.0), 10.0, 7.0) == "plan"
    assert kinds(guard, 10.05, at(0, 10.05), 10.0, 7.0) == "plan"
    assert guard.halts == {"plan": 1}
    assert kinds(guard, 10.1, at(0, 9.0, 10_100_000_000), 10.0, 10.1) == "odometry"
    assert kinds(guard, 10.15, at(0, 10.15), 10.1, 7.0) == "plan"
    assert kinds(guard, 10.2, at(0, 9.0, 10_200_000_000), 10.1, 10.1) == "odometry"
    assert guard.halts == {"plan": 1, "odometry": 1}  # it was missing all the while


def test_an_obstacle_that_another_halt_interrupts_is_counted_again():
    guard, ahead = Guard(CFG), Halt(HaltKind.OBSTACLE, "a leg")
    assert kinds(guard, 10.0, at(0, 10.0), 10.0, 10.0) == ""
    guard.caution(ahead)
    assert kinds(guard, 10.05, None, 10.0, 10.0) == "odometry"
    assert kinds(guard, 10.1, at(0, 10.1), 10.1, 10.1) == ""
    guard.caution(ahead)
    assert guard.halts == {"obstacle": 2, "odometry": 1}
    assert kinds(guard, 10.15, at(0, 10.15), 10.15, 10.15) == ""
    guard.caution(Halt(HaltKind.FLOOR, "a step"))
    assert guard.halts == {"obstacle": 2, "odometry": 1, "floor": 1}


def test_what_is_doubted_just_after_control_stood_still_is_due_to_that():
    guard, doubt = Guard(CFG), Halt(HaltKind.FRAME, "depth comes 1.0 s late by its stamps")
    guard.turn(-1.0)
    guard.turn(0.0)
    overrun = Halt(HaltKind.OVERRUN, "control stood still for 1.0 s")
    assert guard.check(0.0, at(0, 0.0), 0.0, 0.0, doubt=doubt) == overrun
    assert guard.check(0.29, at(0, 0.29), 0.29, 0.29, doubt=doubt) == overrun
    assert guard.check(OVERRUN_S, at(0, 0.3), 0.3, 0.3, doubt=doubt) == doubt
    assert Guard(CFG).check(0.0, at(0, 0.0), 0.0, 0.0, doubt=doubt) == doubt


@pytest.mark.parametrize("kind", HaltKind)
def test_what_holds_a_base_ever_since_is_told_but_for_what_is_in_its_way(kind: HaltKind):
    guard, halt, withheld = Guard(CFG), Halt(kind, ""), kind not in IN_THE_WAY

    def turn(now_s: float, holds: bool) -> None:
        guard.turn(now_s)
        fresh = now_s, at(0, now_s), now_s, now_s
        if kind in (HaltKind.OBSTACLE, HaltKind.FLOOR):
            guard.check(*fresh)
            if holds:
                guard.caution(halt)
        else:
            guard.check(*fresh, doubt=halt if holds else None)

    told = []
    for n, holds in enumerate((False, True, True, True, False, True)):
        turn(10.0 + 0.05 * n, holds)
        if n != 2:
            told.append(guard.held())
    assert told == [False, False, withheld, False, False]
    assert guard.held() is withheld  # as it stands, where no turn was since
    guard.turn(10.3)
    guard.check(10.3, at(0, 10.3), 10.3, 10.3, driving=False, doubt=halt)
    assert guard.held() is False
