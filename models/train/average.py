"""`python -m models.train.average A B --share 0.7 --out C`: the mean of two checkpoints' weights.

A run that starts with another's weights and forgets some of what that knew has most of both in
their mean (Wortsman et al. 2022).
"""

from pathlib import Path

import click
import torch

from models.errors import told
from models.train.export import load_network

FILE = click.Path(path_type=Path, exists=True)


@click.command(epilog="Example:  python -m models.train.average old.pt new.pt --out mean.pt")
@click.argument("earlier", type=FILE)
@click.argument("later", type=FILE)
@click.option("--share", type=click.FloatRange(0, 1), default=0.7, show_default=True)
@click.option("--out", type=click.Path(path_type=Path), required=True)
def main(earlier: Path, later: Path, share: float, out: Path) -> None:
    """Mix two checkpoints; SHARE is the later one's part."""
    (first, _), (last, _) = load_network(earlier), load_network(later)
    other = last.state_dict()
    mixed = {name: value.lerp(other[name], share) if value.dtype.is_floating_point else other[name]
             for name, value in first.state_dict().items()}  # fmt: skip
    torch.save({"average": mixed}, out)


if __name__ == "__main__":
    told(main)
