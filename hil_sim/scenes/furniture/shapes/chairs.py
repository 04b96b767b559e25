"""Meshes of chairs, each variant a type of its own; they look along -y."""

from functools import partial

from hil_sim.scenes.furniture.shapes import palette as c
from hil_sim.scenes.furniture.shapes.palette import Rgb
from hil_sim.scenes.furniture.shapes.primitives import (
    Part,
    around,
    ball,
    box,
    cylinder,
    moved,
    pick,
    shade,
    tube,
)
from hil_sim.scenes.furniture.shapes.soft import bowed, leaning, padded

SEAT_M = 0.45
BACK_Y = 0.2


def _legs(w: float, d: float, colour: Rgb, thick: float, splay: float = 0.0) -> Part:
    """Four legs up to the seat; `splay` is how far each foot stands out."""
    return [
        tube([(x * (w / 2 + splay), y * (d / 2 + splay), 0), (x * w / 2, y * d / 2, SEAT_M - 0.02)],
             thick / 2, colour, 6)
        for x in (-1, 1) for y in (-1, 1)
    ]  # fmt: skip


def _framed(
    wood: Rgb, seat: Rgb, high: float, back: str, arms: bool = False, w: float = 0.44
) -> Part:
    """A wooden chair: a "ladder", "spindles" or a "panel" between the posts of its back."""
    d, rise, edge = 0.42, high - SEAT_M, w / 2 - 0.02
    behind: Part = [tube([(x, 0, 0), (x, 0, rise)], 0.02, wood, 6) for x in (-edge, edge)]
    if back == "ladder":
        for i in range(4):
            behind.append(box((w - 0.06, 0.018, 0.055), (0, 0, 0.1 + i * (rise - 0.16) / 3), wood))
    elif back == "spindles":
        for i in range(6):
            x = (i - 2.5) * (w - 0.1) / 6
            behind.append(tube([(x, 0, 0), (x, 0, rise - 0.06)], 0.008, wood, 5))
        behind.append(box((w + 0.02, 0.024, 0.08), (0, 0, rise - 0.08), wood))
    else:
        behind.append(padded((w - 0.05, 0.03, rise - 0.16), (0, 0, 0.14), seat, 0.012))
    parts = [
        *_legs(w - 0.04, d - 0.04, wood, 0.042),
        padded((w, d, 0.045), (0, 0, SEAT_M - 0.02), seat),
        *leaning(behind, BACK_Y, SEAT_M, 8),
    ]
    for s in (-1, 1) if arms else ():
        x, y, z = s * (w / 2 + 0.01), -d / 2 + 0.05, SEAT_M + 0.2
        parts.append(box((0.045, d - 0.02, 0.025), (x, 0.0, z), wood))
        parts.append(tube([(x, y, SEAT_M), (x, y, z)], 0.018, wood))
    return parts


def _dining(cloth: Rgb, wood: Rgb, high: float) -> Part:
    """Upholstered all over, with a high back."""
    back = padded((0.44, 0.09, high - SEAT_M + 0.06), (0, 0, 0), cloth, 0.04)
    return [
        *_legs(0.38, 0.4, wood, 0.045, 0.015),
        padded((0.46, 0.5, 0.12), (0, 0, SEAT_M - 0.07), cloth, 0.04),
        *leaning([back], BACK_Y + 0.01, SEAT_M - 0.06, 9),
    ]


def _office(cloth: Rgb, mesh: Rgb, high: float, arms: bool) -> Part:
    """On a gas spring and a star with five casters."""
    foot = [
        tube([(0, 0, 0.1), (0, -0.3, 0.06)], (0.025, 0.016), c.BLACK, 6),
        ball((0.05, 0.05, 0.06), (0, -0.3, 0), c.CHARCOAL, 5, 8),
    ]
    spine = [(0, 0.1, SEAT_M), (0, 0.27, SEAT_M + 0.02), (0, 0.29, SEAT_M + 0.25)]
    back = bowed((0.25, 0.1), 0.04, [(0, high - SEAT_M - 0.1)] * 2, (15, 165), mesh)
    parts = [
        *around(foot, "z", 5),
        cylinder(0.026, 0.026, 0.34, c.CHROME, 10, (0, 0, 0.09)),
        padded((0.5, 0.48, 0.09), (0, -0.02, SEAT_M - 0.02), cloth, 0.04),
        tube(spine, 0.022, c.BLACK, 6),
        *leaning([back], 0.14, SEAT_M + 0.12, 6),
    ]
    for s in (-1, 1) if arms else ():
        x, rest = s * 0.3, SEAT_M + 0.2
        arm = [(s * 0.22, 0.02, SEAT_M), (x, 0.02, SEAT_M + 0.02), (x, 0.02, rest)]
        parts.append(tube(arm, 0.016, c.BLACK, 6))
        parts.append(padded((0.07, 0.26, 0.03), (x, -0.02, rest), c.BLACK, 0.014))
    return parts


