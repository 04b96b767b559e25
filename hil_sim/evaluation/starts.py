"""Which episodes of others can be driven in our homes, found before the first of them is.

All homes are looked at up front, one process each: what that measures (free space, the places that
see a goal) is cached, and driving needs it in any case. So it costs no more than opening each home
once more, and who asked for a long evaluation knows at its beginning what it leaves out.
"""

import math
import sys
from collections.abc import Generator
from contextlib import closing
from dataclasses import replace
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING

from tqdm import tqdm

from hil_sim.driving.link import HarnessError
from hil_sim.driving.rig import open_world, start_of
from hil_sim.evaluation.evaluate import Evaluation, sigterm_as_interrupt, workers
from hil_sim.evaluation.left_out import StartCheck, Survey, Undrivable, read_survey, save_survey
from hil_sim.evaluation.pool import Work
from hil_sim.evaluation.worker import Failure, Job, Note, Send, Settings, Task, serve
from hil_sim.ground_truth.episodes import Episode
from hil_sim.ground_truth.goals import not_asked
from hil_sim.scenes.format import SceneError
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.open import open_scene

if TYPE_CHECKING:  # PyBullet prints when it is imported: see open_world
    from hil_sim.ground_truth.truth import SceneTruth
    from hil_sim.simulation.scene_physics import ScenePhysics


def look_at(job: Job, settings: Settings, send: Send) -> None:
    """A verdict on every episode of a job."""
    assets = Assets()
    with open_world(open_scene(job.scene), assets, settings.renderer) as world:
        from hil_sim.ground_truth.truth import SceneTruth

        truth = SceneTruth(world, assets, lambda text: send(Note(text)))
        for task in job.tasks:
            send(StartCheck(task.episode.id, obstacle(task.episode, world, truth)))


def look(job: Job, settings: Settings, parent: Connection) -> None:
    """The main function of a process that looks at a home."""
    serve(look_at, job, settings, parent)


def obstacle(episode: Episode, world: "ScenePhysics", truth: "SceneTruth") -> Undrivable | None:
    """Why an episode cannot be driven in its home; None when it can."""
    start = start_of(episode)
    if not truth.space.is_free(start.x_m, start.y_m):
        inside = world.collides(start.x_m, start.y_m)
        return Undrivable.INSIDE if inside else Undrivable.OFF_FLOOR
    try:
        truth.boxes(episode.goal)
    except SceneError:
        return Undrivable.NO_GOAL
    if not_asked(world.scene, episode.goal):
        return Undrivable.UNRECOGNISED
    try:
        away_m = truth.distance_m(episode.goal, start)
    except SceneError:
        return Undrivable.UNSEEN
    return None if math.isfinite(away_m) else Undrivable.CUT_OFF


def survey(evaluation: Evaluation, target: Work = look) -> Evaluation | None:
    """The evaluation without what cannot be driven, which is kept in OUT and not looked at again;
    None when interrupted. HarnessError when no home can be looked at."""
    out, known = evaluation.settings.out, read_survey(evaluation.settings.out)
    every = [episode.id for episode in evaluation.all_episodes]
    todo = set(known.unchecked if known else every)
    found = {v.episode: v for v in known.left_out} if known else {}
    if todo:
        scenes: dict[str, list[Task]] = {}
        for episode in evaluation.all_episodes:
            if episode.id in todo:
                scenes.setdefault(episode.scene, []).append(Task(episode, ()))
        jobs = [Job(scene, tuple(tasks)) for scene, tasks in scenes.items()]
        try:
            with closing(_verdicts(evaluation, jobs, target, fresh=known is None)) as verdicts:
                for verdict in verdicts:
                    todo.discard(verdict.episode)
                    found[verdict.episode] = verdict
        except KeyboardInterrupt:
            return None
    left = tuple(found[id] for id in every if id in found and found[id].cause is not None)
    save_survey(Survey(left, tuple(id for id in every if id in todo)), out)
    return replace(evaluation, left_out=left)


def _verdicts(
    evaluation: Evaluation, jobs: list[Job], target: Work, fresh: bool
) -> Generator[StartCheck]:
    """Verdicts as they come, with a bar; `fresh`: a failure before the first one ends it."""
    total, done = sum(len(job.tasks) for job in jobs), 0
    with (
        sigterm_as_interrupt(),
        tqdm(total=total, unit="start", desc="looking at starts", disable=None) as bar,
        workers(evaluation, jobs, target, look_at) as messages,
    ):
        bar.write(f"looking at {total} starts in {len(jobs)} homes", file=sys.stderr)
        for message in messages:
            if isinstance(message, StartCheck):
                done += 1
                bar.update()
                yield message
            elif isinstance(message, Note | Failure):
                bar.write(message.text, file=sys.stderr)
            if isinstance(message, Failure) and fresh and not (message.died or done):
                raise HarnessError(message.text)
