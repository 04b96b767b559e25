"""Meshes of larger things that stand about: bags, toys, instruments, racks."""

import numpy as np

from hil_sim.builtin_shapes import (
    BLUE,
    BRASS,
    CREAM,
    DARK,
    DARK_WOOD,
    GREEN,
    GREY,
    NAVY,
    ORANGE,
    PALE_WOOD,
    PINK,
    PURPLE,
    RED,
    STEEL,
    TEAL,
    WHITE,
    WOOD,
    YELLOW,
    Part,
    Rgb,
    arc,
    ball,
    box,
    cylinder,
    disc,
    lathe,
    lathe_grid,
    moved,
    painted,
    pick,
    ring,
    scaled,
    slab,
    tube,
    turned,
)


def suitcase(k: int) -> Part:
    """On wheels with its handle out (even) or an old one with straps (odd)."""
    shell, trim = pick(
        k,
        (RED, DARK),
        (DARK_WOOD, BRASS),
        (BLUE, GREY),
        (GREEN, WOOD),
        (YELLOW, DARK),
        ((0.55, 0.35, 0.25), CREAM),
    )
    if k % 2:
        return [
            box((0.6, 0.18, 0.4), (0, 0, 0), shell),
            *[box((0.05, 0.186, 0.404), (s * 0.17, 0, 0), trim) for s in (-1, 1)],
            *[
                box((0.05, 0.19, 0.05), (sx * 0.277, 0, z), trim)
                for sx in (-1, 1)
                for z in (0, 0.352)
            ],
            tube(
                [(-0.07, 0, 0.4), (-0.06, 0, 0.44), (0.06, 0, 0.44), (0.07, 0, 0.4)], 0.012, trim, 6
            ),
            box((0.604, 0.184, 0.008), (0, 0, 0.26), DARK),
        ]
    w, h = pick(k, (0.4, 0.58), (0, 0), (0.45, 0.68), (0, 0), (0.38, 0.5))
    ribs = [
        box((0.012, 0.25, h * 0.9), (x * w, 0, 0.05 + h * 0.05), darker(shell))
        for x in (-0.35, -0.2, -0.05, 0.1, 0.25, 0.38)
    ]
    wheels = [
        p
        for sx in (-1, 1)
        for sy in (-1, 1)
        for p in moved(
            turned([disc(0.025, 0.03, DARK, 10)], "z", 90), (sx * w * 0.38, sy * 0.08, 0.025)
        )
    ]
    pole = [tube([(s * 0.1, 0.08, h), (s * 0.1, 0.08, h + 0.38)], 0.008, STEEL, 6) for s in (-1, 1)]
    return [
        ball((w, 0.245, h), (0, 0, 0.045), shell, 10, 18, 0.25),
        *ribs,
        *wheels,
        *pole,
        tube([(-0.11, 0.08, h + 0.38), (0.11, 0.08, h + 0.38)], 0.014, trim, 6),
        box((0.14, 0.03, 0.03), (0, -0.02, h + 0.04), trim),
    ]


def darker(colour: Rgb) -> Rgb:
    """A shade darker."""
    return (colour[0] * 0.75, colour[1] * 0.75, colour[2] * 0.75)


def backpack(k: int) -> Part:
    """Standing, its pocket along -y and its straps behind."""
    cloth, pocket = pick(
        k,
        (BLUE, NAVY),
        (RED, DARK),
        (GREEN, DARK_WOOD),
        (DARK, GREY),
        (PURPLE, PINK),
        (YELLOW, BLUE),
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
        box((w * 0.62, 0.006, 0.008), (0, -0.136, h * 0.38), STEEL),
        tube(arc((0, -0.02, h * 0.62), w * 0.42, 10, 170, "xz", 10), 0.007, pocket, 5),
        *[ball((0.05, 0.09, h * 0.4), (s * w * 0.48, 0.0, 0.02), pocket, 6, 8) for s in (-1, 1)],
    ]


GUITAR = (
    (0.0, 0.0), (0.09, 0.015), (0.165, 0.07), (0.19, 0.14), (0.175, 0.21), (0.13, 0.28),
    (0.12, 0.33), (0.135, 0.39), (0.13, 0.44), (0.1, 0.48), (0.05, 0.495), (0.0, 0.5),
)  # fmt: skip
"""The right half of a body's outline: x, z."""


