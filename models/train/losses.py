"""What an answer costs: objectness as quality, boxes as GIoU, regions and scenes as words."""

from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional as F

from models.train.data import Batch
from models.train.names import Names
from models.train.network import Network, Raw
from models.train.targets import Grid, Targets, assign

HARD = 24
"""Background locations per image, the most objectlike, that must resemble no word."""
UNBOXED = 0.2
"""What an answer where no box is counts for, in a frame of which not everything is boxed."""
BOX_WEIGHT, WORD_WEIGHT, ROOM_WEIGHT = 2.0, 1.0, 0.8


class Losses(NamedTuple):
    """Scalars; `total` is their weighted sum."""

    total: Tensor
    objectness: Tensor
    box: Tensor
    words: Tensor
    room: Tensor


class Chosen(NamedTuple):
    """Locations that answer for an object, over a batch."""

    image: Tensor  # (P,) index into the batch
    location: Tensor  # (P,)
    truth: Tensor  # (P, 4)
    label: Tensor  # (P,)
    quality: Tensor  # (P,)


def loss(
    network: Network, raw: Raw, batch: Batch, grid: Grid, names: Names, rng: np.random.Generator
) -> Losses:
    """Everything one batch costs."""
    targets = answers(raw, batch, grid)
    quality = torch.stack([t.quality for t in targets])
    owned = torch.stack([t.owner >= 0 for t in targets])
    certain = torch.where(owned | (batch.boxed == 1).all(1, keepdim=True), 1.0, UNBOXED)
    counted = torch.stack([t.counted for t in targets]) * certain
    chosen = gather(batch, targets)
    weight = chosen.quality.sum().clamp(min=1.0)
    objectness = _quality_focal(raw.objectness, quality, counted) / weight
    giou = generalised_iou(raw.boxes[chosen.image, chosen.location], chosen.truth)
    box = ((1 - giou) * chosen.quality).sum() / weight
    words = _word_loss(network, raw, batch, chosen, targets, names, rng)
    room = room_loss(network, raw.summary, batch.room, names.draw_rooms(rng))
    total = objectness + BOX_WEIGHT * box + WORD_WEIGHT * words + ROOM_WEIGHT * room
    return Losses(total, objectness, box, words, room)


def answers(raw: Raw, batch: Batch, grid: Grid) -> list[Targets]:
    """Who answers for what, an image each; no better than the boxes are sure."""
    found = []
    for i, surety in enumerate(batch.surety):
        target = assign(grid, raw.boxes[i], raw.objectness[i], batch.boxes[i], batch.ignore[i])
        cap = torch.cat((surety, surety.new_ones(1)))[target.owner]  # -1: nobody's
        found.append(target._replace(quality=target.quality * cap))
    return found


def gather(batch: Batch, targets: list[Targets]) -> Chosen:
    """Every answering location with its object."""
    columns: list[list[Tensor]] = [[], [], [], [], []]
    for i, target in enumerate(targets):
        at = torch.nonzero(target.owner >= 0).flatten()
        owner = target.owner[at]
        parts = (torch.full_like(at, i), at, batch.boxes[i][owner], batch.labels[i][owner])
        for column, part in zip(columns, (*parts, target.quality[at]), strict=True):
            column.append(part)
    return Chosen(*(torch.cat(c) for c in columns))


def _quality_focal(logits: Tensor, quality: Tensor, counted: Tensor) -> Tensor:
    """Binary cross entropy toward the quality, easy locations weighted down (Li et al. 2020)."""
    p = logits.sigmoid()
    cost = F.binary_cross_entropy_with_logits(logits, quality, reduction="none")
    return ((p - quality).abs().square() * cost * counted).sum()


