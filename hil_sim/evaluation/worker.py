"""A process that drives episodes of one scene with every method, and tells its parent of each.

One scene a process: PyBullet's EGL renderer cannot draw a second one. One runtime serves all
methods that look with the same detector; of one episode they share the frames that more than one of
them looks at.
"""

import functools
import signal
import sys
import traceback
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING

from hil_sim.driving.child import end_with_parent
from hil_sim.driving.episode_result import End, Ended, EpisodeResult
from hil_sim.driving.episode_run import run_episode
from hil_sim.driving.link import HarnessError, Runtime, rfnav_command
from hil_sim.driving.methods import Method, method_named
from hil_sim.driving.rig import camera_of, home_of, open_world, shortest, start_of
from hil_sim.driving.stage import Driver, StagedHome
from hil_sim.driving.told_votes import HarnessVotes
from hil_sim.evaluation.left_out import StartCheck
from hil_sim.evaluation.memo import LIMIT_BYTES, FrameMemo, Render
from hil_sim.ground_truth.episodes import Episode, check_start
from hil_sim.ground_truth.lies_beyond import LiesBeyond
from hil_sim.ground_truth.metrics import spl
from hil_sim.ground_truth.oracle_votes import OracleKnowledge
from hil_sim.scenes.format import SceneError
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.faults import model_fault, parse_faults
from hil_sim.simulation.protocol import Protocol, protocol_named
from hil_sim.simulation.quiet import keep_stdout_for_python
from runtime.errors import RfNavError

if TYPE_CHECKING:  # PyBullet prints when it is imported: see open_world
    from hil_sim.ground_truth.truth import SceneTruth
    from hil_sim.simulation.scene_physics import ScenePhysics

LABELS_PX = (320, 240)
"""Frame size of methods that get all true labels: their colours are never looked at."""

MEMO_FRAMES = 1000
"""Images whose detections the runtime keeps: methods of one episode see many of the same."""


@dataclass(frozen=True)
class Settings:
    """What all workers of an evaluation share."""

    out: Path
    protocol: str = "hm3d"
    config: Path | None = None
    settings: tuple[str, ...] = ()  # `--set` for the runtime
    renderer: str = "auto"
    faults: tuple[str, ...] = ()
    noise: tuple[str, ...] = ()
    sensors: tuple[str, ...] = ()  # beside the camera
    tilt: str = "level"
    seed: int = 0  # of noise and faults
    realtime: bool = False


@dataclass(frozen=True)
class Task:
    """One episode and the methods that have not driven it yet."""

    episode: Episode
    methods: tuple[str, ...]


@dataclass(frozen=True)
class Job:
    """Episodes of one scene."""

    scene: str
    tasks: tuple[Task, ...]

    @property
    def name(self) -> str:
        """For a log file: each episode begins in one job."""
        return self.tasks[0].episode.id.replace("/", "_")

    @property
    def size(self) -> int:
        """How many results it will have."""
        return sum(len(task.methods) for task in self.tasks)


@dataclass(frozen=True)
class Note:
    """Something slow begins."""

    text: str


@dataclass(frozen=True)
class Failure:
    """The worker for `scene` cannot go on, or `episode` cannot be driven (not `fatal`); one line.
    `died`: the worker's process did, and could not say why."""

    text: str
    fatal: bool = True
    scene: str = ""
    episode: str = ""
    died: bool = False


Message = Note | Failure | EpisodeResult | StartCheck
Send = Callable[[Message], None]
Drive = Callable[[Job, Settings, Send], None]
"""What a worker does with a job, in whatever process."""


def work(job: Job, settings: Settings, parent: Connection) -> None:
    """The main function of a process that drives."""
    serve(drive, job, settings, parent)


