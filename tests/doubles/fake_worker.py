"""A worker without a world: every other episode succeeds. Behaves badly when a setting asks."""

import os
import random
import time
from multiprocessing.connection import Connection

from hil_sim.driving.episode_result import Ended, EpisodeResult
from hil_sim.evaluation.left_out import StartCheck, Undrivable
from hil_sim.evaluation.worker import Failure, Job, Message, Note, Send, Settings
from hil_sim.ground_truth.episodes import Episode


def result_of(method: str, episode: Episode, ended: str = "stop") -> EpisodeResult:
    success = ended == "stop" and episode.id.endswith(("0", "2", "4", "6", "8"))
    return EpisodeResult(
        episode=episode.id,
        scene=episode.scene,
        goal=episode.goal,
        method=method,
        protocol="hm3d",
        success=success,
        ended=Ended.parsed(ended),
        steps=10 + int(episode.id[1:]),
        collisions=0,
        decisions=1,
        shortest_path_m=episode.shortest_path_m,
        path_m=8.0,
        distance_m=0.0 if success else 2.0,
        spl=None,
        soft_spl=None,
        actions={"frontier": 9, "stop": 1},
        wall={"render": 1.0, "runtime.map": 0.5, "total": time.monotonic() % 1 + 2.0},
    )


def drive(job: Job, settings: Settings, send: Send) -> None:
    (mode,) = settings.settings or ("well",)
    send(Note(f"{job.scene}: looking around"))
    for index, task in enumerate(job.tasks):
        if mode.startswith("crash") and index == 1:
            time.sleep(1.0 if mode == "crash late" else 0.0)
            os._exit(3)
        if mode == "fail at once" or (mode == "fail" and index == 1):
            send(Failure("furniture: none here; run `hil-sim assets pull`", scene=job.scene))
            return
        if mode == "hang" and index == 1:
            time.sleep(600)
        for method in task.methods:
            if mode == "shuffle":
                time.sleep(random.random() / 50)
            send(result_of(method, task.episode, "error: late" if mode == "error" else "stop"))


def look(job: Job, settings: Settings, parent: Connection) -> None:
    """Starts of even episodes are good, others lie inside furniture."""
    (mode,) = settings.settings or ("well",)
    for index, task in enumerate(job.tasks):
        if mode == "crash" and job.scene == "cedar" and index == 1:
            os._exit(3)
        if mode == "fail":
            parent.send(Failure("furniture: none here; run `hil-sim assets pull`"))
            return
        if mode == "hang":
            time.sleep(600)
        good = task.episode.id.endswith(("0", "2", "4", "6", "8"))
        parent.send(StartCheck(task.episode.id, None if good else Undrivable.INSIDE))


def work(job: Job, settings: Settings, parent: Connection) -> None:
    drive(job, settings, parent.send)


def drive_with_files(job: Job, settings: Settings, send: Send) -> None:
    def keep(message: Message) -> None:
        if isinstance(message, EpisodeResult):
            folder = settings.out / message.method / message.episode
            folder.mkdir(parents=True)
            (folder / "track.jsonl").write_text(f"{message.method} {message.episode}\n")
        send(message)

    drive(job, settings, keep)
