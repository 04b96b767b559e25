"""What upholstery, bedding and leaves are made of: rounded blocks, bowed walls, sweeps."""

from collections.abc import Sequence

import numpy as np

from hil_sim.scenes.furniture.shapes.palette import Rgb
from hil_sim.scenes.furniture.shapes.primitives import (
    Array,
    Part,
    cushion_grid,
    moved,
    surface,
    turned,
)
from hil_sim.scenes.furniture.soup import Soup

Pairs = Sequence[tuple[float, float]]


def solid(grid: Array, colour: Rgb) -> Soup:
    """A closed (n, m, 3) grid, wound outward whichever way it runs."""
    soup = surface(grid, colour)
    a, b, c = (soup.corners[:, i] for i in range(3))
    return soup if np.sum(a * np.cross(b, c)) >= 0 else surface(grid[:, ::-1], colour)


def swept(sections: Array, colour: Rgb) -> Soup:
    """A solid through (n, m, 3) cross-sections, each an open ring of points, closed at the ends."""
    rings = np.concatenate([sections, sections[:, :1]], axis=1)
    ends = (np.broadcast_to(s.mean(axis=0), rings[0].shape) for s in (sections[0], sections[-1]))
    first, last = ends
    return solid(np.concatenate([first[None], rings, last[None]]), colour)


def padded(
    size: Sequence[float], at: Sequence[float], colour: Rgb, round_m: float = 0.04, n: int = 2
) -> Soup:
    """A cuboid with rounded edges, the centre of its underside at `at`."""
    half = np.array(size) / 2
    r = min(round_m, float(half.min()) * 0.98)
    quarter = np.linspace(0, np.pi / 2, n + 1)
    v = np.concatenate([quarter + i * np.pi / 2 for i in range(4)] + [np.zeros(1)])
    sx = np.concatenate([np.repeat([1, -1, -1, 1], n + 1), [1]])
    sy = np.concatenate([np.repeat([1, 1, -1, -1], n + 1), [1]])
    rows = []
    for u, sz in [(x - np.pi / 2, -1) for x in quarter] + [(x, 1) for x in quarter]:
        rows.append(
            np.stack(
                [
                    sx * (half[0] - r) + r * np.cos(u) * np.cos(v),
                    sy * (half[1] - r) + r * np.cos(u) * np.sin(v),
                    np.full_like(v, sz * (half[2] - r) + r * np.sin(u)),
                ],
                axis=1,
            )
        )
    poles = [np.broadcast_to([0.0, 0.0, s * half[2]], rows[0].shape) for s in (-1, 1)]
    grid = np.stack([poles[0], *rows, poles[1]]) + np.array(at) + (0, 0, half[2])
    return solid(grid, colour)


def pillow(
    size: Sequence[float], at: Sequence[float], colour: Rgb, lean: float = 0.0, yaw: float = 0.0
) -> Part:
    """A cushion (w, d, h) whose underside's centre is `at`; `lean` > 0 lifts its far edge."""
    upper, lower = cushion_grid(size, 6)
    flat = [surface(upper, colour), surface(lower, colour)]
    return moved(turned(turned(flat, "x", lean), "z", yaw), at)


def leaning(parts: Part, y: float, z: float, degrees: float) -> Part:
    """Built upright on the origin, tilted backward about their foot, set at (0, y, z)."""
    return moved(turned(parts, "x", -degrees), (0, y, z))


def bowed(
    radii: tuple[float, float],
    thick: float,
    spans: Pairs,
    angles: tuple[float, float],
    colour: Rgb,
    flare: float = 0.0,
) -> Soup:
    """A wall along a part of an ellipse (0 degrees is +x, 90 the back), its lower and upper ends
    given at even steps; its upper edge leans out by `flare`."""
    turn = np.radians(np.linspace(*angles, 17))
    steps = np.linspace(0, 1, len(spans))
    low, high = (np.interp(np.linspace(0, 1, 17), steps, s) for s in np.array(spans, float).T)
    e = thick / 4
    section = [
        (0, 0, 0),
        (0, 1, -e),
        (-e, 1, 0),
        (-thick + e, 1, 0),
        (-thick, 1, -e),
        (-thick, 0, 0),
    ]
    sections = []
    for out, up, dz in section:
        r = out + up * flare
        z = low + up * (high - low) + dz
        sections.append(
            np.stack([(radii[0] + r) * np.cos(turn), (radii[1] + r) * np.sin(turn), z], axis=1)
        )
    return swept(np.stack(sections, axis=1), colour)


def blade(path: Array, widths: Sequence[float], colour: Rgb, fold: float = 0.25) -> Soup:
    """A leaf along a path (n, 3), creased along its middle rib."""
    ahead = np.gradient(path, axis=0)
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-9)
    side = np.cross(ahead, [0.0, 0.0, 1.0])
    level = np.linalg.norm(side, axis=1, keepdims=True)
    side = np.where(level > 0.05, side / np.maximum(level, 1e-9), [1.0, 0.0, 0.0])
    up = np.cross(side, ahead)
    half = np.array(widths, float)[:, None] / 2
    thin = np.minimum(half * 0.1, 0.003)
    sections = [
        path - side * half,
        path - up * half * fold + up * thin,
        path + side * half,
        path - up * half * fold - up * thin,
    ]
    return swept(np.stack(sections, axis=1), colour)
