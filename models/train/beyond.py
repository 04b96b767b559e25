"""`python -m models.train.beyond`: teaches the scene-layout expert what lies beyond a frontier, by
what `hil-sim beyond` tells of rendered homes. All that is done lies in OUT; the same command goes
on where it was stopped."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import click
import numpy as np
import torch

from models.checksum import sha256
from models.errors import told
from models.store import manifest
from models.train.beyond_data import Homes, Moments, feature_sample, read_homes
from models.train.beyond_head import Lesson, Photographs, examine, rooms_told, teach_head
from models.train.beyond_language import teach_projector
from models.train.beyond_photographs import read_photographs
from models.train.beyond_scores import by_table, judge
from models.train.beyond_speech import bridge, read_speech
from models.train.beyond_words import load_words
from models.train.compaction import KEPT, Compaction
from models.train.memory import keep_memory
from models.words.text_encoder import TextEncoder

LANGUAGE, TEXT = "smollm2-135m", "minilm"
COMPACTION = "compaction.npz"

Say = Callable[[str], None]


@dataclass(frozen=True)
class Given:
    """Folders that `hil-sim beyond` wrote, and the detector that saw them, and sees photographs."""

    train: Path
    dev: Path
    detector: Path


@cache
def encoder() -> TextEncoder:
    """The text encoder, opened once."""
    return TextEncoder(manifest.fetch(TEXT))


def lesson(given: Given, out: Path, say: Say) -> Lesson:
    """Read all that is taught; the features compacted, where they are not already."""
    compaction = compacted(given.train, out / COMPACTION, say)
    by = sha256(given.detector)
    train, dev = (read_homes(path, compaction, by) for path in (given.train, given.dev))
    words = load_words(train.categories, train.room_names, encoder().embed)
    for name, homes in (("train", train), ("dev", dev)):
        say(f"{name}: {homes.home.max() + 1} homes, {len(homes.features)} keyframes, "
            f"{len(homes.frame)} of them toward frontiers")  # fmt: skip
    return Lesson(train, dev, words)


def seen(folder: Path, given: Given, out: Path, taught: Lesson, say: Say) -> Photographs:
    """A folder's photographs of rooms, as the homes' keyframes are seen."""
    kept = out / f"photographs-{folder.parent.name}-{folder.name}.npz"
    change = compacted(given.train, out / COMPACTION, say)
    rooms = taught.train.room_names
    return read_photographs(folder, given.detector, kept, rooms, change, say)


def compacted(folder: Path, kept: Path, say: Say) -> Compaction | None:
    """The compaction of these homes' features, made once; None where they are compact."""
    if kept.exists():
        return Compaction.read(kept)
    sample = feature_sample(folder, np.random.default_rng(0))
    if sample.shape[1] <= KEPT:
        return None
    made = Compaction.of(sample)
    made.save(kept)
    say(f"compaction: {sample.shape[1]} to {KEPT}, of {len(sample)} keyframes")
    return made


def say_table(taught: Lesson, homes: Homes, say: Say) -> None:
    """What the detector's room type and a table of counts say of the same questions."""
    table = by_table(taught.train, homes)
    rows = np.flatnonzero(homes.best)
    scores = judge(table, homes, rows, taught.words.taught, Moments.of(homes))
    say(f"room x table: dev: {scores.told()}")


@click.command(
    epilog="Example:  python -m models.train.beyond --data beyond/train --dev beyond/dev --out run"
)
@click.option("--data", type=click.Path(path_type=Path, exists=True), required=True)
@click.option("--dev", type=click.Path(path_type=Path, exists=True), required=True,
              help="Other homes: weights are chosen by them.")  # fmt: skip
@click.option("--photographs", type=click.Path(path_type=Path, exists=True),
              help="Of rooms; without them nothing of photographs is taught.")  # fmt: skip
@click.option("--dev-photographs", type=click.Path(path_type=Path, exists=True),
              help="Others, by which it is told how many rooms are right.")  # fmt: skip
@click.option("--detector", type=click.Path(path_type=Path), help="Default: the project's.")
@click.option("--out", type=click.Path(path_type=Path), required=True)
@click.option("--head-steps", default=1500, show_default=True)
@click.option("--steps", default=1500, show_default=True, help="Of the soft tokens; 0 leaves out.")
@click.option("--seed", default=1, show_default=True)
def main(
    data: Path, dev: Path, photographs: Path | None, dev_photographs: Path | None,
    detector: Path | None, out: Path, head_steps: int, steps: int, seed: int,
) -> None:  # fmt: skip
    """Teach the plain head, then the soft tokens."""
    torch.set_num_threads(1)
    out.mkdir(parents=True, exist_ok=True)
    given = Given(data, dev, detector or manifest.fetch("rfnav-det"))
    taught = lesson(given, out, click.echo)
    if photographs is not None:
        own = seen(photographs, given, out, taught, click.echo)
        taught = replace(taught, photographs=own)
    say_table(taught, taught.dev, click.echo)
    head = teach_head(taught, out, head_steps, seed, click.echo)
    click.echo(f"plain head: dev: {examine(head, taught, taught.dev).told()}")
    if dev_photographs is not None:
        others = seen(dev_photographs, given, out, taught, click.echo)
        share = rooms_told(head, others, taught.words)
        click.echo(f"plain head: rooms of {len(others.room)} photographs: {share:.3f}")
    if not steps:
        return
    path = manifest.fetch(LANGUAGE)
    speech = read_speech(path, taught.words)
    way = bridge(path, speech, taught.words, encoder().embed)
    teach_projector(taught, speech, way, head, out, steps, seed, click.echo)


if __name__ == "__main__":
    keep_memory()
    told(main)
