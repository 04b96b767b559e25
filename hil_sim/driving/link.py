"""The harness's end of the wire: the runtime as a child process, and its Zenoh link in lockstep."""

import atexit
import json
import math
import queue
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any, Self

import numpy as np
import zenoh
from numpy.typing import NDArray

from hil_sim.driving.child import end, last_line, spawn
from hil_sim.driving.robot_wire import RobotWire, Spoken
from runtime.core.types import Action, Intrinsics, Pose, SearchState, Twist
from runtime.errors import RfNavError, SensorError
from runtime.robot import wire
from runtime.robot.json_text import parse_json
from runtime.robot.session import (
    ACTION,
    DECISION,
    LABELS,
    QUESTION,
    STATE,
    VOTES,
    BusConfig,
    TopicsConfig,
    open_session,
)

READY_S = 300.0  # loading models; the child's exit ends the wait at once
REPLY_S = 60.0  # to a request
ANSWER_S = 120.0  # to an observation
POLL_S = 0.25
RESEND_S = 5.0  # the bus of the runtime knows what it has seen: sending twice does no harm

REQUIRED = ("camera_info", "odom", "depth", "color")  # what the runtime must listen to
STILL = Twist()
Votes = Callable[[Mapping[str, Any]], Mapping[str, Any]]
NOTHING: Mapping[str, bytes] = MappingProxyType({})


class HarnessError(RfNavError):
    """The runtime under test did not start, ended, or did not answer."""


@dataclass(frozen=True)
class Answer:
    """What the runtime said to one observation."""

    action: Action
    state: dict[str, Any]  # empty if none came
    decisions: tuple[dict[str, Any], ...]
    twist: Twist = STILL  # where the runtime commands velocities


