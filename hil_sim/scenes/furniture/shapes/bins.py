"""Meshes of bins, vases and other vessels that stand about."""

import numpy as np

from hil_sim.scenes.furniture.shapes import palette as c
from hil_sim.scenes.furniture.shapes.primitives import (
    Part,
    around,
    ball,
    box,
    cylinder,
    lathe,
    moved,
    pick,
    ring,
    scaled,
    shade,
    surface,
    tube,
    turned,
    vessel,
)

VASES = (
    ((0.35, 0), (0.6, 0.12), (0.75, 0.38), (0.62, 0.62), (0.35, 0.8), (0.34, 0.9), (0.5, 1.0)),
    ((0.5, 0), (0.52, 0.1), (0.6, 0.5), (0.7, 0.9), (0.72, 1.0)),
    ((0.3, 0), (0.9, 0.25), (1.0, 0.42), (0.85, 0.6), (0.3, 0.75), (0.26, 0.9), (0.36, 1.0)),
    ((0.55, 0), (0.45, 0.25), (0.36, 0.5), (0.5, 0.8), (0.72, 1.0)),
    ((0.5, 0), (0.85, 0.3), (0.85, 0.55), (0.5, 0.78), (0.45, 1.0)),
    ((0.35, 0), (0.7, 0.4), (0.75, 0.7), (0.4, 0.86), (0.22, 0.9), (0.22, 0.97), (0.3, 1.0)),
)


def vase(k: int) -> Part:
    """Six turned profiles."""
    colour, band = pick(k, (c.TEAL, c.CREAM), (c.WHITE, c.BLUE), ((0.6, 0.28, 0.16), c.DARK),
                        (c.GREEN, c.YELLOW),
                        (c.NAVY, c.BRASS), (c.PINK, c.WHITE))  # fmt: skip
    r, h = pick(k, (0.1, 0.28), (0.08, 0.22), (0.1, 0.19), (0.1, 0.32), (0.11, 0.2), (0.13, 0.36))
    profile = [(a * r, b * h) for a, b in VASES[k % len(VASES)]]
    parts = vessel(profile, colour, c.DARK, 0.005, 20)
    (r0, z0), (r1, z1) = profile[1], profile[2]
    stripe = [(r0 + (r1 - r0) * t + 0.0012, z0 + (z1 - z0) * t) for t in (0.3, 0.75)]
    return [*parts, lathe(stripe, band, 20)]


def trash_can(k: int) -> Part:
    """Office bin, pedal bin, swing-top bin, recycling bin, round plastic bin, kitchen bin."""
    made = (_office_bin, _pedal_bin, _swing_bin, _recycling_bin, _plastic_bin, _pedal_bin)
    return made[k % 6](k)


def _office_bin(_: int) -> Part:
    shell = vessel([(0.12, 0), (0.15, 0.34), (0.155, 0.35)], c.STEEL, c.GREY, 0.006, 20)
    rim = moved([ring(0.152, 0.006, c.DARK)], (0, 0, 0.345))
    return [*shell, *rim]


def _pedal_bin(k: int) -> Part:
    body, lid, r, h = (c.STEEL, c.GREY, 0.14, 0.42) if k == 1 else (c.RED, c.DARK, 0.16, 0.55)
    return [
        cylinder(r * 1.02, r * 1.02, 0.03, c.DARK, 20),
        cylinder(r, r, h, body, 20, (0, 0, 0.03)),
        lathe([(0, 0), (r * 1.03, 0), (r * 1.03, 0.02), (r * 0.7, 0.06), (0, 0.07)], lid, 20,
              (0, 0, h + 0.03)),
        box((0.07, 0.06, 0.015), (0, -r - 0.015, 0.01), c.DARK),
    ]  # fmt: skip


def _swing_bin(_: int) -> Part:
    lid = scaled([lathe([(0, 0), (0.5, 0), (0.4, 0.3), (0.15, 0.42), (0, 0.44)], c.GREY, 4)], 1)
    lid = scaled(turned(lid, "z", 45), (0.46, 0.34, 0.3))
    return [
        box((0.3, 0.22, 0.45), (0, 0, 0), c.WHITE),
        box((0.32, 0.24, 0.03), (0, 0, 0.45), c.GREY),
        *moved(lid, (0, 0, 0.48)),
        box((0.16, 0.006, 0.05), (0, -0.084, 0.53), c.DARK),
    ]


