"""`hil-sim frames`: labelled frames to train and test detectors on."""

import json
from pathlib import Path

import click

from hil_sim.training_frames.frames import counts, homes, render


@click.command("frames")
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder to write.")
@click.option("--frames", default=1000, show_default=True, type=click.IntRange(1))
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0), help="First home.")
@click.option("--split", type=click.Choice(["train", "val"]), default="train", show_default=True)
@click.option("--replicas", is_flag=True, help="The split's RoboTHOR replicas first.")
@click.option(
    "--cluttered",
    default=0,
    show_default=True,
    type=click.IntRange(0),
    help="So many frames more, of homes strewn with what homes seldom show.",
)
@click.option(
    "--varied",
    default=0,
    show_default=True,
    type=click.IntRange(0),
    help="So many frames more, of homes whose furniture no other home has.",
)
@click.option(
    "--patterns",
    default=0.0,
    show_default=True,
    type=click.FloatRange(0, 1),
    help="Share of the things in view that are made of another stuff: fabric, wood, paint.",
)
@click.option("--width", default=640, show_default=True, type=click.IntRange(64, 1920))
@click.option("--height", default=480, show_default=True, type=click.IntRange(64, 1920))
@click.option("--workers", default=2, show_default=True, type=click.IntRange(1, 64))
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="Counts as JSON.")
def frames_command(
    out: Path, frames: int, seed: int, split: str, replicas: bool, cluttered: int, varied: int,
    patterns: float, width: int, height: int, workers: int, json_file: Path | None,
) -> None:  # fmt: skip
    """Render labelled frames of generated homes and RoboTHOR replicas (COCO detection format).

    \b
    Example: hil-sim frames --out frames/train --frames 5000 --split train --replicas
    A run that was interrupted goes on with the same command.
    """
    names = homes(split, seed, frames, replicas, cluttered, varied)
    coco = render(out, frames + cluttered + varied, names, (width, height), workers, patterns)
    found = counts(coco)
    for name, count in found.items():
        click.echo(f"{name:16} {count:6}")
    click.echo(f"{len(coco['images'])} frames in {out}")
    if json_file:
        json_file.write_text(json.dumps({"frames": len(coco["images"]), "boxes": found}, indent=1))
