"""`python -m models.train.rooms`: the room head learns what rooms look like in photographs, and of
renderings goes on saying what it said. Nothing else of the network changes."""

import copy
from collections.abc import Callable, Sequence
from pathlib import Path

import click
import numpy as np
import torch
from torch import Tensor
from torch.nn import functional as F

from models.errors import told
from models.store import manifest
from models.train.data import batches
from models.train.export import load_network
from models.train.labelled import Labelled, read_frames
from models.train.losses import room_loss
from models.train.memory import keep_memory
from models.train.names import Names, load_names
from models.train.network import Network
from models.train.trainer import save
from models.words.text_encoder import TextEncoder

BATCH = 8
DROPOUT = 0.3
STEPS, RATE = 1500, 5e-4
KEPT = 20.0
"""What a scene's distance from what it was (1 - cosine) costs in renderings."""


@torch.no_grad()
def summaries(
    network: Network, frames: Sequence[Labelled], names: Names, rng: np.random.Generator
) -> tuple[Tensor, Tensor]:
    """(N, S) summaries of the frames, each augmented once, and (N,) their rooms, -1 unknown."""
    rows, rooms = [], []
    for batch in batches(frames, names.rooms, BATCH, rng):
        rows.append(network(batch.image).summary.clone())
        rooms.append(batch.room)
    return torch.cat(rows), torch.cat(rooms)


def learn_rooms(
    network: Network, photographs: tuple[Tensor, Tensor], renderings: Tensor, names: Names,
    rng: np.random.Generator, say: Callable[[str], None], steps: int = STEPS,
) -> Network:  # fmt: skip
    """A copy of the network whose room head was trained on photographs (summaries, rooms), and held
    to what it says of renderings (summaries)."""
    out = copy.deepcopy(network).requires_grad_(True).train()
    with torch.no_grad():
        before = network.embed_scene(renderings)
    summary, room = photographs
    known = torch.nonzero(room >= 0).flatten()
    parameters = [*out.room.parameters()]
    optimiser = torch.optim.AdamW(parameters, lr=RATE, weight_decay=0.02)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, RATE, total_steps=steps)
    for step in range(steps):
        at = known[torch.from_numpy(rng.integers(0, len(known), 256))]
        seen = F.dropout(summary[at], DROPOUT)
        learned = room_loss(out, seen, room[at], names.draw_rooms(rng))
        at = torch.from_numpy(rng.integers(0, len(renderings), 256))
        apart = (1 - (out.embed_scene(renderings[at]) * before[at]).sum(-1)).mean()
        optimiser.zero_grad(set_to_none=True)
        (learned + KEPT * apart).backward()  # type: ignore[no-untyped-call]
        optimiser.step()
        schedule.step()
        if step % 250 == 0 or step == steps - 1:
            say(
                f"rooms: step {step} loss {learned.item():.4f}, renderings apart {apart.item():.4f}"
            )
    return out.eval()


@click.command(
    epilog="Example:  python -m models.train.rooms --checkpoint start.pt --photographs rooms "
    "--renderings frames/train --out rooms.pt"
)
@click.option("--checkpoint", type=click.Path(path_type=Path, exists=True), required=True)
@click.option("--photographs", type=click.Path(path_type=Path, exists=True), required=True)
@click.option("--renderings", type=click.Path(path_type=Path, exists=True), required=True)
@click.option("--out", type=click.Path(path_type=Path), required=True)
@click.option("--seed", default=1, show_default=True)
def main(checkpoint: Path, photographs: Path, renderings: Path, out: Path, seed: int) -> None:
    """Teach the room head of a checkpoint photographs' rooms; write the whole network to OUT."""
    names = load_names(TextEncoder(manifest.fetch("minilm")).embed)
    network, _ = load_network(checkpoint)
    rng = np.random.default_rng(seed)
    torch.manual_seed(seed)
    seen = []
    for folder in (photographs, renderings):
        frames = read_frames(folder, names.categories, names.held_out)
        seen.append(summaries(network, frames, names, rng))
        click.echo(f"{folder}: {len(seen[-1][0])} views")
    done = learn_rooms(network, seen[0], seen[1][0], names, rng, click.echo)
    save(out, {"average": done.state_dict()})


if __name__ == "__main__":
    keep_memory()
    told(main)
