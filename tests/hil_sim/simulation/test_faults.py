"""Faults by name, and what they do to what is sensed, to bodies and to the base."""

import math
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from manual_clock import ManualClock
from places import ROOT

from hil_sim.driving.faulty_runtime import Babbling, cloud_settings, down, nonsense
from hil_sim.scenes.format import Door, Room, Scene
from hil_sim.simulation.body import (
    PERSON_RADIUS_M,
    POLITE_M,
    Body,
    body_of,
    closed_door,
    person_near,
    walk,
)
from hil_sim.simulation.faults import KINDS, Fault, Sensed, When, model_fault, parse_faults
from hil_sim.simulation.mishaps import Mishaps
from runtime import config as configuration
from runtime.clock import Deadline
from runtime.core.types import Brief, FrontierBrief, Missing, NearbyObject, Pose
from runtime.errors import ConfigError
from runtime.experts.cloud import Cloud

ROOM = Room("r", "kitchen", ((0, 0), (6, 0), (6, 6), (0, 6)))
DOORS = (Door((2.0, 0.0), (3.0, 0.0)), Door((0.0, 4.0), (0.0, 4.9), 2.0))
SINK = NearbyObject("sink", 0.9, 0.5)
SCENE = Scene("s", (), DOORS, (ROOM,), ())


class Box:
    """A room of 6 m x 6 m."""

    def move(self, x: float, y: float, yaw: float, distance: float) -> tuple[float, float, bool]:
        steps = max(1, math.ceil(distance / 0.025))
        for n in range(steps):
            ahead = x + distance / steps * math.cos(yaw), y + distance / steps * math.sin(yaw)
            if not (0.2 < ahead[0] < 5.8 and 0.2 < ahead[1] < 5.8):
                return x, y, n < steps
            x, y = ahead
        return x, y, False

    def falls(self, x: float, y: float) -> bool:
        return False


def test_the_floor_opens_ahead_once_there_is_room_and_closes_again() -> None:
    fault, shown = mishaps("stairwell:at=2,for=3")
    fault.move_bodies(When(1, 0.0), Pose(1.0, 3.0, 0.0))
    assert shown[-1] == ()
    fault.move_bodies(When(2, 0.5), Pose(5.5, 3.0, 0.0))  # a wall ahead, and to either side
    fault.move_bodies(When(3, 1.0), Pose(1.0, 3.0, 0.0))
    (opening,) = shown[-1]
    assert (opening.kind, opening.x_m, opening.y_m) == ("opening", pytest.approx(3.2), 3.0)
    fault.move_bodies(When(4, 1.5), Pose(1.25, 3.0, 0.0))
    assert shown[-1] == (opening,)  # it stays where it is
    fault.move_bodies(When(5, 2.0), Pose(1.5, 3.0, 0.0))
    assert shown[-1] == ()


def mishaps(*texts: str) -> tuple[Mishaps, list[tuple[Body, ...]]]:
    shown: list[tuple[Body, ...]] = []
    found = Mishaps(parse_faults(texts), 0, "e", SCENE, Box(), shown.append)
    return found, shown


def frames(count: int, step_s: float = 0.5) -> Iterator[tuple[When, Sensed]]:
    for n in range(1, count + 1):
        rgb, depth = np.full((2, 2, 3), n, np.uint8), np.full((2, 2), n, np.float32)
        yield When(n, (n - 1) * step_s), Sensed(rgb, depth, Pose(float(n), 0, 0), n * 10**9)


