"""Meshes of what a bathroom has."""

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
    scaled,
    surface,
    tube,
    turned,
    vessel,
)


def toilet(k: int) -> Part:
    """A bowl with a seat, its lid down (even) or up (odd), and a cistern."""
    china, seat = pick(
        k,
        (c.WHITE, c.WHITE),
        (c.CREAM, c.WOOD),
        (c.WHITE, c.DARK),
        ((0.8, 0.86, 0.84), c.WHITE),
        (c.WHITE, c.PALE_WOOD),
        (c.PINK, c.WHITE),
    )
    tall = pick(k, 0.36, 0.3, 0.4)
    foot = [(0, 0), (0.6, 0), (0.5, 0.3), (0.62, 0.55), (1, 0.9), (1, 1), (0, 1)]
    button = (pick(k, 0, -0.14), pick(k, 0.24, 0.14), 0.4 + tall)
    parts = [
        *moved(scaled([lathe(foot, china, 18)], (0.19, 0.24, 0.38)), (0, -0.09, 0)),
        *moved(_oval(0.025, seat), (0, -0.1, 0.385)),
        box((0.24, 0.3, 0.36), (0, 0.12, 0), china),
        box((0.4, 0.19, tall), (0, 0.24, 0.38), china),
        box((0.42, 0.21, 0.03), (0, 0.24, 0.38 + tall), china),
        box((0.05, 0.03, 0.015), button, c.STEEL),
    ]
    if k % 2 == 0:
        return [*parts, *moved(_oval(0.03, seat), (0, -0.1, 0.412))]
    lid = moved(turned(_oval(0.02, seat), "x", -80), (0, 0.1, 0.65))
    water = scaled(_oval(0.004, (0.55, 0.68, 0.74)), (0.65, 0.68, 1))
    return [*parts, *lid, *moved(water, (0, -0.11, 0.409))]


def _oval(thick: float, colour: Rgb) -> Part:
    return scaled([cylinder(1, 0.97, thick, colour, 20)], (0.2, 0.25, 1))


def shower(k: int) -> Part:
    """A tray, a pole with its head, and panes; some with a curtain."""
    tray, metal, wall = pick(
        k,
        (c.WHITE, c.STEEL, (0.75, 0.83, 0.85)),
        (c.CREAM, c.BRASS, (0.8, 0.85, 0.82)),
        (c.GREY, c.DARK, (0.7, 0.78, 0.8)),
    )
    w, h = pick(k, 0.9, 0.8), 2.0
    back = w / 2 - 0.01
    pole = [
        tube(
            [(0, back - 0.04, 0.9), (0, back - 0.04, h - 0.05), (0, back - 0.35, h)],
            0.012,
            metal,
            6,
        ),
        cylinder(0.1, 0.02, 0.05, metal, 16, (0, back - 0.36, h - 0.06)),
        box((0.18, 0.06, 0.05), (0, back - 0.05, 0.95), metal),
    ]
    frame = [
        box((0.03, 0.03, h), (sx * (w / 2 - 0.015), sy * (w / 2 - 0.015), 0.06), metal)
        for sx in (-1, 1)
        for sy in (-1, 1)
    ] + [box((w, 0.03, 0.03), (0, s * (w / 2 - 0.015), h + 0.03), metal) for s in (-1, 1)]
    side = box((0.012, w - 0.06, h - 0.02), (w / 2 - 0.015, 0, 0.08), wall)
    half = box((w * 0.42, 0.012, h - 0.02), (-w * 0.26, -w / 2 + 0.015, 0.08), wall)
    drain = cylinder(0.05, 0.05, 0.004, metal, 14, (0, 0, 0.065))
    return [
        box((w, w, 0.04), (0, 0, 0), tray),
        *[box((w, 0.05, 0.08), (0, s * (w / 2 - 0.025), 0), tray) for s in (-1, 1)],
        *[box((0.05, w, 0.08), (s * (w / 2 - 0.025), 0, 0), tray) for s in (-1, 1)],
        box((w, 0.012, h), (0, back, 0.06), (0.85, 0.9, 0.9)),
        *moved([drain], (0, 0, -0.022)),
        *pole,
        *frame,
        side,
        half,
        tube(arc((w * 0.02, -w / 2 + 0.01, 1.05), 0.06, 90, 270, "xz", 6), 0.008, metal, 5),
    ]


