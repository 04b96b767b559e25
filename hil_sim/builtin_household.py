"""Meshes of what a bathroom, a wardrobe or a corner holds."""

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
    moved,
    pick,
    ring,
    scaled,
    surface,
    tube,
    turned,
    vessel,
)


def soap_bottle(k: int) -> Part:
    """With a pump."""
    body, pump = pick(
        k,
        (WHITE, STEEL),
        (TEAL, WHITE),
        (PINK, WHITE),
        (DARK_WOOD, DARK),
        (GREEN, WHITE),
        ((0.85, 0.7, 0.4), DARK),
    )
    r, h = pick(k, (0.034, 0.13), (0.03, 0.15), (0.038, 0.12))
    return [
        lathe([(0, 0), (r, 0), (r, h * 0.85), (r * 0.6, h), (0, h)], body, 16),
        lathe([(r + 0.0007, h * 0.2), (r + 0.0007, h * 0.6)], pick(k, BLUE, CREAM, RED), 16),
        cylinder(0.013, 0.013, 0.018, pump, 10, (0, 0, h)),
        cylinder(0.004, 0.004, 0.03, pump, 6, (0, 0, h + 0.018)),
        box((0.016, 0.05, 0.01), (0, -0.014, h + 0.045), pump),
        tube([(0, -0.036, h + 0.05), (0, -0.046, h + 0.04)], 0.004, pump, 5),
    ]


def toilet_paper(k: int) -> Part:
    """A roll: standing (even) or on a wall holder (odd)."""
    r, h = pick(k, 0.055, 0.05, 0.06), 0.1
    core: Rgb = (0.6, 0.46, 0.32)
    paper = pick(k, WHITE, WHITE, (0.95, 0.88, 0.88), WHITE, (0.85, 0.9, 0.95))
    roll = [
        *vessel([(0.02, 0), (r, 0), (r, h), (0.02, h)], paper, None, 0.002, 22),
        lathe([(0.022, h + 0.0006), (0, h - 0.004)], core, 14),
        box((0.004, 0.05, h), (r, -0.025, 0), paper),
    ]
    if k % 2 == 0:
        return roll
    lying = turned(
        [
            *moved(roll, (0, 0, -h / 2)),
            lathe([(0, -h / 2 - 0.0006), (0.022, -h / 2 - 0.0006)], core, 14),
        ],
        "y",
        90,
    )
    sheet = box((h, 0.002, 0.07), (0, -r, -0.07), paper)
    bar = STEEL if k != 3 else BRASS
    return [
        *lying,
        sheet,
        tube([(-0.09, 0, 0), (0.09, 0, 0)], 0.006, bar, 6),
        tube([(-0.09, 0, 0), (-0.09, 0.07, 0)], 0.006, bar, 6),
        box((0.04, 0.01, 0.06), (-0.09, 0.075, -0.03), bar),
    ]


def towel(k: int) -> Part:
    """Hung over a rail (even) or folded in a pile (odd)."""
    cloth, stripe = pick(
        k, (BLUE, WHITE), (WHITE, TEAL), (RED, CREAM), (PINK, WHITE), (GREEN, WHITE), (GREY, YELLOW)
    )
    if k % 2:
        pile: Part = []
        for i, shade in enumerate((cloth, stripe, cloth)):
            pile += moved(
                [ball((0.34, 0.24, 0.055), (0, 0, 0), shade, 6, 16, 0.3)], (0, 0, 0.05 * i)
            )
        return pile
    w, h = pick(k, 0.5, 0.0, 0.4, 0.0, 0.45), pick(k, 0.6, 0.0, 0.5, 0.0, 0.55)
    t = np.linspace(0, 1, 13)
    wave = 0.006 * np.sin(t * 18)
    front = np.stack(
        [
            np.stack([w * (t - 0.5), -0.03 + wave, np.full_like(t, z)], 1)
            for z in (0, h * 0.12, h * 0.18, h * 0.98, h)
        ]
    )
    back = front[:, ::-1] * np.array([1, 0, 1]) + np.array([0, -0.012, 0])
    which = np.zeros((4, 12), bool)
    which[1] = True
    bar = [
        tube([(-w * 0.62, -0.02, h - 0.008), (w * 0.62, -0.02, h - 0.008)], 0.008, STEEL, 6),
        *[box((0.02, 0.05, 0.03), (s * w * 0.6, 0.005, h - 0.025), STEEL) for s in (-1, 1)],
    ]
    rear = moved(scaled([surface(back, cloth)], (1, 1, 0.75)), (0, 0, h * 0.25))
    return [
        surface(front, cloth, ~which),
        surface(front, stripe, which),
        *rear,
        box((w, 0.03, 0.012), (0, -0.022, h - 0.006), cloth),
        *bar,
    ]


