"""A worker without a world: every other episode succeeds. Behaves badly when a setting asks."""

import os
import time
from multiprocessing.connection import Connection

from hil_sim.episode_run import EpisodeResult
from hil_sim.worker import Failure, Job, Note, Settings


def result_of(job: Job, index: int, ended: str = "stop") -> EpisodeResult:
    episode = job.episodes[index]
    success = ended == "stop" and episode.id.endswith(("0", "2", "4", "6", "8"))
    return EpisodeResult(
        episode=episode.id,
        scene=episode.scene,
        goal=episode.goal,
        method=job.method,
        protocol="hm3d",
        success=success,
        ended=ended,
        steps=10 + index,
        collisions=0,
        decisions=1,
        shortest_path_m=episode.shortest_path_m,
        path_m=8.0,
        distance_m=0.0 if success else 2.0,
        spl=None,
        soft_spl=None,
        wall={"render": 1.0, "runtime.map": 0.5, "total": time.monotonic() % 1 + 2.0},
    )


def work(job: Job, settings: Settings, parent: Connection) -> None:
    (mode,) = settings.settings or ("well",)
    parent.send(Note(f"{job.scene}: looking around"))
    for index in range(len(job.episodes)):
        if mode == "crash" and index == 1:
            os._exit(3)
        if mode == "fail" and index == 1:
            parent.send(Failure("furniture: none here; run `hil-sim assets pull`"))
            return
        if mode == "hang" and index == 1:
            time.sleep(60)
        parent.send(result_of(job, index, "error: late" if mode == "error" else "stop"))
