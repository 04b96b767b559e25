"""An episode in lockstep: look, tell, wait for the answer, move; simulated time waits meanwhile."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from hil_sim.driving.link import Answer, Runtime
from hil_sim.driving.methods import Method
from hil_sim.driving.stage import Driver, RenderedView, StagedHome, Step
from hil_sim.driving.told_votes import HarnessVotes
from hil_sim.ground_truth.true_labels import boxes_alone, true_labels
from hil_sim.ground_truth.witness import Witness, to_scene
from hil_sim.simulation.drive import drive as roll
from hil_sim.simulation.drive import ordered, still
from hil_sim.simulation.faults import Sensed, When
from hil_sim.simulation.mishaps import Mishaps
from hil_sim.simulation.noise import generator
from hil_sim.simulation.protocol import Protocol
from hil_sim.simulation.robot import Robot, act, wrapped
from hil_sim.simulation.sensors import beside, sense
from runtime.core.types import Action, Pose, Twist
from runtime.errors import ConfigError

NO_COMMAND = "none"
BRAKE_S = 1.0
"""What a rolling base is given to come to rest after stop."""


@dataclass
class Tally:
    """What adds up while an episode runs."""

    robot: Robot
    steps: int = 0
    decisions: int = 0
    reason: str = ""
    halted: bool = True  # the base stands, and nothing has told it to go on
    render_s: float = 0.0
    answer_s: float = 0.0
    thinking_s: float = 0.0  # of answer_s, by the runtime's own account
    stages: dict[str, float] = field(default_factory=dict)


@dataclass
class EpisodeRun:
    """One episode under way."""

    episode: str
    start: Pose
    home: StagedHome
    driver: Driver
    protocol: Protocol
    how: Method
    witness: Witness
    mishaps: Mishaps
    seed: int
    watch: Callable[[Step], None]
    tally: Tally
    last_yaw_rad: float | None = None
    voter: HarnessVotes | None = None  # casts votes that are the harness's

    def when(self) -> When:
        """The moment of the observation that is due."""
        return When(self.tally.steps + 1, self.tally.steps * self.protocol.observe_s)


def drive(run: EpisodeRun) -> None:
    """Step until the runtime says stop, the robot falls, or no steps are left."""
    _check(run)
    while not run.tally.robot.over and run.tally.steps < run.protocol.max_steps:
        run.tally.halted = still(run.tally.robot)
        _step(run)
    if isinstance(run.driver, Runtime):
        run.driver.call_again()  # where the link was lost to the end


def _check(run: EpisodeRun) -> None:
    for fault in run.mishaps.faults:
        if fault.kind.realtime:
            raise ConfigError(f"fault {fault.name}: there is none in lockstep; add --realtime")
    if any(fault.name == "clock-step" and fault.size < 0 for fault in run.mishaps.faults):
        raise ConfigError(
            "fault clock-step: size: must be positive in lockstep, where stamps tell steps apart"
        )


def _step(run: EpisodeRun) -> None:
    tally, when = run.tally, run.when()
    before = tally.robot
    run.mishaps.move_bodies(when, before.pose)
    began_s = time.monotonic()
    view = run.home.look(before.pose)
    tally.render_s += time.monotonic() - began_s
    run.witness.look(when.step, before.pose, view.depth_m, view.segmentation)
    sensed = run.mishaps.sense(when, _sensed(run, view, when))
    _mind_the_link(run, when)
    answer = _told(run, view, sensed) if sensed is not None else None
    tally.steps += 1
    if answer is not None and sensed is not None:
        where = to_scene(before.pose, sensed.odometry)
        run.witness.hear(when.step, answer.state, answer.decisions, where)
    deaf = run.mishaps.deaf(when)
    tally.robot = _moved(run, before, answer, deaf, when)
    # A discrete base that was told to move would have gone on.
    tally.halted = still(tally.robot) and (
        answer is None or tally.robot.over or deaf or run.protocol.base is not None
    )
    mode = str(answer.state.get("mode", "")) if answer is not None else ""
    action = answer.action.value if answer is not None else NO_COMMAND
    run.witness.moved(tally.robot, mode, action, tally.robot.collisions > before.collisions)
    run.watch(Step(when.step, answer, tally.robot, run.home.distance_m(tally.robot.pose)))


def _sensed(run: EpisodeRun, view: RenderedView, when: When) -> Sensed:
    """What the robot's sensors make of a view."""
    protocol, robot = run.protocol, run.tally.robot
    last = robot.pose.yaw_rad if run.last_yaw_rad is None else run.last_yaw_rad
    turned_radps = wrapped(robot.pose.yaw_rad - last) / protocol.observe_s
    run.last_yaw_rad = robot.pose.yaw_rad
    rng = generator(run.seed, run.episode, when.step, "camera")
    rgb, depth_m = sense(view, run.home.scene, protocol, turned_radps, rng)
    stamp_ns = round(when.step * protocol.observe_s * 1e9)
    return Sensed(rgb, depth_m, robot.odometry(run.start), stamp_ns)


def _mind_the_link(run: EpisodeRun, when: When) -> None:
    """Close the link while it is lost, and open it again."""
    driver = run.driver
    if isinstance(driver, Runtime) and any(f.name == "link-lost" for f in run.mishaps.faults):
        if run.mishaps.active("link-lost", when):
            driver.hang_up()
        else:
            driver.call_again()


def _told(run: EpisodeRun, view: RenderedView, sensed: Sensed) -> Answer:
    tally, home, pose = run.tally, run.home, run.tally.robot.pose
    labels = None
    if run.how.labels:
        labels = true_labels(home.scene, pose, view.segmentation, view.depth_m)
        labels = boxes_alone(labels) if run.how.labels == "boxes" else labels
    scanner = home.scan if run.protocol.laser else None
    ranges_m = scanner(pose) if scanner is not None else None
    below_m = home.cliffs(pose) if home.cliffs is not None else {}
    voter, in_scene = run.voter, to_scene(pose, sensed.odometry)
    began_s = time.monotonic()
    answer = run.driver.exchange(
        sensed.stamp_ns,
        sensed.rgb,
        sensed.depth_m,
        sensed.odometry,
        run.protocol.intrinsics,
        labels,
        beside(run.protocol, ranges_m, tally.robot.touching, below_m, sensed.stamp_ns),
        (lambda question: voter.answer(question, in_scene)) if voter is not None else None,
    )
    tally.answer_s += time.monotonic() - began_s
    tally.thinking_s += float(answer.state.get("took_s", 0.0))
    tally.stages = answer.state.get("seconds", tally.stages)
    tally.reason = str(answer.state.get("reason", ""))
    tally.decisions += len(answer.decisions)
    return answer


def _moved(run: EpisodeRun, robot: Robot, answer: Answer | None, deaf: bool, when: When) -> Robot:
    """The robot at the next observation."""
    protocol, ground = run.protocol, run.home.ground
    rng = generator(run.seed, run.episode, when.step, "base")
    stop = answer is not None and answer.action is Action.STOP
    if protocol.base is None:
        if answer is None or (deaf and not stop):
            return robot
        return act(robot, answer.action, ground, protocol, rng)
    if answer is not None and not deaf:
        robot = ordered(robot, Twist() if stop else answer.twist, protocol.base)
    robot = roll(robot, protocol.observe_s, ground, protocol.base, protocol.noise, rng)
    if stop:
        robot = roll(robot, BRAKE_S, ground, protocol.base, protocol.noise, rng)
    return replace(robot, stopped=stop)
