"""Which location answers for which object: task-aligned assignment with centre and size priors."""

from typing import NamedTuple

import torch
from torch import Tensor

from models.train.network import STRIDES, locations

RADIUS = 2.5
"""Only locations within this many strides of a box's centre may answer for it."""
REACH = ((0.0, 72.0), (32.0, 144.0), (80.0, 1e9))
"""Half of a box's longer side, px, that each level may answer for; ranges overlap."""
ANSWERS = 8
IOU_POWER = 4.0


class Grid(NamedTuple):
    """All locations: `centre` (L, 2) px, `stride` (L,) px, `reach` (L, 2) px."""

    centre: Tensor
    stride: Tensor
    reach: Tensor


class Targets(NamedTuple):
    """`owner` (L,) index of the box or -1; `quality` (L,) in 0..1; `counted` (L,) bool."""

    owner: Tensor
    quality: Tensor
    counted: Tensor


def make_grid(height: int, width: int) -> Grid:
    """Locations of an image of this size, in the network's order."""
    centres, strides, reach = [], [], []
    for stride, limits in zip(STRIDES, REACH, strict=True):
        c = locations(height // stride, width // stride, stride)
        centres.append(c)
        strides.append(torch.full((len(c),), float(stride)))
        reach.append(torch.tensor(limits).expand(len(c), 2))
    return Grid(torch.cat(centres), torch.cat(strides), torch.cat(reach))


def pairwise_iou(a: Tensor, b: Tensor) -> Tensor:
    """(N, 4), (M, 4) corners -> (N, M) intersection over union."""
    low = torch.maximum(a[:, None, :2], b[None, :, :2])
    high = torch.minimum(a[:, None, 2:], b[None, :, 2:])
    shared = (high - low).clamp(min=0).prod(-1)
    area_a, area_b = (a[:, 2:] - a[:, :2]).prod(-1), (b[:, 2:] - b[:, :2]).prod(-1)
    return shared / (area_a[:, None] + area_b[None] - shared + 1e-6)


@torch.no_grad()
def assign(grid: Grid, boxes: Tensor, objectness: Tensor, truth: Tensor, ignore: Tensor) -> Targets:
    """One image: predictions (L, 4), (L,) logits; truth (G, 4), ignore (G,) bool -> Targets."""
    size = len(grid.centre)
    owner = torch.full((size,), -1)
    quality = torch.zeros(size)
    counted = torch.ones(size, dtype=torch.bool)
    if ignore.any():
        inside = _inside(grid.centre, truth[ignore]).any(0)
        counted &= ~inside
    kept = torch.nonzero(~ignore).flatten()
    if len(kept) == 0:
        return Targets(owner, quality, counted)
    real = truth[kept]
    iou = pairwise_iou(real, boxes)
    metric = objectness.sigmoid().sqrt() * (iou + 1e-3).pow(IOU_POWER) * _allowed(grid, real)
    best, where = metric.topk(min(ANSWERS, size), dim=1)
    chosen = torch.zeros_like(metric).scatter_(1, where, best)
    answers = chosen.amax(0) > 0
    winner = torch.where(chosen > 0, iou + 1e-3, torch.zeros_like(iou)).argmax(0)
    owner[answers] = kept[winner[answers]]
    mine = chosen[winner, torch.arange(size)]
    peak = chosen.amax(1).clamp(min=1e-12)
    top_iou = torch.where(chosen > 0, iou, torch.zeros_like(iou)).amax(1)
    quality[answers] = (mine / peak[winner] * top_iou[winner])[answers].clamp(min=0.02)
    return Targets(owner, quality, counted | answers)


def _inside(centre: Tensor, boxes: Tensor) -> Tensor:
    """(L, 2), (G, 4) -> (G, L) bool."""
    c = centre[None]
    return ((c > boxes[:, None, :2]) & (c < boxes[:, None, 2:])).all(-1)


def _allowed(grid: Grid, boxes: Tensor) -> Tensor:
    """(G, L) float: 1 where a location may answer; a box too small for any gets its nearest."""
    middle = (boxes[:, :2] + boxes[:, 2:]) / 2
    away = (grid.centre[None] - middle[:, None]).abs().amax(-1)
    half = (boxes[:, 2:] - boxes[:, :2]).amax(-1)[:, None] / 2
    fits = (half >= grid.reach[None, :, 0]) & (half <= grid.reach[None, :, 1])
    allowed = _inside(grid.centre, boxes) & (away < RADIUS * grid.stride[None]) & fits
    lost = ~allowed.any(1)
    if lost.any():
        nearest = (away + 1e6 * ~fits)[lost].argmin(1)
        allowed[torch.nonzero(lost).flatten(), nearest] = True
    return allowed.float()
