"""A robot in the flat-land apartment, on the wall clock: CDR over Zenoh at the rates of a real one,
and a base that obeys cmd_vel until its watchdog expires."""

import json
import math
import threading
import time
from collections.abc import Callable
from typing import Any

import zenoh
from other_half import flag

from hil_sim.driving.robot_wire import RobotWire, Spoken
from runtime.core.types import Pose, Twist
from runtime.robot import wire, wire_senses
from runtime.robot.session import DECISION, FEEDBACK, STATE, BusConfig, open_session

WATCHDOG_S = 0.5
STEP_S = 0.02
SILENCE_S = 0.2  # without a message, after which it is looked again


class RobotDouble:
    """`sending` names the streams that are alive, "bumper" and "battery" among them where it has
    those; `blind`: the camera goes on without depth; `bend` alters the place that odometry tells,
    `telling` how it does, `filmed` the messages of color, depth and camera_info, of which b"" is
    none. While a `hand` has the sticks the base obeys nobody else."""

    def __init__(
        self,
        home: Any,
        config: BusConfig,
        odom_hz: float = 20.0,
        fps: float = 4.0,
        spoken: Spoken = "ros2dds",
    ):
        self.home, self.topics, self.wire = home, config.topics, RobotWire(spoken)
        self.session: Any = open_session(config)
        self.sending, self.blind = {"odom", "frames"}, False
        self.bend: Callable[[Pose], Pose] = lambda pose: pose
        self.clock_ns = 0  # what its clock says beyond the machine's
        self.telling: Callable[[Pose, int], bytes] = wire.encode_odometry
        self.filmed: Callable[[str, bytes], bytes] = lambda stream, payload: payload
        self.twist, self.told_s = Twist(), -math.inf
        self.hand: Twist | None = None
        self.touching, self.percent = False, 80.0
        self.commands: list[Twist] = []
        self.states: list[dict[str, Any]] = []
        self.decisions: list[dict[str, Any]] = []
        self.feedback: list[dict[str, Any]] = []
        self.changed = threading.Condition()
        self._ending = threading.Event()
        self._odom_s, self._frame_s = 1 / odom_hz, 1 / fps
        topics = self.topics
        self._declared = [
            self._listen(topics.cmd_vel, self._obey),
            self._listen(STATE, self._hear(self.states, STATE)),
            self._listen(DECISION, self._hear(self.decisions, DECISION)),
            self._listen(FEEDBACK, self._hear(self.feedback, FEEDBACK)),
        ]
        self._threads = [threading.Thread(target=f) for f in (self._drive, self._film)]

    def start(self) -> None:
        for thread in self._threads:
            thread.start()

    def close(self) -> None:
        self._ending.set()
        for thread in self._threads:
            if thread.ident:
                thread.join()
        for one in self._declared:
            one.undeclare()
        self.session.close()

    def ask(self, query: str, body: dict[str, Any] | None = None, tries: int = 300) -> dict:
        for _ in range(tries):
            payload = json.dumps(body or {})
            for reply in self.session.get(f"rfnav/{query}", payload=payload, timeout=30.0):
                if reply.ok is not None:
                    return json.loads(reply.ok.payload.to_bytes())
            time.sleep(0.1)  # the link is not up yet
        raise AssertionError(f"nobody answers rfnav/{query}")

    def hears(self, what: Callable[[], Any], seconds: float) -> bool:
        """Whether something becomes true of what was heard within that time."""
        with self.changed:
            return bool(self.changed.wait_for(what, seconds))

    def until(self, what: Callable[[], Any], seconds: float = 60.0) -> None:
        """Wait for something to become true, of what was heard or of what makes no sound."""
        by_s = time.monotonic() + seconds
        with self.changed:
            while not self.changed.wait_for(what, SILENCE_S):
                assert time.monotonic() < by_s, self.states[-1:]

    def state(self) -> dict[str, Any]:
        return self.states[-1] if self.states else {}

    def _listen(self, topic: str, hear: Callable[[zenoh.Sample], None]) -> Any:
        return self.session.declare_subscriber(self.wire.key(topic), hear)

    def _put(self, topic: str, payload: bytes) -> None:
        self.session.put(self.wire.key(topic), payload, attachment=self.wire.attachment())

    def _hear(self, heard: list, topic: str) -> Callable[[zenoh.Sample], None]:
        def receive(sample: zenoh.Sample) -> None:
            with self.changed:
                heard.append(wire.decode_json(sample.payload.to_bytes(), topic))
                self.changed.notify_all()

        return receive

    def _obey(self, sample: zenoh.Sample) -> None:
        with self.changed:
            self.twist = Twist(*wire.decode_twist(sample.payload.to_bytes(), "cmd_vel"))
            self.told_s = time.monotonic()
            self.commands.append(self.twist)
            self.changed.notify_all()

    def _drive(self) -> None:
        """Move in small steps, publish odometry."""
        last_s = said_s = time.monotonic()
        while not self._ending.wait(STEP_S):
            now_s = time.monotonic()
            dt, last_s = now_s - last_s, now_s
            with self.changed:
                live = now_s - self.told_s < WATCHDOG_S
                if self.hand is not None:
                    self._move(self.hand, dt)
                elif live:
                    self._move(self.twist, dt)
            self._tell_of_the_body()
            if now_s - said_s >= self._odom_s and "odom" in self.sending:
                said_s = now_s
                pose, stamp = self.bend(self.home.pose), time.time_ns() + self.clock_ns
                self._put(self.topics.odom, self.telling(pose, stamp))

    def _tell_of_the_body(self) -> None:
        if self.hand is not None:
            told = wire.encode_twist(self.hand.v_mps, self.hand.w_radps)
            self._put(self.topics.teleop, told)
        if "bumper" in self.sending:
            self._put(self.topics.bumper, flag(self.touching))
        if "battery" in self.sending:
            charge = wire_senses.encode_battery(self.percent, time.time_ns())
            self._put(self.topics.battery, charge)

    def _move(self, twist: Twist, dt: float) -> None:
        p = self.home.pose
        yaw = math.remainder(p.yaw_rad + twist.w_radps * dt, math.tau)
        x = p.x_m + twist.v_mps * dt * math.cos(yaw)
        y = p.y_m + twist.v_mps * dt * math.sin(yaw)
        if not twist.v_mps or self.home.fits(x, y):
            self.home.pose = Pose(x, y, yaw)
            self.touching = self.touching and not twist.v_mps
        else:
            self.touching = True
            self.home.collisions += 1
            self.home.pose = Pose(p.x_m, p.y_m, yaw)

    def _film(self) -> None:
        while not self._ending.wait(self._frame_s):
            if "frames" not in self.sending:
                continue
            stamp = time.time_ns() + self.clock_ns
            obs = self.home.observe()
            told = {
                "camera_info": wire.encode_camera_info(obs.intrinsics, stamp),
                "depth": b"" if self.blind else wire.encode_depth(obs.depth_m, stamp),
                "color": wire.encode_color(obs.rgb, stamp),
            }
            for stream, payload in told.items():
                if payload and (sent := self.filmed(stream, payload)):
                    self._put(getattr(self.topics, stream), sent)
