"""`python -m models.train.finish`: the word heads trained once more, on stored features.

The backbone sees each frame a few times at most; behind it, a head of two layers can see a
hundred epochs of stored features in a minute.
"""

import copy
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
import torch
from torch import Tensor

from models.errors import told
from models.store import manifest
from models.train.data import Batch, batches
from models.train.export import load_network
from models.train.labelled import Labelled, Portion, PortionParam, read_epoch
from models.train.losses import answers, background, gather, room_loss, view_loss, word_loss
from models.train.memory import keep_memory
from models.train.names import Names, load_names
from models.train.network import Network
from models.train.targets import make_grid
from models.train.trainer import CHECKPOINT, save
from models.words.text_encoder import TextEncoder

FINISHED, FEATURES = "finished.pt", "features.pt"
BACKGROUND = 12
BATCH = 8
DROPOUT = 0.6
ROOM_STEPS = 700
JOINED = 64
"""Batches whose features are joined at once: small pieces kept among freed activations would hold
on to all their memory."""

Columns = tuple[Tensor, ...]


@dataclass(frozen=True)
class Features:
    """`regions` (P, C) with `label` (P,), -1 background, `weight` (P,), and which categories are
    `boxed` (P, categories) where they are from; `summary` (N, S) of whole views with `room` (N,),
    -1 unknown, and `present` (N, categories): 1, 0 or NaN."""

    regions: Tensor
    label: Tensor
    weight: Tensor
    boxed: Tensor
    summary: Tensor
    room: Tensor
    present: Tensor


@torch.no_grad()
def collect(
    network: Network, frames: Sequence[Labelled], names: Names, passes: float, seed: int,
    say: Callable[[str], None],
) -> Features:  # fmt: skip
    """Features of every frame, augmented anew in each pass, the last of which may be of a part of
    them, drawn at random; the network is in eval mode."""
    rng = np.random.default_rng(seed)
    whole: list[Columns] = []
    parts: list[Columns] = []
    for number in range(math.ceil(passes)):
        count = round(min(1.0, passes - number) * len(frames))
        chosen = [frames[i] for i in rng.permutation(len(frames))[:count]]
        for batch in batches(chosen, names.rooms, BATCH, rng):
            parts.append((*_of_batch(network, batch), _present(batch, names.compare)))
            if len(parts) == JOINED:
                whole.append(_joined(parts))
                parts = []
        say(f"features: pass {number + 1} of {passes:g}")
    return Features(*_joined(whole + parts))


def _joined(parts: Sequence[Columns]) -> Columns:
    return tuple(torch.cat(column) for column in zip(*parts, strict=True))


def _of_batch(network: Network, batch: Batch) -> tuple[Tensor, ...]:
    raw = network(batch.image)
    grid = make_grid(batch.image.shape[2], batch.image.shape[3])
    targets = answers(raw, batch, grid)
    chosen = gather(batch, targets)
    image, location, likeness = background(raw, targets, BACKGROUND)
    regions = (raw.regions[chosen.image, chosen.location], raw.regions[image, location])
    label = torch.cat((chosen.label, torch.full_like(image, -1)))
    weight = torch.cat((chosen.quality, likeness))
    boxed = batch.boxed[torch.cat((chosen.image, image))]
    return torch.cat(regions), label, weight, boxed, raw.summary, batch.room


def _present(batch: Batch, compare: Tensor) -> Tensor:
    """(B, categories): 1 what counts as seen, NaN what is ignored, near to something seen or not
    boxed throughout."""
    rows = []
    for labels, ignore, boxed in zip(batch.labels, batch.ignore, batch.boxed, strict=True):
        seen = torch.unique(labels[~ignore])  # type: ignore[no-untyped-call]
        row = torch.where(boxed == 1, 0.0, torch.nan)
        row[labels[ignore & (labels >= 0)]] = torch.nan
        row[(compare[seen] == 0).any(0)] = torch.nan
        row[seen] = 1.0
        rows.append(row)
    return torch.stack(rows)


