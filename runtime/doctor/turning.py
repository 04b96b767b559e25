"""What odometry tells of a turn, against what the images show of it and what the base was told."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from runtime.core.types import F64
from runtime.doctor.diagnosis import Diagnosis, bad, ok, unknown, warning
from runtime.doctor.hearing import HeardPose
from runtime.doctor.sight import SeenTurn

LEAST_RAD: Final = 0.35  # that the images have to turn, in all, before anything is said
LIKE: Final = 0.7  # correlation of the two, at least, for them to tell of one turn
EXACT: Final = 0.1  # that the ratio of the two is off
LAG_S: Final = 0.08  # at 1 rad/s five degrees
ONE_WAY: Final = 0.9  # of all turning, from which on it was to one side
LAGS_S: Final = 0.6  # that are tried, both ways, in steps of
LAG_STEP_S: Final = 0.02
UNEVEN: Final = 0.25  # spread of the rate of turning, as a share, without which no lag is seen
ASIDE_M: Final = 0.05  # that the point told of lies beside the one that the base turns about
ALIKE_STEPS: Final = 0.6  # mean cosine between steps told and steps expected
_NS: Final = 1e-9


@dataclass(frozen=True)
class ToldTurn:
    """Of a stretch of odometry: its times (N,) s, its yaw unwrapped and the whole rotation, rad,
    (N,) each."""

    times_s: F64
    yaw_rad: F64
    whole_rad: F64


@dataclass(frozen=True)
class TurnMatch:
    """How odometry follows the images: `ratio` of its turning to theirs; `like`: how well that
    ratio explains it, 0 to 1; `lag_s`: how much later it tells of it by its stamps, None where the
    turning was too even to say."""

    ratio: float
    like: float
    lag_s: float | None


def told_by(odometry: Sequence[HeardPose]) -> ToldTurn:
    """Odometry in the order of its stamps."""
    poses = sorted(odometry, key=lambda pose: pose.stamp_ns)
    times = np.array([pose.stamp_ns for pose in poses], np.float64) * _NS
    yaws = np.unwrap(np.array([pose.yaw_rad for pose in poses], np.float64))
    q = np.array([pose.quaternion for pose in poses], np.float64).reshape(-1, 4)
    steps = np.abs((q[1:] * q[:-1]).sum(axis=1)).clip(0, 1) if len(q) else np.zeros(0)
    whole = np.concatenate([[0.0], np.cumsum(2 * np.arccos(steps))])[: len(q)]
    return ToldTurn(times, np.asarray(yaws, np.float64), np.asarray(whole, np.float64))


def judge_turning(
    odometry: Sequence[HeardPose],
    seen: Sequence[SeenTurn],
    commanded_rad: float | None = None,
) -> Iterator[Diagnosis]:
    """`commanded_rad`: what the base was told to turn, counter-clockwise; None where nobody knows.
    Odometry and images of the same stretch of time."""
    shown_rad = sum(turn.turn_rad for turn in seen)
    moved_rad = sum(abs(turn.turn_rad) for turn in seen)
    told = told_by(odometry)
    if len(told.times_s) < 3 or not seen:
        why = "too little texture in the images, or too few" if odometry else "there is no odometry"
        yield unknown("turning", why, "face something with texture, and run rfnav doctor --turn")
        return
    here = _at_images(told, seen)
    turned_rad = float(here.sum())
    if moved_rad < LEAST_RAD:
        yield _hardly(moved_rad, commanded_rad, told)
        return
    if commanded_rad is not None and shown_rad * commanded_rad < 0 < turned_rad * shown_rad:
        yield bad(
            "turning",
            f"told to turn left, the base turned right, by images and odometry ({_deg(shown_rad)})",
            "swap the sign of angular.z in the base's driver: positive is counter-clockwise "
            "(REP 103)",
        )
        return
    yield from _compared(told, seen, matched(told, seen), commanded_rad)


def _hardly(moved_rad: float, commanded_rad: float | None, told: ToldTurn) -> Diagnosis:
    turned_rad = float(np.ptp(told.yaw_rad))
    if commanded_rad is None:
        why = f"the robot turned by {_deg(moved_rad)} only"
        return unknown("turning", why, "run rfnav doctor --turn, or turn it by hand meanwhile")
    if turned_rad > LEAST_RAD:
        return bad(
            "turning",
            f"odometry turned by {_deg(turned_rad)}, the images by {_deg(moved_rad)}",
            "the camera's images stand still, or the wheels slip: look at both",
        )
    return bad(
        "turning",
        f"the base was told to turn by {_deg(abs(commanded_rad))} and did not",
        "is it armed, its emergency stop released, and cmd_vel of the right type "
        "(bus.cmd_vel_type)?",
    )


def _at_images(told: ToldTurn, seen: Sequence[SeenTurn], lag_s: float = 0.0) -> F64:
    """(N,) rad that odometry turned between the same images."""
    begin = np.array([turn.from_ns for turn in seen], np.float64) * _NS + lag_s
    end = np.array([turn.to_ns for turn in seen], np.float64) * _NS + lag_s
    yaw = np.interp(end, told.times_s, told.yaw_rad) - np.interp(begin, told.times_s, told.yaw_rad)
    return np.asarray(yaw, np.float64)


def matched(told: ToldTurn, seen: Sequence[SeenTurn]) -> TurnMatch:
    """The lag at which odometry's turning is most like the images', and how like it is there."""
    shown = np.array([turn.turn_rad for turn in seen], np.float64)
    spans = np.array([(turn.to_ns - turn.from_ns) * _NS for turn in seen], np.float64)
    square = float(shown @ shown)
    best: tuple[float, float, float] | None = None
    steps = round(LAGS_S / LAG_STEP_S)
    for n in sorted(range(-steps, steps + 1), key=abs):
        lag_s = n * LAG_STEP_S
        turned = _at_images(told, seen, lag_s)
        ratio = float(turned @ shown) / square
        size = float(turned @ turned)
        like = abs(ratio) * math.sqrt(square / size) if size > 0 else 0.0
        if best is None or like > best[1] + 1e-4:
            best = ratio, like, lag_s
    assert best is not None  # there is a lag of 0
    rates = shown / spans
    uneven = float(rates.std()) > UNEVEN * float(np.abs(rates).mean())
    ratio, like, lag_s = best
    if abs(shown.sum()) > ONE_WAY * np.abs(shown).sum():  # sums do not know of late stamps
        ratio = float(_at_images(told, seen, lag_s).sum() / shown.sum())
    return TurnMatch(ratio, min(1.0, like), lag_s if uneven else None)


def _compared(
    told: ToldTurn, seen: Sequence[SeenTurn], found: TurnMatch, commanded_rad: float | None
) -> Iterator[Diagnosis]:
    shown_rad = sum(turn.turn_rad for turn in seen)
    turned_rad = float(_at_images(told, seen).sum())
    both = f"odometry turned by {_deg(turned_rad)}, the images by {_deg(shown_rad)}"
    if sign := _in_degrees(told, seen):
        wrong = "" if sign > 0 else ", and of the wrong sign"
        yield bad(
            "turning",
            f"odometry's yaw is in degrees where radians belong{wrong}",
            "have the base's driver make its quaternion of radians",
        )
    elif found.like < LIKE or abs(found.ratio) < 0.1:
        yield _unlike(told, seen, both, found)
    elif found.ratio < 0:
        yield _other_way(both, turned_rad, shown_rad, commanded_rad)
    elif abs(found.ratio - 1) > EXACT:
        yield warning(
            "turning",
            f"{both}: {found.ratio:.2f} of it",
            f"multiply the wheels' separation in the base's driver by {found.ratio:.3f}; where "
            "that is right, the camera's K is not",
        )
    else:
        yield ok("turning", f"{both}: {found.ratio:.3f} of it")
    if found.like >= LIKE and abs(found.ratio) >= 0.1:
        yield from _lagging(found.lag_s)


def _lagging(lag_s: float | None) -> Iterator[Diagnosis]:
    if lag_s is None:
        yield unknown("turning in time", "the robot turned too evenly to see whether one lags")
    elif abs(lag_s) > LAG_S:
        late_ms = 1e3 * abs(lag_s)
        told = f"odometry tells of it {late_ms:.0f} ms after the images"
        if lag_s < 0:
            told = f"the images tell of it {late_ms:.0f} ms after odometry"
        yield warning(
            "turning in time",
            f"{told}, by their stamps",
            "have the later one stamped when it is measured, not when it is sent, and synchronise "
            "the clocks of camera and base",
        )
    else:
        yield ok("turning in time", f"within {1e3 * max(LAG_STEP_S, abs(lag_s)):.0f} ms")


def _in_degrees(told: ToldTurn, seen: Sequence[SeenTurn]) -> int:
    """1 or -1 where each step of odometry is the images' in degrees, taken for radians, whatever
    whole turns are lost between two messages; 0 where it is not."""
    times = np.array([seen[0].from_ns, *(turn.to_ns for turn in seen)], np.float64) * _NS
    shown = np.concatenate([[0.0], np.cumsum([turn.turn_rad for turn in seen])])
    expected = np.diff(np.interp(told.times_s, times, shown))
    stepped = np.diff(told.yaw_rad)
    moving = np.abs(expected) > 0.2 * float(np.abs(expected).max(initial=0.0))
    moving &= np.abs(expected) > 1e-4
    if moving.sum() < 5:
        return 0
    degrees, steps = np.degrees(expected[moving]), stepped[moving]
    alike = {sign: float(np.cos(steps - sign * degrees).mean()) for sign in (1, -1)}
    sign = max(alike, key=alike.__getitem__)
    plain = max(float(np.cos(steps - way * expected[moving]).mean()) for way in (0, 1, -1))
    large = float(np.median(np.abs(steps))) > 5 * float(np.median(np.abs(expected[moving])))
    return sign if large and alike[sign] > max(ALIKE_STEPS, plain) else 0


def _unlike(told: ToldTurn, seen: Sequence[SeenTurn], both: str, found: TurnMatch) -> Diagnosis:
    moved_rad = sum(abs(turn.turn_rad) for turn in seen)
    yaw_rad = float(np.abs(np.diff(told.yaw_rad)).sum())
    whole_rad = float(told.whole_rad[-1])
    if yaw_rad < 0.1 * moved_rad and whole_rad > 0.5 * moved_rad:
        return bad(
            "turning",
            f"{both}, but it turns by {_deg(whole_rad)} about another axis than up",
            "odometry is told in a camera's optical frame: publish it of the base, z up (REP 103)",
        )
    if 0.5 < yaw_rad / moved_rad * math.degrees(1.0) < 2.0:
        return bad(
            "turning",
            f"{both}: about a fifty-seventh of it",
            "the base's driver makes radians of radians: convert its yaw once",
        )
    if yaw_rad < 0.1 * moved_rad:
        return bad(
            "turning",
            f"{both}: it does not turn",
            "odometry stands still: is it of this base, and does its driver read its wheels?",
        )
    return bad(
        "turning",
        f"{both}, and not at the same times (likeness {found.like:.2f})",
        "look at the clocks of base and camera, and whether odometry is of this robot",
    )


def _other_way(
    both: str, turned_rad: float, shown_rad: float, commanded_rad: float | None
) -> Diagnosis:
    if commanded_rad is not None and shown_rad * commanded_rad < 0:
        return bad(
            "turning",
            f"{both}; odometry goes the way that the base was told to, the images do not",
            "the camera hangs upside down, or its images are mirrored: camera.roll_rad is pi then",
            ("camera.roll_rad", f"{math.pi:.4f}"),
        )
    why = "" if commanded_rad is None else "; the images go the way that the base was told to"
    return bad(
        "turning",
        f"{both}: the other way{why}",
        "swap the sign of yaw in the base's odometry: counter-clockwise is positive (REP 103)"
        + ("" if commanded_rad is not None else "; or the camera hangs upside down"),
    )


def judge_middle(odometry: Sequence[HeardPose]) -> Iterator[Diagnosis]:
    """Whether the point that odometry tells of is the one that the base turns about: of a turn on
    the spot."""
    told = told_by(odometry)
    if len(told.times_s) < 10 or float(np.ptp(told.yaw_rad)) < math.pi / 2:
        return
    poses = sorted(odometry, key=lambda pose: pose.stamp_ns)
    xy = np.array([pose.xy for pose in poses], np.float64)
    c, s, one, zero = (
        np.cos(told.yaw_rad),
        np.sin(told.yaw_rad),
        np.ones(len(xy)),
        np.zeros(len(xy)),
    )
    rows = np.concatenate(
        [np.stack([one, zero, c, -s], axis=1), np.stack([zero, one, s, c], axis=1)]
    )
    ahead_m, left_m = np.linalg.lstsq(rows, np.concatenate([xy[:, 0], xy[:, 1]]), rcond=None)[0][2:]
    aside_m = math.hypot(ahead_m, left_m)
    if aside_m > ASIDE_M:
        yield warning(
            "turning about",
            f"odometry is of a point {ahead_m:.2f} m ahead and {left_m:.2f} m left of the one that "
            "the base turns about",
            "publish odometry of the middle between the driven wheels (base_link), not of a camera",
        )
    else:
        yield ok(
            "turning about", f"the point that odometry tells of, within {100 * aside_m:.0f} cm"
        )


def _deg(angle_rad: float) -> str:
    return f"{math.degrees(angle_rad):.0f} degrees"
