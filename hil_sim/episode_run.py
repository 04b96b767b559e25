"""One episode in lockstep: render, publish, wait for the action, move; then judge."""

import json
import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any
from typing import Protocol as Port

import numpy as np
from numpy.typing import NDArray

from hil_sim.episodes import Episode
from hil_sim.link import Answer, HarnessError
from hil_sim.methods import Method, method_named
from hil_sim.metrics import Outcome, soft_spl, spl
from hil_sim.protocol import Ending, Protocol
from hil_sim.robot import Ground, Robot, act
from hil_sim.scene import Scene
from hil_sim.sightings import true_labels
from hil_sim.witness import TRACK_FILE, Facts, Footprint, Witness, to_scene
from runtime.core.types import Intrinsics, Pose

STEP_NS = 500_000_000  # simulated time between two observations
EPISODE_FILE = "episode.json"


class View(Port):
    """What a camera saw."""

    @property
    def rgb(self) -> NDArray[np.uint8]: ...  # (H, W, 3)

    @property
    def depth_m(self) -> NDArray[np.float32]: ...  # (H, W) true, 0 where nothing is

    @property
    def segmentation(self) -> NDArray[np.int32]: ...  # (H, W) index into scene.objects, or -1


class Driver(Port):
    """Whoever answers observations with actions: the runtime, or a bound that stands in for it."""

    def ask(self, query: str, body: dict[str, object]) -> Any: ...

    def forget(self) -> None: ...

    def exchange(
        self,
        stamp_ns: int,
        rgb: NDArray[np.uint8],
        depth_m: NDArray[np.float32],
        odometry: Pose,
        intrinsics: Intrinsics,
        labels: dict[str, Any] | None = None,
    ) -> Answer: ...


@dataclass(frozen=True)
class Home:
    """A scene that can be looked at and driven in, and the truth about one goal in it.

    `wanted` are the indices of the goal's instances in `scene.objects` and in the segmentation,
    `goal_boxes` their footprints.
    """

    ground: Ground
    look: Callable[[Pose], View]  # scene frame
    distance_m: Callable[[Pose], float]  # geodesic, to the goal's nearest success position
    scene: Scene
    wanted: tuple[int, ...]
    goal_boxes: tuple[Footprint, ...]


@dataclass(frozen=True)
class Step:
    """What happened in one step, for whoever watches."""

    number: int
    answer: Answer
    robot: Robot  # after the action
    distance_m: float


@dataclass(frozen=True)
class EpisodeResult:
    """One finished episode. `ended`: "stop", "steps" (none left) or "error: ...".

    Steps count from 1, an observation each. `seen_at`: the first at which an instance of the goal
    truly showed 200 pixels within 5 m; `seen_steps`: at how many. `believed_at`: the first at which
    the runtime went for a point within 0.5 m of an instance. `claim`: whether the place that it
    stopped for is one ("true", "false"; "" when no find was claimed). `frontier_m`: for each
    decision, the true way from the elected frontier to success, unless there is none. `actions`:
    steps by the runtime's mode. `stopped`: it ended standing still. `fault`: what was done to it.
    `wall` holds wall-clock seconds and nothing else does.
    """

    episode: str
    scene: str
    goal: str
    method: str
    protocol: str
    success: bool
    ended: str
    steps: int
    collisions: int
    decisions: int
    shortest_path_m: float
    path_m: float
    distance_m: float | None  # to success at the end; None when cut off from it
    spl: float | None  # None: too short a way to say anything
    soft_spl: float | None
    reason: str = ""  # the runtime's own, for its last action
    seen_at: int | None = None
    seen_steps: int = 0
    believed_at: int | None = None
    claim: str = ""
    frontier_m: tuple[float, ...] = ()
    actions: dict[str, int] = field(default_factory=dict)
    stopped: bool = False
    fault: str = ""
    wall: dict[str, float] = field(default_factory=dict)

    @property
    def outcome(self) -> Outcome:
        """What the metrics need."""
        left = math.inf if self.distance_m is None else self.distance_m
        return Outcome(self.success, self.shortest_path_m, self.path_m, left, self.steps)

    @classmethod
    def from_json(cls, row: dict[str, Any]) -> "EpisodeResult":
        return cls(**{**row, "frontier_m": tuple(row.get("frontier_m", ()))})


@dataclass
class _Tally:
    """What adds up while an episode runs."""

    robot: Robot
    steps: int = 0
    decisions: int = 0
    reason: str = ""
    halted: bool = True  # the base has nothing left to do
    render_s: float = 0.0
    answer_s: float = 0.0
    thinking_s: float = 0.0  # of answer_s, by the runtime's own account
    stages: dict[str, float] = field(default_factory=dict)


