"""Meshes of lamps."""

from hil_sim.scenes.furniture.shapes import palette as c
from hil_sim.scenes.furniture.shapes.palette import Rgb
from hil_sim.scenes.furniture.shapes.primitives import (
    Part,
    around,
    ball,
    cylinder,
    lathe,
    moved,
    pick,
    tube,
    turned,
    vessel,
)
from hil_sim.scenes.furniture.soup import Soup


def desk_lamp(k: int) -> Part:
    """A jointed arm (even) or a shade on a stem (odd)."""
    metal, shade = pick(
        k,
        (c.DARK, c.DARK),
        (c.BRASS, c.CREAM),
        (c.RED, c.RED),
        (c.WOOD, c.WHITE),
        (c.STEEL, c.STEEL),
        (c.WHITE, c.TEAL),
    )
    if k % 2:
        h, r = pick(k, 0, 0.42, 0, 0.5, 0, 0.38), pick(k, 0, 0.14, 0, 0.16, 0, 0.12)
        return [
            lathe([(0, 0), (0.07, 0), (0.065, 0.015), (0.012, 0.03), (0.01, h * 0.6)], metal, 16),
            *moved(
                vessel([(r, 0), (r * 0.65, h * 0.38)], shade, (0.98, 0.93, 0.75), 0.003, 20),
                (0, 0, h * 0.6),
            ),
            ball((0.05, 0.05, 0.06), (0, 0, h * 0.66), (1.0, 0.95, 0.7), 5, 8),
        ]
    arm = [
        tube([(0, 0.0, 0.02), (0, 0.12, 0.24)], 0.008, c.STEEL if metal != c.STEEL else c.DARK, 6),
        tube([(0, 0.12, 0.24), (0, -0.1, 0.42)], 0.008, c.STEEL if metal != c.STEEL else c.DARK, 6),
        ball((0.03, 0.03, 0.03), (0, 0.12, 0.225), metal, 5, 8),
    ]
    head = moved(
        turned(
            [
                *vessel(
                    [(0.075, 0), (0.055, 0.06), (0.022, 0.11)], shade, (1.0, 0.96, 0.75), 0.004, 16
                ),
                cylinder(0.024, 0.02, 0.03, metal, 10, (0, 0, 0.105)),
            ],
            "x",
            -25,
        ),
        (0, -0.15, 0.33),
    )
    return [
        lathe([(0, 0), (0.085, 0), (0.08, 0.02), (0.02, 0.03), (0, 0.03)], metal, 18),
        *arm,
        *head,
    ]


WARM: Rgb = (1.0, 0.94, 0.75)


def floor_lamp(k: int) -> Part:
    """A shade on a tall stem (0, 3), on a tripod (1, 4), on a bow (2, 5)."""
    metal, cloth = pick(
        k,
        (c.STEEL, c.CREAM),
        (c.WOOD, c.WHITE),
        (c.DARK, c.DARK),
        (c.BRASS, c.TEAL),
        (c.DARK, c.CREAM),
        (c.STEEL, c.ORANGE),
    )
    h, r = pick(k, 1.6, 1.5, 1.75), pick(k, 0.2, 0.22, 0.18)
    if k % 3 == 2:
        return _bow_lamp(h, metal, cloth)
    drum = vessel([(r, 0), (r * pick(k, 0.75, 0.95), 0.28)], cloth, WARM, 0.003, 22)
    if k % 3 == 1:
        foot = around([tube([(0, 0, h - 0.25), (0, 0.28, 0)], 0.016, metal, 6)], "z", 3)
    else:
        foot = [_foot(metal), tube([(0, 0, 0.02), (0, 0, h - 0.1)], 0.012, metal, 8)]
    return [*foot, *moved(drum, (0, 0, h - 0.28))]


def _foot(metal: Rgb) -> Soup:
    return lathe([(0, 0), (0.15, 0), (0.145, 0.02), (0.015, 0.035)], metal, 20)


def _bow_lamp(h: float, metal: Rgb, cloth: Rgb) -> Part:
    bow = [(0, 0.25, 0.02), (0, 0.3, h * 0.6), (0, 0.22, h * 0.9), (0, 0.0, h),
           (0, -0.25, h * 0.93), (0, -0.33, h * 0.85)]  # fmt: skip
    head = vessel([(0.15, 0), (0.13, 0.08), (0.03, 0.14)], cloth, WARM, 0.004, 18)
    return [
        *moved([_foot(metal)], (0, 0.25, 0)),
        tube(bow, 0.012, metal, 8),
        *moved(head, (0, -0.33, h * 0.78)),
    ]
