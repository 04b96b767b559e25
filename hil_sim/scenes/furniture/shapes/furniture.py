"""Meshes of seats, large machines, hearths and pianos."""

import numpy as np

from hil_sim.scenes.furniture.shapes import palette as c
from hil_sim.scenes.furniture.shapes.primitives import (
    Part,
    ball,
    box,
    disc,
    lathe,
    legs,
    moved,
    pick,
    ring,
    shade,
    slab,
    tube,
    turned,
)


def bench(k: int) -> Part:
    """A wooden bench, some with a back, some padded."""
    wood, pad = pick(
        k,
        (c.WOOD, None),
        (c.WHITE, c.GREY),
        (c.PALE_WOOD, None),
        (c.DARK_WOOD, c.RED),
        (c.DARK, c.CREAM),
        (c.PALE_WOOD, c.TEAL),
    )
    w, h = pick(k, 1.2, 1.0, 1.4), 0.45
    parts = (
        [box((w, 0.09, 0.035), (0, y, h - 0.035), wood) for y in (-0.14, 0, 0.14)]
        + legs(w * 0.9, 0.36, h - 0.035, 0.06, wood)
        + [box((w * 0.82, 0.04, 0.06), (0, 0, 0.14), wood)]
    )
    if pad is not None:
        parts.append(ball((w * 0.98, 0.38, 0.09), (0, 0, h - 0.02), pad, 8, 18, 0.3))
    if k % 3 == 2:
        parts += [box((w, 0.03, 0.07), (0, 0.19, h + 0.1 + 0.13 * i), wood) for i in range(3)] + [
            box((0.05, 0.04, 0.42), (s * w * 0.42, 0.2, h - 0.03), wood) for s in (-1, 1)
        ]
    return parts


def ottoman(k: int) -> Part:
    """Round or square, padded, on short feet."""
    cloth, feet = pick(
        k,
        (c.TEAL, c.WOOD),
        (c.GREY, c.DARK),
        (c.ORANGE, c.WOOD),
        (c.CREAM, c.DARK_WOOD),
        (c.NAVY, c.BRASS),
        (c.PINK, c.PALE_WOOD),
    )
    w, h = pick(k, 0.55, 0.6, 0.45), pick(k, 0.42, 0.4)
    stubs = legs(w * 0.75, w * 0.75, 0.07, 0.04, feet)
    seam = (cloth[0] * 0.7, cloth[1] * 0.7, cloth[2] * 0.7)
    if k % 2:
        return [
            *stubs,
            ball((w, w * 0.8, h - 0.05), (0, 0, 0.05), cloth, 10, 20, 0.25),
            box((w * 0.98, w * 0.79, 0.012), (0, 0, h * 0.62), seam),
            ball((0.03, 0.03, 0.014), (0, 0, h - 0.005), seam, 4, 8),
        ]
    r = w / 2
    return [
        *stubs,
        lathe(
            [(0, 0.05), (r * 0.93, 0.05), (r, 0.1), (r, h * 0.7), (r * 0.97, h * 0.72)], cloth, 22
        ),
        lathe([(r * 0.97, h * 0.72), (r * 1.02, h * 0.8), (r * 0.9, h * 0.96), (0, h)], cloth, 22),
        *moved([ring(r * 0.985, 0.008, seam, "xy", 22, 4)], (0, 0, h * 0.72)),
    ]


def washing_machine(k: int) -> Part:
    """A front loader."""
    body, door = pick(
        k,
        (c.WHITE, c.STEEL),
        (c.STEEL, c.DARK),
        (c.WHITE, c.DARK),
        (c.GREY, c.STEEL),
        (c.CREAM, c.STEEL),
        (c.DARK, c.STEEL),
    )
    h, r = pick(k, 0.85, 0.82), pick(k, 0.17, 0.19, 0.155)
    porthole = [
        *turned([ring(r, 0.025, door, "xy", 22, 6)], "x", 90),
        *moved([disc(r * 0.9, 0.03, (0.25, 0.3, 0.36), 20)], (0, 0, 0)),
    ]
    return [
        box((0.6, 0.58, h), (0, 0, 0), body),
        *moved(porthole, (0, -0.3, h * 0.45)),
        box((0.58, 0.01, 0.11), (0, -0.292, h - 0.13), c.GREY if body != c.GREY else c.WHITE),
        *moved(
            [disc(0.035, 0.03, c.STEEL if body != c.STEEL else c.DARK, 12)],
            (0.05, -0.305, h - 0.075),
        ),
        box((0.17, 0.012, 0.08), (-0.18, -0.296, h - 0.115), body),
        box((0.1, 0.012, 0.05), (0.2, -0.296, h - 0.1), (0.1, 0.3, 0.35)),
        box((0.54, 0.01, 0.08), (0, -0.29, 0.02), c.GREY),
    ]


