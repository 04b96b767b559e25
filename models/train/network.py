"""The detector's network: EfficientNet-Lite0, a light FPN, a one-stage head, text-aligned outputs.

Input (B, 3, H, W) float32 RGB in 0..255, H and W multiples of 32. Levels have strides 8, 16, 32
and their locations are concatenated in that order: L = sum of H * W / stride**2.
"""

from collections.abc import Mapping
from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn import functional as F

from models.detection.told import IMAGENET

STRIDES = (8, 16, 32)
TEXT_DIM = 384
# EfficientNet-Lite0 (Tan and Le 2019, "lite" variant): kernel, stride, expansion, output, repeats
STAGES = (
    (3, 1, 1, 16, 1),
    (3, 2, 6, 24, 2),
    (5, 2, 6, 40, 2),
    (3, 2, 6, 80, 3),
    (5, 1, 6, 112, 3),
    (5, 2, 6, 192, 4),
    (3, 1, 6, 320, 1),
)
TAPS = {4: 40, 10: 112, 15: 320}
"""Blocks whose outputs feed the FPN, with their channels."""


class Raw(NamedTuple):
    """What the head says at every location, before any selection."""

    boxes: Tensor  # (B, L, 4) pixels x0, y0, x1, y1
    objectness: Tensor  # (B, L) logits
    regions: Tensor  # (B, L, C) features, to be embedded where they are needed
    summary: Tensor  # (B, S) what the whole image holds, to be embedded as a room