def finish(
    network: Network, features: Features, names: Names, seed: int, say: Callable[[str], None],
    room_steps: int = ROOM_STEPS, word_steps: int = 1000, view_weight: float = 0.1,
) -> Network:  # fmt: skip
    """A copy of the network whose word heads were trained on stored features, the room head anew
    (with 0 `room_steps` it is as it was)."""
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    out = copy.deepcopy(network).requires_grad_(True).train()
    summary, middle, spread = _standard(features.summary)
    known = torch.nonzero(features.room >= 0).flatten()

    scale, bias = torch.nn.Parameter(torch.tensor(2.7)), torch.nn.Parameter(torch.tensor(-4.0))

    def views() -> Tensor:
        at = torch.from_numpy(rng.integers(0, len(summary), 256))
        seen = torch.nn.functional.dropout(summary[at], DROPOUT)
        return view_loss(out, seen, features.present[at], names.draw_views(rng), scale, bias)

    def rooms() -> Tensor:
        at = known[torch.from_numpy(rng.integers(0, len(known), 256))]
        seen = torch.nn.functional.dropout(summary[at], DROPOUT)
        room = room_loss(out, seen, features.room[at], names.draw_rooms(rng))
        return room + view_weight * views()

    def words() -> Tensor:
        at = torch.from_numpy(rng.integers(0, len(features.label), 1024))
        label, boxed = features.label[at], features.boxed[at]
        # What is nearly alike is told apart here, too, by labels that do so: COCO's are coarser.
        whole = (boxed == 1).all(1, keepdim=True).float()
        compare = torch.maximum(names.compare[label.clamp(min=0)], whole)
        parts = features.regions[at], label, features.weight[at], boxed, names.draw(rng)
        return word_loss(out, *parts, compare)

    if room_steps:
        _reset(out)
        heads = [*out.room.parameters(), out.room_log_scale, scale, bias]
        _descend("rooms and views", heads, rooms, room_steps, 1e-3, say)
        _fold_standard(out, middle, spread)
    scales = [out.log_scale, out.bias]
    _descend("words", [*out.region.parameters(), *scales], words, word_steps, 5e-4, say)
    return out.eval()


def _standard(x: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Columns to mean 0 and deviation 1, with the means and deviations they had."""
    middle, spread = x.mean(0), x.std(0) + 1e-3
    return (x - middle) / spread, middle, spread


def _reset(network: Network) -> None:
    """Start the room head anew."""
    for layer in network.room:
        if isinstance(layer, torch.nn.Linear):
            layer.reset_parameters()
    with torch.no_grad():
        network.room_log_scale.fill_(2.7)


@torch.no_grad()
def _fold_standard(network: Network, middle: Tensor, spread: Tensor) -> None:
    """Let the room head take features as they are, after it learned on standardised ones."""
    first = network.room[0]
    assert isinstance(first, torch.nn.Linear)
    first.weight /= spread
    first.bias.sub_(first.weight @ middle)


def _descend(
    what: str, parameters: Sequence[Tensor], cost: Callable[[], Tensor], steps: int, rate: float,
    say: Callable[[str], None],
) -> None:  # fmt: skip
    optimiser = torch.optim.AdamW(parameters, lr=rate, weight_decay=0.02)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, rate, total_steps=steps)
    for step in range(steps):
        loss = cost()
        optimiser.zero_grad(set_to_none=True)
        loss.backward()  # type: ignore[no-untyped-call]
        optimiser.step()
        schedule.step()
        if step % 250 == 0 or step == steps - 1:
            say(f"{what}: step {step} loss {float(loss.detach()):.4f}")


def _kept(out: Path, passes: float, seed: int, make: Callable[[], Features]) -> Features:
    """The features as OUT/features.pt has them, if it is of the checkpoint as it is."""
    path, known = out / FEATURES, [(out / CHECKPOINT).stat().st_mtime_ns, passes, seed]
    if path.is_file():
        kept = torch.load(path, weights_only=True)
        if kept.pop("of") == known:
            return Features(**kept)
    features = make()
    save(path, {"of": known, **vars(features)})
    return features


@click.command(epilog="Example:  python -m models.train.finish --data frames/train --out out/train")
@click.option("--data", type=PortionParam(), multiple=True, required=True)
@click.option("--out", type=click.Path(path_type=Path, exists=True), required=True)
@click.option("--passes", default=2.0, show_default=True, help="Augmented passes over the frames.")
@click.option("--seed", default=1, show_default=True)
@click.option(
    "--rooms/--no-rooms",
    default=True,
    show_default=True,
    help="The room head anew, or as it is: few homes are not enough for it.",
)
def main(data: tuple[Portion, ...], out: Path, passes: float, seed: int, rooms: bool) -> None:
    """Read OUT/checkpoint.pt, train its word heads on stored features, write OUT/finished.pt."""
    names = load_names(TextEncoder(manifest.fetch("minilm")).embed)
    network, _ = load_network(out / CHECKPOINT)
    rng = np.random.default_rng(seed)
    frames = read_epoch(data, names.categories, names.held_out, rng)
    features = _kept(
        out, passes, seed, lambda: collect(network, frames, names, passes, seed, click.echo)
    )
    done = finish(network, features, names, seed, click.echo, room_steps=ROOM_STEPS if rooms else 0)
    save(out / FINISHED, {"average": done.state_dict()})


if __name__ == "__main__":
    keep_memory()
    told(main)