def guitar(k: int) -> Part:
    """Standing upright, its strings along -y: acoustic, or with a solid body (1, 4)."""
    top, side = pick(
        k,
        (ORANGE, DARK_WOOD),
        (RED, DARK),
        (PALE_WOOD, WOOD),
        (DARK_WOOD, DARK),
        (BLUE, DARK),
        (DARK, DARK),
    )
    top = pick(k, (0.82, 0.58, 0.28), top, top, (0.5, 0.25, 0.12), top, (0.12, 0.11, 0.11))
    half = np.array(GUITAR)
    left = (half * np.array([-1, 1]))[-2:0:-1]
    outline = np.concatenate([half, left])
    thick = 0.045 if k in (1, 4) else 0.1
    plate = turned(
        [
            slab(outline, thick - 0.006, side),
            slab(
                outline * np.array([0.97, 0.985]) + np.array([0, 0.004]), 0.008, top, thick - 0.006
            ),
        ],
        "x",
        90,
    )
    hole = (
        [disc(0.05, 0.006, DARK, 18)]
        if k not in (1, 4)
        else [box((0.09, 0.006, 0.02), (0, 0, z0), DARK) for z0 in (-0.06, 0.02)]
    )
    front = -thick - 0.003
    neck = [
        box((0.052, 0.03, 0.5), (0, front + 0.012, 0.44), DARK_WOOD),
        box((0.072, 0.025, 0.16), (0, front + 0.014, 0.94), top if k in (1, 4) else side),
        box((0.14, 0.012, 0.025), (0, front, 0.13), DARK),
    ]
    pegs = [
        cylinder(0.008, 0.008, 0.014, BRASS, 6, (s * 0.042, front + 0.01, 0.96 + 0.04 * i))
        for s in (-1, 1)
        for i in range(3)
    ]
    strings = [
        box((0.003, 0.003, 0.8), (0.008 * i, front - 0.006, 0.15), STEEL) for i in (-1.5, 0, 1.5)
    ]
    return turned([*plate, *moved(hole, (0, front, 0.31)), *neck, *pegs, *strings], "x", -8)


def aquarium(k: int) -> Part:
    """Water, gravel, fish and weed between a base and a hood; odd ones are bowls."""
    water: Rgb = (0.45, 0.7, 0.82)
    fish = [
        ball((0.06, 0.015, 0.03), (x, 0, z), c, 5, 8)
        for x, z, c in ((-0.1, 0.0, ORANGE), (0.08, 0.06, YELLOW), (0.02, -0.04, RED))
    ]
    if k % 2:
        r = pick(k, 0, 0.13, 0, 0.16, 0, 0.145)
        bowl = [(0.5, 0), (0.85, 0.25), (1, 0.6), (0.9, 1.0), (0.7, 1.25)]
        glass = [
            lathe([(0, 0), *[(a * r, b * r * 1.3) for a, b in bowl]], water, 20),
            lathe(
                [
                    (0.7 * r, 1.625 * r),
                    (0.74 * r, 1.68 * r),
                    (0.68 * r, 1.68 * r),
                    (0.6 * r, 1.5 * r),
                    (0, 1.5 * r),
                ],
                WHITE,
                20,
            ),
            lathe([(0.51 * r, 0), (0.72 * r, 0.2 * r)], pick(k, CREAM, GREEN, PINK, GREY), 20),
        ]
        return [*glass, *moved(scaled(fish[:2], (0.9, 1, 0.9)), (0, -r * 0.95, r * 0.7))]
    w, d, h = pick(k, (0.8, 0.35, 0.45), (0, 0, 0), (0.6, 0.3, 0.36), (0, 0, 0), (1.0, 0.4, 0.5))
    weed = [
        tube(
            [
                (x, -d * 0.5 - 0.004, 0.06),
                (x + 0.02, -d * 0.5 - 0.004, h * 0.4),
                (x - 0.01, -d * 0.5 - 0.004, h * 0.7),
            ],
            [0.012, 0.016, 0.003],
            GREEN,
            5,
        )
        for x in (-w * 0.36, -w * 0.28, w * 0.3)
    ]
    frame = pick(k, DARK, DARK, WOOD, DARK, STEEL)
    return [
        box((w * 1.02, d * 1.04, 0.04), (0, 0, 0), frame),
        box((w, d, h), (0, 0, 0.03), water),
        box((w * 1.003, d * 1.008, 0.05), (0, 0, 0.035), CREAM),
        box((w * 1.02, d * 1.04, 0.06), (0, 0, h + 0.02), frame),
        *weed,
        *moved(fish, (0, -d / 2, h * 0.55)),
        *moved(scaled(fish, (-1, -1, 1)), (0.1, -d / 2, h * 0.35)),
        ball((0.14, 0.03, 0.1), (w * 0.12, -d / 2, 0.06), GREY, 5, 8),
    ]


def clothes_rack(k: int) -> Part:
    """A rail with garments on hangers."""
    metal = pick(k, STEEL, DARK, WOOD, WHITE)
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
        colour = pick(i * 3 + k, RED, BLUE, WHITE, GREEN, DARK, YELLOW, PINK, TEAL, GREY)
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
        clothes.append(tube([(x, 0, h - 0.1), (x, 0, h + 0.02)], 0.004, STEEL, 4))
    return frame + clothes


def drying_rack(k: int) -> Part:
    """Crossed legs, wires, wings, with washing."""
    metal = pick(k, WHITE, STEEL, BLUE, GREY)
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
            pick(i + k, WHITE, RED, TEAL, YELLOW, PINK, BLUE),
        )
        for i in range(4)
    ]
    return [*legs, *wires, *edges, *washing]


