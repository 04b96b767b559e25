"""`python -m models.train.curves OUT`: the losses of a run, from its log.csv, as a picture."""

import csv
from pathlib import Path

import click

from models.errors import ModelFileError, told

PARTS = ("objectness", "box", "words", "room")
SMOOTH = 25
"""Logged steps that a point is the mean of."""


def read_log(path: Path) -> dict[str, list[float]]:
    """Columns of log.csv by name. Raises ModelFileError."""
    try:
        with path.open(newline="") as stream:
            rows = list(csv.DictReader(stream))
        columns = {k: [float(row[k]) for row in rows] for k in ("step", "frames_per_s", *PARTS)}
    except (OSError, KeyError, ValueError) as error:
        raise ModelFileError(f"{path}: not the log of a training run ({error})") from error
    if not rows:
        raise ModelFileError(f"{path}: empty; the first line is written after 20 steps")
    return columns


def smooth(values: list[float], span: int = SMOOTH) -> list[float]:
    """The mean of each value and up to `span` - 1 before it."""
    return [sum(v := values[max(0, i + 1 - span) : i + 1]) / len(v) for i in range(len(values))]


def draw(log: dict[str, list[float]], path: Path) -> None:
    """One panel a loss, over training steps."""
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot

    figure, panels = pyplot.subplots(1, len(PARTS), figsize=(14, 3.2), layout="constrained")
    for panel, part in zip(panels, PARTS, strict=True):
        panel.plot(log["step"], log[part], color="0.85", linewidth=0.6)
        panel.plot(log["step"], smooth(log[part]), color="C0")
        panel.set_title(part)
        panel.set_xlabel("step")
        panel.set_ylim(bottom=0)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


@click.command(epilog="Example:  python -m models.train.curves out/train")
@click.argument("out", type=click.Path(path_type=Path, exists=True, file_okay=False))
def main(out: Path) -> None:
    """Draw OUT/log.csv as OUT/curves.png."""
    draw(read_log(out / "log.csv"), out / "curves.png")
    click.echo(f"{out / 'curves.png'}")


if __name__ == "__main__":
    told(main)
