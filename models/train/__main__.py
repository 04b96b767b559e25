"""`python -m models.train --data DIR --out DIR`: train the detector on rendered frames."""

import functools
import os
import sys
from pathlib import Path

import click

from models.errors import ModelError
from models.train.part import take_part
from models.train.team import together
from models.train.trainer import Recipe

# glibc gives freed activations back to the kernel and faults them in again every step; keeping
# them makes a step several times faster. It must be in the environment before the process starts.
KEEP_MEMORY = {
    "MALLOC_MMAP_THRESHOLD_": str(1 << 33),
    "MALLOC_TRIM_THRESHOLD_": str(1 << 33),
    "MALLOC_TOP_PAD_": str(1 << 28),
    "OMP_WAIT_POLICY": "passive",
}


@click.command(epilog="Example:  python -m models.train --data frames/train --out out/train")
@click.option("--data", type=click.Path(path_type=Path, exists=True), required=True)
@click.option("--out", type=click.Path(path_type=Path), required=True)
@click.option("--minutes", default=55.0, show_default=True, help="Training time in all.")
@click.option("--batch", default=8, show_default=True, help="Frames a step and process.")
@click.option(
    "--processes",
    default=2,
    show_default=True,
    help="Share every step; each takes a batch and a core: one with two threads sees half as much.",
)
@click.option("--seed", default=1, show_default=True)
@click.option(
    "--start",
    type=click.Path(path_type=Path, exists=True),
    help="Checkpoint of an earlier run to begin with; default: ImageNet's weights.",
)
def main(
    data: Path, out: Path, minutes: float, batch: int, processes: int, seed: int, start: Path | None
) -> None:
    """Train, or go on training, the detector; checkpoints and log.csv go to OUT."""
    recipe = Recipe(minutes=minutes, batch=batch, seed=seed)
    together(processes, functools.partial(take_part, data, out, recipe, start))


if __name__ == "__main__":
    if any(os.environ.get(key) != value for key, value in KEEP_MEMORY.items()):
        os.execve(
            sys.executable, [sys.executable, *sys.orig_argv[1:]], {**os.environ, **KEEP_MEMORY}
        )
    try:
        main()
    except ModelError as error:
        print(f"models.train: {error}", file=sys.stderr)
        raise SystemExit(2) from None
