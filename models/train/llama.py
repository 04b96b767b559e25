"""A small Llama from a GGUF file, frozen, in torch: what soft tokens are trained against.

llama.cpp rounds activations where this computes in bfloat16: the two agree to that."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from gguf import GGUFReader, dequantize
from torch import Tensor
from torch.nn import functional as F

from models.errors import ModelFileError

WEIGHTS = ("attn_norm", "attn_q", "attn_k", "attn_v", "attn_output", "ffn_norm", "ffn_gate",
           "ffn_up", "ffn_down")  # fmt: skip


class Shape(NamedTuple):
    """What the file's head says."""

    blocks: int
    heads: int
    shared: int  # heads of keys and values
    base: float  # of the rotation's frequencies
    least: float  # of a norm


class FrozenLlama:
    """The model of a GGUF file of architecture llama, weights in bfloat16 that are never trained.
    `embedding` (V, E) float32 are the tokens' vectors; the answers' are the same."""

    def __init__(self, path: Path) -> None:
        reader = GGUFReader(str(path))

        def field(key: str) -> Any:
            found = reader.get_field(key)
            if found is None:
                raise ModelFileError(f"{path}: has no {key}; give a GGUF file of a Llama")
            return found.contents()

        if (kind := field("general.architecture")) != "llama":
            raise ModelFileError(f"{path}: architecture {kind}; soft tokens are trained for llama")
        self.shape = Shape(
            field("llama.block_count"), field("llama.attention.head_count"),
            field("llama.attention.head_count_kv"), field("llama.rope.freq_base"),
            field("llama.attention.layer_norm_rms_epsilon"),
        )  # fmt: skip
        self._weights: dict[str, Tensor] = {}
        for tensor in reader.tensors:
            values = np.array(dequantize(tensor.data, tensor.tensor_type), np.float32)
            if tensor.name == "token_embd.weight":
                self.embedding = torch.from_numpy(values)
                continue
            self._weights[tensor.name] = torch.from_numpy(values).bfloat16()
        if "output.weight" in self._weights:
            raise ModelFileError(f"{path}: answers by weights of their own, which is not supported")

    def last(self, vectors: Tensor) -> Tensor:
        """(N, T, E) tokens' vectors -> (N, E) float32, whose products with `embedding` are the
        logits of the token that follows."""
        x = vectors.bfloat16()
        turn = rotation(x.shape[1], x.shape[2] // self.shape.heads, self.shape.base)
        hidden = torch.full((x.shape[1],) * 2, -1e9, dtype=torch.bfloat16).triu(1)
        for block in range(self.shape.blocks):
            own = {name: self._weights[f"blk.{block}.{name}.weight"] for name in WEIGHTS}
            x = x + self._attend(self._norm(x, own["attn_norm"]), own, turn, hidden)
            told = self._norm(x, own["ffn_norm"])
            gate = F.silu(told @ own["ffn_gate"].T) * (told @ own["ffn_up"].T)
            x = x + gate @ own["ffn_down"].T
        return self._norm(x[:, -1], self._weights["output_norm.weight"]).float()

    def _attend(
        self, x: Tensor, own: dict[str, Tensor], turn: tuple[Tensor, Tensor], hidden: Tensor
    ) -> Tensor:
        q, k, v = (
            (x @ own[f"attn_{name}"].T).unflatten(-1, (count, -1)).transpose(1, 2)
            for name, count in zip(
                "qkv", (self.shape.heads, self.shape.shared, self.shape.shared), strict=True
            )
        )
        q, k = turned(q, turn), turned(k, turn)
        each = self.shape.heads // self.shape.shared
        k, v = k.repeat_interleave(each, 1), v.repeat_interleave(each, 1)
        weight = (q @ k.transpose(-1, -2) * q.shape[-1] ** -0.5 + hidden).float().softmax(-1)
        return (weight.bfloat16() @ v).transpose(1, 2).flatten(2) @ own["attn_output"].T

    def _norm(self, x: Tensor, weight: Tensor) -> Tensor:
        wide = x.float()
        wide = wide * (wide.square().mean(-1, keepdim=True) + self.shape.least).rsqrt()
        return wide.bfloat16() * weight


def rotation(length: int, width: int, base: float) -> tuple[Tensor, Tensor]:
    """Cosines and sines (T, D / 2) of every place."""
    frequency = base ** (-torch.arange(0, width, 2).float() / width)
    angle = torch.arange(length).float()[:, None] * frequency
    return angle.cos().bfloat16(), angle.sin().bfloat16()


def turned(x: Tensor, turn: tuple[Tensor, Tensor]) -> Tensor:
    """(..., T, D) with neighbouring pairs turned by their places, as GGUF files have them."""
    cos, sin = turn
    even, odd = x[..., ::2], x[..., 1::2]
    return torch.stack((even * cos - odd * sin, even * sin + odd * cos), -1).flatten(-2)
