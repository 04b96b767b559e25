"""`hil-sim episodes`: sample episodes by seed and write them as a suite."""

import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import click

from hil_sim.episodes import HM3D_GOALS, Episode, sample_episode, save_suite
from hil_sim.quiet import hushed, keep_stdout_for_python
from hil_sim.scene import load_scene


def sample_scene(scene: str, goals: tuple[str, ...], starts: int, seed: int) -> list[Episode]:
    """`starts` episodes for each goal in a scene, with seeds from `seed` on."""
    keep_stdout_for_python()
    with hushed():
        from hil_sim.assets import Assets
        from hil_sim.truth import Truth
        from hil_sim.world import World

    assets = Assets()
    with World(load_scene(scene), assets) as world:
        truth = Truth(world, assets)
        return [
            sample_episode(
                truth.space, truth.success(goal), goal, seed + i, truth.sees(goal), scene
            )
            for goal in goals
            for i in range(starts)
        ]


@click.command("episodes")
@click.argument("scenes", nargs=-1, required=True)
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Suite to write.")
@click.option("--goal", "goals", multiple=True, default=HM3D_GOALS, show_default=True)
@click.option("--starts", default=2, show_default=True, type=click.IntRange(1), help="A goal.")
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0))
def episodes_command(
    scenes: tuple[str, ...], out: Path, goals: tuple[str, ...], starts: int, seed: int
) -> None:
    """Sample episodes in SCENES (names or files): every goal from several starts.

    \b
    Example: hil-sim episodes maple cedar --out hil_sim/suites/smoke.json
    """
    # One process a scene: EGL reuses texture ids wrongly.
    spawn = multiprocessing.get_context("spawn")
    found: list[Episode] = []
    with ProcessPoolExecutor(1, mp_context=spawn, max_tasks_per_child=1) as pool:
        jobs = [pool.submit(sample_scene, scene, goals, starts, seed) for scene in scenes]
        for job in jobs:
            found += job.result()
    save_suite(tuple(found), out)
    click.echo(f"{len(found)} episodes in {out}")


if __name__ == "__main__":
    episodes_command()
