"""What a soak counts."""

from collections import Counter
from dataclasses import replace

import pytest
from blink import Blink
from corridor import EPISODE, SCENE, SMALL, Corridor

from hil_sim.driving.living_robot import LivingRobot, Mate
from hil_sim.driving.rig import start_of
from hil_sim.driving.soak import (
    MOST_MB,
    REPEATS_S,
    STOPS_WITHIN_S,
    Memory,
    Watch,
    soak,
    told,
    wrong,
)
from hil_sim.driving.soak_plan import Trouble
from hil_sim.simulation.mishaps import Mishaps
from hil_sim.simulation.protocol import DifferentialDrive
from hil_sim.simulation.robot import Robot
from runtime.core.types import Pose, Twist

STANDING = Robot(Pose(0.0, 0.0, 0.0))
MOVING = replace(STANDING, twist=Twist(0.3, 0.0))
BLIND = Trouble("camera-drop", 10.0, 5.0)


def watched(*seen: tuple[float, Robot], troubles: tuple[Trouble, ...] = (BLIND,)) -> Watch:
    watch = Watch(troubles)
    for now_s, robot in seen:
        watch.note(now_s, robot)
    return watch


def test_a_stop_in_time_is_none_that_was_missed():
    watch = watched((9.0, MOVING), (10.0, MOVING), (10.5, MOVING), (11.0, STANDING))
    (felt,) = watch.felt
    assert (felt.moved, felt.longest_s, watch.missed()) == (True, 0.5, ())


def test_a_stop_that_is_late_is_missed():
    late_s = 10.0 + STOPS_WITHIN_S + 0.1
    assert len(watched((10.0, MOVING), (late_s, MOVING), (12.0, STANDING)).missed()) == 1


def test_a_camera_that_freezes_is_given_the_frame_that_tells():
    frozen = (Trouble("camera-freeze", 10.0, 5.0),)
    due_s = STOPS_WITHIN_S + REPEATS_S["camera-freeze"]
    for late_s, missed in ((-0.1, 0), (0.1, 1)):
        seen = (10.0, MOVING), (10.0 + due_s + late_s, MOVING), (13.0, STANDING)
        assert len(watched(*seen, troubles=frozen).missed()) == missed


def test_what_shows_in_motion_alone_may_be_moved_in_again_but_not_for_long():
    seen = (10.0, STANDING), (11.0, MOVING), (12.0, MOVING), (12.5, STANDING), (14.0, MOVING)
    (felt,) = watched(*seen).felt
    assert (felt.moved, felt.longest_s, felt.missed) == (False, 1.0, False)
    assert watched(*seen[:3], (13.0, MOVING)).missed()


def test_without_depth_it_may_turn_and_not_drive():
    blank, turning = (Trouble("depth-blank", 10.0, 5.0),), replace(STANDING, twist=Twist(0.0, 0.8))
    assert not watched((10.0, turning), (14.0, turning), troubles=blank).missed()
    assert watched((10.0, MOVING), (14.0, MOVING), troubles=blank).missed()
    assert watched((10.0, turning), (14.0, turning)).missed()


def test_it_may_move_when_the_trouble_is_over_or_does_not_forbid_it():
    assert not watched((10.0, STANDING), (15.1, MOVING)).missed()
    person = (Trouble("person", 10.0, 5.0),)
    assert not watched((10.0, MOVING), (14.0, MOVING), troubles=person).missed()


def test_a_killed_service_may_be_back_before_the_trouble_would_be_over():
    kill = (Trouble("kill", 10.0, 8.0),)
    assert not watched((10.0, MOVING), (11.0, STANDING), (14.0, MOVING), troubles=kill).missed()


def test_collisions_are_booked_with_the_trouble_they_fall_into():
    hit = replace(STANDING, collisions=1)
    person = (Trouble("person", 10.0, 5.0),)
    watch = watched((9.0, STANDING), (12.0, hit), (20.0, hit), troubles=person)
    assert (watch.collisions, watch.felt[0].collisions) == (1, 1)
    before = watched((9.0, hit), (12.0, hit), troubles=person)
    assert (before.collisions, before.felt[0].collisions) == (1, 0)


def test_the_report_has_every_figure():
    watch = watched((10.0, MOVING), (10.5, MOVING), (11.0, STANDING))
    memory = Memory()
    memory.note(1, 600.0)
    memory.note(1, 500.0)
    memory.note(2, None)
    rows = told(watch, memory, Counter(found=3, cancelled=1), 2, 1)
    assert "0.50 s" in rows[1]
    assert rows[2:] == [
        "stops that were due and did not come: 0",
        "collisions: 0",
        "goals: 4 with a result (cancelled 1, found 3), 2 without",
        "saved files that could not be read: 1",
        "memory, most of each life: 600 MB",
        "outlived: no: goals without a result: 2; saved files that could not be read: 1",
    ]
    memory.note(2, MOST_MB + 1)
    late = watched((10.0, MOVING), (14.0, MOVING))
    assert wrong(late, memory, 0, 0) == [
        "stops that were due and did not come: 1", "lives of more than 900 MB: 1",
    ]  # fmt: skip
    assert told(watch, Memory(), Counter(), 0, 0)[-1] == "outlived: yes"


class Quiet:
    """A bus that nobody is on."""

    def publish(self, topic: str, payload: bytes) -> None: ...

    def command(self) -> Twist | None:
        return None

    def hand(self) -> Twist | None:
        return None

    def hang_up(self) -> None: ...

    def call_again(self) -> None: ...


class Told:
    """A service that notes what is done to it."""

    full_disk = None

    def __init__(self, broken: bool = False) -> None:
        self.did, self._broken = list[str](), broken

    def signal(self, number: int) -> None:
        self.did.append(f"signal {int(number)}")

    def restart(self) -> None:
        if self._broken:
            raise OSError("no systemctl")
        self.did.append("restart")

    def memory_mb(self) -> float | None:
        return 500.0

    def starts(self) -> int:
        return 1


def living() -> LivingRobot:
    corridor, protocol = Corridor(), replace(SMALL, base=DifferentialDrive())
    mishaps = Mishaps((), 0, "e", SCENE, corridor, corridor.bodies.append)
    return LivingRobot(start_of(EPISODE), Mate(corridor, Blink(), Quiet(), mishaps, protocol))


def test_a_service_has_its_troubles_at_their_times():
    plan = (Trouble("kill", 0.05, 1.0), Trouble("restart", 0.15, 1.0))
    service, said = Told(), list[str]()
    watch, memory = soak(living(), service, plan, 2.0, said.append)
    assert service.did == ["signal 9", "restart"]
    assert [felt.trouble for felt in watch.felt] == list(plan)
    assert memory.most == {1: 500.0}
    assert len(said) == 2


def test_a_trouble_that_cannot_be_made_ends_the_soak():
    with pytest.raises(OSError, match="no systemctl"):
        soak(living(), Told(broken=True), (Trouble("restart", 0.05, 1.0),), 5.0)