def soap_bottle(k: int) -> Part:
    """With a pump."""
    body, pump = pick(
        k,
        (c.WHITE, c.STEEL),
        (c.TEAL, c.WHITE),
        (c.PINK, c.WHITE),
        (c.DARK_WOOD, c.DARK),
        (c.GREEN, c.WHITE),
        ((0.85, 0.7, 0.4), c.DARK),
    )
    r, h = pick(k, (0.034, 0.13), (0.03, 0.15), (0.038, 0.12))
    return [
        lathe([(0, 0), (r, 0), (r, h * 0.85), (r * 0.6, h), (0, h)], body, 16),
        lathe([(r + 0.0007, h * 0.2), (r + 0.0007, h * 0.6)], pick(k, c.BLUE, c.CREAM, c.RED), 16),
        cylinder(0.013, 0.013, 0.018, pump, 10, (0, 0, h)),
        cylinder(0.004, 0.004, 0.03, pump, 6, (0, 0, h + 0.018)),
        box((0.016, 0.05, 0.01), (0, -0.014, h + 0.045), pump),
        tube([(0, -0.036, h + 0.05), (0, -0.046, h + 0.04)], 0.004, pump, 5),
    ]


def toilet_paper(k: int) -> Part:
    """A roll: standing (even) or on a wall holder (odd)."""
    r, h = pick(k, 0.055, 0.05, 0.06), 0.1
    core: Rgb = (0.6, 0.46, 0.32)
    paper = pick(k, c.WHITE, c.WHITE, (0.95, 0.88, 0.88), c.WHITE, (0.85, 0.9, 0.95))
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
    bar = c.STEEL if k != 3 else c.BRASS
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
        k,
        (c.BLUE, c.WHITE),
        (c.WHITE, c.TEAL),
        (c.RED, c.CREAM),
        (c.PINK, c.WHITE),
        (c.GREEN, c.WHITE),
        (c.GREY, c.YELLOW),
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
        tube([(-w * 0.62, -0.02, h - 0.008), (w * 0.62, -0.02, h - 0.008)], 0.008, c.STEEL, 6),
        *[box((0.02, 0.05, 0.03), (s * w * 0.6, 0.005, h - 0.025), c.STEEL) for s in (-1, 1)],
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
        (c.RED, c.WOOD),
        (c.DARK, c.WHITE),
        (c.ORANGE, c.PALE_WOOD),
        (c.BLUE, c.WHITE),
        ((0.6, 0.2, 0.15), c.DARK_WOOD),
        (c.GREEN, c.STEEL),
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
        (c.BLUE, c.WHITE),
        (c.PINK, c.CREAM),
        (c.CREAM, c.GREEN),
        (c.TEAL, c.YELLOW),
        (c.WHITE, c.PURPLE),
        (c.GREY, c.ORANGE),
    )
    w, d, h = pick(k, (0.23, 0.12, 0.08), (0.12, 0.12, 0.13))
    tissue = [
        lathe([(0.035, 0), (0.028, 0.02), (0.045, 0.05), (0.02, 0.07), (0, 0.055)], c.WHITE, 7)
    ]
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


def paper_towel(k: int) -> Part:
    """A roll, some on a stand."""
    r, h = pick(k, 0.06, 0.055, 0.065), pick(k, 0.24, 0.26)
    base = [
        cylinder(0.08, 0.075, 0.012, pick(k, c.WOOD, c.STEEL, c.DARK), 18),
        cylinder(0.008, 0.008, 0.3, pick(k, c.WOOD, c.STEEL, c.DARK), 8),
    ]
    roll = vessel([(0.02, 0), (r, 0), (r, h), (0.02, h)], c.WHITE, None, 0.002, 20)
    sheet = box((0.05, 0.003, h), (r - 0.02, -r - 0.001, 0), c.WHITE)
    print_ = lathe(
        [(r + 0.0006, h * 0.12), (r + 0.0006, h * 0.18)], pick(k, c.BLUE, c.PINK, c.GREEN), 20
    )
    core = lathe([(0.02, h), (0, h * 0.99)], (0.65, 0.5, 0.35), 12)
    return [
        *base,
        *moved([*roll, sheet, print_, core, *moved([print_], (0, 0, h * 0.6))], (0, 0, 0.012)),
    ]
