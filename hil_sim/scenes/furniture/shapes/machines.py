"""Meshes of small household machines."""

from hil_sim.scenes.furniture.shapes import palette as c
from hil_sim.scenes.furniture.shapes.palette import Rgb
from hil_sim.scenes.furniture.shapes.primitives import (
    Part,
    arc,
    around,
    ball,
    box,
    cylinder,
    disc,
    lathe,
    moved,
    pick,
    ring,
    scaled,
    tube,
    turned,
    vessel,
    wheel,
)


def toaster(k: int) -> Part:
    """Two slots above, a lever at its end."""
    body = pick(k, c.STEEL, c.RED, c.CREAM, c.DARK, c.TEAL, c.WHITE)
    w, h = pick(k, 0.28, 0.26), pick(k, 0.19, 0.18)
    parts = [
        box((w * 0.98, 0.15, 0.02), (0, 0, 0), c.DARK),
        ball((w, 0.17, h), (0, 0, 0.012), body, 10, 18, 0.3),
    ]
    top = h + 0.012
    slots = [
        box((w * 0.72, 0.028, 0.004), (0, side * 0.035, top - 0.002), c.DARK) for side in (-1, 1)
    ]
    bread = [box((w * 0.5, 0.016, 0.035), (0, 0.035, top), (0.8, 0.6, 0.35))] if k % 2 else []
    return [
        *parts,
        *slots,
        *bread,
        box((0.02, 0.035, 0.02), (w / 2 + 0.008, 0, h * 0.7), c.DARK),
        *moved([disc(0.016, 0.012, pick(k, c.DARK, c.STEEL), 10)], (w * 0.25, -0.088, h * 0.35)),
    ]


def coffee_machine(k: int) -> Part:
    """A tower with a jug (even) or an espresso machine (odd)."""
    body = pick(k, c.DARK, c.STEEL, c.WHITE, c.RED, c.GREY, c.CREAM)
    if k % 2:
        return [
            box((0.26, 0.28, 0.05), (0, 0, 0), c.GREY),
            box((0.26, 0.14, 0.2), (0, 0.07, 0.05), body),
            box((0.26, 0.28, 0.1), (0, 0, 0.22), body),
            cylinder(0.035, 0.03, 0.035, c.STEEL, 14, (0, -0.07, 0.185)),
            tube([(0, -0.09, 0.2), (0, -0.22, 0.19)], 0.012, c.DARK, 6),
            tube([(0.1, -0.1, 0.22), (0.11, -0.13, 0.1)], 0.006, c.STEEL, 5),
            *moved(
                vessel([(0.02, 0), (0.028, 0.045)], c.WHITE, c.DARK_WOOD, 0.003, 12),
                (0, -0.07, 0.051),
            ),
            *moved(
                [disc(0.018, 0.01, c.RED if body != c.RED else c.STEEL, 12)], (-0.07, -0.145, 0.27)
            ),
        ]
    jug = vessel(
        [(0.05, 0), (0.062, 0.03), (0.055, 0.1), (0.04, 0.12)], (0.25, 0.16, 0.12), None, 0.003, 16
    )
    grip = tube(arc((0, -0.055, 0.06), 0.035, 90, 270, "yz", 6), 0.006, c.DARK, 5)
    return [
        box((0.19, 0.24, 0.03), (0, 0, 0), body),
        box((0.19, 0.08, 0.28), (0, 0.08, 0.03), body),
        box((0.19, 0.24, 0.1), (0, 0, 0.24), body),
        box((0.08, 0.006, 0.04), (0, -0.122, 0.27), (0.3, 0.7, 0.5)),
        *moved([*jug, grip], (0, -0.04, 0.031)),
    ]


def microwave(k: int) -> Part:
    """With a dark door, a handle and keys."""
    body, door = pick(
        k,
        (c.WHITE, c.DARK),
        (c.STEEL, c.DARK),
        (c.DARK, c.GREY),
        (c.CREAM, c.DARK),
        (c.RED, c.DARK),
        (c.GREY, c.DARK),
    )
    w, d, h = pick(k, (0.48, 0.36, 0.28), (0.52, 0.4, 0.3), (0.45, 0.34, 0.26))
    parts = [
        box((w, d, h), (0, 0, 0), body),
        box((w * 0.68, 0.008, h * 0.84), (-w * 0.13, -d / 2 - 0.003, h * 0.08), door),
        box((w * 0.5, 0.004, h * 0.52), (-w * 0.15, -d / 2 - 0.008, h * 0.24), (0.16, 0.17, 0.19)),
        tube(
            [(w * 0.2, -d / 2 - 0.03, h * 0.15), (w * 0.2, -d / 2 - 0.03, h * 0.85)],
            0.008,
            c.STEEL,
            6,
        ),
        box((w * 0.19, 0.004, h * 0.14), (w * 0.36, -d / 2 - 0.002, h * 0.74), (0.1, 0.75, 0.5)),
    ]
    keys = [
        box(
            (w * 0.045, 0.005, h * 0.07),
            (w * (0.29 + 0.07 * i), -d / 2 - 0.002, h * (0.2 + 0.12 * j)),
            c.GREY if body != c.GREY else c.WHITE,
        )
        for i in range(3)
        for j in range(4)
    ]
    return parts + keys


