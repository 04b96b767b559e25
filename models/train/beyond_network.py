"""The networks of the scene-layout expert: both look at a keyframe's parts toward a frontier. The
plain head answers with a vector in the text encoder's space, the projector with soft tokens of the
language model. They are small: what there is to learn from are some hundred homes."""

from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn import functional as F

GRID = (6, 8)
"""Rows and columns of the parts that a keyframe is seen in."""
TEXT_DIM = 384
BESIDE = 2
"""Columns of parts to either side of the frontier's, that are looked at as they lie to it."""
PART, MAPS, GEOMETRY, HIDDEN, DIRECTIONS = 32, 6, 32, 64, 16
VIEWED, LOOKS = 64, 4
SCALE = 10.0
"""Of an answer's vector, so that it is learned at the pace of other weights."""
TOKENS, SPOKEN = 8, 64
HALFWAY_M = 5.0
"""Unit of lengths inside the networks."""


class LayoutAnswer(NamedTuple):
    """`beyond` and `view` (N, 386): a vector in the text space, what is said of any name, log of
    floor in m2; `rooms` (N, R) log odds of the room types beyond."""

    beyond: Tensor
    view: Tensor
    rooms: Tensor


class TowardFrontier(nn.Module):
    """What lies round the way to a frontier: features (N, C, h, w), depth (N, 2, h, w), way (N, 2)
    column and range -> what it looks like (N, `width`), how far one can see there (N, GEOMETRY)."""

    def __init__(self, channels: int, dropout: float) -> None:
        super().__init__()
        rows, cols = GRID
        across = 2 * BESIDE + 1
        self.gain = gains(channels)
        self.part = nn.Linear(channels, PART)
        self.maps = nn.Parameter(torch.randn(rows, across, MAPS) * 0.1 + 0.1)
        self.geometry = nn.Linear(3 * rows * across, GEOMETRY - 3)
        self.width = MAPS * PART + PART + 3
        self.drop = nn.Dropout(dropout)
        self.register_buffer("columns", torch.arange(cols).float(), persistent=False)
        beside = torch.arange(-BESIDE, BESIDE + 1).float()
        self.register_buffer("beside", beside, persistent=False)

    def forward(self, features: Tensor, depth: Tensor, way: Tensor) -> tuple[Tensor, Tensor]:
        """Parts are read between columns, so that the way is always in the middle."""
        column, range_ = way[:, :1], way[:, 1:]
        at = (column * GRID[1] - 0.5 + self.beside).clamp(0, GRID[1] - 1)
        read = (1 - (at[:, :, None] - self.columns).abs()).clamp(min=0)[:, None]
        metres, share = depth[:, 0] / HALFWAY_M, depth[:, 1]
        metres, share = (plane @ read[:, 0].transpose(1, 2) for plane in (metres, share))
        further = (metres - range_[:, :, None]) * share
        geometry = torch.stack((metres, further, share), 1).flatten(1)
        parts = self.part(self.drop((features * self.gain).permute(0, 2, 3, 1)))
        mapped = torch.einsum("nrjz,rjm->nmz", read @ parts, self.maps).flatten(1)
        aside = (column - 0.5).abs()
        where = (range_, aside, (range_ - 0.8).clamp(min=0))
        looks = torch.cat((mapped / read.shape[2], parts.mean((1, 2)), *where), 1)
        return looks, torch.cat((F.gelu(self.geometry(geometry)), *where), 1)


class WholeView(nn.Module):
    """What is in view, wherever: features (N, C, h, w) -> (N, `width`)."""

    width = LOOKS * VIEWED

    def __init__(self, channels: int, dropout: float) -> None:
        super().__init__()
        self.gain = gains(channels)
        self.part = nn.Linear(channels, VIEWED)
        self.look = nn.Linear(VIEWED, LOOKS)
        self.drop = nn.Dropout(dropout)

    def forward(self, features: Tensor) -> Tensor:
        """Each look weighs the parts in its own way."""
        scaled = (features * self.gain).flatten(2).transpose(1, 2)
        parts = F.gelu(self.part(self.drop(scaled)))
        weight = self.look(parts).softmax(1)
        return (weight.transpose(1, 2) @ parts).flatten(1)


def gains(channels: int) -> nn.Parameter:
    """(C, 1, 1) what a component counts for at first: the first ones vary most."""
    return nn.Parameter((torch.arange(channels) + 1.0).pow(-0.25)[:, None, None])


