"""One episode, from the goal to its result. `lockstep` drives it step by step."""

import json
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path

from hil_sim.driving.drawn_bounds import UNBOUND, DrawnBounds
from hil_sim.driving.episode_result import End, Ended, EpisodeResult
from hil_sim.driving.link import HarnessError
from hil_sim.driving.lockstep import EpisodeRun, Tally, drive
from hil_sim.driving.methods import method_named
from hil_sim.driving.stage import Driver, StagedHome, Step
from hil_sim.driving.told_votes import HarnessVotes
from hil_sim.ground_truth.episodes import Episode
from hil_sim.ground_truth.metrics import Outcome, soft_spl, spl
from hil_sim.ground_truth.witness import TRACK_FILE, Witness
from hil_sim.simulation.faults import Fault
from hil_sim.simulation.mishaps import Mishaps
from hil_sim.simulation.protocol import Ending, Protocol
from hil_sim.simulation.robot import Robot
from runtime.core.types import Pose

EPISODE_FILE = "episode.json"


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
    settings: tuple[str, ...] = (),
    bounds: DrawnBounds = UNBOUND,
    voter: HarnessVotes | None = None,
) -> EpisodeResult:
    """Drive one episode. What the runtime fails at becomes the result's `ended`; HarnessError is
    raised only when it refuses the goal, or the method's votes are the harness's and no `voter`
    casts them. `seed` is that of noise and faults; `play` drives: in lockstep, or in real time
    (`realtime.drive`); `settings` of this search come last. `bounds`: what people have drawn."""
    began_s = time.monotonic()
    how = method_named(method)
    if how.casts and voter is None:
        raise HarnessError(f"method {method}: votes are cast by `hil-sim eval` alone, in lockstep")
    log_dir.mkdir(parents=True, exist_ok=True)
    (log_dir / EPISODE_FILE).write_text(json.dumps(asdict(episode), indent=1) + "\n")
    start = Pose(episode.start.x_m, episode.start.y_m, episode.start.yaw_rad)
    asked = (*protocol.settings, *how.settings, *settings), bounds.draw(runtime, start)
    _give_goal(episode, runtime, *asked, log_dir)
    witness = _witness(home, log_dir)
    mishaps = Mishaps(faults, seed, episode.id, home.scene, home.ground, home.populate)
    run = EpisodeRun(
        episode.id, start, home, runtime, protocol, how, witness, mishaps, seed, watch,
        Tally(Robot(start)), voter=voter,
    )  # fmt: skip
    try:
        play(run)
        ended = Ended(_end(run.tally.robot))
    except HarnessError as error:
        ended = Ended(End.ERROR, str(error))
    finally:
        witness.close()
        home.populate(())
    ended = _take_back(run, ended)
    bounds.wipe(runtime)
    return _result(episode, run, method, ended, time.monotonic() - began_s)


def _witness(home: StagedHome, log_dir: Path) -> Witness:
    track = log_dir / TRACK_FILE
    return Witness(home.wanted, home.goal_boxes, home.distance_m, track, home.things)


def _end(robot: Robot) -> End:
    if robot.fell:
        return End.FELL
    return End.STOP if robot.stopped else End.STEPS


def _give_goal(
    episode: Episode,
    runtime: Driver,
    settings: tuple[str, ...],
    bound: Mapping[str, object],
    log_dir: Path,
) -> None:
    request: dict[str, object] = {
        "goal": episode.goal,
        "episode": episode.id,
        "log_dir": str(log_dir.resolve()),
        "settings": list(settings),
        **bound,
    }
    reply = runtime.ask("goal", request)
    if not reply.get("accepted"):
        raise HarnessError(str(reply.get("error") or "the runtime refused the goal"))
    runtime.forget()


def _take_back(run: EpisodeRun, ended: Ended) -> Ended:
    """End the search; the reply holds the time by stage. Returns how the episode ended."""
    try:
        reply = run.driver.ask("cancel", {"reason": str(ended)})
        run.tally.stages = reply.get("seconds", run.tally.stages)
    except HarnessError as error:
        return ended if ended.failed else Ended(End.ERROR, str(error))
    return ended


def _result(
    episode: Episode, run: EpisodeRun, method: str, ended: Ended, took_s: float
) -> EpisodeResult:
    tally, protocol = run.tally, run.protocol
    distance_m = run.home.distance_m(tally.robot.pose)
    end = Ending(tally.robot.stopped, distance_m, run.witness.sightings)
    success = ended.end is End.STOP and protocol.success(end)
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