def plunger(k: int) -> Part:
    """Upright on its cup."""
    cup, stick = pick(
        k,
        (RED, WOOD),
        (DARK, WHITE),
        (ORANGE, PALE_WOOD),
        (BLUE, WHITE),
        ((0.6, 0.2, 0.15), DARK_WOOD),
        (GREEN, STEEL),
    )
    r, h = pick(k, 0.07, 0.065, 0.075), pick(k, 0.5, 0.42)
    return [
        lathe(
            [
                (0, 0.01),
                (r * 0.9, 0.0),
                (r, 0.004),
                (r * 0.95, 0.035),
                (r * 0.5, 0.075),
                (0.02, 0.085),
                (0.018, 0.11),
                (0, 0.11),
            ],
            cup,
            18,
        ),
        cylinder(0.012, 0.011, h - 0.1, stick, 10, (0, 0, 0.1)),
        ball((0.028, 0.028, 0.028), (0, 0, h - 0.015), stick, 6, 8),
    ]


def tissue_box(k: int) -> Part:
    """A tissue stands out of it."""
    card, trim = pick(
        k,
        (BLUE, WHITE),
        (PINK, CREAM),
        (CREAM, GREEN),
        (TEAL, YELLOW),
        (WHITE, PURPLE),
        (GREY, ORANGE),
    )
    w, d, h = pick(k, (0.23, 0.12, 0.08), (0.12, 0.12, 0.13))
    tissue = [lathe([(0.035, 0), (0.028, 0.02), (0.045, 0.05), (0.02, 0.07), (0, 0.055)], WHITE, 7)]
    spots = [
        box((0.02, 0.002, 0.02), (x * w, -d / 2, h * z), trim)
        for x, z in ((-0.35, 0.2), (-0.1, 0.5), (0.15, 0.2), (0.35, 0.55), (-0.38, 0.65))
    ]
    return [
        box((w, d, h), (0, 0, 0), card),
        box((w * 0.6, d * 0.45, 0.002), (0, 0, h - 0.0005), trim),
        *moved(scaled(tissue, (1.2, 0.5, 1)), (0, 0, h)),
        *spots,
        box((w * 1.002, d * 1.01, 0.006), (0, 0, h * 0.04), trim),
    ]


def laundry_basket(k: int) -> Part:
    """Slatted or woven, with linen in it."""
    body, linen = pick(
        k,
        (PALE_WOOD, WHITE),
        (WHITE, BLUE),
        (GREY, CREAM),
        (WOOD, PINK),
        (CREAM, TEAL),
        (BLUE, WHITE),
    )
    r, h = pick(k, (0.22, 0.55), (0.26, 0.32), (0.2, 0.6))
    shell = vessel(
        [(r * 0.82, 0), (r, h * 0.96), (r * 1.04, h * 0.96), (r * 1.04, h)], body, None, 0.01, 18
    )
    shade = (body[0] * 0.72, body[1] * 0.72, body[2] * 0.72)
    holes = [
        p
        for i in range(9)
        for j in range(3)
        for p in turned(
            [
                box(
                    (r * 0.2, 0.004, h * 0.18),
                    (0, -r * (0.86 + 0.05 * j), h * (0.12 + 0.26 * j)),
                    shade,
                )
            ],
            "z",
            30 * i,
        )
    ]
    return [
        *shell,
        *holes,
        ball((r * 1.5, r * 1.4, h * 0.3), (0.02, 0, h * 0.78), linen, 6, 10),
        ball(
            (r * 0.9, r * 0.8, h * 0.25),
            (-r * 0.3, -r * 0.2, h * 0.86),
            pick(k, RED, CREAM, NAVY, YELLOW),
            5,
            8,
        ),
    ]


