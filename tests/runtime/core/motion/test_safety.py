"""What holds the base, and what lets it go again."""

from hypothesis import given
from hypothesis import strategies as st

from runtime.core.motion.safety import OVERRUN_S, Guard, Halt, HaltKind, Odometry, SafetyConfig
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
