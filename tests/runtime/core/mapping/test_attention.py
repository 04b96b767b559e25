"""Which image is looked at next, where the detector is slower than the camera."""

import math

import numpy as np
import pytest

from runtime.core.mapping.attention import KEPT, WORTH, Attention, View, view_of
from runtime.core.types import Pose


def fan(pose: Pose, reach_m: float, half_rad: float = 0.6) -> np.ndarray:
    """An outline of free floor as far as `reach_m` all over the view."""
    azimuths = pose.yaw_rad + np.linspace(-half_rad, half_rad, 160)
    rim = np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1) * reach_m
    return np.concatenate([[pose.xy], pose.xy + rim])


def seen(yaw: float = 0.0, x: float = 0.0, reach_m: float = 3.0) -> View:
    pose = Pose(x, 0.0, yaw)
    return view_of(fan(pose, reach_m), pose)


def strip(first: int, n: int) -> View:
    """`n` patches in a row, from a given one on."""
    return View(frozenset(range(first, first + n)), 0)


def test_a_view_is_as_many_patches_as_its_floor_has_no_farther_than_things_are_recognised():
    area_m2 = 0.6 * 3.3**2
    assert len(seen().patches) == pytest.approx(area_m2 / 0.25**2, rel=0.25)
    assert seen(reach_m=30.0).patches == seen(reach_m=5.0).patches
    assert len(seen(reach_m=0.2).patches) >= 1  # before a wall there is still the wall


def test_a_view_that_passes_by_while_the_detector_is_busy_is_looked_at():
    """One image a fifth of a second, a look of three seconds: the robot turns past a doorway, and
    what it faces before and after is known."""
    attention: Attention[str] = Attention()
    for n in range(4):
        attention.offer(f"known {n}", seen())
        attention.take()
    for n in range(15):
        door = n in (5, 6)
        yaw, reach_m = (math.pi / 2, 4.0) if door else (0.0, 3.0)
        attention.offer(f"{'door' if door else 'known'} {n}", seen(yaw, reach_m=reach_m))
    looked = [attention.take(), attention.take()]
    assert [name.split()[0] for name in looked if name] == ["door", "known"]
    assert looked[1] == "known 14"


def test_of_too_many_the_one_goes_that_adds_least_to_the_others():
    attention: Attention[str] = Attention()
    attention.offer("lone", strip(1000, 10))
    for n in range(KEPT):
        attention.offer(f"alike {n}", strip(n, 30))
    kept = [w.item for w in attention.waiting]
    assert len(kept) == KEPT
    assert "lone" in kept
    assert kept[-1] == f"alike {KEPT - 1}"


def test_every_other_look_is_at_the_newest_whatever_waits():
    attention: Attention[int] = Attention()
    for n in range(4):
        attention.offer(n, strip(1000 * n, 100 - n))
    first = attention.take()
    attention.offer(9, strip(0, 1))
    second = attention.take()
    third = attention.take()
    assert (first, second, third) == (0, 9, 1)


def test_old_ones_that_show_nothing_new_any_more_are_forgotten_and_the_newest_is_looked_at():
    attention: Attention[int] = Attention()
    for n in range(4):
        attention.offer(n, strip(0, 30))
    assert attention.news()
    assert attention.take() is not None
    assert not attention.news()
    attention.offer(7, strip(0, 30))
    assert attention.take() == 7
    assert attention.take() is None


def test_the_newest_is_taken_where_it_is_what_matters():
    attention: Attention[int] = Attention()
    attention.offer(0, strip(0, 100))
    attention.offer(1, strip(0, 10))
    assert attention.take(newest=True) == 1
    alone: Attention[int] = Attention(newest_only=True)
    alone.offer(0, strip(0, 100))
    alone.offer(1, strip(0, 10))
    assert (alone.take(), alone.take()) == (1, None)


def test_the_other_side_of_what_was_looked_at_is_worth_less_than_what_was_not():
    attention: Attention[int] = Attention()
    attention.offer(0, View(frozenset(range(40)), 0))
    attention.take()
    behind, new = View(frozenset(range(40)), 4), View(frozenset(range(100, 140)), 0)
    assert attention.novelty(View(frozenset(range(40)), 0)) == 0
    assert WORTH < attention.novelty(behind) < attention.novelty(new)
