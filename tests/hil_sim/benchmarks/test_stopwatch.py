"""Stages are timed where they are called, and only meanwhile."""

import math

import pytest
from apartment import MOUNT, TWO_ROOMS, Apartment

from hil_sim.benchmarks.stopwatch import STAGES, ReferenceWork, StageTimes
from runtime import navigate
from runtime.core.mapping import grid
from runtime.core.types import Pose
from runtime.core.world import World

NAMES = ("toilet", "sofa", "bed")


def test_every_stage_of_a_frame_is_timed_once_a_frame():
    home = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, 0.0))
    home.things = {"bed": (5.2, 3.2, 0.3)}
    world = World.begin("toilet", NAMES, (), home.pose, 0.18)
    times, before = StageTimes(), grid.integrate
    with times.watching():
        for _ in range(3):
            obs = home.observe()
            cfg = navigate.NavigateConfig()
            navigate.perceive(world, obs, home.detect(NAMES, obs), MOUNT, cfg)
            times.next_frame()
    assert grid.integrate is before
    for stage in set(STAGES) - {"keyframe"}:  # there is no embedding of the whole image
        assert len(times.seconds[stage]) == 3
        assert 0 < times.median_ms(stage) <= times.p99_ms(stage)
    assert times.median_ms("of that, terrain") < times.median_ms("terrain and distances")
    assert math.isnan(times.median_ms("keyframe"))


def test_what_fails_is_timed_too():
    times = StageTimes()
    with pytest.raises(ZeroDivisionError):
        times.timed("broken", lambda: 1 // 0)()
    times.next_frame()
    assert len(times.seconds["broken"]) == 1


def test_the_reference_is_work():
    times = StageTimes()
    work = times.timed("reference", ReferenceWork())
    for _ in range(5):
        work()
        times.next_frame()
    assert 0.05 < times.median_ms("reference") < 100
