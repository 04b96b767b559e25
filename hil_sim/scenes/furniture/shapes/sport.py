"""Meshes of bags, instruments and what one plays or trains with."""

import numpy as np

from hil_sim.scenes.furniture.shapes import palette as c
from hil_sim.scenes.furniture.shapes.palette import Rgb
from hil_sim.scenes.furniture.shapes.primitives import (
    Part,
    arc,
    ball,
    box,
    cylinder,
    disc,
    lathe_grid,
    moved,
    painted,
    pick,
    scaled,
    shade,
    slab,
    tube,
    turned,
    wheel,
)


def suitcase(k: int) -> Part:
    """On wheels with its handle out (even) or an old one with straps (odd)."""
    shell, trim = pick(
        k,
        (c.RED, c.DARK),
        (c.DARK_WOOD, c.BRASS),
        (c.BLUE, c.GREY),
        (c.GREEN, c.WOOD),
        (c.YELLOW, c.DARK),
        ((0.55, 0.35, 0.25), c.CREAM),
    )
    return _old_suitcase(shell, trim) if k % 2 else _trolley(k, shell, trim)


def _old_suitcase(shell: Rgb, trim: Rgb) -> Part:
    grip = [(-0.07, 0, 0.4), (-0.06, 0, 0.44), (0.06, 0, 0.44), (0.07, 0, 0.4)]
    corners = [(sx * 0.277, 0, z) for sx in (-1, 1) for z in (0, 0.352)]
    return [
        box((0.6, 0.18, 0.4), (0, 0, 0), shell),
        *[box((0.05, 0.186, 0.404), (s * 0.17, 0, 0), trim) for s in (-1, 1)],
        *[box((0.05, 0.19, 0.05), at, trim) for at in corners],
        tube(grip, 0.012, trim, 6),
        box((0.604, 0.184, 0.008), (0, 0, 0.26), c.DARK),
    ]


