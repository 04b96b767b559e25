"""A robot that lives beside whoever drives it."""

import time
from collections.abc import Callable
from dataclasses import replace

from blink import Blink
from corridor import EPISODE, SCENE, SMALL, Corridor

from hil_sim.driving.link import free_port
from hil_sim.driving.living_robot import LivingRobot, Mate, RobotBus
from hil_sim.driving.rig import start_of
from hil_sim.simulation.faults import parse_faults
from hil_sim.simulation.mishaps import Mishaps
from hil_sim.simulation.protocol import DifferentialDrive
from runtime.core.types import Twist
from runtime.robot import wire
from runtime.robot.session import BusConfig, open_session

PROTOCOL = replace(SMALL, base=DifferentialDrive())
IMAGES = ("camera/color/image_raw", "camera/depth/image_raw", "camera/color/camera_info")


class Line:
    """The robot's bus, with one driver on it who says the same over and over."""

    def __init__(self, says: Twist | None, sticks: Twist | None = None) -> None:
        self._says, self._sticks, self.up = says, sticks, True
        self.heard: list[tuple[str, bytes]] = []

    def publish(self, topic: str, payload: bytes) -> None:
        if self.up:
            self.heard.append((topic, payload))

    def command(self) -> Twist | None:
        return self._says if self.up else None

    def hand(self) -> Twist | None:
        return self._sticks

    def hang_up(self) -> None:
        self.up = False

    def call_again(self) -> None:
        self.up = True

    def topics(self) -> set[str]:
        return {topic for topic, _ in self.heard}


def living(line: Line, *faults: str) -> tuple[LivingRobot, Blink]:
    corridor, camera = Corridor(), Blink()
    mishaps = Mishaps(parse_faults(faults), 0, "e", SCENE, corridor, corridor.bodies.append)
    mate = Mate(corridor, camera, line, mishaps, PROTOCOL)
    return LivingRobot(start_of(EPISODE), mate), camera


def lives(robot: LivingRobot, until: Callable[[], bool], ticks: int = 400) -> None:
    while not until():
        assert robot.ticks < ticks
        robot.tick()


def test_it_reports_and_looks_though_nobody_drives_it():
    robot, camera = living(line := Line(None))
    lives(robot, lambda: robot.frames >= 2)
    assert line.topics() == {*IMAGES, "odom", "battery_state"}
    assert robot.robot.path_m == 0.0
    assert [glance.number for glance in camera.glances[:2]] == [1, 2]


def test_it_obeys_and_reports_how_far_it_has_come():
    robot, _ = living(line := Line(Twist(0.3, 0.0)))
    lives(robot, lambda: robot.robot.path_m > 0.2)
    payload = [payload for topic, payload in line.heard if topic == "odom"][-1]
    told = wire.decode(payload, "nav_msgs/msg/Odometry", "odom").pose.pose.position
    assert abs(told.x - robot.robot.path_m) < 0.05


def test_a_hand_on_its_sticks_is_heard_and_obeyed_alone():
    robot, _ = living(line := Line(Twist(0.3, 0.0)), "hand:at=0s,for=60s")
    lives(robot, lambda: abs(robot.robot.pose.yaw_rad - robot.start.yaw_rad) > 0.3)
    assert "cmd_vel_teleop" in line.topics()
    assert robot.robot.path_m == 0.0


def test_its_faults_are_felt():
    robot, _ = living(
        line := Line(Twist(0.3, 0.0)), "base-deaf:at=0s,for=60s", "camera-drop:at=0s,for=60s"
    )
    lives(robot, lambda: robot.frames >= 2)
    assert line.topics() == {"odom", "battery_state"}
    assert robot.robot.path_m == 0.0


def test_a_lost_link_comes_again():
    robot, _ = living(line := Line(None), "link-lost:at=0s,for=0.2s")
    robot.tick()
    assert not line.up
    lives(robot, lambda: line.up)


def test_whoever_asks_the_runtime_reaches_it_through_the_robots_bus():
    bus = RobotBus(endpoint := f"tcp/127.0.0.1:{free_port()}")
    runtime = open_session(BusConfig(connect=(endpoint,)))
    answers = runtime.declare_queryable(
        "rfnav/goal", lambda query: query.reply("rfnav/goal", "yes")
    )
    asking = open_session(BusConfig(mode="client", connect=(endpoint,)))
    said: list[str] = []
    while not said:
        replies = asking.get("rfnav/goal", timeout=1.0)
        said = [reply.ok.payload.to_string() for reply in replies if reply.ok is not None]
    assert said == ["yes"]
    asking.close()
    answers.undeclare()
    runtime.close()
    bus.hang_up()


def test_its_bus_hears_commands_once_and_comes_again():
    bus = RobotBus(endpoint := f"tcp/127.0.0.1:{free_port()}")
    driver = open_session(BusConfig(connect=(endpoint,)))
    heard = None
    while heard is None:
        driver.put("cmd_vel", wire.encode_twist(0.2, -0.1))
        heard = bus.command()
    assert heard == Twist(0.2, -0.1)
    driver.close()
    bus.hang_up()
    bus.publish("odom", b"")  # lost
    bus.call_again()
    bus.hang_up()


def test_who_speaks_on_the_sticks_topic_has_the_base():
    robot, _ = living(Line(Twist(0.3, 0.0), Twist(0.0, 0.6)))
    lives(robot, lambda: abs(robot.robot.pose.yaw_rad - robot.start.yaw_rad) > 0.3)
    assert robot.robot.path_m == 0.0


def test_the_sticks_are_let_go_half_a_second_after_their_last_word():
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    bus = RobotBus(endpoint)
    assert bus.hand() is None
    bus.publish("cmd_vel_teleop", wire.encode_twist(0.1, 0.0))  # its own: a fault that it plays
    time.sleep(0.2)
    assert bus.hand() is None
    with open_session(BusConfig(mode="client", connect=(endpoint,))) as session:
        until_s, held = time.monotonic() + 10.0, None
        while held is None and time.monotonic() < until_s:
            session.put("cmd_vel_teleop", wire.encode_twist(0.2, 0.5))
            time.sleep(0.02)
            held = bus.hand()
        assert held == Twist(0.2, 0.5)
        time.sleep(0.7)
        assert bus.hand() is None
    bus.hang_up()