def _shell(colour: Rgb, under: Rgb, sled: bool) -> Part:
    """A moulded bucket on splayed wooden legs or a sled of bent tube."""
    high = SEAT_M - 0.03
    runner = [(0.2, -0.2, high), (0.23, -0.22, 0.012), (0.23, 0.22, 0.012), (0.2, 0.16, high)]
    if sled:
        parts = [tube([(s * x, y, z) for x, y, z in runner], 0.011, under, 6) for s in (-1, 1)]
    else:
        parts = _legs(0.28, 0.28, under, 0.036, 0.09)
    wall = [(SEAT_M, SEAT_M + rise) for rise in (0.1, 0.3, 0.38, 0.3, 0.1)]
    return [
        *parts,
        ball((0.46, 0.44, 0.09), (0, -0.01, SEAT_M - 0.04), colour, 6, 16, 0.6),
        bowed((0.23, 0.2), 0.02, wall, (-15, 195), colour, 0.03),
    ]


def _folding(wood: Rgb) -> Part:
    """Two frames that cross below a slatted seat."""
    parts = Part()
    for s in (-1, 1):
        x = s * 0.2
        parts.append(tube([(x, -0.24, 0), (x, 0.2, 0.86)], 0.016, wood, 6))
        parts.append(tube([(x * 0.88, 0.24, 0), (x * 0.88, -0.18, SEAT_M)], 0.016, wood, 6))
    parts += [box((0.4, 0.055, 0.018), (0, -0.17 + i * 0.07, SEAT_M), wood) for i in range(6)]
    parts += [box((0.4, 0.018, 0.07), (0, 0.13 + i * 0.05, 0.66 + i * 0.1), wood) for i in range(2)]
    return parts


def _cantilever(hide: Rgb, metal: Rgb) -> Part:
    """One bent tube a side, nothing below the back of the seat."""
    path = [(0.22, 0.01), (-0.2, 0.01), (-0.24, 0.05), (-0.22, SEAT_M), (-0.18, SEAT_M + 0.02),
            (0.16, SEAT_M), (0.2, SEAT_M + 0.04), (0.26, 0.86)]  # fmt: skip
    return [
        *[tube([(s * 0.23, y, z) for y, z in path], 0.012, metal, 6) for s in (-1, 1)],
        tube([(-0.23, 0.22, 0.01), (0.23, 0.22, 0.01)], 0.012, metal, 6),
        padded((0.44, 0.4, 0.03), (0, -0.02, SEAT_M), hide, 0.012),
        *leaning([padded((0.44, 0.025, 0.26), (0, 0, 0), hide, 0.012)], 0.22, 0.58, 8),
    ]


def _low(seat: Rgb, metal: Rgb) -> Part:
    """A round seat with a low bent back, as in a cafe."""
    parts = [
        *_legs(0.26, 0.26, metal, 0.026, 0.06),
        cylinder(0.2, 0.21, 0.045, seat, 18, (0, 0, SEAT_M - 0.02)),
        *moved([bowed((0.2, 0.19), 0.025, [(0.2, 0.34)] * 2, (10, 170), seat)], (0, 0, SEAT_M)),
    ]
    for x in (-0.17, 0.17):
        parts.append(tube([(x, 0.08, SEAT_M), (x, 0.1, SEAT_M + 0.3)], 0.011, metal, 5))
    return parts


def chair(k: int) -> Part:
    """Ladder, panel, spindle, two upholstered, two office, two shell, folding, cantilever, cafe."""
    return pick(
        k,
        partial(_framed, c.WOOD, c.WOOD, 0.98, "ladder"),
        partial(_framed, c.WHITE, c.WHITE, 0.88, "panel"),
        partial(_framed, c.DARK_WOOD, c.DARK_WOOD, 0.92, "spindles", w=0.46),
        partial(_dining, c.LINEN, c.OAK, 1.02),
        partial(_dining, c.NAVY, c.BLACK, 0.9),
        partial(_office, c.CHARCOAL, c.BLACK, 1.05, True),
        partial(_office, c.TEAL, shade(c.TEAL, 0.8), 0.9, False),
        partial(_shell, c.WHITE, c.PALE_WOOD, False),
        partial(_shell, c.MUSTARD, c.CHROME, True),
        partial(_folding, c.OAK),
        partial(_cantilever, c.COGNAC, c.CHROME),
        partial(_low, c.RED, c.IRON),
        partial(_framed, c.WALNUT, c.CREAM, 0.86, "panel", arms=True, w=0.5),
        partial(_framed, c.ASH, c.GREY, 1.1, "ladder", arms=True),
    )()
