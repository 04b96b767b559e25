"""The training loop: a schedule in wall time, an average of the weights, checkpoints to resume."""

import contextlib
import copy
import csv
import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from models.train.data import FULL, SMALL, Batch, batches
from models.train.labelled import Portion, read_epoch
from models.train.losses import Losses, loss
from models.train.names import Embed, Names, load_names
from models.train.network import Network
from models.train.targets import make_grid
from models.train.team import Team

LOG_EVERY = 20
SAVE_EVERY = 200
CHECKPOINT = "checkpoint.pt"
ALONE = Team()


@dataclass(frozen=True)
class Recipe:
    """How to train. The learning rate warms up, then falls as a cosine over `minutes`.

    Frames are small for the first `small_until` of the time: more of them are seen.
    """

    minutes: float = 55.0
    batch: int = 8
    head_rate: float = 1.2e-3
    backbone_rate: float = 2e-4
    height: float = 1.0  # factor of both rates
    weight_decay: float = 1e-4
    warmup_steps: int = 200
    average_decay: float = 0.998
    clip: float = 10.0
    small_until: float = 0.6
    seed: int = 1


class Trainer:
    """All state of a run; `spent_s` is training time, which a resumed run goes on counting."""

    def __init__(self, network: Network, names: Names, recipe: Recipe, team: Team = ALONE) -> None:
        self.network, self.names, self.recipe, self.team = network, names, recipe, team
        self.learned = [p for p in network.parameters() if p.requires_grad]
        self.average = copy.deepcopy(network).requires_grad_(False)
        backbone = [p for p in network.backbone.parameters() if p.requires_grad]
        known = {id(p) for p in network.backbone.parameters()}
        rest = [p for p in network.parameters() if id(p) not in known]
        self.optimiser = torch.optim.AdamW(
            [
                {"params": backbone, "rate": recipe.backbone_rate},
                {"params": rest, "rate": recipe.head_rate},
            ],
            lr=recipe.head_rate,
            weight_decay=recipe.weight_decay,
        )
        self.rng = np.random.default_rng((recipe.seed, team.rank))
        self.step, self.epoch, self.spent_s = 0, 0, 0.0

    def learn(self, batch: Batch) -> Losses:
        """One step on one batch."""
        self.network.train()
        grid = make_grid(batch.image.shape[2], batch.image.shape[3])
        losses = loss(self.network, self.network(batch.image), batch, grid, self.names, self.rng)
        self.optimiser.zero_grad(set_to_none=True)
        losses.total.backward()  # type: ignore[no-untyped-call]
        self.team.average_gradients(self.learned)
        torch.nn.utils.clip_grad_norm_(self.learned, self.recipe.clip)
        for group in self.optimiser.param_groups:
            group["lr"] = group["rate"] * self.pace()
        self.optimiser.step()
        self._follow()
        self.step += 1
        return losses

    def done(self) -> float:
        """Share of the time that is used, 0..1."""
        return min(1.0, self.spent_s / (60 * self.recipe.minutes))

    def size(self) -> tuple[int, int]:
        """Width and height of the frames to learn from now, px."""
        return SMALL if self.done() < self.recipe.small_until else FULL

    def pace(self) -> float:
        """Factor of the learning rates now."""
        warm = min(1.0, (self.step + 1) / self.recipe.warmup_steps)
        done = self.done()
        return self.recipe.height * warm * (0.02 + 0.98 * 0.5 * (1 + math.cos(math.pi * done)))

    @torch.no_grad()
    def _follow(self) -> None:
        decay = min(self.recipe.average_decay, (1 + self.step) / (10 + self.step))
        mine = self.average.state_dict()
        for key, value in self.network.state_dict().items():
            if value.dtype.is_floating_point:
                mine[key].lerp_(value, 1 - decay)
            else:
                mine[key].copy_(value)

    def save(self, path: Path) -> None:
        """Write everything."""
        state = {
            "network": self.network.state_dict(),
            "average": self.average.state_dict(),
            "optimiser": self.optimiser.state_dict(),
            "categories": self.names.categories,
            "rooms": self.names.rooms,
            "step": self.step,
            "epoch": self.epoch,
            "spent_s": self.spent_s,
        }
        save(path, state)

    def restore(self, path: Path) -> None:
        """Go on from a file that `save` wrote."""
        state: dict[str, Any] = torch.load(path, map_location="cpu", weights_only=True)
        self.network.load_state_dict(state["network"])
        self.average.load_state_dict(state["average"])
        self.optimiser.load_state_dict(state["optimiser"])
        self.step, self.epoch = state["step"], state["epoch"]
        self.spent_s = state["spent_s"]
        self.rng = np.random.default_rng((self.recipe.seed, self.team.rank, self.step))