def serve(does: Drive, job: Job, settings: Settings, parent: Connection) -> None:
    """Do a job in a process of its own; ends early on SIGTERM, taking its runtime along, and when
    its parent has died, however."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    end_with_parent()
    keep_stdout_for_python()
    try:
        does(job, settings, parent.send)
    except RfNavError as error:
        parent.send(Failure(str(error), scene=job.scene))
    finally:
        parent.close()


def drive(job: Job, settings: Settings, send: Send) -> None:
    """Every task of a job, one message for each that is done."""
    assets = Assets()
    methods = {name for task in job.tasks for name in task.methods}
    with ExitStack() as stack:
        asked = [m for m in map(method_named, sorted(methods)) if m.driver == "runtime"]
        standbys = {
            start: stack.enter_context(_Standby(job, settings, method))
            for start, method in {m.start: m for m in asked}.items()
        }
        for standby in standbys.values():
            standby.spawn()  # it loads while the scene does
        world = stack.enter_context(open_world(open_scene(job.scene), assets, settings.renderer))
        for standby in standbys.values():
            standby.ready()  # what it cannot do is said before slow work begins
        from hil_sim.ground_truth.truth import SceneTruth

        truth = SceneTruth(world, assets, lambda text: send(Note(text)))
        rig = _Rig(world, truth, standbys, settings)
        for task in job.tasks:
            try:
                check_start(task.episode, truth.space)
                rig.memo.clear()
                for method in task.methods:
                    send(rig.run(task.episode, method))
            except SceneError as error:
                send(Failure(str(error), False, job.scene, task.episode.id))
            except RfNavError:
                raise
            except Exception as error:  # noqa: BLE001 -- a fault of ours costs one episode
                traceback.print_exc()
                for standby in standbys.values():
                    standby.close()
                why = " ".join(f"{type(error).__name__}: {error}".split())
                send(Failure(f"{task.episode.id}: {why}", False, job.scene, task.episode.id))


class _Rig:
    """One scene with a robot in it, for one method's episode after another."""

    def __init__(
        self,
        world: "ScenePhysics",
        truth: "SceneTruth",
        standbys: "Mapping[tuple[str, ...], _Standby]",
        settings: Settings,
    ) -> None:
        self._world, self._truth, self._standbys = world, truth, standbys
        self._settings = settings
        self._lies = functools.cache(lambda: LiesBeyond.of(truth.space))
        self._faults = parse_faults(settings.faults)
        # Who walks in front of the camera must be in every frame.
        self.memo = FrameMemo(_renderer(world), 0 if self._faults else LIMIT_BYTES)

    def run(self, episode: Episode, name: str) -> EpisodeResult:
        """Drive one episode; what goes wrong with the runtime is in the result."""
        method = method_named(name)
        protocol = protocol_for(self._settings, method)
        camera, tilt = camera_of(protocol), protocol.tilt_rad
        home = home_of(
            self._world, self._truth, protocol, episode.goal,
            lambda pose: self.memo.look(pose, camera, tilt, method.labels != "all"),
        )  # fmt: skip
        home.distance_m(start_of(episode))  # what is slow happens before the clock runs
        self.memo.reset()
        try:
            result = self._episode(episode, name, method, home, protocol)
        except HarnessError as error:  # the goal was refused
            away_m = home.distance_m(start_of(episode))
            result = refused(episode, protocol, name, str(error), away_m)
        if result.ended.failed and method.start in self._standbys:
            self._standbys[method.start].close()
        frames = {"rendered": self.memo.rendered, "recalled": self.memo.recalled}
        return replace(result, wall={**result.wall, **frames})

    def _episode(
        self, episode: Episode, name: str, method: Method, home: StagedHome, protocol: Protocol
    ) -> EpisodeResult:
        driver: Driver
        if method.driver == "shortest":
            driver, home = shortest(self._truth, home, episode, protocol)
        else:
            driver = self._standbys[method.start].ready()
        log_dir, seed = self._settings.out / name / episode.id, self._settings.seed
        if isinstance(driver, Runtime) and self._settings.realtime:
            from hil_sim.driving.realtime import run_realtime

            return run_realtime(
                episode, home, driver, protocol, name, log_dir,
                faults=self._faults, seed=seed, renderer=self._settings.renderer,
            )  # fmt: skip
        voter = None
        if method.casts:
            known = OracleKnowledge(self._truth, episode.goal, self._lies)
            voter = HarnessVotes(method.casts, known, episode.id, seed)
        return run_episode(
            episode, home, driver, protocol, name, log_dir, faults=self._faults, seed=seed,
            voter=voter,
        )  # fmt: skip


def protocol_for(settings: Settings, method: Method) -> Protocol:
    """The protocol as a method sees it: those that look at no colours have smaller frames."""
    protocol = protocol_named(settings.protocol, settings.tilt, settings.noise, settings.sensors)
    if method.driver == "shortest" and (protocol.base is not None or settings.realtime):
        raise HarnessError("oracle-goal: takes steps and turns; choose hm3d or robothor, lockstep")
    if method.casts and settings.realtime:
        raise HarnessError("votes of the harness's are for lockstep; leave --realtime out")
    if method.labels == "all":
        width, height = LABELS_PX
        protocol = replace(protocol, width=width, height=height)
    return protocol


def _renderer(world: "ScenePhysics") -> Render:
    return lambda x, y, yaw, camera, pitch, colour: world.render(
        x, y, yaw, camera, pitch, colour=colour
    )


def refused(
    episode: Episode, protocol: Protocol, method: str, why: str, distance_m: float
) -> EpisodeResult:
    """The result of an episode that never began; `distance_m` is its start's, to success."""
    blank = EpisodeResult(
        episode=episode.id,
        scene=episode.scene,
        goal=episode.goal,
        method=method,
        protocol=protocol.name,
        success=False,
        ended=Ended(End.ERROR, why),
        steps=0,
        collisions=0,
        decisions=0,
        shortest_path_m=episode.shortest_path_m,
        path_m=0.0,
        distance_m=distance_m,
        spl=None,
        soft_spl=0.0,
    )
    return replace(blank, spl=spl(blank.outcome))


class _Standby:
    """A runtime that loads while the scene does, and comes back after it has failed: for a method
    and all that start it as that does."""

    def __init__(self, job: Job, settings: Settings, method: Method) -> None:
        name = f"{job.name}-{method.eyes}" if method.eyes else job.name
        self._log = settings.out / "logs" / f"runtime-{name}.log"
        mode = () if settings.realtime else ("--lockstep",)
        command, more = model_fault(parse_faults(settings.faults), mode)
        self._command = command or rfnav_command(mode)
        memo = f"research.detector_memo_frames={MEMO_FRAMES}"
        self._settings = (memo, *settings.settings, *more, *method.start)
        self._config = settings.config
        self._runtime: Runtime | None = None
        self._entered = False

    def __enter__(self) -> "_Standby":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def spawn(self) -> Runtime:
        """Begin to load, if nothing is loaded."""
        if self._runtime is None:
            self._runtime = Runtime(self._log, self._config, self._settings, self._command)
        return self._runtime

    def ready(self) -> Runtime:
        """The runtime; RfNavError when it cannot start."""
        runtime = self.spawn()
        if not self._entered:
            try:
                runtime.__enter__()
            except HarnessError as error:
                raise RfNavError(str(error)) from error
            self._entered = True
        return runtime

    def close(self) -> None:
        """End it, if it runs; the next `ready` starts another."""
        if self._runtime is not None:
            self._runtime.close()
        self._runtime, self._entered = None, False
