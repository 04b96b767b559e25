"""`hil-sim episodes`: sample episodes by seed and write them as a suite."""

import itertools
from collections.abc import Iterable
from pathlib import Path

import click

from hil_sim.evaluation.sample import Wish, not_asked_for, sample_all
from hil_sim.evaluation.suites import REPLICAS, UNSEEN, make_suite
from hil_sim.ground_truth.episodes import HM3D_GOALS, ROBOTHOR_GOALS, save_suite
from hil_sim.scenes.format import SceneError


@click.command("episodes")
@click.argument("scenes", nargs=-1)
@click.option("--make", help="Make a bundled suite again, from its recipe: val, labels, official.")
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
        found, note = make_suite(make, replicas, workers)
        _tell(itertools.product(UNSEEN if make == "official" else REPLICAS, ROBOTHOR_GOALS))
    else:
        _tell(itertools.product(scenes, goals))
        strict = not skip_missing
        wishes = [Wish(scene, goals, starts=starts, seed=seed, strict=strict) for scene in scenes]
        found = tuple(e for episodes in sample_all(wishes, workers) for e in episodes)
        if not found:
            raise SceneError(f"{', '.join(scenes)}: none of these goals can be met; name others")
    save_suite(found, out, note)
    click.echo(f"{len(found)} episodes in {out}")


def _tell(wanted: Iterable[tuple[str, str]]) -> None:
    for line in not_asked_for(wanted):
        click.echo(line, err=True)
