"""Episodes of many scenes, sampled by seed or taken from those given; a process for each scene."""

import multiprocessing
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tqdm import tqdm

from hil_sim.evaluation.starts import obstacle
from hil_sim.ground_truth.episodes import (
    HM3D_GOALS,
    SHORTEST_M,
    Episode,
    home_name,
    sample_episode,
)
from hil_sim.ground_truth.goals import not_asked
from hil_sim.scenes.format import SceneError
from hil_sim.scenes.open import is_replica, open_scene
from hil_sim.simulation.quiet import keep_stdout_for_python

if TYPE_CHECKING:  # PyBullet prints when it is imported
    from hil_sim.ground_truth.truth import SceneTruth


@dataclass(frozen=True)
class Wish:
    """Episodes of one scene: up to `most` of the `goals`, in their order, those that cannot be
    met being passed over, unless `strict`, and always those that a person would not recognise (see
    `not_asked_for`); `starts` episodes each, with seeds from `seed` on.

    With `given`, up to `most` of these instead, that can be begun and done in this scene, each of
    another goal; or, where `all_given`, every one of them that can, with its own length.
    """

    scene: str
    goals: tuple[str, ...] = HM3D_GOALS
    most: int = 1000
    starts: int = 1
    seed: int = 0
    strict: bool = False
    given: tuple[Episode, ...] = ()
    all_given: bool = False


def sample_all(wishes: Iterable[Wish], workers: int = 1) -> list[list[Episode]]:
    """Each wish's episodes, in one fresh process each: EGL cannot draw a second scene."""
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=spawn, max_tasks_per_child=1) as pool:
        jobs = [pool.submit(sample_scene, wish) for wish in wishes]
        try:
            return [job.result() for job in tqdm(jobs, unit="home", disable=None)]
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def not_asked_for(wanted: Iterable[tuple[str, str]]) -> list[str]:
    """Of scenes and goals, a line for each pair that no episode asks for, with the reason."""
    lines = []
    for scene, goal in sorted(set(wanted)):
        why = not_asked(open_scene(scene), goal) if is_replica(scene) else ""
        if why:
            lines.append(f"{scene}: {goal} left out, a person would not recognise it: {why}")
    return lines


def sample_scene(wish: Wish) -> list[Episode]:
    """One wish's episodes; SceneError if it is strict and cannot be met."""
    keep_stdout_for_python()
    from hil_sim.driving.rig import open_world
    from hil_sim.scenes.furniture.assets import Assets

    assets = Assets()
    with open_world(open_scene(wish.scene), assets, "auto") as world:
        from hil_sim.ground_truth.truth import SceneTruth

        truth = SceneTruth(world, assets)
        if wish.all_given:
            home = home_name(truth.space)
            can = [e for e in wish.given if obstacle(e, world, truth) is None]
            return [Episode(e.id, e.scene, e.start, e.goal, e.shortest_path_m, home) for e in can]
        if wish.given:
            return adopted(wish.given, truth, wish.most)
        found: list[list[Episode]] = []
        for goal in wish.goals:
            if len(found) == wish.most:
                break
            if not_asked(world.scene, goal):
                continue
            try:
                success, sees = truth.success(goal), truth.sees(goal)
                seeds = range(wish.seed, wish.seed + wish.starts)
                found.append(
                    [
                        sample_episode(truth.space, success, goal, seed, sees, wish.scene)
                        for seed in seeds
                    ]
                )
            except SceneError:
                if wish.strict:
                    raise
        return [episode for episodes in found for episode in episodes]


def adopted(given: Sequence[Episode], truth: "SceneTruth", most: int) -> list[Episode]:
    """The first `most` of the given episodes, each of another goal, that begin on free floor and
    can be done; with the length of the shortest path in this home."""
    found: dict[str, Episode] = {}
    for episode in given:
        start, goal = episode.start, episode.goal
        if len(found) == most:
            break
        if goal in found or not truth.space.is_free(start.x_m, start.y_m):
            continue
        if not_asked(truth.space.scene, goal):
            continue
        try:
            field = truth.field(goal)
        except SceneError:
            continue
        length = truth.space.distance(field, start.x_m, start.y_m)
        if SHORTEST_M <= length < 1e6:
            home = home_name(truth.space)
            found[goal] = Episode(episode.id, episode.scene, start, goal, round(length, 3), home)
    return list(found.values())
