"""Triangles without an index: what shapes are made of, and what meshes are made from."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass
class Material:
    """What an MTL says of a material, as far as it is used."""

    colour: tuple[float, float, float] = (0.7, 0.7, 0.7)
    texture: Path | None = None
    opacity: float = 1.0


@dataclass
class Soup:
    """Triangles of one material: corners (N, 3, 3) m and texture coordinates (N, 3, 2)."""

    material: Material
    corners: Array
    uv: Array


def bounds(soups: Sequence[Soup]) -> tuple[Array, Array]:
    """(3,) lowest and highest x, y, z of all corners, m."""
    points = np.concatenate([s.corners.reshape(-1, 3) for s in soups])
    return points.min(axis=0), points.max(axis=0)