def save(path: Path, state: dict[str, Any]) -> None:
    """Write a checkpoint; the old file stays whole until the new one is."""
    partial = path.with_suffix(".partial")
    torch.save(state, partial)
    partial.replace(path)


def train(
    data: Sequence[Portion],
    out: Path,
    backbone: dict[str, Tensor],
    embed: Embed,
    recipe: Recipe,
    say: Callable[[str], None],
    start: Path | None = None,
    team: Team = ALONE,
) -> None:
    """Train until the recipe's minutes are used; frames that appear meanwhile join each epoch.

    `start`: a checkpoint whose averaged weights a new run begins with, in place of ImageNet's.
    Every member of a team calls this; the leader writes.
    """
    torch.manual_seed(recipe.seed)
    out.mkdir(parents=True, exist_ok=True)
    network = Network()
    network.backbone.load_imagenet(backbone)
    if start is not None:
        network.load_state_dict(torch.load(start, map_location="cpu", weights_only=True)["average"])
    network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    trainer = Trainer(network, load_names(embed), recipe, team)
    checkpoint = out / CHECKPOINT
    if checkpoint.exists():
        trainer.restore(checkpoint)
        say(f"resumed at step {trainer.step}, {trainer.spent_s / 60:.1f} min spent")
    while trainer.done() < 1:
        names = trainer.names
        shown = read_epoch(data, names.categories, names.held_out, trainer.rng)
        say(f"epoch {trainer.epoch}: {len(shown)} frames, {len({f.path for f in shown})} different")
        source = batches(team.share(shown), names.rooms, recipe.batch, trainer.rng, trainer.size)
        with contextlib.closing(source):
            for losses in _steps(trainer, source):
                if team.leads and trainer.step % LOG_EVERY == 0:
                    _log(out / "log.csv", trainer, losses, say)
                if team.leads and trainer.step % SAVE_EVERY == 0:
                    trainer.save(checkpoint)
                if trainer.done() >= 1:
                    break
        trainer.epoch += 1
        if team.leads:
            trainer.save(checkpoint)


def _steps(trainer: Trainer, source: Iterator[Batch]) -> Iterator[Losses]:
    mark = time.monotonic()
    for batch in source:
        losses = trainer.learn(batch)
        trainer.spent_s = trainer.team.mean(trainer.spent_s + time.monotonic() - mark)
        mark = time.monotonic()
        yield losses


def _log(path: Path, trainer: Trainer, losses: Losses, say: Callable[[str], None]) -> None:
    values = [f"{float(v.detach()):.4f}" for v in losses]
    seen = trainer.step * trainer.recipe.batch * trainer.team.count
    rate = f"{seen / max(trainer.spent_s, 1e-6):.2f}"
    new = not path.exists()
    with path.open("a", newline="") as stream:
        writer = csv.writer(stream)
        if new:
            writer.writerow(["step", "epoch", "spent_s", "pace", *losses._fields, "frames_per_s"])
        progress = [trainer.step, trainer.epoch, f"{trainer.spent_s:.0f}", f"{trainer.pace():.3f}"]
        writer.writerow([*progress, *values, rate])
    say(f"step {trainer.step} {dict(zip(losses._fields, values, strict=True))} {rate} frames/s")
