"""What is told of odometry beside the images of a turn: each fault by its own words."""

import itertools
import math
from collections.abc import Callable

import pytest

from runtime.doctor.diagnosis import Diagnosis, Grade
from runtime.doctor.hearing import HeardPose
from runtime.doctor.sight import SeenTurn
from runtime.doctor.turning import judge_middle, judge_turning

S = 10**9
RATE, RAMP_S, STANDS_S = 0.6, 0.2, 1.0
TURN_S = math.tau / RATE
IMAGE_S, ODOM_S = 0.1, 0.05


def yaw_at(t_s: float) -> float:
    """At rest, then round with a ramp, then at rest."""
    moving = min(max(t_s - STANDS_S, 0.0), TURN_S)
    ramp = min(moving, RAMP_S)
    return RATE * (ramp * ramp / (2 * RAMP_S) + (moving - ramp))


END_S = 2 * STANDS_S + TURN_S


def seen(yaw: Callable[[float], float] = yaw_at) -> list[SeenTurn]:
    times = [n * IMAGE_S for n in range(round(END_S / IMAGE_S))]
    return [
        SeenTurn(round(a * S), round(b * S), yaw(b) - yaw(a)) for a, b in itertools.pairwise(times)
    ]


def about_z(yaw: float) -> tuple[float, float, float, float]:
    return 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)


def told(
    yaw: Callable[[float], float] = yaw_at,
    quaternion: Callable[[float], tuple[float, float, float, float]] = about_z,
    xy: Callable[[float], tuple[float, float]] = lambda yaw: (0.0, 0.0),
    step_s: float = ODOM_S,
) -> list[HeardPose]:
    times = [n * step_s for n in range(round(END_S / step_s))]
    return [
        HeardPose(round(t * S), "odom", "base_link", xy(yaw(t)), quaternion(yaw(t))) for t in times
    ]


def found(
    odometry: list[HeardPose], images: list[SeenTurn], commanded: float | None = None
) -> dict[str, Diagnosis]:
    return {one.about: one for one in judge_turning(odometry, images, commanded)}


def test_odometry_that_is_right():
    judged = found(told(), seen(), math.tau)
    assert {one.grade for one in judged.values()} == {Grade.OK}
    assert "1.000 of it" in judged["turning"].told


@pytest.mark.parametrize("commanded", [None, math.tau])
def test_the_wrong_sign(commanded: float | None):
    judged = found(told(lambda t: -yaw_at(t)), seen(), commanded)["turning"]
    assert judged.grade is Grade.BAD
    assert "the other way" in judged.told
    assert "counter-clockwise is positive (REP 103)" in judged.remedy
    assert ("upside down" in judged.remedy) is (commanded is None)


def test_a_camera_upside_down_is_told_from_it_by_what_the_base_was_told():
    judged = found(told(), seen(lambda t: -yaw_at(t)), math.tau)["turning"]
    assert judged.grade is Grade.BAD
    assert judged.settings == (("camera.roll_rad", "3.1416"),)


def test_a_base_that_turns_the_wrong_way_is_told_from_both():
    judged = found(told(lambda t: -yaw_at(t)), seen(lambda t: -yaw_at(t)), math.tau)["turning"]
    assert judged.grade is Grade.BAD
    assert "angular.z" in judged.remedy


@pytest.mark.parametrize("step_s", [0.02, 0.05, 0.1])
def test_degrees_for_radians_whatever_turns_are_lost_between_two_messages(step_s: float):
    judged = found(told(lambda t: math.degrees(yaw_at(t)), step_s=step_s), seen())["turning"]
    assert judged.grade is Grade.BAD
    assert judged.told == "odometry's yaw is in degrees where radians belong"
    wrong = found(told(lambda t: -math.degrees(yaw_at(t)), step_s=step_s), seen())["turning"]
    assert wrong.told.endswith("and of the wrong sign")