def dishwasher(k: int) -> Part:
    """A front with a bar across, keys and a plinth."""
    body = pick(k, c.STEEL, c.WHITE, c.GREY, (0.75, 0.76, 0.78), c.CREAM, c.DARK)
    dark = c.DARK if body != c.DARK else c.GREY
    keys = [
        box(
            (0.025, 0.01, 0.012),
            (0.04 * i, -0.297, 0.775),
            pick(i, c.WHITE, c.WHITE, c.GREEN) if dark == c.DARK else c.WHITE,
        )
        for i in range(5)
    ]
    return [
        box((0.6, 0.56, 0.84), (0, 0.01, 0), body),
        box((0.58, 0.02, 0.1), (0, -0.285, 0), dark),
        box((0.6, 0.02, 0.62), (0, -0.28, 0.11), body),
        box((0.6, 0.025, 0.095), (0, -0.282, 0.74), dark),
        *keys,
        tube(
            [(-0.25, -0.325, 0.68), (0.25, -0.325, 0.68)],
            0.012,
            c.STEEL if body != c.STEEL else c.DARK,
            8,
        ),
        *[box((0.02, 0.04, 0.02), (s * 0.22, -0.305, 0.67), c.STEEL) for s in (-1, 1)],
        box((0.08, 0.01, 0.035), (-0.2, -0.296, 0.77), (0.1, 0.55, 0.6)),
    ]


def fireplace(k: int) -> Part:
    """A mantel around a dark opening, logs and fire in it."""
    stone, hearth = pick(
        k,
        (c.WHITE, c.GREY),
        ((0.6, 0.33, 0.25), c.DARK),
        (c.DARK_WOOD, c.GREY),
        (c.CREAM, c.DARK),
        (c.GREY, c.DARK),
        (c.PALE_WOOD, c.STEEL),
    )
    w, h = pick(k, 1.3, 1.2, 1.4), pick(k, 1.05, 1.15)
    fire = [
        lathe([(0.06, 0), (0.075, 0.06), (0.03, 0.16), (0, 0.22)], c.ORANGE, 8, (x, -0.04, 0.11))
        for x in (-0.12, 0.02, 0.14)
    ]
    logs = [
        tube(
            [(-0.22, -0.05 + 0.05 * i, 0.09 + 0.03 * i), (0.22, 0.02 - 0.04 * i, 0.09 + 0.03 * i)],
            0.035,
            c.DARK_WOOD,
            7,
        )
        for i in range(2)
    ]
    return [
        *[box((w * 0.22, 0.3, h - 0.15), (s * w * 0.38, 0, 0.04), stone) for s in (-1, 1)],
        box((w * 0.96, 0.3, h * 0.28), (0, 0, h * 0.72 - 0.1), stone),
        box((w, 0.38, 0.07), (0, -0.02, h - 0.09), stone),
        box((w, 0.42, 0.05), (0, -0.05, 0), hearth),
        box((w * 0.6, 0.02, h * 0.7), (0, 0.13, 0.03), c.DARK),
        *logs,
        *fire,
    ]


def piano(k: int) -> Part:
    """An upright with its keys."""
    wood = pick(k, c.DARK, c.DARK_WOOD, c.WOOD, c.WHITE, (0.4, 0.12, 0.08), c.GREY)
    h = pick(k, 1.2, 1.1)
    black = [
        box((0.016, 0.085, 0.015), (-0.59 + 0.0504 * i, -0.19, 0.712), c.DARK)
        for i in range(24)
        if i % 7 not in (2, 6)
    ]
    return [
        box((1.45, 0.34, h), (0, 0.12, 0), wood),
        box((1.48, 0.38, 0.03), (0, 0.11, h), wood),
        box((1.45, 0.26, 0.1), (0, -0.17, 0.59), wood),
        box((1.3, 0.15, 0.022), (0, -0.22, 0.689), c.WHITE),
        *black,
        *[box((0.08, 0.26, 0.16), (s * 0.685, -0.17, 0.6), wood) for s in (-1, 1)],
        *[box((0.07, 0.07, 0.6), (s * 0.66, -0.25, 0), wood) for s in (-1, 1)],
        box((0.6, 0.02, 0.22), (0, -0.06, h * 0.72), shade(wood, 1.2)),
        *[box((0.03, 0.12, 0.02), (x, -0.1, 0.04), c.BRASS) for x in (-0.08, 0, 0.08)],
    ]


