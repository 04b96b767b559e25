"""`hil-sim depth`: what depth cameras' faults and a mount that sways cost the map."""

import json
from collections.abc import Mapping
from pathlib import Path

import click
from tqdm import tqdm

from hil_sim.evaluation.depth_maps import MapCase, MapScore, compare
from hil_sim.simulation.depth_cameras import CAMERAS

NOISES = ("none", "flying=1", *(f"camera={name}" for name in CAMERAS))
HOMES = ",".join(f"val-{seed}" for seed in range(4))


def cases(sways: bool) -> list[MapCase]:
    """The table's lines."""
    if sways:
        mounts = ("fixed", "floor", "tf")
        return [MapCase(n, True, m) for n in NOISES if not n.startswith("flying") for m in mounts]
    return [MapCase(noise, drops) for noise in NOISES for drops in (False, True)]


def lines(scores: Mapping[MapCase, MapScore]) -> list[str]:
    """The table, ready to print."""
    rows = [
        "| depth | flying pixels | mount | floor left free | false obstacles | obstacles missed |",
        "|---|---|---|---|---|---|",
    ]
    for case, score in scores.items():
        kept = "dropped" if case.drops else "kept"
        figures = " | ".join(f"{100 * share:.1f} %" for share in score.shares)
        rows.append(f"| {case.noise} | {kept} | {case.mount} | {figures} |")
    return rows


@click.command(
    "depth",
    epilog="Examples:  hil-sim depth   |   hil-sim depth --sways   |   hil-sim depth --homes "
    "maple,train-1 --places 1 --json depth.json",
)
@click.option("--homes", default=HOMES, show_default=True, metavar="NAMES")
@click.option("--places", default=2, show_default=True, type=click.IntRange(1),
              help="In each home, to look around from.")  # fmt: skip
@click.option("--sways", is_flag=True, help="The camera tilts by 5 degrees and rises by 5 cm, up "
              "and down; else flying pixels are dropped and not.")  # fmt: skip
@click.option("--seed", default=0, show_default=True)
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="The counts as JSON.")
def depth_command(homes: str, places: int, sways: bool, seed: int, json_file: Path | None) -> None:
    """Maps of looks around, by depth cameras' noise, against the map of true depth."""
    names = [name.strip() for name in homes.split(",")]
    scores = {case: MapScore() for case in cases(sways)}
    found = compare(names, places, list(scores), sways, seed)
    for place in tqdm(found, total=len(names) * places, unit="place", disable=None):
        scores = {case: score + place[case] for case, score in scores.items()}
    for line in lines(scores):
        click.echo(line)
    if json_file is not None:
        told = [{**vars(case), **vars(score)} for case, score in scores.items()]
        json_file.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