def dumbbell(k: int) -> Part:
    """Lying, along x."""
    weight = pick(k, DARK, BLUE, PINK, STEEL, TEAL, RED)
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
        tube([(-0.07, 0, 0), (0.07, 0, 0)], 0.014, STEEL if weight != STEEL else DARK, 10),
    ]


def vacuum_cleaner(k: int) -> Part:
    """On wheels with a hose (even) or upright (odd)."""
    body, trim = pick(
        k, (RED, DARK), (BLUE, GREY), (GREEN, DARK), (PURPLE, STEEL), (YELLOW, DARK), (GREY, ORANGE)
    )
    if k % 2:
        return [
            box((0.3, 0.22, 0.08), (0, -0.12, 0), trim),
            box((0.26, 0.02, 0.05), (0, -0.235, 0.02), body),
            *moved(
                turned(
                    [
                        ball((0.2, 0.17, 0.6), (0, 0, 0), body, 8, 14, 0.6),
                        tube([(0, 0.02, 0.55), (0, 0.03, 0.95)], 0.015, STEEL, 6),
                        box((0.03, 0.04, 0.14), (0, 0.02, 0.92), DARK),
                        cylinder(0.07, 0.07, 0.22, trim, 14, (0, -0.04, 0.2)),
                    ],
                    "x",
                    -14,
                ),
                (0, -0.03, 0.05),
            ),
            *[
                p
                for s in (-1, 1)
                for p in moved(
                    turned([disc(0.07, 0.03, DARK, 14)], "z", 90), (s * 0.12, 0.02, 0.07)
                )
            ],
        ]
    wheels = [
        p
        for s in (-1, 1)
        for p in moved(turned([disc(0.09, 0.03, DARK, 16)], "z", 90), (s * 0.14, 0.1, 0.09))
    ]
    hose = tube(
        [
            (0, -0.16, 0.18),
            (0, -0.3, 0.3),
            (0.1, -0.4, 0.35),
            (0.22, -0.35, 0.4),
            (0.26, -0.2, 0.55),
        ],
        0.022,
        DARK,
        7,
    )
    wand = tube([(0.26, -0.2, 0.55), (0.27, -0.42, 0.3), (0.27, -0.62, 0.04)], 0.015, STEEL, 6)
    return [
        ball((0.27, 0.42, 0.24), (0, 0, 0.03), body, 8, 16, 0.7),
        box((0.1, 0.16, 0.03), (0, 0.05, 0.26), trim),
        *wheels,
        hose,
        wand,
        box((0.28, 0.08, 0.03), (0.27, -0.64, 0), trim),
    ]


def dog_bed(k: int) -> Part:
    """A thick rim around a cushion."""
    rim, inside = pick(
        k,
        (GREY, CREAM),
        (DARK_WOOD, CREAM),
        (NAVY, GREY),
        (RED, CREAM),
        (TEAL, WHITE),
        (PALE_WOOD, BLUE),
    )
    w, d = pick(k, (0.75, 0.6), (0.6, 0.6), (0.9, 0.65))
    t = np.radians(np.linspace(-80, 260, 21))
    path = np.stack(
        [np.cos(t) * (w / 2 - 0.07), np.sin(t) * (d / 2 - 0.07), np.full_like(t, 0.09)], 1
    )
    low = 0.25 * (path[:, 1] < -d * 0.2)
    bone = [
        ball((0.05, 0.05, 0.04), (x, y, 0.125), WHITE, 4, 6)
        for x in (-0.08, 0.08)
        for y in (-0.02, 0.02)
    ]
    return [
        tube(path, np.asarray(0.08 * (1 - low), float), rim, 10),
        ball((w * 0.86, d * 0.86, 0.12), (0, 0, 0.01), inside, 6, 18),
        *bone,
        box((0.15, 0.03, 0.025), (0, 0, 0.128), WHITE),
    ]


