"""Meshes of toys, boots, umbrellas and fish."""

import numpy as np

from hil_sim.scenes.furniture.shapes import palette as c
from hil_sim.scenes.furniture.shapes.palette import Rgb
from hil_sim.scenes.furniture.shapes.primitives import (
    Part,
    arc,
    ball,
    box,
    cylinder,
    lathe,
    moved,
    pick,
    ring,
    scaled,
    surface,
    tube,
    turned,
    wheel,
)

BRIGHT = (c.RED, c.BLUE, c.YELLOW, c.GREEN, c.ORANGE, c.PURPLE)


def toy(k: int) -> Part:
    """A car (0, 3), building blocks (1, 4), a stacking ring tower (2, 5)."""
    return pick(k, _toy_car, _blocks, _ring_tower)(k // 3)


def _toy_car(k: int) -> Part:
    body = pick(k, c.RED, c.BLUE)
    parts = [
        box((0.13, 0.28, 0.05), (0, 0, 0.03), body),
        ball((0.115, 0.16, 0.075), (0, 0.015, 0.07), (0.65, 0.8, 0.9), 6, 14, 0.4),
        box((0.1, 0.1, 0.01), (0, 0.015, 0.138), body),
    ]
    for s in (-1, 1):
        parts.append(ball((0.025, 0.015, 0.025), (s * 0.045, -0.138, 0.05), c.YELLOW, 4, 6))
        for y in (-0.08, 0.08):
            parts += wheel(0.032, 0.03, c.DARK, (s * 0.06, y, 0.032))
            parts += wheel(0.015, 0.034, c.YELLOW, (s * 0.06, y, 0.032))
    return parts


def _blocks(k: int) -> Part:
    places = (
        (-0.06, 0, 0, 10), (0.03, 0.01, 0, -8), (0.11, -0.03, 0, 25),
        (-0.02, 0.0, 0.07, -15), (0.06, 0.0, 0.07, 12), (0.02, 0.0, 0.14, 30),
    )  # fmt: skip
    parts: Part = []
    for i, (x, y, z, turn) in enumerate(places):
        cube = box((0.07, 0.07, 0.07), (0, 0, 0), pick(i + 3 * k, *BRIGHT))
        letter = box((0.035, 0.072, 0.035), (0, 0, 0.0175), c.CREAM)
        parts += moved(turned([cube, letter], "z", turn), (x, y, z))
    return parts


def _ring_tower(k: int) -> Part:
    parts = [
        cylinder(0.09, 0.085, 0.018, c.PALE_WOOD, 20),
        cylinder(0.025, 0.02, 0.19, c.WHITE, 12),
        ball((0.05, 0.05, 0.05), (0, 0, 0.185), pick(k, c.RED, c.BLUE), 6, 10),
    ]
    for i in range(5):
        hoop = ring(0.075 - 0.011 * i, 0.018, pick(i + 2 + 3 * k, *BRIGHT), "xy", 10, 5)
        parts += moved([hoop], (0, 0, 0.035 + 0.034 * i))
    return parts


def teddy_bear(k: int) -> Part:
    """Sitting, facing -y."""
    fur, pale = pick(
        k,
        ((0.55, 0.35, 0.18), c.CREAM),
        (c.CREAM, c.WHITE),
        ((0.35, 0.2, 0.1), (0.7, 0.55, 0.35)),
        (c.WHITE, c.PINK),
        (c.GREY, c.WHITE),
        (c.PINK, c.CREAM),
    )
    parts: Part = [
        ball((0.2, 0.17, 0.24), (0, 0, 0), fur, 7, 10),
        ball((0.19, 0.17, 0.17), (0, -0.01, 0.2), fur, 7, 10),
        ball((0.085, 0.06, 0.065), (0, -0.085, 0.23), pale, 4, 6),
        ball((0.03, 0.02, 0.02), (0, -0.118, 0.262), c.DARK, 4, 6),
        ball((0.12, 0.05, 0.15), (0, -0.07, 0.04), pale, 4, 6),
    ]
    for s in (-1, 1):
        parts += [
            ball((0.07, 0.04, 0.07), (s * 0.075, 0.01, 0.325), fur, 4, 7),
            ball((0.018, 0.012, 0.018), (s * 0.035, -0.088, 0.298), c.DARK, 4, 5),
            *moved(
                turned([ball((0.07, 0.07, 0.16), (0, 0, -0.16), fur, 4, 7)], "y", -s * 35),
                (s * 0.08, -0.03, 0.21),
            ),
            ball((0.085, 0.19, 0.085), (s * 0.08, -0.1, 0), fur, 4, 7),
            ball((0.075, 0.02, 0.075), (s * 0.08, -0.187, 0.005), pale, 4, 8),
        ]
    bow = [ball((0.1, 0.03, 0.04), (0, -0.085, 0.185), pick(k, c.RED, c.BLUE, c.GREEN), 3, 7)]
    return [*parts, *bow] if k % 2 else parts


WATER: Rgb = (0.45, 0.7, 0.82)


def aquarium(k: int) -> Part:
    """Water, gravel, fish and weed between a base and a hood; odd ones are bowls."""
    fish = [
        ball((0.06, 0.015, 0.03), (x, 0, z), colour, 5, 8)
        for x, z, colour in ((-0.1, 0.0, c.ORANGE), (0.08, 0.06, c.YELLOW), (0.02, -0.04, c.RED))
    ]
    return _fish_bowl(k // 2, fish) if k % 2 else _fish_tank(k // 2, fish)


def _fish_bowl(k: int, fish: Part) -> Part:
    r = pick(k, 0.13, 0.16, 0.145)
    bowl = [(0, 0), (0.5, 0), (0.85, 0.325), (1, 0.78), (0.9, 1.3), (0.7, 1.625)]
    rim = [(0.7, 1.625), (0.74, 1.68), (0.68, 1.68), (0.6, 1.5), (0, 1.5)]
    gravel = [(0.51, 0), (0.72, 0.2)]
    glass = [
        lathe(bowl, WATER, 20),
        lathe(rim, c.WHITE, 20),
        lathe(gravel, pick(k, c.GREEN, c.GREY, c.CREAM), 20),
    ]
    swimming = moved(scaled(fish[:2], (0.55, 1, 0.8)), (0, -r * 0.95, r * 0.7))
    return [*scaled(glass, r), *swimming]


def _fish_tank(k: int, fish: Part) -> Part:
    w, d, h = pick(k, (0.8, 0.35, 0.45), (0.6, 0.3, 0.36), (1.0, 0.4, 0.5))
    frame, y = pick(k, c.DARK, c.WOOD, c.STEEL), -d * 0.5 - 0.004
    weed = []
    for x in (-w * 0.36, -w * 0.28, w * 0.3):
        path = [(x, y, 0.06), (x + 0.02, y, h * 0.4), (x - 0.01, y, h * 0.7)]
        weed.append(tube(path, [0.012, 0.016, 0.003], c.GREEN, 5))
    return [
        box((w * 1.02, d * 1.04, 0.04), (0, 0, 0), frame),
        box((w, d, h), (0, 0, 0.03), WATER),
        box((w * 1.003, d * 1.008, 0.05), (0, 0, 0.035), c.CREAM),
        box((w * 1.02, d * 1.04, 0.06), (0, 0, h + 0.02), frame),
        *weed,
        *moved(fish, (0, -d / 2, h * 0.55)),
        *moved(scaled(fish, (-1, -1, 1)), (0.1, -d / 2, h * 0.35)),
        ball((0.14, 0.03, 0.1), (w * 0.12, -d / 2, 0.06), c.GREY, 5, 8),
    ]


def boots(k: int) -> Part:
    """A pair: rubber (even) or laced (odd)."""
    body, sole = pick(
        k,
        (c.GREEN, c.DARK),
        (c.DARK_WOOD, c.DARK),
        (c.YELLOW, c.WHITE),
        (c.DARK, c.CREAM),
        (c.RED, c.DARK),
        (c.WOOD, c.CREAM),
    )
    h = pick(k, 0.32, 0.2, 0.28, 0.18)
    one: Part = [
        ball((0.1, 0.27, 0.13), (0, -0.05, 0.01), body, 7, 14, 0.8),
        cylinder(0.052, 0.06, h - 0.05, body, 14, (0, 0.03, 0.05)),
        lathe([(0.052, h + 0.001), (0, h - 0.02)], c.DARK, 14, (0, 0.03, 0)),
        box((0.1, 0.16, 0.02), (0, -0.1, 0), sole),
        box((0.09, 0.09, 0.03), (0, 0.035, 0), sole),
        lathe([(0.0615, h - 0.025), (0.0615, h)], sole, 14, (0, 0.03, 0)),
    ]
    if k % 2:
        one += [
            box((0.06, 0.008, 0.006), (0, -0.028 - 0.018 * (4 - i), 0.09 + 0.014 * i), c.CREAM)
            for i in range(4)
        ]
    return [
        *moved(turned(one, "z", 6), (-0.075, 0, 0)),
        *moved(turned(one, "z", -9), (0.075, 0.02, 0)),
    ]


def umbrella(k: int) -> Part:
    """Folded, standing on its tip, leaning back."""
    cloth = pick(k, c.DARK, c.RED, c.BLUE, c.GREEN, c.YELLOW, c.PURPLE)
    t = np.linspace(0, 2 * np.pi, 17)
    rows = [
        np.stack(
            [
                f * (1 + 0.25 * np.cos(8 * t)) * np.cos(t),
                f * (1 + 0.25 * np.cos(8 * t)) * np.sin(t),
                np.full_like(t, z),
            ],
            1,
        )
        for f, z in ((0.006, 0.06), (0.03, 0.2), (0.045, 0.55), (0.03, 0.62), (0.012, 0.63))
    ]
    crook = [(0, 0, 0.62), (0, 0, 0.8), *arc((0, 0.035, 0.8), 0.035, 180, 20, "yz", 6).tolist()]
    return turned(
        [
            tube([(0, 0, 0), (0, 0, 0.07)], 0.006, c.STEEL, 6),
            surface(np.stack(rows), cloth),
            tube(crook, 0.009, pick(k, c.WOOD, c.DARK, c.DARK_WOOD), 6),
            lathe([(0.042, 0.42), (0.046, 0.45)], c.WHITE, 12),
        ],
        "x",
        -6,
    )


def broom(k: int) -> Part:
    """Standing on its bristles, leaning back."""
    head, stick = pick(
        k,
        (c.YELLOW, c.WOOD),
        (c.RED, c.STEEL),
        (c.PALE_WOOD, c.BLUE),
        (c.GREEN, c.WHITE),
        (c.DARK, c.PALE_WOOD),
        (c.BLUE, c.YELLOW),
    )
    bristles = moved(
        scaled(
            turned([lathe([(0, 0), (0.7, 0), (0.5, 1), (0, 1)], head, 4)], "z", 45),
            (0.36, 0.07, 0.13),
        ),
        (0, 0, 0),
    )
    return turned(
        [
            *bristles,
            box((0.28, 0.05, 0.04), (0, 0, 0.13), stick),
            tube([(0, 0, 0.15), (0, 0, pick(k, 1.3, 1.2, 1.4))], 0.013, stick, 8),
        ],
        "x",
        -7,
    )