class SameConv(nn.Conv2d):
    """Convolution with TensorFlow's SAME padding and a bias: a batch norm is folded into it."""

    def __init__(self, cin: int, cout: int, kernel: int, stride: int = 1, groups: int = 1):
        super().__init__(cin, cout, kernel, stride, kernel // 2, groups=groups)
        short = (kernel - 2) // 2  # even input, stride 2: one row less before than after
        self.lopsided = (short, kernel - 2 - short) * 2 if stride == 2 else None
        if self.lopsided:
            self.padding = (0, 0)

    def forward(self, x: Tensor) -> Tensor:
        return super().forward(F.pad(x, self.lopsided) if self.lopsided else x)


class Block(nn.Module):
    """Inverted residual without squeeze-and-excitation, ReLU6."""

    def __init__(self, cin: int, cout: int, kernel: int, stride: int, expansion: int):
        super().__init__()
        mid = cin * expansion
        self.expand = SameConv(cin, mid, 1) if expansion > 1 else None
        self.depthwise = SameConv(mid, mid, kernel, stride, groups=mid)
        self.project = SameConv(mid, cout, 1)
        self.residual = stride == 1 and cin == cout

    def forward(self, x: Tensor) -> Tensor:
        y = F.relu6(self.expand(x), inplace=True) if self.expand is not None else x
        y = self.project(F.relu6(self.depthwise(y), inplace=True))
        out: Tensor = x + y if self.residual else y
        return out


class Backbone(nn.Module):
    """EfficientNet-Lite0, batch norms folded; the first `frozen` blocks take no gradient."""

    def __init__(self, frozen: int = 5):
        super().__init__()
        self.frozen = frozen
        self.stem = SameConv(3, 32, 3, 2)
        blocks, cin = [], 32
        for kernel, stride, expansion, cout, repeats in STAGES:
            for i in range(repeats):
                blocks.append(Block(cin, cout, kernel, stride if i == 0 else 1, expansion))
                cin = cout
        self.blocks = nn.ModuleList(blocks)
        if frozen:
            self.stem.requires_grad_(False)
            self.blocks[:frozen].requires_grad_(False)

    def forward(self, x: Tensor) -> list[Tensor]:
        taps = []
        x = F.relu6(self.stem(x), inplace=True)
        for i, block in enumerate(self.blocks):
            x = block(x)
            if i in TAPS:
                taps.append(x)
        return taps

    def load_imagenet(self, state: Mapping[str, Tensor]) -> None:
        """Take the published state dict, each batch norm folded into its convolution."""
        fold(self.stem, state, "_conv_stem", "_bn0")
        for i, block in enumerate(self.blocks):
            at = f"_blocks.{i}."
            if block.expand is not None:
                fold(block.expand, state, at + "_expand_conv", at + "_bn0")
            fold(block.depthwise, state, at + "_depthwise_conv", at + "_bn1")
            fold(block.project, state, at + "_project_conv", at + "_bn2")


def fold(conv: object, state: Mapping[str, Tensor], weight: str, norm: str) -> None:
    """Take a convolution of the state dict, the batch norm behind it folded in."""
    assert isinstance(conv, SameConv)
    assert conv.bias is not None
    gain = state[norm + ".weight"] / torch.sqrt(state[norm + ".running_var"] + 1e-3)
    with torch.no_grad():
        conv.weight.copy_(state[weight + ".weight"] * gain[:, None, None, None])
        conv.bias.copy_(state[norm + ".bias"] - state[norm + ".running_mean"] * gain)


def _separable(cin: int, cout: int, kernel: int = 3) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(cin, cin, kernel, padding=kernel // 2, groups=cin, bias=False),
        nn.Conv2d(cin, cout, 1, bias=False),
        nn.BatchNorm2d(cout),
        nn.ReLU(inplace=True),
    )


class Pyramid(nn.Module):
    """Top-down, then bottom-up, with depthwise-separable convolutions (PANet, light)."""

    def __init__(self, channels: int):
        super().__init__()
        self.lateral = nn.ModuleList(nn.Conv2d(c, channels, 1) for c in TAPS.values())
        self.down = nn.ModuleList(_separable(channels, channels, 5) for _ in range(2))
        self.up = nn.ModuleList(_separable(channels, channels, 5) for _ in range(2))

    def forward(self, taps: list[Tensor]) -> list[Tensor]:
        p3, p4, p5 = (lat(t) for lat, t in zip(self.lateral, taps, strict=True))
        p4 = self.down[0](p4 + F.interpolate(p5, scale_factor=2.0, mode="nearest"))
        p3 = self.down[1](p3 + F.interpolate(p4, scale_factor=2.0, mode="nearest"))
        p4 = self.up[0](p4 + F.max_pool2d(p3, 2))
        p5 = self.up[1](p5 + F.max_pool2d(p4, 2))
        return [p3, p4, p5]


class Head(nn.Module):
    """One head for all levels: a tower for boxes and objectness, a tower for what it is."""

    def __init__(self, channels: int):
        super().__init__()
        self.where = nn.Sequential(_separable(channels, channels), _separable(channels, channels))
        self.what = nn.Sequential(_separable(channels, channels), _separable(channels, channels))
        self.box = nn.Conv2d(channels, 4, 1)
        self.objectness = nn.Conv2d(2 * channels, 1, 1)
        self.scale = nn.Parameter(torch.ones(len(STRIDES)))
        nn.init.constant_(self.objectness.bias, -4.0)  # type: ignore[arg-type]
        nn.init.constant_(self.box.bias, 1.0)  # type: ignore[arg-type]

    def forward(self, levels: list[Tensor]) -> tuple[Tensor, Tensor, Tensor]:
        boxes, scores, regions = [], [], []
        for i, (x, stride) in enumerate(zip(levels, STRIDES, strict=True)):
            where, what = self.where(x), self.what(x)
            reach = F.softplus(self.box(where) * self.scale[i]) * (2.0 * stride)
            boxes.append(_corners(reach, stride))
            scores.append(self.objectness(torch.cat((where, what), 1)).flatten(1))
            regions.append(what.flatten(2).transpose(1, 2))
        return torch.cat(boxes, 1), torch.cat(scores, 1), torch.cat(regions, 1)


def _corners(reach: Tensor, stride: int) -> Tensor:
    """(B, 4, h, w) distances left, top, right, bottom in px -> (B, h*w, 4) corners in px."""
    centre = locations(reach.shape[2], reach.shape[3], stride).to(reach.device)
    r = reach.flatten(2).transpose(1, 2)
    return torch.cat((centre - r[..., :2], centre + r[..., 2:]), -1)


def locations(rows: int, columns: int, stride: int) -> Tensor:
    """(rows * columns, 2) centres x, y of a level's cells in pixels."""
    y, x = torch.meshgrid(torch.arange(rows), torch.arange(columns), indexing="ij")
    return torch.stack((x, y), -1).reshape(-1, 2).float().add_(0.5).mul_(float(stride))


def _mlp(cin: int, hidden: int) -> nn.Sequential:
    return nn.Sequential(nn.Linear(cin, hidden), nn.ReLU(), nn.Linear(hidden, TEXT_DIM))


class Network(nn.Module):
    """Everything that is trained. `scale` and `bias` turn cosines into logits (SigLIP)."""

    mean: Tensor
    std: Tensor

    def __init__(self, channels: int = 96, frozen: int = 5):
        super().__init__()
        self.backbone = Backbone(frozen)
        self.pyramid = Pyramid(channels)
        self.head = Head(channels)
        self.region = _mlp(channels, 256)
        self.room = _mlp(2 * list(TAPS.values())[-1] + 2 * channels, 256)
        self.log_scale = nn.Parameter(torch.tensor(2.7))
        self.bias = nn.Parameter(torch.tensor(-8.0))
        self.room_log_scale = nn.Parameter(torch.tensor(2.7))
        self.register_buffer("mean", torch.tensor(IMAGENET.mean).view(1, 3, 1, 1), persistent=False)
        self.register_buffer(
            "std", torch.tensor(IMAGENET.deviation).view(1, 3, 1, 1), persistent=False
        )

    def forward(self, image: Tensor) -> Raw:
        taps = self.backbone((image - self.mean) / self.std)
        boxes, objectness, regions = self.head(self.pyramid(taps))
        return Raw(boxes, objectness, regions, _summary(taps[-1], objectness, regions))

    def embed(self, regions: Tensor) -> Tensor:
        """(..., C) region features -> (..., 384) unit rows in the text encoder's space."""
        return F.normalize(self.region(regions), dim=-1)

    def embed_scene(self, summary: Tensor) -> Tensor:
        """(B, S) -> (B, 384) unit rows in the text encoder's space."""
        return F.normalize(self.room(summary), dim=-1)


def _summary(top: Tensor, objectness: Tensor, regions: Tensor) -> Tensor:
    """Mean and maximum of the coarsest features, and of what seems to be an object."""
    weight = objectness.sigmoid()[..., None]
    thing = (regions * weight).sum(1) / (weight.sum(1) + 1e-3)
    pooled = (top.mean((2, 3)), top.amax((2, 3)), thing, (regions * weight).amax(1))
    return torch.cat(pooled, 1)