def watering_can(k: int) -> Part:
    """With a rose on its spout, along -y."""
    body, trim = pick(
        k, (GREEN, GREEN), (STEEL, BRASS), (BLUE, YELLOW), (RED, RED), (PINK, WHITE), (TEAL, WOOD)
    )
    r, h = pick(k, (0.09, 0.2), (0.1, 0.17))
    spout = tube(
        [(0, -r * 0.9, h * 0.2), (0, -r - 0.09, h * 0.6), (0, -r - 0.16, h * 1.1)],
        [0.022, 0.014, 0.01],
        body,
        8,
    )
    rose = moved(
        turned([cylinder(0.012, 0.035, 0.035, trim, 12)], "x", 35), (0, -r - 0.155, h * 1.08)
    )
    grip = tube(
        [
            (0, r * 0.95, h * 0.25),
            (0, r + 0.08, h * 0.5),
            (0, r + 0.05, h * 1.05),
            (0, 0, h * 1.3),
            (0, -r * 0.7, h),
        ],
        0.01,
        trim,
        6,
    )
    return [
        *vessel([(r, 0), (r * 0.95, h * 0.5), (r * 0.9, h)], body, DARK, 0.004, 18),
        lathe([(r * 0.9, h), (r * 0.5, h * 1.03)], body, 18),
        spout,
        *rose,
        grip,
    ]


def boots(k: int) -> Part:
    """A pair: rubber (even) or laced (odd)."""
    body, sole = pick(
        k,
        (GREEN, DARK),
        (DARK_WOOD, DARK),
        (YELLOW, WHITE),
        (DARK, CREAM),
        (RED, DARK),
        (WOOD, CREAM),
    )
    h = pick(k, 0.32, 0.2, 0.28, 0.18)
    one: Part = [
        ball((0.1, 0.27, 0.13), (0, -0.05, 0.01), body, 7, 14, 0.8),
        cylinder(0.052, 0.06, h - 0.05, body, 14, (0, 0.03, 0.05)),
        lathe([(0.052, h + 0.001), (0, h - 0.02)], DARK, 14, (0, 0.03, 0)),
        box((0.1, 0.16, 0.02), (0, -0.1, 0), sole),
        box((0.09, 0.09, 0.03), (0, 0.035, 0), sole),
        lathe([(0.0615, h - 0.025), (0.0615, h)], sole, 14, (0, 0.03, 0)),
    ]
    if k % 2:
        one += [
            box((0.06, 0.008, 0.006), (0, -0.028 - 0.018 * (4 - i), 0.09 + 0.014 * i), CREAM)
            for i in range(4)
        ]
    return [
        *moved(turned(one, "z", 6), (-0.075, 0, 0)),
        *moved(turned(one, "z", -9), (0.075, 0.02, 0)),
    ]


def garbage_bag(k: int) -> Part:
    """Full and tied."""
    skin = pick(k, DARK, WHITE, (0.15, 0.2, 0.3), GREEN, GREY, YELLOW)
    r, h = pick(k, (0.24, 0.5), (0.2, 0.4), (0.27, 0.55))
    t = np.linspace(0, 2 * np.pi, 19)
    rows = []
    for f, z in (
        (0, 0),
        (0.8, 0),
        (1, 0.2),
        (0.95, 0.45),
        (0.6, 0.7),
        (0.16, 0.82),
        (0.12, 0.86),
        (0.34, 1),
        (0.1, 0.9),
    ):
        wave = 1 + 0.07 * np.sin(5 * t + 9 * z + k) + 0.04 * np.sin(9 * t + 4 * k)
        rows.append(
            np.stack(
                [r * f * wave * np.cos(t), r * f * wave * np.sin(t), np.full_like(t, h * z)], 1
            )
        )
    tie = moved(
        [ring(r * 0.13, 0.012, pick(k, RED, YELLOW, WHITE), "xy", 12, 5)], (0, 0, h * 0.845)
    )
    return [surface(np.stack(rows), skin), *tie]


def umbrella(k: int) -> Part:
    """Folded, standing on its tip, leaning back."""
    cloth = pick(k, DARK, RED, BLUE, GREEN, YELLOW, PURPLE)
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
            tube([(0, 0, 0), (0, 0, 0.07)], 0.006, STEEL, 6),
            surface(np.stack(rows), cloth),
            tube(crook, 0.009, pick(k, WOOD, DARK, DARK_WOOD), 6),
            lathe([(0.042, 0.42), (0.046, 0.45)], WHITE, 12),
        ],
        "x",
        -6,
    )


def broom(k: int) -> Part:
    """Standing on its bristles, leaning back."""
    head, stick = pick(
        k,
        (YELLOW, WOOD),
        (RED, STEEL),
        (PALE_WOOD, BLUE),
        (GREEN, WHITE),
        (DARK, PALE_WOOD),
        (BLUE, YELLOW),
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
