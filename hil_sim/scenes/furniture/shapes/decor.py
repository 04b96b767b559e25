"""Meshes of cushions, statues, boxes, curtains and clocks."""

import numpy as np

from hil_sim.scenes.furniture.shapes import palette as c
from hil_sim.scenes.furniture.shapes.palette import Rgb
from hil_sim.scenes.furniture.shapes.primitives import (
    Part,
    ball,
    box,
    cushion_grid,
    cylinder,
    disc,
    lathe,
    moved,
    painted,
    pick,
    scaled,
    surface,
    tube,
    turned,
)

SKIN_TONES: tuple[Rgb, ...] = (
    (0.85, 0.83, 0.78),
    (0.45, 0.33, 0.2),
    (0.3, 0.42, 0.36),
    (0.7, 0.55, 0.28),
)


def pillow(k: int) -> Part:
    """Lying flat; some striped or chequered."""
    size = pick(k, (0.45, 0.45, 0.16), (0.65, 0.42, 0.15), (0.4, 0.4, 0.14), (0.55, 0.35, 0.16))
    plain, other = pick(
        k,
        (c.TEAL, c.CREAM),
        (c.WHITE, c.WHITE),
        (c.RED, c.CREAM),
        (c.NAVY, c.WHITE),
        (c.YELLOW, c.GREY),
        (c.PINK, c.PURPLE),
    )
    i, j = np.indices((10, 10))
    which = pick(
        k,
        j // 2 % 2,
        0 * i,
        ((i > 2) & (i < 7) & (j > 2) & (j < 7)).astype(int),
        i // 2 % 2,
        (i // 2 + j // 2) % 2,
        0 * i,
    )
    upper, lower = cushion_grid(size)
    return [*painted(upper, (plain, other), which), surface(lower, plain)]


def pillow_upright(k: int) -> Part:
    """Standing, leaning back."""
    return turned(pillow(k), "x", 68)


def statue(k: int) -> Part:
    """A bust (0, 3), a standing figure (1, 4), an abstract loop (2), a horse-like beast (5)."""
    stone = pick(k, *SKIN_TONES)
    plinth = [
        box((0.14, 0.14, 0.05), (0, 0, 0), c.DARK if k != 2 else c.WOOD),
        box((0.11, 0.11, 0.02), (0, 0, 0.05), stone),
    ]
    made = pick(k, _bust, _figure, _loop, _bust, _figure, _beast)(stone)
    return (
        plinth + scaled(moved(made, (0, 0, 0.07)), 1)
        if k != 5
        else [box((0.26, 0.11, 0.02), (0, 0, 0), c.DARK_WOOD), *moved(made, (0, 0, 0.02))]
    )


def _bust(stone: Rgb) -> Part:
    return [
        ball((0.22, 0.11, 0.12), (0, 0, 0), stone, 8, 14),
        cylinder(0.032, 0.03, 0.08, stone, 10, (0, 0, 0.09)),
        ball((0.095, 0.12, 0.145), (0, -0.005, 0.14), stone, 10, 14),
        ball((0.105, 0.11, 0.09), (0, 0.02, 0.21), stone, 6, 12),
        ball((0.018, 0.03, 0.045), (0, -0.068, 0.185), stone, 5, 6),
        *[ball((0.014, 0.03, 0.035), (side * 0.049, 0.0, 0.19), stone, 4, 6) for side in (-1, 1)],
    ]


def _figure(stone: Rgb) -> Part:
    robe = lathe(
        [
            (0, 0),
            (0.05, 0),
            (0.04, 0.12),
            (0.032, 0.2),
            (0.045, 0.28),
            (0.02, 0.32),
            (0.014, 0.34),
            (0, 0.34),
        ],
        stone,
        14,
    )
    arms = [
        tube(
            [(side * 0.04, 0, 0.29), (side * 0.065, -0.01, 0.22), (side * 0.03, -0.045, 0.19)],
            0.012,
            stone,
            6,
        )
        for side in (-1, 1)
    ]
    return [
        *scaled([robe], (1, 0.75, 1)),
        *arms,
        ball((0.045, 0.05, 0.06), (0, 0, 0.335), stone, 8, 10),
    ]


def _loop(stone: Rgb) -> Part:
    t = np.linspace(0, 2 * np.pi, 25)
    path = np.stack([0.09 * np.sin(t), 0.03 * np.sin(2 * t), 0.12 - 0.1 * np.cos(t)], axis=1)
    return [tube(path, 0.02 + 0.008 * np.cos(t), stone, 8)]


def _beast(stone: Rgb) -> Part:
    legs = [
        tube([(x, y, 0.13), (x * 1.15, y, 0.06), (x * 1.1, y, 0)], [0.018, 0.012, 0.014], stone, 6)
        for x in (-0.07, 0.07)
        for y in (-0.025, 0.025)
    ]
    neck = tube(
        [(-0.07, 0, 0.16), (-0.11, 0, 0.23), (-0.12, 0, 0.26)], [0.035, 0.024, 0.022], stone, 8
    )
    return [
        ball((0.22, 0.075, 0.09), (0, 0, 0.11), stone, 8, 12),
        *legs,
        neck,
        tube([(-0.105, 0, 0.27), (-0.17, 0, 0.23)], [0.024, 0.013], stone, 8),
        tube([(0.1, 0, 0.17), (0.14, 0, 0.14), (0.145, 0, 0.07)], [0.012, 0.014, 0.005], stone, 6),
        box((0.02, 0.012, 0.03), (-0.112, 0, 0.285), stone),
    ]


def cardboard_box(k: int) -> Part:
    """With open flaps (even) or taped shut (odd)."""
    card = pick(k, (0.7, 0.55, 0.38), (0.62, 0.47, 0.3), (0.85, 0.83, 0.78))
    inside = tuple(0.75 * channel for channel in card)
    w, d, h = pick(k, (0.4, 0.3, 0.25), (0.5, 0.36, 0.32), (0.3, 0.3, 0.2), (0.35, 0.25, 0.16))
    if k % 2:
        return [
            box((w, d, h), (0, 0, 0), card),
            box((w + 0.002, 0.05, 0.002), (0, 0, h - 0.001), pick(k, c.CREAM, c.RED)),
            box((0.002, 0.05, h * 0.3), (w / 2, 0, h * 0.7), pick(k, c.CREAM, c.RED)),
            box((w * 0.3, 0.002, h * 0.3), (w * 0.2, -d / 2, h * 0.3), c.WHITE),
            box((w * 0.22, 0.003, 0.008), (w * 0.2, -d / 2 - 0.001, h * 0.45), c.DARK),
            box((w * 0.22, 0.003, 0.008), (w * 0.2, -d / 2 - 0.001, h * 0.38), c.DARK),
        ]
    dark = (inside[0], inside[1], inside[2])
    t = 0.006
    parts = [
        box((w, d, t), (0, 0, 0), dark),
        *[box((w, t, h), (0, s * (d - t) / 2, 0), card) for s in (-1, 1)],
        *[box((t, d, h), (s * (w - t) / 2, 0, 0), card) for s in (-1, 1)],
        box((w - 3 * t, d - 3 * t, 0.002), (0, 0, h * 0.3), dark),
    ]
    flap_y = moved(
        turned([box((w, t, d * 0.45), (0, 0, 0), card)], "x", -pick(k, 125, 0, 40)), (0, d / 2, h)
    )
    flap_x = moved(
        turned([box((t, d, w * 0.4), (0, 0, 0), card)], "y", pick(k, 120, 0, 60, 0, 100)),
        (w / 2, 0, h),
    )
    return [*parts, *flap_y, *turned(flap_y, "z", 180), *flap_x, *turned(flap_x, "z", 180)]


def clock(k: int) -> Part:
    """For a wall, round (even) or square (odd)."""
    rim, face, hand = pick(
        k,
        (c.DARK, c.WHITE, c.DARK),
        (c.WOOD, c.CREAM, c.DARK),
        (c.RED, c.WHITE, c.DARK),
        (c.STEEL, c.DARK, c.WHITE),
        (c.TEAL, c.CREAM, c.DARK),
        (c.WHITE, c.NAVY, c.WHITE),
    )
    r = pick(k, 0.15, 0.14, 0.18)
    if k % 2:
        body = [
            box((2 * r, 0.04, 2 * r), (0, 0, -r), rim),
            box((1.75 * r, 0.01, 1.75 * r), (0, -0.022, -0.875 * r), face),
        ]
    else:
        body = [disc(r, 0.04, rim, 26), *moved([disc(r * 0.88, 0.01, face, 26)], (0, -0.022, 0))]
    ticks = [
        p
        for a in range(0, 360, 30)
        for p in turned(
            [box((0.012 if a % 90 == 0 else 0.006, 0.004, 0.025), (0, -0.029, r * 0.66), hand)],
            "y",
            a,
        )
    ]
    hands = turned(
        [box((0.012, 0.004, r * 0.62), (0, -0.031, -0.02), hand)], "y", 30 + 47 * k
    ) + turned([box((0.016, 0.004, r * 0.42), (0, -0.034, -0.02), hand)], "y", -60 + 31 * k)
    return [
        *body,
        *ticks,
        *hands,
        *moved([disc(0.014, 0.01, c.RED if rim != c.RED else c.DARK, 8)], (0, -0.036, 0)),
    ]


def curtain(k: int) -> Part:
    """Two wings in folds on a rail."""
    cloth, rail = pick(
        k,
        (c.RED, c.BRASS),
        (c.CREAM, c.WOOD),
        (c.BLUE, c.STEEL),
        (c.GREEN, c.DARK),
        (c.GREY, c.STEEL),
        (c.TEAL, c.DARK_WOOD),
    )
    w, h = pick(k, 1.4, 1.2, 1.6), pick(k, 2.1, 1.9, 2.2)
    wing = pick(k, 0.34, 0.28, 0.46)
    t = np.linspace(0, 1, 31)
    parts = [
        tube([(-w * 0.54, 0, h - 0.03), (w * 0.54, 0, h - 0.03)], 0.014, rail, 8),
        *[ball((0.05, 0.05, 0.05), (s * w * 0.55, 0, h - 0.055), rail, 5, 8) for s in (-1, 1)],
    ]
    for side in (-1, 1):
        x = side * (w / 2 - wing * w * (1 - t)) if side > 0 else -w / 2 + wing * w * t
        y = 0.035 * np.sin(t * 2 * np.pi * 6)
        sheet = np.stack(
            [
                np.stack([x, y * f - 0.0, np.full_like(t, z)], 1)
                for z, f in ((0, 1.2), (h * 0.5, 1.0), (h - 0.03, 0.7))
            ]
        )
        parts += [surface(sheet, cloth), surface(sheet[:, ::-1] + np.array([0, 0.004, 0]), cloth)]
    return parts
