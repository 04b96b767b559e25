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
from hil_sim.link import Answer, HarnessError, Runtime
from hil_sim.metrics import Outcome, soft_spl, spl
from hil_sim.protocol import Ending, Protocol
from hil_sim.robot import Ground, Robot, act
from runtime.core.types import Pose

STEP_NS = 500_000_000  # simulated time between two observations
EPISODE_FILE = "episode.json"


class View(Port):
    """What a camera saw."""

    @property
    def rgb(self) -> NDArray[np.uint8]: ...  # (H, W, 3)

    @property
    def depth_m(self) -> NDArray[np.float32]: ...  # (H, W) true, 0 where nothing is


@dataclass(frozen=True)
class Home:
    """A scene that can be looked at and driven in, and the truth about one goal in it."""

    ground: Ground
    look: Callable[[Pose], View]  # scene frame
    distance_m: Callable[[Pose], float]  # geodesic, to the goal's nearest success position


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
    wall: dict[str, float] = field(default_factory=dict)

    @property
    def outcome(self) -> Outcome:
        """What the metrics need."""
        left = math.inf if self.distance_m is None else self.distance_m
        return Outcome(self.success, self.shortest_path_m, self.path_m, left, self.steps)

    @classmethod
    def from_json(cls, row: dict[str, Any]) -> "EpisodeResult":
        return cls(**row)


@dataclass
class _Tally:
    """What adds up while an episode runs."""

    robot: Robot
    steps: int = 0
    decisions: int = 0
    reason: str = ""
    render_s: float = 0.0
    answer_s: float = 0.0
    thinking_s: float = 0.0  # of answer_s, by the runtime's own account
    stages: dict[str, float] = field(default_factory=dict)


def run_episode(
    episode: Episode,
    home: Home,
    runtime: Runtime,
    protocol: Protocol,
    method: str,
    log_dir: Path,
    watch: Callable[[Step], None] = lambda step: None,
) -> EpisodeResult:
    """Drive one episode. What the runtime fails at becomes the result's `ended`; HarnessError is
    raised only when it refuses the goal."""
    began_s = time.monotonic()
    log_dir.mkdir(parents=True, exist_ok=True)
    (log_dir / EPISODE_FILE).write_text(json.dumps(asdict(episode), indent=1) + "\n")
    _give_goal(episode, runtime, log_dir)
    start = Pose(episode.start.x_m, episode.start.y_m, episode.start.yaw_rad)
    tally = _Tally(Robot(start))
    try:
        _drive(tally, start, home, runtime, protocol, watch)
        ended = "stop" if tally.robot.stopped else "steps"
    except HarnessError as error:
        ended = f"error: {error}"
    try:
        tally.stages = runtime.ask("cancel", {"reason": ended}).get("seconds", tally.stages)
    except HarnessError as error:
        ended = ended if ended.startswith("error") else f"error: {error}"
    distance_m = home.distance_m(tally.robot.pose)
    success = not ended.startswith("error") and protocol.success(
        Ending(tally.robot.stopped, distance_m)
    )
    return _result(episode, protocol, method, tally, ended, success, distance_m, began_s)


def _give_goal(episode: Episode, runtime: Runtime, log_dir: Path) -> None:
    reply = runtime.ask(
        "goal", {"goal": episode.goal, "episode": episode.id, "log_dir": str(log_dir.resolve())}
    )
    if not reply.get("accepted"):
        raise HarnessError(str(reply.get("error") or "the runtime refused the goal"))
    runtime.forget()


def _drive(
    tally: _Tally,
    start: Pose,
    home: Home,
    runtime: Runtime,
    protocol: Protocol,
    watch: Callable[[Step], None],
) -> None:
    while not tally.robot.stopped and tally.steps < protocol.max_steps:
        t0 = time.monotonic()
        view = home.look(tally.robot.pose)
        t1 = time.monotonic()
        answer = runtime.exchange(
            (tally.steps + 1) * STEP_NS,
            view.rgb,
            protocol.sensed(view.depth_m),
            tally.robot.odometry(start),
            protocol.intrinsics,
        )
        tally.render_s += t1 - t0
        tally.answer_s += time.monotonic() - t1
        tally.thinking_s += float(answer.state.get("took_s", 0.0))
        tally.stages = answer.state.get("seconds", tally.stages)
        tally.reason = str(answer.state.get("reason", ""))
        tally.decisions += len(answer.decisions)
        tally.steps += 1
        tally.robot = act(tally.robot, answer.action, home.ground, protocol)
        watch(Step(tally.steps, answer, tally.robot, home.distance_m(tally.robot.pose)))


def _result(
    episode: Episode,
    protocol: Protocol,
    method: str,
    tally: _Tally,
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
        wall={stage: round(seconds, 4) for stage, seconds in wall.items()},
    )


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 4)