def dog_bed(k: int) -> Part:
    """A thick rim around a cushion."""
    rim, inside = pick(
        k,
        (c.GREY, c.CREAM),
        (c.DARK_WOOD, c.CREAM),
        (c.NAVY, c.GREY),
        (c.RED, c.CREAM),
        (c.TEAL, c.WHITE),
        (c.PALE_WOOD, c.BLUE),
    )
    w, d = pick(k, (0.75, 0.6), (0.6, 0.6), (0.9, 0.65))
    t = np.radians(np.linspace(-80, 260, 21))
    path = np.stack(
        [np.cos(t) * (w / 2 - 0.07), np.sin(t) * (d / 2 - 0.07), np.full_like(t, 0.09)], 1
    )
    low = 0.25 * (path[:, 1] < -d * 0.2)
    bone = [
        ball((0.05, 0.05, 0.04), (x, y, 0.125), c.WHITE, 4, 6)
        for x in (-0.08, 0.08)
        for y in (-0.02, 0.02)
    ]
    return [
        tube(path, np.asarray(0.08 * (1 - low), float), rim, 10),
        ball((w * 0.86, d * 0.86, 0.12), (0, 0, 0.01), inside, 6, 18),
        *bone,
        box((0.15, 0.03, 0.025), (0, 0, 0.128), c.WHITE),
    ]


def clothes_rack(k: int) -> Part:
    """A rail with garments on hangers."""
    metal = pick(k, c.STEEL, c.DARK, c.WOOD, c.WHITE)
    w, h = pick(k, 1.1, 0.9, 1.3), pick(k, 1.5, 1.6)
    frame = [tube([(s * w / 2, 0, 0.05), (s * w / 2, 0, h)], 0.014, metal, 6) for s in (-1, 1)] + [
        tube([(-w / 2, 0, h), (w / 2, 0, h)], 0.014, metal, 6),
        tube([(-w / 2, 0, 0.15), (w / 2, 0, 0.15)], 0.012, metal, 6),
    ]
    frame += [
        tube([(s * w / 2, -0.22, 0.03), (s * w / 2, 0.22, 0.03)], 0.016, metal, 6) for s in (-1, 1)
    ]
    clothes: Part = []
    for i in range(pick(k, 6, 4, 7)):
        x = -w * 0.38 + i * w * 0.115
        colour = pick(
            i * 3 + k, c.RED, c.BLUE, c.WHITE, c.GREEN, c.DARK, c.YELLOW, c.PINK, c.TEAL, c.GREY
        )
        low = 0.5 + 0.13 * ((i + k) % 3)
        coat = [
            (-0.2, low - h),
            (0.2, low - h),
            (0.21, -0.22),
            (0.05, -0.09),
            (-0.05, -0.09),
            (-0.21, -0.22),
        ]
        clothes += moved(
            turned(turned([slab(coat, 0.03, colour, -0.015)], "x", 90), "z", 80 + 6 * (i % 3)),
            (x, 0, h),
        )
        clothes.append(tube([(x, 0, h - 0.1), (x, 0, h + 0.02)], 0.004, c.STEEL, 4))
    return frame + clothes


def drying_rack(k: int) -> Part:
    """Crossed legs, wires, wings, with washing."""
    metal = pick(k, c.WHITE, c.STEEL, c.BLUE, c.GREY)
    w, d, h = 0.55, pick(k, 1.1, 0.9), pick(k, 0.95, 0.85)
    legs = [
        tube([(sx * w / 2, sy * d * 0.35, 0), (sx * w / 2, -sy * d * 0.3, h)], 0.01, metal, 5)
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]
    wires = [
        tube([(-w / 2, y * d, h), (w / 2, y * d, h)], 0.005, metal, 4)
        for y in np.linspace(-0.5, 0.5, 9)
    ]
    edges = [tube([(s * w / 2, -d / 2, h), (s * w / 2, d / 2, h)], 0.01, metal, 5) for s in (-1, 1)]
    washing = [
        box(
            (0.36, 0.02, 0.3 + 0.1 * (i % 2)),
            (0.06 * (i % 3 - 1), (-0.375 + 0.25 * i) * d, h - 0.3 - 0.1 * (i % 2)),
            pick(i + k, c.WHITE, c.RED, c.TEAL, c.YELLOW, c.PINK, c.BLUE),
        )
        for i in range(4)
    ]
    return [*legs, *wires, *edges, *washing]
