"""An episode in real time: the base rolls and reports 50 times a second, frames come at up to 5 a
second, and the runtime commands velocities on `cmd_vel` whenever it likes.

    with CameraProcess(scene, protocol, episode.id, seed, renderer) as camera:
        run_episode(..., play=partial(realtime.drive, camera=camera))

`run_realtime` does that. The runtime must have been started without `--lockstep`
(`link.rfnav_command(())`).
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any
from typing import Protocol as Port

from hil_sim.driving.base_wires import BaseWire, CmdVelWire
from hil_sim.driving.camera_process import CameraProcess, Glance, Shot
from hil_sim.driving.drawn_bounds import UNBOUND, DrawnBounds
from hil_sim.driving.episode_result import EpisodeResult
from hil_sim.driving.episode_run import run_episode
from hil_sim.driving.link import Answer, HarnessError, Runtime
from hil_sim.driving.lockstep import EpisodeRun
from hil_sim.driving.stage import StagedHome, Step
from hil_sim.ground_truth.episodes import Episode
from hil_sim.ground_truth.true_labels import boxes_alone, true_labels
from hil_sim.ground_truth.witness import to_scene
from hil_sim.simulation.drive import drive as roll
from hil_sim.simulation.drive import ordered, still
from hil_sim.simulation.faults import Fault, Sensed, When
from hil_sim.simulation.hand import Sticks
from hil_sim.simulation.noise import generator
from hil_sim.simulation.protocol import DifferentialDrive, Protocol
from hil_sim.simulation.robot import Robot
from hil_sim.simulation.sensors import SCAN, encode_scan, felt
from runtime.core.types import Action, Pose, SearchState, Twist
from runtime.core.world import Mode
from runtime.robot import wire, wire_senses
from runtime.robot.session import TopicsConfig

TOPICS = TopicsConfig()
TICK_S = 0.02
FRAME_S = 0.2
LONGEST_S = 0.5
"""A tick that comes later than this does not make up for it."""
BRAKE_S = 2.0
"""How long the base has to come to rest when the search is over."""
OVER = tuple(state for state in SearchState if state.over)
CHARGE_S = 0.5
"""Between two messages of the battery's."""
FULL_PERCENT = 80.0


class CameraPort(Port):
    """What looks; see `CameraProcess`."""

    busy: bool

    def look(self, glance: Glance) -> None: ...

    def seen(self) -> Shot | None: ...


def run_realtime(
    episode: Episode,
    home: StagedHome,
    runtime: Runtime,
    protocol: Protocol,
    method: str,
    log_dir: Path,
    watch: Callable[[Step], None] = lambda step: None,
    faults: tuple[Fault, ...] = (),
    seed: int = 0,
    renderer: str = "auto",
    wire: BaseWire | None = None,
    bounds: DrawnBounds = UNBOUND,
) -> EpisodeResult:
    """`run_episode` in real time. A protocol of discrete actions gets a base that drives; the time
    allowed is its observations times the time between them. PyBullet's calls for collisions are
    made in the calling thread; frames are rendered in another process. `wire`: to the base; None is
    ROS 2's."""
    protocol = replace(protocol, base=protocol.base or DifferentialDrive())
    with CameraProcess(home.scene, protocol, episode.id, seed, renderer) as camera:
        play = partial(drive, camera=camera, base_wire=wire)
        return run_episode(
            episode, home, runtime, protocol, method, log_dir, watch, faults, seed, play,
            bounds=bounds,
        )  # fmt: skip


@dataclass
class _Frame:
    """One that is being rendered, and what was true when it was asked for."""

    when: When
    robot: Robot
    stamp_ns: int


@dataclass
class _State:
    """What the loop remembers."""

    began_s: float
    now_s: float
    wire: BaseWire
    frame: _Frame | None = None
    next_frame_s: float = 0.0
    ticks: int = 0
    said: dict[str, Any] | None = None
    aim: list[float] | None = None  # what the runtime went for last, in its map
    decisions: tuple[dict[str, Any], ...] = ()
    collisions: int = 0  # until the last frame
    searching: bool = False  # the runtime has said so: before, what it says is of another search
    sticks: Sticks = field(default_factory=Sticks)
    charge_s: float = -1.0  # when the battery was heard last


