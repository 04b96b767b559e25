"""`hil-sim beyond`: what robots see toward frontiers, and what truly lies behind them."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import click

from hil_sim.expert_bench.bank import SIDES, side_of
from hil_sim.expert_bench.home_jobs import claim, make_homes
from hil_sim.scenes.robothor.metadata import APARTMENTS
from hil_sim.simulation.quiet import keep_stdout_for_python

HOMES, PLAN_FILE = "homes", "beyond.json"


@dataclass(frozen=True)
class BeyondPlan:
    """Which homes a folder is of; how many there are may grow."""

    seed: int
    split: str
    replicas: bool


@click.command(
    "beyond",
    epilog="Examples:  hil-sim beyond --out out/beyond/train --homes 250 --seed 200000 --replicas "
    "|  hil-sim beyond --out out/beyond/dev --homes 40 --split val --seed 300000 "
    "--also detector.onnx",
)
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder to write.")
@click.option("--homes", default=100, show_default=True, type=click.IntRange(1))
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0), help="First home.")
@click.option("--split", type=click.Choice(["train", "val"]), default="train", show_default=True)
@click.option("--replicas", is_flag=True,
              help=f"Train replicas of RoboTHOR, of side {SIDES[0]}, among them.")  # fmt: skip
@click.option("--also", "others", multiple=True, metavar="MODEL",
              help="Keep in OUT/MODEL what another detector, a name or an ONNX file, sees in the "
                   "same frames; may be given more than once.")  # fmt: skip
@click.option("--workers", default=2, show_default=True, type=click.IntRange(1, 64))
def beyond_command(
    out: Path, homes: int, seed: int, split: str, replicas: bool, others: tuple[str, ...],
    workers: int,
) -> None:  # fmt: skip
    """Drive through homes with true object names, and keep, for each frontier, the views toward it
    and what lies behind: to train the scene-layout expert on, and to judge it by.

    A run that was interrupted goes on with the same command, or with more homes.
    """
    if replicas and split != "train":
        raise click.UsageError("--replicas are of the split train alone: leave out one of the two")
    from hil_sim.expert_bench.seeing import DETECTOR
    from hil_sim.expert_bench.views import read_views

    stems = [HOMES, DETECTOR, *(Path(other).stem for other in others)]
    if len(set(stems)) < len(stems):
        told = f"--also: two models of one name, or one called {HOMES} or {DETECTOR}: rename it"
        raise click.UsageError(told)

    names = home_names(homes, seed, split, replicas)
    folders = {DETECTOR: out, **{other: out / Path(other).stem for other in others}}
    for folder in folders.values():
        (folder / HOMES).mkdir(parents=True, exist_ok=True)
        claim(folder / PLAN_FILE, BeyondPlan(seed, split, replicas))
    files = {name: files_of(folders, name) for name in names}
    todo = [name for name in names if not all(file.exists() for file in files[name].values())]
    make_homes(names, todo, workers, partial(make_home, folders))
    for detector, folder in folders.items():
        homes_views = [read_views(files[name][detector]) for name in names]
        rows, frames = (sum(len(column) for column in columns) for columns in (
            [v.frame for v in homes_views], [v.room for v in homes_views]))  # fmt: skip
        click.echo(f"{len(names)} homes in {folder / HOMES}: {rows} views in {frames} frames")


def home_names(count: int, seed: int, split: str, replicas: bool) -> list[str]:
    """Generated homes of seeds from `seed` on, every fifth one a replica while there are any."""
    first = f"FloorPlan_{split.capitalize()}"
    more = [n for n in APARTMENTS if n.startswith(first) and side_of(n) == SIDES[0]]
    queue = sorted(more, key=lambda name: int(name.rpartition("_")[2])) if replicas else []
    names = list[str]()
    while len(names) < count:
        if queue and len(names) % 5 == 4:
            names.append(queue.pop(0))
        else:
            names.append(f"{split}-{seed}")
            seed += 1
    return names


def files_of(folders: Mapping[str, Path], name: str) -> dict[str, Path]:
    """A home's file in each detector's folder."""
    return {detector: folder / HOMES / f"{name}.npz" for detector, folder in folders.items()}


def make_home(folders: Mapping[str, Path], name: str) -> None:
    """A worker's task: one home."""
    keep_stdout_for_python()
    import cv2

    from hil_sim.expert_bench.views import make_views

    cv2.setNumThreads(1)
    make_views(files_of(folders, name), name)