def teddy_bear(k: int) -> Part:
    """Sitting, facing -y."""
    fur, pale = pick(
        k,
        ((0.55, 0.35, 0.18), CREAM),
        (CREAM, WHITE),
        ((0.35, 0.2, 0.1), (0.7, 0.55, 0.35)),
        (WHITE, PINK),
        (GREY, WHITE),
        (PINK, CREAM),
    )
    parts: Part = [
        ball((0.2, 0.17, 0.24), (0, 0, 0), fur, 7, 10),
        ball((0.19, 0.17, 0.17), (0, -0.01, 0.2), fur, 7, 10),
        ball((0.085, 0.06, 0.065), (0, -0.085, 0.23), pale, 4, 6),
        ball((0.03, 0.02, 0.02), (0, -0.118, 0.262), DARK, 4, 6),
        ball((0.12, 0.05, 0.15), (0, -0.07, 0.04), pale, 4, 6),
    ]
    for s in (-1, 1):
        parts += [
            ball((0.07, 0.04, 0.07), (s * 0.075, 0.01, 0.325), fur, 4, 7),
            ball((0.018, 0.012, 0.018), (s * 0.035, -0.088, 0.298), DARK, 4, 5),
            *moved(
                turned([ball((0.07, 0.07, 0.16), (0, 0, -0.16), fur, 4, 7)], "y", -s * 35),
                (s * 0.08, -0.03, 0.21),
            ),
            ball((0.085, 0.19, 0.085), (s * 0.08, -0.1, 0), fur, 4, 7),
            ball((0.075, 0.02, 0.075), (s * 0.08, -0.187, 0.005), pale, 4, 8),
        ]
    return [
        *parts,
        *(
            moved(
                [ball((0.1, 0.03, 0.04), (0, -0.085, 0.185), pick(k, RED, BLUE, GREEN), 4, 8)],
                (0, 0, 0),
            )
            if k % 2
            else []
        ),
    ]


def toy(k: int) -> Part:
    """A car (0, 3), building blocks (1, 4), a stacking ring tower (2, 5)."""
    body = pick(k, RED, BLUE, YELLOW, BLUE, GREEN, ORANGE)
    if k % 3 == 0:
        wheels = [
            p
            for sx in (-1, 1)
            for y in (-0.08, 0.08)
            for p in moved(
                turned(
                    [
                        disc(0.032, 0.03, DARK, 14),
                        *moved([disc(0.015, 0.034, YELLOW, 8)], (0, 0, 0)),
                    ],
                    "z",
                    90,
                ),
                (sx * 0.06, y, 0.032),
            )
        ]
        return [
            box((0.13, 0.28, 0.05), (0, 0, 0.03), body),
            ball((0.115, 0.16, 0.075), (0, 0.015, 0.07), (0.65, 0.8, 0.9), 6, 14, 0.4),
            box((0.1, 0.1, 0.01), (0, 0.015, 0.138), body),
            *wheels,
            *[
                ball((0.025, 0.015, 0.025), (s * 0.045, -0.138, 0.05), YELLOW, 4, 6)
                for s in (-1, 1)
            ],
        ]
    if k % 3 == 1:
        cubes = [
            ((-0.06, 0, 0), RED, 10),
            ((0.03, 0.01, 0), BLUE, -8),
            ((0.11, -0.03, 0), YELLOW, 25),
            ((-0.02, 0.0, 0.07), GREEN, -15),
            ((0.06, 0.0, 0.07), ORANGE, 12),
            ((0.02, 0.0, 0.14), PURPLE, 30),
        ]
        shift = 0 if k == 1 else 3
        return [
            p
            for i, (at, _, turn) in enumerate(cubes)
            for p in moved(
                turned(
                    [
                        box(
                            (0.07, 0.07, 0.07),
                            (0, 0, 0),
                            pick(i + shift, RED, BLUE, YELLOW, GREEN, ORANGE, PURPLE),
                        ),
                        box((0.035, 0.072, 0.035), (0, 0, 0.0175), CREAM),
                    ],
                    "z",
                    turn,
                ),
                at,
            )
        ]
    rings = [
        moved(
            [
                ring(
                    0.075 - 0.011 * i,
                    0.018,
                    pick(i + k, RED, ORANGE, YELLOW, GREEN, BLUE, PURPLE),
                    "xy",
                    10,
                    5,
                )
            ],
            (0, 0, 0.035 + 0.034 * i),
        )
        for i in range(5)
    ]
    return [
        cylinder(0.09, 0.085, 0.018, PALE_WOOD, 20),
        cylinder(0.025, 0.02, 0.19, WHITE, 12),
        ball((0.05, 0.05, 0.05), (0, 0, 0.185), pick(k, RED, RED, RED, BLUE, BLUE, BLUE), 6, 10),
        *[p for r in rings for p in r],
    ]


def soccer_ball(k: int) -> Part:
    """With dark patches."""
    base, patch = pick(
        k,
        (WHITE, DARK),
        (YELLOW, BLUE),
        (WHITE, RED),
        (ORANGE, DARK),
        (WHITE, NAVY),
        (WHITE, GREEN),
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