def _recycling_bin(_: int) -> Part:
    parts = turned(vessel([(0.2, 0), (0.26, 0.38), (0.275, 0.4)], c.BLUE, c.NAVY, 0.01, 4), "z", 45)
    sign: Part = []
    for turn in (0, 120, 240):
        arrow = [box((0.02, 0.004, 0.06), (0.032, 0, -0.03), c.WHITE)]
        sign += turned(arrow, "y", turn)
    return [*scaled(parts, (1, 0.8, 1)), *moved(sign, (0, -0.134, 0.2))]


def _plastic_bin(_: int) -> Part:
    shell = vessel([(0.1, 0), (0.13, 0.26), (0.14, 0.27)], c.GREEN, c.DARK, 0.006, 18)
    rings = [
        lathe([(0.1 + 0.115 * z, z), (0.102 + 0.115 * z, z + 0.012)], c.DARK, 18)
        for z in (0.05, 0.12, 0.19)
    ]
    paper = ball((0.12, 0.1, 0.1), (0.03, 0, 0.2), c.WHITE, 5, 7)
    return [*shell, *rings, paper, ball((0.1, 0.1, 0.08), (-0.05, 0.02, 0.19), c.CREAM, 4, 6)]


def bucket(k: int) -> Part:
    """With a bail handle."""
    body = pick(k, c.BLUE, c.RED, c.STEEL, c.YELLOW, c.GREEN, c.GREY)
    return [
        *vessel([(0.1, 0), (0.14, 0.25), (0.146, 0.25), (0.146, 0.26)], body, None, 0.004, 20),
        tube(
            [
                (0.146 * np.cos(a), -0.12 * np.sin(a), 0.25 + 0.08 * np.sin(a))
                for a in np.linspace(0, np.pi, 12)
            ],
            0.004,
            c.STEEL if body != c.STEEL else c.DARK,
            5,
        ),
    ]


def watering_can(k: int) -> Part:
    """With a rose on its spout, along -y."""
    body, trim = pick(
        k,
        (c.GREEN, c.GREEN),
        (c.STEEL, c.BRASS),
        (c.BLUE, c.YELLOW),
        (c.RED, c.RED),
        (c.PINK, c.WHITE),
        (c.TEAL, c.WOOD),
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
        *vessel([(r, 0), (r * 0.95, h * 0.5), (r * 0.9, h)], body, c.DARK, 0.004, 18),
        lathe([(r * 0.9, h), (r * 0.5, h * 1.03)], body, 18),
        spout,
        *rose,
        grip,
    ]


def laundry_basket(k: int) -> Part:
    """Slatted or woven, with linen in it."""
    body, linen, other = pick(
        k,
        (c.PALE_WOOD, c.WHITE, c.RED),
        (c.WHITE, c.BLUE, c.CREAM),
        (c.GREY, c.CREAM, c.NAVY),
        (c.WOOD, c.PINK, c.YELLOW),
        (c.CREAM, c.TEAL, c.RED),
        (c.BLUE, c.WHITE, c.CREAM),
    )
    r, h = pick(k, (0.22, 0.55), (0.26, 0.32), (0.2, 0.6))
    outside = [(r * 0.82, 0), (r, h * 0.96), (r * 1.04, h * 0.96), (r * 1.04, h)]
    parts = vessel(outside, body, None, 0.01, 18)
    for row in range(3):
        at = (0, -r * (0.86 + 0.05 * row), h * (0.12 + 0.26 * row))
        parts += around([box((r * 0.2, 0.004, h * 0.18), at, shade(body, 0.72))], "z", 9)
    heap = (-r * 0.3, -r * 0.2, h * 0.86)
    return [
        *parts,
        ball((r * 1.5, r * 1.4, h * 0.3), (0.02, 0, h * 0.78), linen, 6, 10),
        ball((r * 0.9, r * 0.8, h * 0.25), heap, other, 5, 8),
    ]


def garbage_bag(k: int) -> Part:
    """Full and tied."""
    skin = pick(k, c.DARK, c.WHITE, (0.15, 0.2, 0.3), c.GREEN, c.GREY, c.YELLOW)
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
        [ring(r * 0.13, 0.012, pick(k, c.RED, c.YELLOW, c.WHITE), "xy", 12, 5)], (0, 0, h * 0.845)
    )
    return [surface(np.stack(rows), skin), *tie]
