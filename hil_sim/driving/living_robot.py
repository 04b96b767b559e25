"""A simulated robot that lives: it rolls, looks and reports on a bus of its own whether or not
anybody drives it, as a real one does while the service that drives it is started, ends and starts
again.
"""

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any
from typing import Protocol as Port

import zenoh

from hil_sim.driving.camera_process import Glance, Shot
from hil_sim.driving.realtime import CHARGE_S, FRAME_S, FULL_PERCENT, LONGEST_S, TICK_S, CameraPort
from hil_sim.simulation.drive import drive as roll
from hil_sim.simulation.drive import ordered
from hil_sim.simulation.faults import Sensed, When
from hil_sim.simulation.hand import Sticks
from hil_sim.simulation.mishaps import Mishaps
from hil_sim.simulation.noise import generator
from hil_sim.simulation.protocol import DifferentialDrive, Protocol
from hil_sim.simulation.robot import Ground, Robot
from hil_sim.simulation.sensors import felt
from runtime.core.types import Pose, Twist
from runtime.errors import SensorError
from runtime.robot import wire, wire_senses
from runtime.robot.session import BusConfig, TopicsConfig, open_session

TOPICS = TopicsConfig()
NAME = "living"
HAND_S = 0.5  # that the sticks have the base after their last word


class RobotBus:
    """The robot's end: it listens on `endpoint`, as a bridge does, and the runtime and whoever asks
    it connect. Published with the topics' default names, in the dialect of a bridge."""

    def __init__(self, endpoint: str) -> None:
        self._config = BusConfig(listen=(endpoint,))
        self._command: Twist | None = None
        self._hand = Twist(), -HAND_S  # what was told on the sticks last, and when
        self._session: Any = None
        self.call_again()

    def publish(self, topic: str, payload: bytes) -> None:
        """While the link is down it is lost."""
        if not self._session.is_closed():
            drop = zenoh.CongestionControl.DROP
            self._session.put(topic, payload, congestion_control=drop, express=True)

    def command(self) -> Twist | None:
        """The newest velocity, once."""
        command, self._command = self._command, None
        return command

    def hand(self) -> Twist | None:
        """What a person tells the base, who has its sticks until half a second after the last word:
        the base's own multiplexer, as robots have one."""
        twist, told_s = self._hand
        return twist if time.monotonic() - told_s < HAND_S else None

    def hang_up(self) -> None:
        """Leave the bus. Idempotent."""
        if not self._session.is_closed():
            self._session.close()

    def call_again(self) -> None:
        """Be on the bus. Idempotent."""
        if self._session is None or self._session.is_closed():
            self._session = open_session(self._config)
            self._session.declare_subscriber(TOPICS.cmd_vel, self._obey)
            others = zenoh.Locality.REMOTE  # a fault `hand` speaks there itself
            self._session.declare_subscriber(TOPICS.teleop, self._obey_hand, allowed_origin=others)

    def _obey(self, sample: zenoh.Sample) -> None:
        with suppress(SensorError):
            self._command = Twist(*wire.decode_twist(sample.payload.to_bytes(), TOPICS.cmd_vel))

    def _obey_hand(self, sample: zenoh.Sample) -> None:
        with suppress(SensorError):
            told = wire.decode_twist(sample.payload.to_bytes(), TOPICS.teleop)
            self._hand = Twist(*told), time.monotonic()


class RobotPort(Port):
    """The bus of a robot; see `RobotBus`."""

    def publish(self, topic: str, payload: bytes) -> None: ...

    def command(self) -> Twist | None: ...

    def hand(self) -> Twist | None: ...

    def hang_up(self) -> None: ...

    def call_again(self) -> None: ...


@dataclass(frozen=True)
class Mate:
    """What a robot needs beside itself: the floor it drives on, its eyes and its bus."""

    ground: Ground
    camera: CameraPort
    bus: RobotPort
    mishaps: Mishaps
    protocol: Protocol
    clock: Callable[[], float] = time.monotonic
    stamp_ns: Callable[[], int] = time.time_ns