def run_episode(
    episode: Episode,
    home: Home,
    runtime: Driver,
    protocol: Protocol,
    method: str,
    log_dir: Path,
    watch: Callable[[Step], None] = lambda step: None,
) -> EpisodeResult:
    """Drive one episode. What the runtime fails at becomes the result's `ended`; HarnessError is
    raised only when it refuses the goal."""
    began_s = time.monotonic()
    how = method_named(method)
    log_dir.mkdir(parents=True, exist_ok=True)
    (log_dir / EPISODE_FILE).write_text(json.dumps(asdict(episode), indent=1) + "\n")
    _give_goal(episode, runtime, how, log_dir)
    start = Pose(episode.start.x_m, episode.start.y_m, episode.start.yaw_rad)
    tally = _Tally(Robot(start))
    witness = Witness(home.wanted, home.goal_boxes, home.distance_m, log_dir / TRACK_FILE)
    try:
        _drive(tally, start, home, runtime, protocol, how, witness, watch)
        ended = "stop" if tally.robot.stopped else "steps"
    except HarnessError as error:
        ended = f"error: {error}"
    finally:
        witness.close()
    try:
        tally.stages = runtime.ask("cancel", {"reason": ended}).get("seconds", tally.stages)
    except HarnessError as error:
        ended = ended if ended.startswith("error") else f"error: {error}"
    distance_m = home.distance_m(tally.robot.pose)
    success = not ended.startswith("error") and protocol.success(
        Ending(tally.robot.stopped, distance_m)
    )
    return _result(
        episode, protocol, method, tally, witness.facts(), ended, success, distance_m, began_s
    )


def _give_goal(episode: Episode, runtime: Driver, how: Method, log_dir: Path) -> None:
    request: dict[str, object] = {
        "goal": episode.goal,
        "episode": episode.id,
        "log_dir": str(log_dir.resolve()),
        "settings": list(how.settings),
    }
    reply = runtime.ask("goal", request)
    if not reply.get("accepted"):
        raise HarnessError(str(reply.get("error") or "the runtime refused the goal"))
    runtime.forget()


def _drive(
    tally: _Tally,
    start: Pose,
    home: Home,
    runtime: Driver,
    protocol: Protocol,
    how: Method,
    witness: Witness,
    watch: Callable[[Step], None],
) -> None:
    while not tally.robot.stopped and tally.steps < protocol.max_steps:
        tally.halted = True
        before, number = tally.robot, tally.steps + 1
        t0 = time.monotonic()
        view = home.look(before.pose)
        t1 = time.monotonic()
        witness.look(number, before.pose, view.depth_m, view.segmentation)
        reported = before.odometry(start)
        answer = runtime.exchange(
            number * STEP_NS,
            view.rgb,
            protocol.sensed(view.depth_m),
            reported,
            protocol.intrinsics,
            true_labels(home.scene, before.pose, view.segmentation) if how.labels else None,
        )
        tally.render_s += t1 - t0
        _note(tally, answer, time.monotonic() - t1)
        witness.hear(number, answer.state, answer.decisions, to_scene(before.pose, reported))
        tally.robot = act(before, answer.action, home.ground, protocol)
        tally.halted = tally.robot.stopped
        mode = str(answer.state.get("mode", ""))
        collided = tally.robot.collisions > before.collisions
        witness.moved(tally.robot, mode, answer.action.value, collided)
        watch(Step(number, answer, tally.robot, home.distance_m(tally.robot.pose)))


def _note(tally: _Tally, answer: Answer, took_s: float) -> None:
    tally.answer_s += took_s
    tally.thinking_s += float(answer.state.get("took_s", 0.0))
    tally.stages = answer.state.get("seconds", tally.stages)
    tally.reason = str(answer.state.get("reason", ""))
    tally.decisions += len(answer.decisions)
    tally.steps += 1


def _result(
    episode: Episode,
    protocol: Protocol,
    method: str,
    tally: _Tally,
    facts: Facts,
    ended: str,
    success: bool,
    distance_m: float,
    began_s: float,
) -> EpisodeResult:
    shortest_m = episode.shortest_path_m
    outcome = Outcome(success, shortest_m, tally.robot.path_m, distance_m, tally.steps)
    wall = {
        "render": tally.render_s,
        "bus": max(0.0, tally.answer_s - tally.thinking_s),
        **{f"runtime.{stage}": float(s) for stage, s in sorted(tally.stages.items())},
        "total": time.monotonic() - began_s,
    }
    return EpisodeResult(
        episode=episode.id,
        scene=episode.scene,
        goal=episode.goal,
        method=method,
        protocol=protocol.name,
        success=success,
        ended=ended,
        steps=tally.steps,
        collisions=tally.robot.collisions,
        decisions=tally.decisions,
        shortest_path_m=shortest_m,
        path_m=round(tally.robot.path_m, 4),
        distance_m=round(distance_m, 4) if math.isfinite(distance_m) else None,
        spl=_rounded(spl(outcome)),
        soft_spl=_rounded(soft_spl(outcome)),
        reason=tally.reason,
        **vars(facts),
        stopped=tally.halted,
        wall={stage: round(seconds, 4) for stage, seconds in wall.items()},
    )


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 4)
