"""Which mesh shows a thing of RoboTHOR's, and how large: its box is filled as far as the mesh's own
proportions allow, so that a person goes on seeing what it is."""

import math
import random
from collections.abc import Sequence

from hil_sim.scenes.furniture.boxes import CatalogMesh
from hil_sim.scenes.robothor.footprints import Footprint

Size = tuple[float, float, float]

STRETCH = 1.25
"""How much more a mesh is stretched along one side than along another, at most."""
BALLS = ("BasketBall",)
"""Not stretched at all."""
TO_MEASURE = (
    "Bed", "Book", "Box", "CD", "CoffeeTable", "Desk", "DiningTable", "Dresser", "Newspaper",
    "Painting", "Pillow", "ShelvingUnit", "SideTable", "Sofa", "TVStand",
)  # fmt: skip
"""What comes in any proportions: boards, cushions and sheets. It fills its box, as what stands on
it asks for."""
FRONTED = (
    "AlarmClock", "ArmChair", "Bed", "Chair", "Desk", "Dresser", "Laptop", "Painting",
    "ShelvingUnit", "Sofa", "TVStand", "Television",
)  # fmt: skip
"""Types whose front matters; the others are turned to fit a mesh's longer side."""
SIMILAR, NEARLY = 1.35, 1.1
"""Meshes that are stretched up to this factor more than the best are as good: where any proportions
will do, and where not."""


def fitted(
    rng: random.Random, meshes: Sequence[CatalogMesh], box: Footprint, kind: str
) -> tuple[str, int, Size]:
    """A mesh for a thing of AI2-THOR's type `kind`, one of those that fit its box well; the quarter
    turns that fit it, and its width, depth and height, m, none larger than the box's."""
    free = kind in TO_MEASURE
    turns = (0,) if kind in FRONTED else (0, 1)
    best = [min(_rated(mesh, box, turn) for turn in turns) for mesh in meshes]
    least = min(row[0] for row in best)
    limit = least * SIMILAR if free else max(least * NEARLY, STRETCH)
    good = sorted(row[1:] for row in best if row[0] <= limit)
    id, turn, factors, size = rng.choice(good)
    most = math.inf if free else 1.0 if kind in BALLS else STRETCH
    scale = [min(factor, most * min(factors)) for factor in factors]
    width, depth, height = (a * b for a, b in zip(scale, size, strict=True))
    return id, turn, (width, depth, height)


def _rated(mesh: CatalogMesh, box: Footprint, turn: int) -> tuple[float, str, int, Size, Size]:
    """How much more a mesh is stretched along one side than along another to fill the box, which
    one, its quarter turns, by how much along its width, depth and height, and its own size."""
    width, depth = (box.depth, box.width) if turn else (box.width, box.depth)
    w, d, h = (max(side, 1e-3) for side in mesh.size_m)
    factors = width / w, depth / d, box.height / h
    return max(factors) / min(factors), mesh.id, turn, factors, mesh.size_m
