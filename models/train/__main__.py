"""`python -m models.train --data DIR --out DIR`: train the detector on rendered frames."""

import os
import sys
from pathlib import Path

import click
import cv2
import torch

from models import store
from models.errors import ModelError
from models.text import TextEncoder
from models.train.trainer import Recipe, train

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
@click.option("--batch", default=8, show_default=True)
@click.option("--threads", default=2, show_default=True)
@click.option("--seed", default=1, show_default=True)
@click.option(
    "--start",
    type=click.Path(path_type=Path, exists=True),
    help="Checkpoint of an earlier run to begin with; default: ImageNet's weights.",
)
def main(
    data: Path, out: Path, minutes: float, batch: int, threads: int, seed: int, start: Path | None
) -> None:
    """Train, or go on training, the detector; checkpoints and log.csv go to OUT."""
    torch.set_num_threads(threads)
    cv2.setNumThreads(1)
    state = torch.load(store.fetch("efficientnet-lite0"), map_location="cpu", weights_only=True)
    encoder = TextEncoder(store.fetch("minilm"))
    recipe = Recipe(minutes=minutes, batch=batch, seed=seed)
    train(data, out, state, encoder.embed, recipe, click.echo, start)


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