def free_port() -> int:
    """A TCP port of the loopback that is free now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def rfnav_command(mode: Sequence[str] = ("--lockstep",)) -> list[str]:
    """This installation's `rfnav run`; without a mode it drives in real time. Goals bring settings
    of a method, and where their files go."""
    return [sys.executable, "-m", "runtime", "run", "--harness", *mode]


class Runtime:
    """The runtime under test: spawned at once, ready when entered, always killed on `close`.

    `settings` are `--set` values; the harness adds where the bus is and, where they are `named`,
    its dialect and the default topics. Without `odometry` the runtime has it by another wire.
    HarnessError carries the child's own last line when it ends by itself.
    """

    def __init__(
        self,
        log: Path,
        config: Path | None = None,
        settings: Sequence[str] = (),
        command: Sequence[str] | None = None,
        answer_s: float = ANSWER_S,
        odometry: bool = True,
        spoken: Spoken = "ros2dds",
        named: bool = True,
    ) -> None:
        endpoint = f"tcp/127.0.0.1:{free_port()}"
        bus, self._wire = BusConfig(listen=(endpoint,)), RobotWire(spoken)
        arguments = list(command if command is not None else rfnav_command())
        if config is not None:
            arguments += ["--config", str(config)]
        told = self._wire.settings if named else ()
        for setting in (*settings, *_bus_settings(endpoint, named), *told):
            arguments += ["--set", setting]
        self._bus, self._awaited = bus, [n for n in REQUIRED if odometry or n != "odom"]
        self._heard: queue.SimpleQueue[tuple[str, dict[str, Any]]] = queue.SimpleQueue()
        self._log = log
        self._answer_s = answer_s
        self._declared: list[Any] = []
        self._command: Twist | None = None
        self._child: subprocess.Popen[bytes] | None = None
        self._session: Any = open_session(bus)
        atexit.register(self.close)
        try:
            self._declare()
            self._child = spawn(arguments, log)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        try:
            self._wait_ready()
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def ask(self, query: str, body: dict[str, object], timeout_s: float = REPLY_S) -> Any:
        """Send a JSON request to `rfnav/<query>` and return the JSON reply."""
        key = f"rfnav/{query}"
        until_s = time.monotonic() + timeout_s
        replies = self._session.get(key, payload=json.dumps(body), timeout=timeout_s)
        while time.monotonic() < until_s:
            try:
                reply = replies.try_recv()
            except zenoh.ZError:
                break  # nobody answers this query (any more)
            if reply is not None and reply.ok is not None:
                return parse_json(reply.ok.payload.to_bytes(), key)
            self.check_alive()
            time.sleep(0.002)
        self.check_alive()
        raise HarnessError(f"{key}: the runtime did not reply in {timeout_s:g} s")

    def forget(self) -> None:
        """Drop what was said before: a new episode counts its stamps from the start."""
        while not self._heard.empty():
            self._heard.get_nowait()

    def exchange(
        self,
        stamp_ns: int,
        rgb: NDArray[np.uint8],
        depth_m: NDArray[np.float32],
        odometry: Pose,
        intrinsics: Intrinsics,
        labels: dict[str, Any] | None = None,
        beside: Mapping[str, bytes] = NOTHING,
        votes: Votes | None = None,
    ) -> Answer:
        """Publish one observation and wait for the action: one step of the lockstep. `labels`
        (see `ground_truth.true_labels`) go ahead of the images that they belong to, and so does
        what is published `beside` them (topic: CDR). `votes` answers what is asked meanwhile."""
        for topic, payload in beside.items():
            self.publish(topic, payload)
        observation = _encoded(stamp_ns, rgb, depth_m, odometry, intrinsics, labels)
        send_s = time.monotonic()
        until_s = send_s + self._answer_s
        state: dict[str, Any] = {}
        decisions: list[dict[str, Any]] = []
        while (now_s := time.monotonic()) < until_s:
            if now_s >= send_s:
                send_s = now_s + RESEND_S
                for name, payload in observation.items():
                    self._publish[name].put(payload, attachment=self._wire.attachment())
            try:
                topic, value = self._heard.get(timeout=POLL_S)
            except queue.Empty:
                self.check_alive()
                continue
            if value.get("stamp_ns") != stamp_ns:
                continue
            if topic == STATE:
                state = value
            elif topic == DECISION:
                decisions.append(value)
            elif topic == QUESTION and votes is not None:
                self.publish(VOTES, wire.encode_json(votes(value)))
            elif topic == ACTION:
                return Answer(_action(value), state, tuple(decisions), _twist(value))
        raise HarnessError(f"no answer to an observation in {self._answer_s:g} s")

    def publish(self, stream: str, payload: bytes) -> None:
        """One message of "color", "depth", "camera_info", "odom" or "labels", or on another
        topic by its name. While the link is down it is lost."""
        if self._session.is_closed():
            return
        publisher = self._publish.get(stream)
        goes_along = self._wire.attachment()
        if publisher is not None:
            publisher.put(payload, attachment=goes_along)
        else:
            self._session.put(self._wire.key(stream), payload, attachment=goes_along)

    def hear(self) -> Iterator[tuple[str, dict[str, Any]]]:
        """What was said since, as ("state" | "decision" | ..., message)."""
        names = {STATE: "state", DECISION: "decision"}
        while not self._heard.empty():
            topic, value = self._heard.get_nowait()
            if topic in names and "error" not in value:
                yield names[topic], value

    def command(self) -> Twist | None:
        """The newest velocity on cmd_vel, once; None when there is no newer one."""
        command, self._command = self._command, None
        return command

    def check_alive(self) -> None:
        """HarnessError with the child's last line when it has ended."""
        child = self._child
        if child is None:
            raise HarnessError("the runtime has been closed")
        status = child.poll()
        if status is not None:
            raise HarnessError(last_line(self._log) or f"rfnav ended with status {status}")

    def close(self) -> None:
        """Undeclare, close the session, end the child. Idempotent."""
        atexit.unregister(self.close)
        child, self._child = self._child, None
        end(child)
        self.hang_up()

    def hang_up(self) -> None:
        """Leave the bus; the runtime finds its harness gone. Idempotent."""
        declared, self._declared = self._declared, []
        for entity in declared:
            entity.undeclare()
        if not self._session.is_closed():
            self._session.close()

    def call_again(self, wait: bool = True) -> None:
        """Come back to the bus, and perhaps wait until the runtime has noticed."""
        if self._session.is_closed():
            self._session = open_session(self._bus)
            self._declare()
            if wait:
                self._wait_ready((SearchState.READY, SearchState.SEARCHING))

    def _declare(self) -> None:
        bus = self._bus

        def hear(sample: zenoh.Sample) -> None:
            topic = self._wire.topic(str(sample.key_expr))
            if topic not in (ACTION, STATE, DECISION, QUESTION):
                return
            try:
                self._heard.put((topic, wire.decode_json(sample.payload.to_bytes(), topic)))
            except SensorError as error:
                self._heard.put((topic, {"error": str(error)}))

        def obey(sample: zenoh.Sample) -> None:
            with suppress(SensorError):
                speeds = wire.decode_twist(sample.payload.to_bytes(), bus.topics.cmd_vel)
                self._command = Twist(*speeds)

        cmd_vel, reports = self._wire.key(bus.topics.cmd_vel), self._wire.key("rfnav/*")
        self._declared.append(self._session.declare_subscriber(cmd_vel, obey))
        # One subscriber for all three, so that they come in the order they were sent.
        self._declared.append(self._session.declare_subscriber(reports, hear))
        self._publish: dict[str, Any] = {}
        keys = {name: getattr(bus.topics, name) for name in REQUIRED}
        for name, topic in {**keys, "labels": LABELS}.items():
            self._publish[name] = self._session.declare_publisher(
                self._wire.key(topic),
                congestion_control=zenoh.CongestionControl.BLOCK,
                express=True,
            )
        self._declared += self._publish.values()

    def _wait_ready(self, states: tuple[SearchState, ...] = (SearchState.READY,)) -> None:
        # Also for Zenoh's sake: what is sent in the first moments of a link can be lost, so the
        # status is asked until it is answered, and observations come after that.
        until_s = time.monotonic() + READY_S
        while time.monotonic() < until_s:
            self.check_alive()
            try:
                status = self.ask("status", {}, POLL_S)
            except HarnessError:
                time.sleep(0.02)
                continue
            heard = all(self._publish[name].matching_status for name in self._awaited)
            if status.get("state") in states and heard:
                return
            time.sleep(0.02)
        raise HarnessError(f"rfnav was not ready in {READY_S:g} s; its log is {self._log}")