def drive(
    run: EpisodeRun,
    camera: CameraPort,
    clock: Callable[[], float] = time.monotonic,
    base_wire: BaseWire | None = None,
) -> None:
    """Until the runtime says that the search is over, the robot falls, or the time allowed has
    passed."""
    if not isinstance(run.driver, Runtime) or run.protocol.base is None:
        raise HarnessError("real time needs a runtime, and a base that drives")
    state = _State(clock(), clock(), base_wire or CmdVelWire(run.driver))
    for fault in run.mishaps.faults:
        if fault.kind.realtime and not isinstance(state.wire, CmdVelWire):
            raise HarnessError(f"fault {fault.name}: comes over ROS 2; leave --base away")
    allowed_s = run.protocol.max_steps * run.protocol.observe_s
    while not run.tally.robot.over and state.now_s - state.began_s < allowed_s:
        _tick(run, run.driver, camera, state, clock)
        if state.said is not None and _over(state, state.said):
            _conclude(run, state, state.said)
    until_s = clock() + BRAKE_S
    while not still(run.tally.robot) and clock() < until_s:
        _tick(run, run.driver, camera, state, clock)
    run.driver.call_again(wait=False)
    run.tally.halted = still(run.tally.robot)


def _over(state: _State, said: dict[str, Any]) -> bool:
    """Whether the runtime says that the search has ended. That of the episode before was cancelled,
    too, and may still be told of."""
    ended = said.get("state")
    return ended in OVER and (state.searching or ended != SearchState.CANCELLED)


def _conclude(run: EpisodeRun, state: _State, said: dict[str, Any]) -> None:
    """The runtime says that the search is over: a stop, for what it went for last if it found."""
    tally = run.tally
    robot = tally.robot
    aim = state.aim if said["state"] == SearchState.FOUND else None
    here = to_scene(robot.pose, robot.odometry(run.start))
    run.witness.hear(tally.steps, {"mode": Mode.STOP, "toward_xy": aim}, state.decisions, here)
    tally.decisions += len(state.decisions)
    tally.reason = str(said.get("reason", ""))
    tally.robot, state.decisions = replace(robot, stopped=True), ()


def _tick(
    run: EpisodeRun, runtime: Runtime, camera: CameraPort, state: _State, clock: Callable[[], float]
) -> None:
    """Obey, roll, report; begin a frame or hand one over when it is time."""
    time.sleep(max(0.0, state.now_s + TICK_S - clock()))
    passed_s, state.now_s = clock() - state.now_s, clock()
    state.ticks += 1
    runtime.check_alive()
    when = When(run.tally.steps + 1, state.now_s - state.began_s)
    base, protocol = run.protocol.base, run.protocol
    assert base is not None
    ours = state.wire.command(state.now_s)  # one that is not obeyed now is not obeyed later
    command = _by_hand(run, runtime, state, when) or ours
    if command is not None and not run.mishaps.deaf(when):
        run.tally.robot = ordered(run.tally.robot, command, base)
    rng = generator(run.seed, run.episode, state.ticks, "base")
    run.tally.robot = roll(
        run.tally.robot, min(passed_s, LONGEST_S), run.home.ground, base, protocol.noise, rng
    )
    stamp_ns = time.time_ns()
    _link(run, runtime, when)
    _report(run, runtime, state, when, stamp_ns)
    _report_charge(run, runtime, state, when, stamp_ns)
    _listen(runtime, state)
    sight = camera.seen() if camera.busy else None
    if sight is not None and state.frame is not None:
        _deliver(run, runtime, state, state.frame, sight)
        state.frame = None
    if not camera.busy and state.now_s >= state.next_frame_s:
        state.next_frame_s = state.now_s + FRAME_S
        run.mishaps.move_bodies(when, run.tally.robot.pose)
        robot = run.tally.robot
        state.frame = _Frame(when, robot, stamp_ns)
        camera.look(Glance(when.step, robot.pose, robot.twist.w_radps, run.mishaps.bodies))


def _link(run: EpisodeRun, runtime: Runtime, when: When) -> None:
    if run.mishaps.active("link-lost", when):
        runtime.hang_up()
    else:
        runtime.call_again(wait=False)