def _trolley(k: int, shell: Rgb, trim: Rgb) -> Part:
    w, h = pick(k // 2, (0.4, 0.58), (0.45, 0.68), (0.38, 0.5))
    parts = [ball((w, 0.245, h), (0, 0, 0.045), shell, 10, 18, 0.25)]
    for x in (-0.35, -0.2, -0.05, 0.1, 0.25, 0.38):
        parts.append(box((0.012, 0.25, h * 0.9), (x * w, 0, 0.05 + h * 0.05), shade(shell, 0.75)))
    for sx in (-1, 1):
        parts += wheel(0.025, 0.03, c.DARK, (sx * w * 0.38, -0.08, 0.025))
        parts += wheel(0.025, 0.03, c.DARK, (sx * w * 0.38, 0.08, 0.025))
        parts.append(tube([(sx * 0.1, 0.08, h), (sx * 0.1, 0.08, h + 0.38)], 0.008, c.STEEL, 6))
    return [
        *parts,
        tube([(-0.11, 0.08, h + 0.38), (0.11, 0.08, h + 0.38)], 0.014, trim, 6),
        box((0.14, 0.03, 0.03), (0, -0.02, h + 0.04), trim),
    ]


def backpack(k: int) -> Part:
    """Standing, its pocket along -y and its straps behind."""
    cloth, pocket = pick(
        k,
        (c.BLUE, c.NAVY),
        (c.RED, c.DARK),
        (c.GREEN, c.DARK_WOOD),
        (c.DARK, c.GREY),
        (c.PURPLE, c.PINK),
        (c.YELLOW, c.BLUE),
    )
    w, h = pick(k, 0.3, 0.32, 0.27), pick(k, 0.44, 0.48)
    straps = [
        tube(
            [
                (s * 0.07, 0.08, h * 0.9),
                (s * 0.085, 0.15, h * 0.65),
                (s * 0.1, 0.14, h * 0.3),
                (s * 0.11, 0.08, h * 0.08),
            ],
            0.014,
            pocket,
            6,
        )
        for s in (-1, 1)
    ]
    return [
        ball((w, 0.18, h), (0, 0, 0), cloth, 9, 14, 0.5),
        ball((w * 0.8, 0.1, h * 0.42), (0, -0.085, h * 0.06), pocket, 6, 12, 0.4),
        *straps,
        *turned([tube(arc((0, 0, h), 0.035, 0, 180, "xz", 6), 0.009, pocket, 5)], "z", 0),
        box((w * 0.62, 0.006, 0.008), (0, -0.136, h * 0.38), c.STEEL),
        tube(arc((0, -0.02, h * 0.62), w * 0.42, 10, 170, "xz", 10), 0.007, pocket, 5),
        *[ball((0.05, 0.09, h * 0.4), (s * w * 0.48, 0.0, 0.02), pocket, 6, 8) for s in (-1, 1)],
    ]


GUITAR = (
    (0.0, 0.0), (0.09, 0.015), (0.165, 0.07), (0.19, 0.14), (0.175, 0.21), (0.13, 0.28),
    (0.12, 0.33), (0.135, 0.39), (0.13, 0.44), (0.1, 0.48), (0.05, 0.495), (0.0, 0.5),
)  # fmt: skip
"""The right half of a body's outline: x, z."""


def guitar(k: int) -> Part:
    """Leaning back, its strings along -y: acoustic, or with a solid body (1, 4)."""
    solid = k in (1, 4)
    top = pick(
        k, (0.82, 0.58, 0.28), c.RED, c.PALE_WOOD, (0.5, 0.25, 0.12), c.BLUE, (0.12, 0.11, 0.11)
    )
    side = pick(k, c.DARK_WOOD, c.DARK, c.WOOD, c.DARK, c.DARK, c.DARK)
    half = np.array(GUITAR)
    outline = np.concatenate([half, (half * np.array([-1, 1]))[-2:0:-1]])
    thick = 0.045 if solid else 0.1
    face = outline * np.array([0.97, 0.985]) + np.array([0, 0.004])
    plates = [slab(outline, thick - 0.006, side), slab(face, 0.008, top, thick - 0.006)]
    front = -thick - 0.003
    hole = [disc(0.05, 0.006, c.DARK, 18)]
    if solid:
        hole = [box((0.09, 0.006, 0.02), (0, 0, z), c.DARK) for z in (-0.06, 0.02)]
    neck = [
        box((0.052, 0.03, 0.5), (0, front + 0.012, 0.44), c.DARK_WOOD),
        box((0.072, 0.025, 0.16), (0, front + 0.014, 0.94), top if solid else side),
        box((0.14, 0.012, 0.025), (0, front, 0.13), c.DARK),
    ]
    for z in (0.96, 1.0, 1.04):
        for s in (-1, 1):
            at = (s * 0.042, front + 0.01, z)
            neck.append(cylinder(0.008, 0.008, 0.014, c.BRASS, 6, at))
    for x in (-0.012, 0.0, 0.012):
        neck.append(box((0.003, 0.003, 0.8), (x, front - 0.006, 0.15), c.STEEL))
    return turned([*turned(plates, "x", 90), *moved(hole, (0, front, 0.31)), *neck], "x", -8)


def racket(k: int) -> Part:
    """A tennis racket on its handle, upright."""
    frame, grip = pick(
        k,
        (c.RED, c.DARK),
        (c.BLUE, c.WHITE),
        (c.YELLOW, c.DARK),
        (c.DARK, c.RED),
        (c.GREEN, c.WHITE),
        (c.WHITE, c.NAVY),
    )
    hoop = moved(scaled(turned([*_hoop(frame)], "x", 0), (0.125, 1, 0.165)), (0, 0, 0.52))
    a = 0.118
    strings = [
        box(
            (0.002, 0.002, 2 * 0.155 * np.sqrt(1 - (x / a) ** 2)),
            (x, 0, 0.52 - 0.155 * np.sqrt(1 - (x / a) ** 2)),
            c.CREAM,
        )
        for x in np.linspace(-0.1, 0.1, 9)
    ]
    strings += [
        box((2 * a * np.sqrt(1 - (z / 0.155) ** 2), 0.002, 0.002), (0, 0, 0.52 + z), c.CREAM)
        for z in np.linspace(-0.13, 0.13, 11)
    ]
    throat = [
        tube([(0, 0, 0.24), (s * 0.03, 0, 0.3), (s * 0.075, 0, 0.39)], 0.009, frame, 6)
        for s in (-1, 1)
    ]
    return [
        *hoop,
        *strings,
        *throat,
        cylinder(0.017, 0.016, 0.2, grip, 8),
        tube([(0, 0, 0.19), (0, 0, 0.26)], 0.012, frame, 8),
    ]


def _hoop(frame: Rgb) -> Part:
    t = np.linspace(0, 2 * np.pi, 25)
    path = np.stack([np.cos(t), 0 * t, np.sin(t)], axis=1)
    return scaled(moved([tube(path, 0.06, frame, 6)], (0, 0, 0)), (1, 0.2, 1))


def tennis_racket(k: int) -> Part:
    """Lying, along y."""
    return turned(racket(k), "x", 90)


def tennis_racket_standing(k: int) -> Part:
    """On its head's edge, leaning back."""
    return turned(turned(racket(k), "x", 180), "x", -14)


def dumbbell(k: int) -> Part:
    """Lying, along x."""
    weight = pick(k, c.DARK, c.BLUE, c.PINK, c.STEEL, c.TEAL, c.RED)
    r, w = pick(k, 0.05, 0.042, 0.06), pick(k, 0.06, 0.08)
    head = [
        cylinder(r * 0.9, r, w * 0.2, weight, 6 if k % 2 else 16),
        cylinder(r, r, w * 0.6, weight, 6 if k % 2 else 16, (0, 0, w * 0.2)),
        cylinder(r, r * 0.85, w * 0.2, weight, 6 if k % 2 else 16, (0, 0, w * 0.8)),
    ]
    one = moved(turned(head, "y", 90), (0.065, 0, 0))
    return [
        *one,
        *turned(one, "z", 180),
        tube([(-0.07, 0, 0), (0.07, 0, 0)], 0.014, c.STEEL if weight != c.STEEL else c.DARK, 10),
    ]


def soccer_ball(k: int) -> Part:
    """With dark patches."""
    base, patch = pick(
        k,
        (c.WHITE, c.DARK),
        (c.YELLOW, c.BLUE),
        (c.WHITE, c.RED),
        (c.ORANGE, c.DARK),
        (c.WHITE, c.NAVY),
        (c.WHITE, c.GREEN),
    )
    grid = lathe_grid([(np.cos(a), np.sin(a)) for a in np.linspace(-np.pi / 2, np.pi / 2, 13)], 20)
    which = np.zeros((12, 20), np.int64)
    which[:1] = which[11:] = 1
    for i in range(5):
        which[3:5, [4 * i, (4 * i + 1) % 20]] = 1
        which[7:9, [(4 * i + 2) % 20, (4 * i + 3) % 20]] = 1
    return scaled(
        turned(painted(grid, (base, patch), which), "x", 30 + 20 * k), pick(k, 0.11, 0.105)
    )
