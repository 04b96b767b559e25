"""`python -m models.train --data DIR --out DIR`: train the detector on rendered frames, and
on photographs beside them."""

import functools
from pathlib import Path

import click

from models.errors import told
from models.train.labelled import Portion, PortionParam
from models.train.memory import keep_memory
from models.train.part import take_part
from models.train.team import together
from models.train.trainer import Recipe


@click.command(epilog="Example:  python -m models.train --data frames/train --out out/train")
@click.option(
    "--data",
    type=PortionParam(),
    multiple=True,
    required=True,
    help="Frames; of several folders those with a SHARE (0 to 1) of an epoch, one without.",
)
@click.option("--out", type=click.Path(path_type=Path), required=True)
@click.option("--minutes", default=55.0, show_default=True, help="Training time in all.")
@click.option("--batch", default=8, show_default=True, help="Frames a step and process.")
@click.option(
    "--processes",
    default=2,
    show_default=True,
    help="They share every step; each takes a batch and a core.",
)
@click.option("--seed", default=1, show_default=True)
@click.option(
    "--start",
    type=click.Path(path_type=Path, exists=True),
    help="Checkpoint of an earlier run to begin with; default: ImageNet's weights.",
)
@click.option(
    "--height",
    default=1.0,
    show_default=True,
    help="Of the learning rate; 0.3 forgets less of what --start knows.",
)
def main(
    data: tuple[Portion, ...], out: Path, minutes: float, batch: int, processes: int, seed: int,
    start: Path | None, height: float,
) -> None:  # fmt: skip
    """Train, or go on training, the detector; checkpoints and log.csv go to OUT."""
    recipe = Recipe(minutes=minutes, batch=batch, seed=seed, height=height)
    together(processes, functools.partial(take_part, data, out, recipe, start))


if __name__ == "__main__":
    keep_memory()
    told(main)
