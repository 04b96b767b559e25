"""Fewer numbers for what the backbone has of each part of an image: principal components of its
channels, each of the same weight, with deviation 1. Keyframes are kept in them."""

import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from models.errors import ModelFileError

Floats = NDArray[np.float32]
KEPT = 96
FLOOR = 1e-6
"""Of what varies least, beside what varies most."""


@dataclass(frozen=True)
class Compaction:
    """`weight` (C, D) and `bias` (D,): a part's features (C,) become (D,)."""

    weight: Floats
    bias: Floats

    @classmethod
    def of(cls, features: Floats, kept: int = KEPT) -> "Compaction":
        """(F, C, h, w) -> the directions in which their parts vary most."""
        parts = np.moveaxis(features, 1, -1).reshape(-1, features.shape[1]).astype(np.float64)
        mean, spread = parts.mean(axis=0), parts.std(axis=0)
        spread = np.maximum(spread, FLOOR * spread.max())
        value, vector = np.linalg.eigh(np.cov((parts - mean) / spread, rowvar=False))
        order = np.argsort(-value)[:kept]
        deviation = np.sqrt(np.maximum(value[order], FLOOR * value.max()))
        weight = vector[:, order] / deviation / spread[:, None]
        return cls(weight.astype(np.float32), (-mean @ weight).astype(np.float32))

    def __call__(self, features: Floats) -> Floats:
        """(F, C, h, w) -> (F, D, h, w)."""
        told = np.tensordot(self.weight, features, (0, 1)) + self.bias[:, None, None, None]
        return np.ascontiguousarray(np.moveaxis(told, 0, 1), np.float32)

    def save(self, path: Path) -> None:
        """Write it."""
        np.savez(path, weight=self.weight, bias=self.bias)

    @classmethod
    def read(cls, path: Path) -> "Compaction":
        """One that `save` wrote. Raises ModelFileError."""
        try:
            with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
                return cls(file["weight"], file["bias"])
        except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
            told = " ".join(str(error).split())[:120]
            raise ModelFileError(
                f"{path}: no compaction ({told}); models.train.beyond makes one"
            ) from error