def generalised_iou(a: Tensor, b: Tensor) -> Tensor:
    """(N, 4), (N, 4) corners -> (N,) in -1..1 (Rezatofighi et al. 2019)."""
    shared = (torch.minimum(a[:, 2:], b[:, 2:]) - torch.maximum(a[:, :2], b[:, :2])).clamp(min=0)
    hull = torch.maximum(a[:, 2:], b[:, 2:]) - torch.minimum(a[:, :2], b[:, :2])
    inner = shared.prod(-1)
    union = (a[:, 2:] - a[:, :2]).prod(-1) + (b[:, 2:] - b[:, :2]).prod(-1) - inner + 1e-6
    outer = hull.prod(-1) + 1e-6
    return inner / union - (outer - union) / outer


def _word_loss(
    network: Network, raw: Raw, batch: Batch, chosen: Chosen, targets: list[Targets], names: Names,
    rng: np.random.Generator,
) -> Tensor:  # fmt: skip
    image, location, likeness = background(raw, targets)
    return word_loss(
        network,
        torch.cat((raw.regions[chosen.image, chosen.location], raw.regions[image, location])),
        torch.cat((chosen.label, torch.full_like(image, -1))),
        torch.cat((chosen.quality, likeness)),
        batch.boxed[torch.cat((chosen.image, image))],
        names.draw(rng),
        names.compare[torch.cat((chosen.label, torch.zeros_like(image)))],
    )


def word_loss(
    network: Network, regions: Tensor, label: Tensor, weight: Tensor, boxed: Tensor, rows: Tensor,
    compare: Tensor,
) -> Tensor:  # fmt: skip
    """Sigmoid alignment (Zhai et al. 2023) of regions with one name of every category.

    `label` (P,): category, or -1 for a region that must resemble no word, as far as things of that
    name are `boxed` (P, C) there; `rows` (C + absent, 384); `compare` (P, C): 1 where a word counts
    for what is there.
    """
    thing = label >= 0
    right = F.one_hot(label.clamp(min=0), len(rows)).float() * thing[:, None]
    beyond = torch.ones(len(label), len(rows) - compare.shape[1])
    named = torch.maximum(torch.cat((compare, beyond), 1), right)
    empty = torch.cat((boxed, beyond * (boxed == 1).all(1, keepdim=True)), 1)
    matter = torch.where(thing[:, None], named, empty)
    logits = network.embed(regions) @ rows.T * network.log_scale.exp() + network.bias
    cost = F.binary_cross_entropy_with_logits(logits, right, reduction="none")
    return (cost * matter * weight[:, None]).sum() / weight.sum().clamp(min=1.0)


@torch.no_grad()
def background(
    raw: Raw, targets: list[Targets], count: int = HARD
) -> tuple[Tensor, Tensor, Tensor]:
    """Image, location and weight of the most objectlike locations that no object owns."""
    free = torch.stack([t.counted & (t.owner < 0) for t in targets])
    score = raw.objectness.sigmoid().masked_fill(~free, 0.0)
    likeness, location = score.topk(count, dim=1)
    image = torch.arange(len(targets))[:, None].expand_as(location)
    return image.flatten(), location.flatten(), likeness.flatten()


def room_loss(network: Network, summary: Tensor, room: Tensor, rows: Tensor) -> Tensor:
    """Cross entropy over the room types; -1 is an unknown one."""
    if not bool((room >= 0).any()):
        return summary.sum() * 0.0
    logits = network.embed_scene(summary) @ rows.T * network.room_log_scale.exp()
    return F.cross_entropy(logits, room, ignore_index=-1, label_smoothing=0.05)


def view_loss(
    network: Network, summary: Tensor, present: Tensor, rows: Tensor, scale: Tensor, bias: Tensor
) -> Tensor:
    """Sigmoid alignment of whole views with what is in them: `present` (B, C) is 1, 0, or NaN where
    a category neither counts as seen nor as absent; `rows` (C, 384)."""
    logits = network.embed_scene(summary) @ rows.T * scale.exp() + bias
    known = ~present.isnan()
    cost = F.binary_cross_entropy_with_logits(logits, present.nan_to_num(), reduction="none")
    return (cost * known).sum() / len(summary)
