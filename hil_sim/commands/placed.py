"""`hil-sim placed`: how far from where they are the runtime places what a camera sees."""

import json
import statistics
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

import click
from tqdm import tqdm

from hil_sim.evaluation.placed_things import MISPLACED_M, PlacedThing, placed_things

HOMES: Final = ",".join(f"train-{seed}" for seed in range(10))
RANGES_M: Final = ((0.0, 1.0), (1.0, 3.5), (3.5, 5.0), (5.0, 100.0))


def lines(things: Sequence[PlacedThing]) -> list[str]:
    """The table, ready to print."""
    rows = [
        "| things | boxes | off, median | misplaced | placed nowhere |",
        "|---|---|---|---|---|",
        _line("all", things),
    ]
    for low_m, high_m in RANGES_M:
        what = f"{low_m:g} to {high_m:g} m away" if high_m < 100 else f"beyond {low_m:g} m"
        rows.append(_line(what, [t for t in things if low_m <= t.range_m < high_m]))
    return rows


def _line(what: str, things: Sequence[PlacedThing]) -> str:
    off = [thing.off_m for thing in things if thing.off_m is not None]
    median = f"{100 * statistics.median(off):.0f} cm" if off else "–"
    misplaced = _share(thing.misplaced for thing in things)
    nowhere = _share(thing.off_m is None for thing in things)
    return f"| {what} | {len(things)} | {median} | {misplaced} | {nowhere} |"


def _share(which: Iterable[bool]) -> str:
    known = list(which)
    return f"{100 * sum(known) / len(known):.1f} %" if known else "–"


@click.command(
    "placed",
    epilog="Examples:  hil-sim placed   |   hil-sim placed --homes maple,train-1 --views 10",
)
@click.option("--homes", default=HOMES, show_default=True, metavar="NAMES")
@click.option("--views", default=40, show_default=True, type=click.IntRange(1),
              help="In each home, from anywhere.")  # fmt: skip
@click.option("--seed", default=0, show_default=True)
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="All boxes as JSON.")
def placed_command(homes: str, views: int, seed: int, json_file: Path | None) -> None:
    """Things in rendered images, each by its true box alone, and where the runtime places them."""
    names = [name.strip() for name in homes.split(",")]
    things: list[PlacedThing] = []
    found = placed_things(names, views, seed)
    for seen in tqdm(found, total=len(names) * views, unit="view", disable=None):
        things += seen
    for line in lines(things):
        click.echo(line)
    click.echo(f"misplaced: by more than {MISPLACED_M} m from the nearest of it that is in view")
    if json_file is not None:
        told = [vars(thing) for thing in things]
        json_file.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