class PlainHead(nn.Module):
    """What lies beyond, and what is in view, without a language model. What lies there is told by
    what it looks like; how much, by depth alone, which tells it better than both together."""

    def __init__(self, channels: int, rooms: int, dropout: float = 0.4) -> None:
        super().__init__()
        self.toward = TowardFrontier(channels, dropout)
        self.seen = WholeView(channels, dropout / 2)
        self.think = thinking(self.toward.width, HIDDEN, dropout)
        self.measure = thinking(GEOMETRY, GEOMETRY, dropout / 2)
        self.direction = nn.Linear(HIDDEN, DIRECTIONS)
        self.vector = silent(DIRECTIONS, TEXT_DIM)
        self.sure, self.area = silent(GEOMETRY, 1), nn.Linear(GEOMETRY, 1)
        self.rooms = nn.Linear(HIDDEN, rooms)
        self.view = nn.Sequential(
            thinking(WholeView.width, 2 * HIDDEN, dropout / 2), silent(2 * HIDDEN, TEXT_DIM + 2)
        )

    def forward(self, features: Tensor, depth: Tensor, way: Tensor) -> LayoutAnswer:
        """The way is (column 0..1, range in units of HALFWAY_M)."""
        looks, geometry = self.toward(features, depth, way)
        hidden, measured = self.think(looks), self.measure(geometry)
        vector = self.vector(self.direction(hidden)) * SCALE
        view = self.view(self.seen(features))
        return LayoutAnswer(
            torch.cat((vector, self.sure(measured), self.area(measured)), 1),
            torch.cat((view[:, :TEXT_DIM] * SCALE, view[:, TEXT_DIM:]), 1),
            self.rooms(hidden),
        )


def thinking(width: int, hidden: int, dropout: float) -> nn.Sequential:
    """(N, width) -> (N, hidden)."""
    return nn.Sequential(
        nn.LayerNorm(width), nn.Dropout(dropout), nn.Linear(width, hidden), nn.GELU(),
        nn.Dropout(dropout),
    )  # fmt: skip


def silent(width: int, out: int) -> nn.Linear:
    """A layer that begins with saying nothing."""
    layer = nn.Linear(width, out)
    nn.init.zeros_(layer.weight)
    nn.init.zeros_(layer.bias)
    return layer


def evidence(answer: Tensor, rows: Tensor) -> Tensor:
    """(N, 386), (K, 384) rows less their mean -> (N, K) nats."""
    return answer[:, :TEXT_DIM] @ rows.T + answer[:, TEXT_DIM : TEXT_DIM + 1]


class Projector(nn.Module):
    """Soft tokens (N, 8, E) of a picture toward a way: a start that is always the same, then seven
    that speak through a map from the text encoder's space to the language model's."""

    def __init__(self, channels: int, start: Tensor, bridge: Tensor, dropout: float = 0.2) -> None:
        """`start` (E,) a token's vector; `bridge` (384, E) from words' rows to tokens' vectors."""
        super().__init__()
        self.toward, self.seen = TowardFrontier(channels, dropout), WholeView(channels, dropout)
        width = self.toward.width + GEOMETRY + WholeView.width
        self.think = thinking(width, 192, dropout)
        self.each = nn.Linear(192, (TOKENS - 1) * SPOKEN)
        self.words = nn.Linear(SPOKEN, TEXT_DIM)
        self.bridge = nn.Linear(len(bridge), len(start))
        self.beside = nn.Linear(SPOKEN, len(start))
        self.start = nn.Parameter(start.clone())
        with torch.no_grad():
            self.bridge.weight.copy_(bridge.T)
            self.beside.weight.mul_(0.1)
            for layer in (self.bridge, self.beside):
                layer.bias.zero_()

    def forward(self, features: Tensor, depth: Tensor, way: Tensor) -> Tensor:
        """As PlainHead's -> (N, 8, E)."""
        told = torch.cat((*self.toward(features, depth, way), self.seen(features)), 1)
        each = F.gelu(self.each(self.think(told)).unflatten(1, (TOKENS - 1, SPOKEN)))
        spoken = self.bridge(F.normalize(self.words(each), dim=-1)) + self.beside(each)
        start = self.start + 0 * each[:, :1, :1]  # as many as there are, in the file, too
        return torch.cat((start, spoken), 1)