def _report(run: EpisodeRun, runtime: Runtime, state: _State, when: When, stamp_ns: int) -> None:
    """Odometry, and what the body feels."""
    robot = run.tally.robot
    told = run.mishaps.odometry(when, robot.odometry(run.start), stamp_ns)
    if told is not None:
        pose, stamp_ns = told
        state.wire.report(pose, stamp_ns, state.now_s)
    cliffs = run.home.cliffs
    below_m = cliffs(robot.pose) if cliffs is not None else {}
    for topic, payload in felt(run.protocol, robot.touching, below_m, stamp_ns).items():
        runtime.publish(topic, payload)


def _by_hand(run: EpisodeRun, runtime: Runtime, state: _State, when: When) -> Twist | None:
    """What a hand on the sticks tells the base, which then hears nobody else; None without one."""
    twist = state.sticks.twist(run.mishaps.active("hand", when), run.tally.robot, state.now_s)
    if twist is not None and state.sticks.speak(state.now_s):
        runtime.publish(TOPICS.teleop, wire.encode_twist(twist.v_mps, twist.w_radps))
    return twist


def _report_charge(
    run: EpisodeRun, runtime: Runtime, state: _State, when: When, stamp_ns: int
) -> None:
    """The battery, of a robot that is to run low."""
    if not any(fault.name == "battery-low" for fault in run.mishaps.faults):
        return
    if state.now_s - state.charge_s >= CHARGE_S:
        state.charge_s, low = state.now_s, run.mishaps.active("battery-low", when)
        percent = low.size if low is not None else FULL_PERCENT
        runtime.publish(TOPICS.battery, wire_senses.encode_battery(percent, stamp_ns))


def _listen(runtime: Runtime, state: _State) -> None:
    for name, message in runtime.hear():
        if name == "state":
            state.said = message
            state.searching |= message.get("state") == SearchState.SEARCHING
            state.aim = message.get("toward_xy") or state.aim
        elif name == "decision":
            state.decisions = (*state.decisions, message)


def _deliver(run: EpisodeRun, runtime: Runtime, state: _State, frame: _Frame, sight: Shot) -> None:
    """Publish a frame as it was when it was asked for, and take note of what is known by now."""
    tally, robot, when = run.tally, frame.robot, frame.when
    run.witness.look(when.step, robot.pose, sight.true_depth_m, sight.segmentation)
    reported = robot.odometry(run.start)
    sensed = run.mishaps.sense(when, Sensed(sight.rgb, sight.depth_m, reported, frame.stamp_ns))
    if sensed is not None:
        _publish(run, runtime, robot.pose, sensed, sight)
    tally.steps += 1
    said, action = state.said or {}, Action.STOP if tally.robot.stopped else Action.MOVE_FORWARD
    run.witness.hear(when.step, said, state.decisions, to_scene(robot.pose, reported))
    tally.decisions += len(state.decisions)
    tally.reason = str(said.get("reason", "")) or tally.reason
    tally.stages = said.get("seconds", tally.stages)
    collided = tally.robot.collisions > state.collisions
    run.witness.moved(robot, str(said.get("mode", "")), "velocity", collided)
    twist = Twist(robot.twist.v_mps, robot.twist.w_radps)
    answer = Answer(action, said, state.decisions, twist)
    run.watch(Step(when.step, answer, robot, run.home.distance_m(robot.pose)))
    state.decisions, state.collisions = (), tally.robot.collisions


def _publish(run: EpisodeRun, runtime: Runtime, pose: Pose, sensed: Sensed, sight: Shot) -> None:
    protocol, stamp_ns = run.protocol, sensed.stamp_ns
    scanner = run.home.scan if protocol.laser else None
    if scanner is not None:
        runtime.publish(SCAN, encode_scan(scanner(pose), stamp_ns))
    if run.how.labels:
        labels = true_labels(run.home.scene, pose, sight.segmentation, sight.true_depth_m)
        labels = boxes_alone(labels) if run.how.labels == "boxes" else labels
        runtime.publish("labels", wire.encode_json({"stamp_ns": stamp_ns, **labels}))
    runtime.publish("camera_info", wire.encode_camera_info(protocol.intrinsics, stamp_ns))
    runtime.publish("depth", wire.encode_depth(sensed.depth_m, stamp_ns))
    runtime.publish("color", wire.encode_color(sensed.rgb, stamp_ns))