def sent(text: str, count: int = 8) -> list[Sensed | None]:
    found, _ = mishaps(text)
    return [found.sense(when, sensed) for when, sensed in frames(count)]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("camera-frieze", r"^fault camera-frieze: unknown; known: camera-freeze, .*, cloud-down$"),
        ("camera-drop:size=3", r"^fault camera-drop: parameter 'size': unknown; it takes at, for$"),
        ("llm-hang:at=3", r"^fault llm-hang: parameter 'at': unknown; it takes none$"),
        ("camera-drop:at=soon", r"^fault camera-drop: at=soon: must be a number of observations"),
        ("camera-drop:for=-1", r"^fault camera-drop: for=-1: must be"),
        ("odometry-jump:size=far", r"^fault odometry-jump: size=far: must be a number \(metres"),
        ("person:size=0", r"^fault person: size=0: must be"),
        ("cloud-down:at=3", r"^fault cloud-down: parameter 'at': unknown; it takes none$"),
        ("", r"^fault : unknown"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(text: str, says: str) -> None:
    with pytest.raises(ConfigError, match=says):
        parse_faults([text])


@given(st.sampled_from(list(KINDS)), st.text(max_size=20))
def test_nothing_but_a_config_error_leaves_the_parser(name: str, rest: str) -> None:
    try:
        found = parse_faults([f"{name}:{rest}"])
    except ConfigError:
        return
    assert [type(fault) for fault in found] == [Fault]


def test_a_frozen_camera_repeats_its_image_with_new_stamps() -> None:
    found = sent("camera-freeze:at=3,for=4")
    assert [int(s.rgb[0, 0, 0]) for s in found if s] == [1, 2, 3, 3, 3, 3, 7, 8]
    assert [s.depth_m[0, 0] for s in found if s] == [1, 2, 3, 3, 3, 3, 7, 8]
    assert [s.stamp_ns // 10**9 for s in found if s] == list(range(1, 9))


def test_times_in_seconds() -> None:
    found = sent("camera-freeze:at=1s,for=1s")  # observations come at 0, 0.5, 1.0, ... s
    assert [int(s.rgb[0, 0, 0]) for s in found if s] == [1, 2, 3, 3, 5, 6, 7, 8]


def test_dropped_frames_are_not_sent() -> None:
    assert [s is None for s in sent("camera-drop:at=2,for=3")] == [
        False, True, True, True, False, False, False, False,
    ]  # fmt: skip


def test_depth_goes_blank_and_comes_back() -> None:
    assert [float(s.depth_m[0, 0]) for s in sent("depth-blank:at=2,for=2") if s][:5] == [
        1, 0, 0, 4, 5,
    ]  # fmt: skip


def test_odometry_jumps_for_good_and_stops_for_a_while() -> None:
    jumped = [s.odometry.x_m for s in sent("odometry-jump:at=3,size=0.7") if s]
    assert jumped == pytest.approx([1, 2, 3.7, 4.7, 5.7, 6.7, 7.7, 8.7])
    stopped = [s.odometry.x_m for s in sent("odometry-stop:at=3,for=3") if s]
    assert stopped == [1, 2, 3, 3, 3, 6, 7, 8]


def test_the_clock_steps() -> None:
    stamps = [s.stamp_ns // 10**9 for s in sent("clock-step:at=4,size=100") if s]
    assert stamps == [1, 2, 3, 104, 105, 106, 107, 108]


def test_two_faults_at_once() -> None:
    found, _ = mishaps("depth-blank:at=1,for=9", "odometry-jump:at=1,size=1")
    when, sensed = next(frames(1))
    both = found.sense(when, sensed)
    assert both is not None
    assert (both.depth_m.max(), both.odometry.x_m) == (0, 2)


def test_odometry_of_real_time_stops_or_jumps_on_its_own() -> None:
    found, _ = mishaps("odometry-stop:at=2,for=1", "odometry-jump:at=3,size=2")
    told = [found.odometry(When(n, 0.0), Pose(0, 0, 0), n) for n in (1, 2, 3)]
    assert told == [(Pose(0, 0, 0), 1), None, (Pose(2, 0, 0), 3)]


def test_a_deaf_base() -> None:
    found, _ = mishaps("base-deaf:at=2,for=2")
    assert [found.deaf(When(n, 0.0)) for n in (1, 2, 3, 4)] == [False, True, True, False]


def test_a_person_walks_and_never_through_walls_or_the_robot() -> None:
    robot = Pose(3.0, 3.0, 0.0)
    found, shown = mishaps("person:at=2,for=60,size=1.0")
    for n in range(1, 64):
        found.move_bodies(When(n, 0.5 * (n - 1)), robot)
    people = [bodies[0] for bodies in shown if bodies]
    assert len(people) == 60
    assert shown[-1] == ()
    for person in people:
        assert 0.2 <= person.x_m <= 5.8
        assert 0.2 <= person.y_m <= 5.8
        assert math.hypot(person.x_m - 3.0, person.y_m - 3.0) >= POLITE_M - 1e-6
    ways = [math.dist((a.x_m, a.y_m), (b.x_m, b.y_m)) for a, b in pairwise(people)]
    assert max(ways) <= 0.5 + 1e-6
    assert sum(ways) > 10


def test_people_are_the_same_for_the_same_seed() -> None:
    def way(seed: int) -> Body:
        rng = np.random.default_rng(seed)
        person = person_near(Pose(3, 3, 0), Box(), rng)
        assert person is not None
        return walk(person, 5.0, Box(), Pose(3, 3, 0), rng)

    assert way(1) == way(1)
    assert way(1) != way(2)


def test_the_nearest_door_closes_once_the_robot_is_out_of_it() -> None:
    assert closed_door(SCENE, Pose(2.5, 1.0, 0), 0.3) == body_of(DOORS[0])
    assert closed_door(SCENE, Pose(2.5, 0.2, 0), 0.3) == body_of(DOORS[1])
    assert closed_door(Scene("s", (), (), (ROOM,), ()), Pose(1, 1, 0), 0.3) is None
    found, shown = mishaps("door-closes:at=2")
    for n, y in ((1, 4.0), (2, 1.0), (3, 4.0)):
        found.move_bodies(When(n, 0.0), Pose(0.5, y, 0))
    assert shown[-1] == (body_of(DOORS[0]),)  # it stays closed, wherever the robot goes


def test_a_person_stands_in_the_nearest_doorway_and_goes_on() -> None:
    found, shown = mishaps("person-stands:at=2,for=2")
    told = []
    for n in (1, 2, 3, 4):
        found.move_bodies(When(n, 0.0), Pose(2.4, 1.0, 0))
        told.append([(body.kind, body.x_m, body.y_m) for body in shown[-1]])
    assert told == [[], [("person", 2.5, 0.0)], [("person", 2.5, 0.0)], []]


@given(st.floats(-3, 3), st.floats(-3, 3))
def test_distance_to_a_body(x: float, y: float) -> None:
    person = Body("person", 0.0, 0.0, 0.0, (0.4, 0.4, 1.7))
    assert person.distance_m(x, y) == pytest.approx(math.hypot(x, y) - PERSON_RADIUS_M)
    door = Body("door", 0.0, 0.0, math.pi / 2, (1.0, 0.1, 2.0))  # along y
    outside = math.hypot(max(abs(x) - 0.05, 0.0), max(abs(y) - 0.5, 0.0))
    assert max(door.distance_m(x, y), 0.0) == pytest.approx(outside, abs=1e-9)


HARNESS = ("--harness", "--lockstep")


def test_a_model_at_fault_is_another_command() -> None:
    assert model_fault(parse_faults(["camera-drop"])) == (None, ())
    command, settings = model_fault(parse_faults(["llm-hang"]))
    assert command is not None
    assert command[1:] == ["-m", "hil_sim.driving.faulty_runtime", "hang", "run", *HARNESS]
    asked = "research.word_evidence=language"
    assert settings == ("research.budget_in_lockstep=true", asked)
    assert model_fault(parse_faults(["llm-nonsense"]))[1] == (asked,)
    assert model_fault(parse_faults(["llm-nonsense"]), ())[0][-2:] == ["run", "--harness"]  # type: ignore[index]
    command, settings = model_fault(parse_faults(["cloud-down"]))
    assert command is not None
    assert command[1:] == [
        "-m",
        "hil_sim.driving.faulty_runtime",
        "cloud-down",
        "run",
        *HARNESS,
    ]
    assert settings == ("research.budget_in_lockstep=true",)


def test_a_cloud_that_is_down_refuses_or_never_answers(tmp_path: Path) -> None:
    words = cloud_settings(down(), str(tmp_path))
    config = configuration.load(None, words[1::2])
    clock, causes = ManualClock(), []
    brief = Brief("toilet", 0, tuple(FrontierBrief(i, 1.0, (SINK,), ()) for i in (1, 2)))
    with Cloud(replace(config.cloud, timeout_s=0.4), clock) as cloud:
        for _ in range(4):
            outcome = cloud.expert("o2f")(brief, Deadline.never(clock))
            assert isinstance(outcome, Missing)
            causes.append(outcome.cause.split(" (")[0])
            clock.advance(1000.0)
    assert causes == ["late", "the connection broke"] * 2


def test_nonsense_repeats() -> None:
    texts = [f" word {n}" for n in range(80)]
    first = Babbling(None).score("In the room", texts)  # type: ignore[arg-type]
    assert [nonsense(f"In the room/{text}") for text in texts] == pytest.approx(first, nan_ok=True)
    assert 3 <= sum(math.isnan(score) for score in first) <= 20


def test_the_faulty_runtime_says_what_it_takes() -> None:
    command = [sys.executable, "-m", "hil_sim.driving.faulty_runtime", "sulk", "run"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 2
    assert done.stderr == (
        "faulty_runtime: the first word must be one of hang, nonsense, cloud-down\n"
    )


def test_the_faulty_runtime_is_the_runtime() -> None:
    command = [sys.executable, "-m", "hil_sim.driving.faulty_runtime", "nonsense", "run"]
    command += ["--lockstep", "--set", "nosuch.key=1"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 2
    assert done.stderr.startswith("rfnav: ")
    assert "nosuch" in done.stderr