@dataclass
class LivingRobot:
    """`tick` as often as 50 times a second; what is wrong meanwhile are the mishaps, of which times
    count from its begin."""

    start: Pose  # scene frame
    mate: Mate
    seed: int = 0
    robot: Robot = field(init=False)
    ticks: int = 0
    frames: int = 0
    _began_s: float = field(init=False)
    _now_s: float = field(init=False)
    _next_frame_s: float = 0.0
    _glance: tuple[When, Robot, int] | None = None  # what is being rendered, of where and when
    _sticks: Sticks = field(default_factory=Sticks)
    _charge_s: float = -1.0

    def __post_init__(self) -> None:
        self.robot = Robot(self.start)
        self._began_s = self._now_s = self.mate.clock()

    @property
    def now_s(self) -> float:
        """Since its begin, as of the last tick."""
        return self._now_s - self._began_s

    def tick(self) -> None:
        """Obey, roll, report; begin a frame or publish one when it is time. Waits for its turn."""
        mate = self.mate
        time.sleep(max(0.0, self._now_s + TICK_S - mate.clock()))
        passed_s, self._now_s = mate.clock() - self._now_s, mate.clock()
        self.ticks += 1
        when = When(self.frames + 1, self.now_s)
        if mate.mishaps.active("link-lost", when):
            mate.bus.hang_up()
        else:
            mate.bus.call_again()
        self._roll(when, min(passed_s, LONGEST_S))
        self._report(when)
        self._look(when)

    def _roll(self, when: When, passed_s: float) -> None:
        mate, base = self.mate, self.mate.protocol.base or DifferentialDrive()
        ours = mate.bus.command()  # one that is not obeyed now is not obeyed later
        command = self._by_hand(when) or mate.bus.hand() or ours
        if command is not None and not mate.mishaps.deaf(when):
            self.robot = ordered(self.robot, command, base)
        rng = generator(self.seed, NAME, self.ticks, "base")
        noise = mate.protocol.noise
        self.robot = roll(self.robot, passed_s, mate.ground, base, noise, rng)

    def _by_hand(self, when: When) -> Twist | None:
        twist = self._sticks.twist(self.mate.mishaps.active("hand", when), self.robot, self._now_s)
        if twist is not None and self._sticks.speak(self._now_s):
            self.mate.bus.publish(TOPICS.teleop, wire.encode_twist(twist.v_mps, twist.w_radps))
        return twist

    def _report(self, when: When) -> None:
        mate, robot, stamp_ns = self.mate, self.robot, self.mate.stamp_ns()
        told = mate.mishaps.odometry(when, robot.odometry(self.start), stamp_ns)
        if told is not None:
            mate.bus.publish(TOPICS.odom, wire.encode_odometry(*told))
        for topic, payload in felt(mate.protocol, robot.touching, {}, stamp_ns).items():
            mate.bus.publish(topic, payload)
        if self._now_s - self._charge_s >= CHARGE_S:
            self._charge_s = self._now_s
            low = mate.mishaps.active("battery-low", when)
            percent = low.size if low is not None else FULL_PERCENT
            mate.bus.publish(TOPICS.battery, wire_senses.encode_battery(percent, stamp_ns))

    def _look(self, when: When) -> None:
        camera, mishaps = self.mate.camera, self.mate.mishaps
        sight = camera.seen() if camera.busy else None
        if sight is not None and self._glance is not None:
            self._show(*self._glance, sight)
            self._glance = None
        if not camera.busy and self._now_s >= self._next_frame_s:
            self._next_frame_s = self._now_s + FRAME_S
            mishaps.move_bodies(when, self.robot.pose)
            self._glance = when, self.robot, self.mate.stamp_ns()
            at = self.robot.pose, self.robot.twist.w_radps, mishaps.bodies
            camera.look(Glance(when.step, *at))

    def _show(self, when: When, robot: Robot, stamp_ns: int, sight: Shot) -> None:
        """Publish a frame as it was when it was asked for."""
        mate = self.mate
        self.frames += 1
        here = robot.odometry(self.start)
        told = Sensed(sight.rgb, sight.depth_m, here, stamp_ns)
        sensed = mate.mishaps.sense(when, told)
        if sensed is None:
            return
        info = wire.encode_camera_info(mate.protocol.intrinsics, sensed.stamp_ns)
        mate.bus.publish(TOPICS.camera_info, info)
        mate.bus.publish(TOPICS.depth, wire.encode_depth(sensed.depth_m, sensed.stamp_ns))
        mate.bus.publish(TOPICS.color, wire.encode_color(sensed.rgb, sensed.stamp_ns))