def blender(k: int) -> Part:
    """A jug on a motor."""
    body = pick(k, c.DARK, c.WHITE, c.RED, c.STEEL, c.GREEN, c.CREAM)
    jug = lathe([(0.04, 0.14), (0.065, 0.32), (0, 0.32)], c.GLASS, 12)
    drink = lathe([(0.043, 0.143), (0.056, 0.24)], pick(k, c.PINK, c.ORANGE, c.GREEN, c.GLASS), 12)
    return [
        lathe([(0, 0), (0.08, 0), (0.075, 0.05), (0.05, 0.14), (0, 0.14)], body, 16),
        jug,
        *scaled([drink], (1.03, 1.03, 1)),
        cylinder(0.062, 0.05, 0.03, c.DARK, 14, (0, 0, 0.32)),
        *moved([disc(0.018, 0.012, c.STEEL, 12)], (0, -0.066, 0.07)),
        tube([(0.06, 0, 0.3), (0.1, 0, 0.28), (0.1, 0, 0.2), (0.05, 0, 0.17)], 0.008, body, 6),
    ]


def vacuum_cleaner(k: int) -> Part:
    """On wheels with a hose (even) or upright (odd)."""
    body, trim = pick(
        k,
        (c.RED, c.DARK),
        (c.BLUE, c.GREY),
        (c.GREEN, c.DARK),
        (c.PURPLE, c.STEEL),
        (c.YELLOW, c.DARK),
        (c.GREY, c.ORANGE),
    )
    return _upright_vacuum(body, trim) if k % 2 else _canister_vacuum(body, trim)


def _upright_vacuum(body: Rgb, trim: Rgb) -> Part:
    column = [
        ball((0.2, 0.17, 0.6), (0, 0, 0), body, 8, 14, 0.6),
        tube([(0, 0.02, 0.55), (0, 0.03, 0.95)], 0.015, c.STEEL, 6),
        box((0.03, 0.04, 0.14), (0, 0.02, 0.92), c.DARK),
        cylinder(0.07, 0.07, 0.22, trim, 14, (0, -0.04, 0.2)),
    ]
    return [
        box((0.3, 0.22, 0.08), (0, -0.12, 0), trim),
        box((0.26, 0.02, 0.05), (0, -0.235, 0.02), body),
        *moved(turned(column, "x", -14), (0, -0.03, 0.05)),
        *wheel(0.07, 0.03, c.DARK, (-0.12, 0.02, 0.07)),
        *wheel(0.07, 0.03, c.DARK, (0.12, 0.02, 0.07)),
    ]


def _canister_vacuum(body: Rgb, trim: Rgb) -> Part:
    hose = [(0, -0.16, 0.18), (0, -0.3, 0.3), (0.1, -0.4, 0.35), (0.22, -0.35, 0.4),
            (0.26, -0.2, 0.55)]  # fmt: skip
    return [
        ball((0.27, 0.42, 0.24), (0, 0, 0.03), body, 8, 16, 0.7),
        box((0.1, 0.16, 0.03), (0, 0.05, 0.26), trim),
        *wheel(0.09, 0.03, c.DARK, (-0.14, 0.1, 0.09)),
        *wheel(0.09, 0.03, c.DARK, (0.14, 0.1, 0.09)),
        tube(hose, 0.022, c.DARK, 7),
        tube([(0.26, -0.2, 0.55), (0.27, -0.42, 0.3), (0.27, -0.62, 0.04)], 0.015, c.STEEL, 6),
        box((0.28, 0.08, 0.03), (0.27, -0.64, 0), trim),
    ]


def fan(k: int) -> Part:
    """A caged propeller on a foot: for a table (even) or the floor (odd)."""
    body, blade = pick(
        k,
        (c.WHITE, c.BLUE),
        (c.DARK, c.GREY),
        (c.TEAL, c.CREAM),
        (c.STEEL, c.STEEL),
        (c.RED, c.WHITE),
        (c.WHITE, c.GREEN),
    )
    h, r = pick(k, (0.3, 0.15), (1.0, 0.21))
    spoke = tube([(0, -0.045, 0), (0, -0.04, r * 0.6), (0, 0, r)], 0.0025, body, 3)
    wing = scaled([ball((1, 1, 1), (0, 0, 0), blade, 4, 7)], (r * 0.6, 0.012, r * 0.85))
    head = [
        *turned([ring(r, 0.006, body, "xy", 20, 3)], "x", 90),
        *moved(turned([ring(r * 0.55, 0.003, body, "xy", 16, 3)], "x", 90), (0, -0.04, 0)),
        *around([spoke], "y", 10),
        *around(moved(wing, (0.02, -0.005, 0.0)), "y", 3),
        *moved([disc(0.035, 0.03, body, 12)], (0, -0.04, 0)),
        *moved([disc(0.05, 0.09, body, 14)], (0, 0.06, 0)),
    ]
    return [
        lathe([(0, 0), (r * 0.8, 0), (r * 0.75, 0.02), (0.02, 0.04)], body, 20),
        tube([(0, 0.06, 0.02), (0, 0.06, h)], 0.015, body, 8),
        *moved(head, (0, 0, h + 0.02)),
    ]
