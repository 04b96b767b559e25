"""Furniture as boxes: which meshes there are, how large they are, and whether boxes overlap."""

import functools
import json
import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.format import SceneObject

Outline = tuple[tuple[float, float], ...]
ROBOT_M = 0.22
"""Inflation for the passage check: body radius 0.18 m and a margin."""


@dataclass(frozen=True)
class CatalogMesh:
    """A mesh with its natural size (width, depth, height) and height above the floor."""

    id: str
    size_m: tuple[float, float, float]
    z_m: float = 0.0
    top: bool = False
    split: str = "train"
    category: str = "other"


@dataclass(frozen=True)
class Box:
    """An upright box: footprint centre, width, depth, yaw, and its span in z. Metres."""

    x: float
    y: float
    width: float
    depth: float
    yaw: float
    z0: float
    z1: float

    outline: Outline = field(init=False, repr=False, compare=False)
    """The four corners of the footprint."""
    span: tuple[float, float, float, float] = field(init=False, repr=False, compare=False)
    """x0, y0, x1, y1 of the axis-aligned rectangle around the footprint."""

    square: bool = field(init=False, repr=False, compare=False)
    """Whether its sides run along the axes."""

    def __post_init__(self) -> None:
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        w, d = self.width / 2, self.depth / 2
        ax, ay, bx, by = w * c - d * s, w * s + d * c, w * c + d * s, w * s - d * c
        x, y = self.x, self.y
        outline = ((x - ax, y - ay), (x + bx, y + by), (x + ax, y + ay), (x - bx, y - by))
        dx, dy = max(abs(ax), abs(bx)), max(abs(ay), abs(by))
        object.__setattr__(self, "square", abs(c * s) < 1e-5)
        object.__setattr__(self, "outline", outline)
        object.__setattr__(self, "span", (x - dx, y - dy, x + dx, y + dy))

    def corners(self, grow: float = 0.0) -> NDArray[np.float64]:
        """(4, 2) corners of the footprint, grown by `grow` on each side."""
        w, d = self.width / 2 + grow, self.depth / 2 + grow
        local = np.array([[-w, -d], [w, -d], [w, d], [-w, d]])
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        turned: NDArray[np.float64] = local @ np.array([[c, s], [-s, c]]) + (self.x, self.y)
        return turned

    def overlaps(self, other: "Box", slack: float = 0.005) -> bool:
        """Whether the boxes cut into each other by more than `slack` (separating axes)."""
        if self.z0 >= other.z1 - slack or other.z0 >= self.z1 - slack:
            return False
        a, b = self.span, other.span
        if a[0] >= b[2] - slack or b[0] >= a[2] - slack:
            return False
        if a[1] >= b[3] - slack or b[1] >= a[3] - slack:
            return False
        if self.square and other.square:
            return True
        return not any(
            _apart(self.outline, other.outline, math.cos(turn), math.sin(turn), slack)
            for yaw in (self.yaw, other.yaw)
            for turn in (yaw, yaw + math.pi / 2)
        )

    def at(self, u: float, v: float) -> tuple[float, float]:
        """(u, v) from the middle in the box's own axes -> scene."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return self.x + u * c - v * s, self.y + u * s + v * c

    def holds(self, x: float, y: float, slack: float = 0.0) -> bool:
        """Whether a point lies on the footprint."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        u, v = (x - self.x) * c + (y - self.y) * s, (y - self.y) * c - (x - self.x) * s
        return abs(u) <= self.width / 2 + slack and abs(v) <= self.depth / 2 + slack


def _apart(a: Outline, b: Outline, ux: float, uy: float, slack: float) -> bool:
    pa, pb = [x * ux + y * uy for x, y in a], [x * ux + y * uy for x, y in b]
    return max(pa) <= min(pb) + slack or max(pb) <= min(pa) + slack


def hits(box: Box, others: Iterable[Box], slack: float = 0.005) -> bool:
    """Whether the box cuts into one of the others by more than `slack`."""
    x0, y0, x1, y1 = box.span
    for other in others:
        a0, b0, a1, b1 = other.span
        if x0 < a1 and a0 < x1 and y0 < b1 and b0 < y1 and box.overlaps(other, slack):
            return True
    return False


def box_of(obj: SceneObject) -> Box:
    """The box of an object whose size is given."""
    assert obj.size_m is not None
    (x, y, z), (w, d, h) = obj.position_m, obj.size_m
    return Box(x, y, w, d, obj.yaw_rad, z, z + h)


def gap(a: Box, b: Box) -> float:
    """About how far two footprints are apart, m: between the rectangles around them."""
    dx = max(a.span[0] - b.span[2], b.span[0] - a.span[2], 0.0)
    dy = max(a.span[1] - b.span[3], b.span[1] - a.span[3], 0.0)
    return math.hypot(dx, dy)


@functools.cache
def furniture() -> dict[str, tuple[CatalogMesh, ...]]:
    """Meshes by category, from furniture.json."""
    rows = json.loads((Path(__file__).parent / "furniture.json").read_text(encoding="utf-8"))
    return {
        category: tuple(
            CatalogMesh(
                name,
                tuple(r["size_m"]),
                r.get("z_m", 0.0),
                "top" in r,
                r.get("split", "train"),
                category,
            )
            for name, r in meshes.items()
        )
        for category, meshes in rows.items()
    }


@functools.cache
def mesh_named(id: str) -> CatalogMesh | None:
    """The furniture list's entry of a mesh, None if it has none."""
    return next((m for meshes in furniture().values() for m in meshes if m.id == id), None)


def has_top(obj: SceneObject) -> bool:
    """Whether things can stand on it."""
    mesh = mesh_named(obj.mesh)
    return mesh is not None and mesh.top


def offset(anchor: SceneObject, u: float, v: float) -> tuple[float, float]:
    """(u, v) in the anchor's axes -> scene."""
    c, s = math.cos(anchor.yaw_rad), math.sin(anchor.yaw_rad)
    x, y, _ = anchor.position_m
    return x + u * c - v * s, y + u * s + v * c
