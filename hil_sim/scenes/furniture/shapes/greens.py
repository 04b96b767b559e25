"""Meshes of plants in pots, each variant a kind of its own."""

import math
from functools import partial

import numpy as np

from hil_sim.scenes.furniture.shapes import palette as c
from hil_sim.scenes.furniture.shapes.palette import Rgb
from hil_sim.scenes.furniture.shapes.primitives import (
    Part,
    ball,
    box,
    cylinder,
    lathe,
    moved,
    pick,
    tube,
    turned,
)
from hil_sim.scenes.furniture.shapes.soft import blade

CLAY, SOIL = (0.68, 0.36, 0.24), (0.2, 0.14, 0.1)
DEEP, LEAF, LIME = (0.1, 0.3, 0.12), (0.22, 0.45, 0.17), (0.48, 0.62, 0.25)


def _pot(radius: float, high: float, colour: Rgb, wide: float = 1.25) -> Part:
    top = radius * wide
    return [
        lathe([(0, 0), (radius, 0), (top, high), (top * 0.88, high), (top * 0.86, high * 0.9),
               (0, high * 0.9)], colour, 16),
        cylinder(top * 0.85, top * 0.85, 0.01, SOIL, 14, (0, 0, high * 0.9)),
    ]  # fmt: skip


def _frond(long: float, droop: float, wide: float, colour: Rgb, steep: float = 60.0) -> Part:
    """A leaf that rises along +x and bends over."""
    t = np.linspace(0, 1, 6)
    angle = np.radians(steep) * (1 - droop * t)
    step = long / 5
    x = np.concatenate([[0], np.cumsum(np.cos(angle[:-1]) * step)])
    z = np.concatenate([[0], np.cumsum(np.sin(angle[:-1]) * step)])
    widths = wide * np.sin(np.pi * np.clip(t * 0.9 + 0.08, 0, 1)) + 0.004
    return [blade(np.stack([x, np.zeros(6), z], axis=1), widths.tolist(), colour)]


def _rosette(
    n: int, long: float, droop: float, wide: float, colours: tuple[Rgb, ...], z: float,
    steep: float = 60.0,
) -> Part:  # fmt: skip
    """`n` leaves about one point at height `z`, each of its own length and slope."""
    parts = Part()
    for i in range(n):
        size = long * (0.75 + 0.25 * math.cos(2.4 * i))
        slope = min(88.0, steep * (0.8 + 0.3 * ((i * 5) % 7) / 6))
        leaf = _frond(size, droop, wide, colours[i % len(colours)], slope)
        parts += moved(turned(leaf, "z", i * 137.5), (0, 0, z))
    return parts


def _palm(pot: Rgb) -> Part:
    trunk = tube([(0, 0, 0.25), (0.02, 0, 0.6), (0, 0.02, 0.95)], (0.035, 0.022, 0.018), c.WOOD, 7)
    return [*_pot(0.15, 0.28, pot), trunk, *_rosette(18, 0.75, 1.5, 0.07, (LEAF, DEEP), 0.95, 65)]


def _broad(pot: Rgb) -> Part:
    parts = _pot(0.14, 0.26, pot)
    for i in range(9):
        stem = 0.35 + 0.09 * i
        x, y = (0.12 * math.cos(2.4 * i), 0.12 * math.sin(2.4 * i))
        parts.append(tube([(0, 0, 0.22), (x, y, stem)], 0.008, LEAF, 5))
        leaf = _frond(0.34, 1.3, 0.24, (LEAF, DEEP, LEAF)[i % 3], 40)
        leaf = turned(leaf, "z", math.degrees(2.4 * i))
        parts += moved(leaf, (x, y, stem))
    return parts


def _cactus(pot: Rgb) -> Part:
    body = (0.24, 0.42, 0.22)
    parts = [*_pot(0.1, 0.16, pot), ball((0.15, 0.15, 0.6), (0, 0, 0.14), body, 10, 10, 0.7)]
    for s, z in ((-1, 0.34), (1, 0.46)):
        parts.append(tube([(0, 0, z), (s * 0.13, 0, z), (s * 0.15, 0, z + 0.22)], 0.035, body, 8))
    return parts


def _fern(pot: Rgb) -> Part:
    return [*_pot(0.11, 0.2, pot), *_rosette(34, 0.5, 2.3, 0.045, (LIME, LEAF), 0.2, 62)]


def _snake(pot: Rgb) -> Part:
    return [
        *_pot(0.12, 0.22, pot, 1.05),
        *_rosette(14, 0.7, 0.12, 0.06, (DEEP, LIME, LEAF), 0.2, 82),
    ]


def _succulents(pot: Rgb) -> Part:
    parts = [box((0.34, 0.14, 0.08), (0, 0, 0), pot), box((0.32, 0.12, 0.01), (0, 0, 0.075), SOIL)]
    for i, (x, colour) in enumerate(((-0.1, c.TEAL), (0.0, LIME), (0.1, (0.5, 0.35, 0.4)))):
        rosette = _rosette(12, 0.07 + 0.02 * i, 0.5, 0.03, (colour,), 0.08, 45)
        parts += moved(rosette, (x, 0, 0))
    return parts


def _bush(pot: Rgb) -> Part:
    """A small tree in a square planter."""
    parts = [box((0.36, 0.36, 0.36), (0, 0, 0), pot), box((0.32, 0.32, 0.01), (0, 0, 0.355), SOIL)]
    parts.append(tube([(0, 0, 0.35), (0.01, 0, 0.95)], 0.02, c.WOOD, 7))
    for i in range(15):
        turn, high = 2.4 * i, 0.75 + 0.85 * i / 15
        reach = 0.32 * math.sin(math.pi * (0.15 + 0.8 * i / 15))
        at = (reach * math.cos(turn), reach * math.sin(turn), high)
        leaves = _rosette(4, 0.27, 1.2, 0.12, (DEEP, LEAF, LIME), 0.0, 40)
        parts += moved(turned(leaves, "z", 50.0 * i), at)
    return parts


def _orchid(pot: Rgb) -> Part:
    parts = [*_pot(0.06, 0.12, pot), *_rosette(5, 0.2, 1.1, 0.06, (DEEP,), 0.11, 35)]
    for s in (-1, 1):
        path = np.array(
            [(0, 0, 0.11), (s * 0.04, 0, 0.34), (s * 0.12, 0, 0.48), (s * 0.22, 0, 0.5)]
        )
        parts.append(tube(path, 0.004, LEAF, 5))
        for f in (0.45, 0.6, 0.75, 0.9, 1.0):
            x, z = (float(np.interp(f, [0, 0.4, 0.75, 1], path[:, i])) for i in (0, 2))
            at = (x, 0.0, z - 0.025)
            parts.append(ball((0.055, 0.03, 0.05), at, (c.PINK, c.WHITE)[s > 0], 5, 8))
    return parts


def plant(k: int) -> Part:
    """Palm, broad leaves, cactus, fern, snake plant, succulents, small tree, orchid."""
    return pick(
        k,
        partial(_palm, CLAY),
        partial(_broad, c.WHITE),
        partial(_cactus, c.TEAL),
        partial(_fern, c.GREY),
        partial(_snake, c.CREAM),
        partial(_succulents, c.WOOD),
        partial(_bush, c.DARK),
        partial(_orchid, c.WHITE),
    )()
