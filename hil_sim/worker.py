"""A process that drives episodes of one scene with one method, and tells its parent of each.

One scene a process: PyBullet's EGL renderer cannot draw a second one.
"""

import signal
import sys
from contextlib import ExitStack
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING

from hil_sim.assets import Assets
from hil_sim.episode_run import EpisodeResult, Home, run_episode
from hil_sim.episodes import Episode, check_start
from hil_sim.link import HarnessError, Runtime, method_settings
from hil_sim.metrics import spl
from hil_sim.protocol import Protocol, protocol_named
from hil_sim.quiet import hushed, keep_stdout_for_python
from hil_sim.scene import Scene, load_scene
from runtime.core.types import Pose
from runtime.errors import RfNavError

if TYPE_CHECKING:  # PyBullet prints when it is imported: see open_world
    from hil_sim.truth import Truth
    from hil_sim.world import World


@dataclass(frozen=True)
class Settings:
    """What all workers of an evaluation share."""

    out: Path
    protocol: str = "hm3d"
    config: Path | None = None
    settings: tuple[str, ...] = ()  # `--set` for the runtime
    renderer: str = "auto"


@dataclass(frozen=True)
class Job:
    """Episodes of one scene for one method."""

    method: str
    scene: str
    episodes: tuple[Episode, ...]


@dataclass(frozen=True)
class Note:
    """Something slow begins."""

    text: str


@dataclass(frozen=True)
class Failure:
    """The worker cannot go on; one line."""

    text: str


Message = Note | Failure | EpisodeResult


def work(job: Job, settings: Settings, parent: Connection) -> None:
    """The process's main function; ends early on SIGTERM, taking its runtime along."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    keep_stdout_for_python()
    try:
        _drive(job, settings, parent)
    except RfNavError as error:
        parent.send(Failure(str(error)))
    finally:
        parent.close()


def open_world(scene: Scene, assets: Assets, renderer: str) -> "World":
    """A scene in PyBullet, without the lines that PyBullet and EGL print when they start."""
    with hushed():
        from hil_sim.world import World

        return World(scene, assets, renderer)


def home_of(world: "World", truth: "Truth", protocol: Protocol, goal: str) -> Home:
    """A world, seen through the protocol's camera, and the truth about one goal."""
    from hil_sim.world import Camera

    camera = Camera(protocol.width, protocol.height, protocol.hfov_rad, protocol.camera_z_m)
    return Home(
        ground=world,
        look=lambda pose: world.render(pose.x_m, pose.y_m, pose.yaw_rad, camera),
        distance_m=lambda pose: truth.distance_m(goal, pose),
    )


def _drive(job: Job, settings: Settings, parent: Connection) -> None:
    protocol = protocol_named(settings.protocol)
    assets = Assets()
    with ExitStack() as stack:
        runtime = stack.enter_context(_Standby(job, settings))
        world = stack.enter_context(open_world(load_scene(job.scene), assets, settings.renderer))
        runtime.ready()  # what it cannot do is said before slow work begins
        from hil_sim.truth import Truth

        truth = Truth(world, assets, lambda text: parent.send(Note(text)))
        for episode in job.episodes:
            check_start(episode, truth.space)
            home = home_of(world, truth, protocol, episode.goal)
            home.distance_m(_start(episode))  # what is slow happens before the clock runs
            log_dir = settings.out / job.method / episode.id
            try:
                result = run_episode(episode, home, runtime.ready(), protocol, job.method, log_dir)
            except HarnessError as error:  # the goal was refused
                result = refused(episode, protocol, job.method, str(error), home)
            if result.ended.startswith("error"):
                runtime.restart()
            parent.send(result)


def refused(
    episode: Episode, protocol: Protocol, method: str, why: str, home: Home
) -> EpisodeResult:
    """The result of an episode that never began."""
    blank = EpisodeResult(
        episode=episode.id,
        scene=episode.scene,
        goal=episode.goal,
        method=method,
        protocol=protocol.name,
        success=False,
        ended=f"error: {why}",
        steps=0,
        collisions=0,
        decisions=0,
        shortest_path_m=episode.shortest_path_m,
        path_m=0.0,
        distance_m=home.distance_m(_start(episode)),
        spl=None,
        soft_spl=0.0,
    )
    return replace(blank, spl=spl(blank.outcome))


def _start(episode: Episode) -> Pose:
    return Pose(episode.start.x_m, episode.start.y_m, episode.start.yaw_rad)


class _Standby:
    """A runtime that loads while the scene does, and comes back after it has failed."""

    def __init__(self, job: Job, settings: Settings) -> None:
        name = f"runtime-{job.method}-{job.episodes[0].id}.log"
        self._log = settings.out / "logs" / name
        self._settings = (*settings.settings, *method_settings(job.method))
        self._config = settings.config
        self._runtime = self._spawn()
        self._entered = False

    def __enter__(self) -> "_Standby":
        return self

    def __exit__(self, *_: object) -> None:
        self._runtime.close()

    def ready(self) -> Runtime:
        """The runtime; HarnessError when it cannot start."""
        if not self._entered:
            try:
                self._runtime.__enter__()
            except HarnessError as error:
                raise RfNavError(str(error)) from error
            self._entered = True
        return self._runtime

    def restart(self) -> None:
        self._runtime.close()
        self._runtime = self._spawn()
        self._entered = False

    def _spawn(self) -> Runtime:
        return Runtime(self._log, self._config, self._settings)