def test_radians_made_of_radians():
    judged = found(told(lambda t: math.radians(yaw_at(t))), seen())["turning"]
    assert judged.grade is Grade.BAD
    assert "a fifty-seventh" in judged.told


def test_a_frame_with_another_axis_up():
    def about_y(yaw: float) -> tuple[float, float, float, float]:
        return 0.0, math.sin(yaw / 2), 0.0, math.cos(yaw / 2)

    def about_x(yaw: float) -> tuple[float, float, float, float]:
        return math.sin(yaw / 2), 0.0, 0.0, math.cos(yaw / 2)

    judged = found(told(quaternion=about_x), seen())["turning"]
    assert judged.grade is Grade.BAD
    assert "optical frame" in judged.remedy
    assert found(told(quaternion=about_y), seen())["turning"].grade is Grade.BAD


def test_odometry_that_stands_still():
    judged = found(told(lambda t: 0.3), seen())["turning"]
    assert judged.grade is Grade.BAD
    assert "it does not turn" in judged.told


@pytest.mark.parametrize("ratio", [0.8, 1.25])
def test_a_ratio_that_is_off_is_told_with_what_mends_it(ratio: float):
    judged = found(told(lambda t: ratio * yaw_at(t)), seen())["turning"]
    assert judged.grade is Grade.WARNING
    assert f"by {ratio:.3f}" in judged.remedy


@pytest.mark.parametrize("lag_s", [-0.3, 0.16, 0.4])
def test_a_lag_is_told_apart_from_a_ratio(lag_s: float):
    judged = found(told(lambda t: yaw_at(t - lag_s)), seen())
    assert judged["turning"].grade is Grade.OK
    lag = judged["turning in time"]
    assert lag.grade is Grade.WARNING
    assert lag.told.startswith("odometry tells" if lag_s > 0 else "the images tell")
    milliseconds = float(lag.told.split(" ms")[0].split()[-1])
    assert milliseconds == pytest.approx(1e3 * abs(lag_s), abs=41)


def test_a_turn_without_ends_tells_of_no_lag():
    judged = found(told(lambda t: RATE * t), seen(lambda t: RATE * t))
    assert judged["turning"].grade is Grade.OK
    assert judged["turning in time"].grade is Grade.UNKNOWN


def test_what_has_nothing_to_do_with_the_images():
    judged = found(told(lambda t: 0.8 * math.sin(3 * t)), seen())["turning"]
    assert judged.grade is Grade.BAD
    assert "likeness" in judged.told


def test_without_a_turn_nothing_is_known_unless_one_was_commanded():
    rest, still = seen(lambda t: 0.0), told(lambda t: 0.0)
    judged = found(still, rest)["turning"]
    assert judged.grade is Grade.UNKNOWN
    assert "--turn" in judged.remedy
    deaf = found(still, rest, math.tau)["turning"]
    assert deaf.grade is Grade.BAD
    assert "did not" in deaf.told
    frozen = found(told(), rest, math.tau)["turning"]
    assert frozen.grade is Grade.BAD
    assert "images stand still" in frozen.remedy
    assert found(told(), [])["turning"].grade is Grade.UNKNOWN
    assert found([], seen())["turning"].grade is Grade.UNKNOWN


@pytest.mark.parametrize(
    ("ahead_m", "grade"), [(0.0, Grade.OK), (0.03, Grade.OK), (0.22, Grade.WARNING)]
)
def test_the_point_that_the_base_turns_about(ahead_m: float, grade: Grade):
    (judged,) = judge_middle(
        told(xy=lambda yaw: (3.0 + ahead_m * math.cos(yaw), ahead_m * math.sin(yaw)))
    )
    assert judged.grade is grade
    if grade is Grade.WARNING:
        assert "0.22 m ahead and 0.00 m left" in judged.told


def test_without_a_turn_it_is_not_said_what_it_turns_about():
    assert list(judge_middle(told(lambda t: 0.0))) == []
