"""Each finding about the camera, of hearings made up by hand."""

from dataclasses import replace

import numpy as np
import pytest
from hearings import FRAME, LEVEL, came, healthy

from runtime.config import Config
from runtime.doctor.camera import judge_camera
from runtime.doctor.diagnosis import Diagnosis, Grade
from runtime.doctor.hearing import HeardInfo, HeardTopic, Hearing

CONFIG = Config()


def found(hearing: Hearing) -> dict[str, Diagnosis]:
    return {one.about: one for one in judge_camera(hearing, CONFIG)}


def again(hearing: Hearing, name: str, **how: float) -> Hearing:
    before = hearing.streams[name]
    fresh = came(replace(before, arrivals=[], received=0), **how)
    return replace(hearing, streams={**hearing.streams, name: fresh})


def test_a_healthy_camera():
    told = found(healthy(CONFIG))
    assert {one.grade for one in told.values()} == {Grade.OK}
    assert told["pairs"].told.startswith("100% of the images have colour and depth within 20 ms")
    assert told["frames"].told == "50 of 50 depth images became a frame of the map"
    assert told["registration"].told == (
        f'depth and colour are both in "{FRAME}"; frames are 160x120'
    )


def test_without_depth_nothing_is_said_of_pairs():
    hearing = healthy(CONFIG)
    streams = dict(hearing.streams)
    streams["depth"] = HeardTopic("depth", "sensor_msgs/msg/Image")
    assert found(replace(hearing, streams=streams)) == {}


@pytest.mark.parametrize(
    ("late_s", "grade"), [(0.0, Grade.OK), (0.015, Grade.OK), (0.035, Grade.BAD)]
)
def test_pairs_are_judged_by_the_runtimes_own_tolerance(late_s: float, grade: Grade):
    told = found(again(healthy(CONFIG), "depth", hz=10.0, clock_s=late_s))
    assert told["pairs"].grade is grade
    if grade is Grade.BAD:
        assert "35 ms apart at the median" in told["pairs"].told


def test_some_pairs_are_few():
    told = found(again(healthy(CONFIG), "depth", hz=11.0))
    assert told["pairs"].grade is Grade.WARNING


def test_frames_that_do_not_come_have_the_runtimes_own_words():
    topic = CONFIG.bus.topics.depth
    for change, remedy in (
        ({"errors": {topic: "depth: publish depth registered"}}, "depth: publish depth registered"),
        ({"held": "odom is 2.00 s behind"}, "odom is 2.00 s behind"),
        ({}, "mend pairs, clocks and odometry's rate"),
    ):
        told = found(replace(healthy(CONFIG), frames=0, **change))["frames"]
        assert (told.grade, told.remedy) == (Grade.BAD, remedy)
    assert found(replace(healthy(CONFIG), frames=20))["frames"].grade is Grade.WARNING


def test_depth_in_another_frame_is_taken_to_colours_pixels_where_frames_come():
    hearing = healthy(CONFIG)
    hearing.streams["depth"].frame = "camera_depth_optical_frame"
    told = found(hearing)["registration"]
    assert told.grade is Grade.OK
    assert told.told.startswith(
        'depth is in "camera_depth_optical_frame" and colour is in "camera_c'
    )
    assert "registration" not in found(replace(hearing, frames=0))


def test_stamps_that_stand_still_tell_of_no_pairs():
    hearing = healthy(CONFIG)
    for name in ("color", "depth"):
        hearing.streams[name].arrivals = [
            replace(one, stamp_ns=0) for one in hearing.streams[name].arrivals
        ]
    assert found(hearing)["pairs"].grade is Grade.UNKNOWN


def test_a_bent_lens_is_told_of():
    info = HeardInfo(LEVEL, FRAME, "plumb_bob", (-0.3, 0.1, 0.0, 0.0, 0.0))
    told = found(replace(healthy(CONFIG), info=info))["lens"]
    assert told.grade is Grade.OK
    assert told.told.endswith("plumb_bob distortion -0.3, 0.1, 0, 0, 0 is undone")
    straight = replace(healthy(CONFIG), info=HeardInfo(LEVEL, FRAME, "plumb_bob", (0.0,) * 5))
    assert found(straight)["lens"].grade is Grade.OK


@pytest.mark.parametrize(
    ("depth_m", "share", "grade"),
    [(2.0, 1.0, Grade.OK), (2.0, 0.1, Grade.WARNING), (2.0, 0.0, Grade.BAD)],
)
def test_readings_are_judged_by_how_many_and_how_far(depth_m: float, share: float, grade: Grade):
    depth = np.zeros((120, 160), np.float32)
    depth[: round(120 * share)] = depth_m
    assert found(replace(healthy(CONFIG), depths=[depth] * 3))["depth readings"].grade is grade
