"""`hil-sim episodes`: sample episodes by seed and write them as a suite."""

import multiprocessing
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import click
from tqdm import tqdm

from hil_sim.ground_truth.episodes import HM3D_GOALS, Episode, sample_episode, save_suite
from hil_sim.scenes.format import SceneError
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.quiet import keep_stdout_for_python


@dataclass(frozen=True)
class Wish:
    """Episodes of one scene: up to `most` of the `goals`, in their order, those that cannot be
    met being passed over, unless `strict`; `starts` episodes each, with seeds from `seed` on.

    With `given`, up to `most` of these instead, that can be begun and done in this scene.
    """

    scene: str
    goals: tuple[str, ...] = HM3D_GOALS
    most: int = 1000
    starts: int = 1
    seed: int = 0
    strict: bool = False
    given: tuple[Episode, ...] = ()


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


def sample_scene(wish: Wish) -> list[Episode]:
    """One wish's episodes; SceneError if it is strict and cannot be met."""
    keep_stdout_for_python()
    from hil_sim.driving.rig import open_world
    from hil_sim.scenes.furniture.assets import Assets

    assets = Assets()
    with open_world(open_scene(wish.scene), assets, "auto") as world:
        from hil_sim.ground_truth.truth import SceneTruth

        truth = SceneTruth(world, assets)
        if wish.given:
            from hil_sim.evaluation.suites import adopted

            return adopted(wish.given, truth, wish.most)
        found: list[list[Episode]] = []
        for goal in wish.goals:
            if len(found) == wish.most:
                break
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


@click.command("episodes")
@click.argument("scenes", nargs=-1)
@click.option("--make", help="Make a bundled suite again, from its recipe: val, labels.")
@click.option(
    "--replicas", type=click.Path(path_type=Path), help="RoboTHOR's episodes, for --make."
)
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Suite to write.")
@click.option("--goal", "goals", multiple=True, default=HM3D_GOALS, show_default=True)
@click.option("--starts", default=2, show_default=True, type=click.IntRange(1), help="A goal.")
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0))
@click.option("--skip-missing", is_flag=True, help="Pass over goals that cannot be met in a scene.")
@click.option("--workers", default=1, show_default=True, type=click.IntRange(1, 64))
def episodes_command(
    scenes: tuple[str, ...],
    make: str | None,
    replicas: Path | None,
    out: Path,
    goals: tuple[str, ...],
    starts: int,
    seed: int,
    skip_missing: bool,
    workers: int,
) -> None:
    """Sample episodes in SCENES (bundled, files, val-17, FloorPlan_Val1_1, …): every goal from
    several starts. Each has the length of its shortest path.

    \b
    Examples: hil-sim episodes maple cedar --out my.json
              hil-sim episodes --make val --replicas ../robothor/episodes --out val.json
    """
    if bool(scenes) == bool(make):
        raise click.UsageError("name scenes, or a suite to make with --make")
    note = ""
    if make:
        from hil_sim.evaluation.suites import make_suite

        found, note = make_suite(make, replicas, workers)
    else:
        strict = not skip_missing
        wishes = [Wish(scene, goals, starts=starts, seed=seed, strict=strict) for scene in scenes]
        found = tuple(e for episodes in sample_all(wishes, workers) for e in episodes)
        if not found:
            raise SceneError(f"{', '.join(scenes)}: none of these goals can be met; name others")
    save_suite(found, out, note)
    click.echo(f"{len(found)} episodes in {out}")


if __name__ == "__main__":
    episodes_command()
