"""One episode, from the goal to its result. `lockstep` drives it step by step."""

import json
import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from hil_sim.driving.link import HarnessError
from hil_sim.driving.lockstep import EpisodeRun, Tally, drive
from hil_sim.driving.methods import method_named
from hil_sim.driving.stage import Driver, RenderedView, StagedHome, Step
from hil_sim.ground_truth.episodes import Episode
from hil_sim.ground_truth.metrics import Outcome, soft_spl, spl
from hil_sim.ground_truth.witness import TRACK_FILE, Witness
from hil_sim.simulation.faults import Fault
from hil_sim.simulation.mishaps import Mishaps
from hil_sim.simulation.protocol import Ending, Protocol
from hil_sim.simulation.robot import Robot
from runtime.core.types import Pose

__all__ = ["EpisodeResult", "RenderedView", "StagedHome", "Step", "run_episode"]

EPISODE_FILE = "episode.json"


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


def run_episode(
    episode: Episode,
    home: StagedHome,
    runtime: Driver,
    protocol: Protocol,
    method: str,
    log_dir: Path,
    watch: Callable[[Step], None] = lambda step: None,
    faults: tuple[Fault, ...] = (),
    seed: int = 0,
    play: Callable[[EpisodeRun], None] = drive,
) -> EpisodeResult:
    """Drive one episode. What the runtime fails at becomes the result's `ended`; HarnessError is
    raised only when it refuses the goal. `seed` is that of noise and faults; `play` drives: in
    lockstep, or in real time (`realtime.drive`)."""
    began_s = time.monotonic()
    how = method_named(method)
    log_dir.mkdir(parents=True, exist_ok=True)
    (log_dir / EPISODE_FILE).write_text(json.dumps(asdict(episode), indent=1) + "\n")
    _give_goal(episode, runtime, (*protocol.settings, *how.settings), log_dir)
    start = Pose(episode.start.x_m, episode.start.y_m, episode.start.yaw_rad)
    witness = Witness(home.wanted, home.goal_boxes, home.distance_m, log_dir / TRACK_FILE)
    mishaps = Mishaps(faults, seed, episode.id, home.scene, home.ground, home.populate)
    run = EpisodeRun(
        episode.id, start, home, runtime, protocol, how, witness, mishaps, seed, watch,
        Tally(Robot(start)),
    )  # fmt: skip
    try:
        play(run)
        ended = "stop" if run.tally.robot.stopped else "steps"
    except HarnessError as error:
        ended = f"error: {error}"
    finally:
        witness.close()
        home.populate(())
    ended = _take_back(run, ended)
    return _result(episode, run, method, ended, time.monotonic() - began_s)


def _give_goal(episode: Episode, runtime: Driver, settings: tuple[str, ...], log_dir: Path) -> None:
    request: dict[str, object] = {
        "goal": episode.goal,
        "episode": episode.id,
        "log_dir": str(log_dir.resolve()),
        "settings": list(settings),
    }
    reply = runtime.ask("goal", request)
    if not reply.get("accepted"):
        raise HarnessError(str(reply.get("error") or "the runtime refused the goal"))
    runtime.forget()


def _take_back(run: EpisodeRun, ended: str) -> str:
    """End the search; the reply holds the time by stage. Returns how the episode ended."""
    try:
        reply = run.driver.ask("cancel", {"reason": ended})
        run.tally.stages = reply.get("seconds", run.tally.stages)
    except HarnessError as error:
        return ended if ended.startswith("error") else f"error: {error}"
    return ended


def _result(
    episode: Episode, run: EpisodeRun, method: str, ended: str, took_s: float
) -> EpisodeResult:
    tally, protocol = run.tally, run.protocol
    distance_m = run.home.distance_m(tally.robot.pose)
    end = Ending(tally.robot.stopped, distance_m, run.witness.sightings)
    success = not ended.startswith("error") and protocol.success(end)
    shortest_m = episode.shortest_path_m
    outcome = Outcome(success, shortest_m, tally.robot.path_m, distance_m, tally.steps)
    wall = {
        "render": tally.render_s,
        "bus": max(0.0, tally.answer_s - tally.thinking_s),
        **{f"runtime.{stage}": float(s) for stage, s in sorted(tally.stages.items())},
        "total": took_s,
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
        **vars(run.witness.facts()),
        stopped=tally.halted,
        fault="; ".join(fault.text for fault in run.mishaps.faults),
        wall={stage: round(seconds, 4) for stage, seconds in wall.items()},
    )


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 4)