def _encoded(
    stamp_ns: int,
    rgb: NDArray[np.uint8],
    depth_m: NDArray[np.float32],
    odometry: Pose,
    intrinsics: Intrinsics,
    labels: dict[str, Any] | None,
) -> dict[str, bytes]:
    """An observation's messages by stream, in the order in which they are sent."""
    said = {"labels": wire.encode_json({"stamp_ns": stamp_ns, **labels})} if labels else {}
    return {
        **said,
        "camera_info": wire.encode_camera_info(intrinsics, stamp_ns),
        "odom": wire.encode_odometry(odometry, stamp_ns),
        "depth": wire.encode_depth(depth_m, stamp_ns),
        "color": wire.encode_color(rgb, stamp_ns),
    }


def _bus_settings(endpoint: str, named: bool = True) -> list[str]:
    """The harness decides where the bus is and how its topics are called."""
    topics = TopicsConfig()
    names = (f'bus.topics.{f.name}="{getattr(topics, f.name)}"' for f in fields(topics) if named)
    return ['bus.mode="peer"', f'bus.connect=["{endpoint}"]', "bus.listen=[]", 'bus.prefix=""',
            'bus.cmd_vel_type="Twist"',
            *names]  # fmt: skip


def _action(value: dict[str, Any]) -> Action:
    try:
        return Action(value["action"])
    except (KeyError, ValueError):
        known = ", ".join(action.value for action in Action)
        raise HarnessError(f"rfnav/action: {value.get('action')!r}: must be {known}") from None


def _twist(value: dict[str, Any]) -> Twist:
    speeds = (value.get("v_mps", 0.0), value.get("w_radps", 0.0))
    if not all(isinstance(speed, int | float) and math.isfinite(speed) for speed in speeds):
        raise HarnessError(f"rfnav/action: velocity {speeds}: must be two finite numbers")
    return Twist(*(float(speed) for speed in speeds))
