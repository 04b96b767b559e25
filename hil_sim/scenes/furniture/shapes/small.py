"""Meshes of small things that lie about a home."""

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
    slab,
    tube,
    turned,
    vessel,
)


def remote_control(k: int) -> Part:
    """Lying, along y, its keys above."""
    body, key = pick(
        k,
        (c.DARK, c.WHITE),
        (c.GREY, c.DARK),
        (c.WHITE, c.GREY),
        (c.DARK, c.GREY),
        (c.STEEL, c.DARK),
        (c.NAVY, c.CREAM),
    )
    w, d = pick(k, (0.05, 0.2), (0.055, 0.17), (0.042, 0.16), (0.06, 0.22))
    keys = [
        box((w * 0.18, 0.009, 0.004), (w * 0.28 * x, d * (0.02 + 0.07 * y) - d * 0.25, 0.02), key)
        for x in (-1, 0, 1)
        for y in range(5)
    ]
    return [
        box((w, d, 0.02), (0, 0, 0), body),
        *keys,
        cylinder(w * 0.3, w * 0.28, 0.004, key, 12, (0, d * 0.22, 0.02)),
        cylinder(0.006, 0.006, 0.005, c.RED, 8, (w * 0.28, d * 0.42, 0.02)),
        box((w * 0.3, 0.01, 0.004), (-w * 0.2, d * 0.42, 0.02), c.GREEN),
    ]


def cell_phone(k: int) -> Part:
    """Lying on its back, its screen above; some are lit."""
    body, glass = pick(
        k,
        (c.DARK, (0.1, 0.1, 0.13)),
        (c.WHITE, (0.3, 0.5, 0.8)),
        (c.BLUE, c.DARK),
        (c.RED, (0.15, 0.15, 0.2)),
        (c.STEEL, (0.8, 0.45, 0.35)),
        (c.PINK, (0.1, 0.1, 0.13)),
    )
    w, d = pick(k, (0.072, 0.148), (0.078, 0.16), (0.066, 0.135))
    icons = [
        box(
            (0.01, 0.01, 0.0006),
            (w * 0.25 * x, -d * 0.3 + 0.022 * y, 0.0105),
            pick(x + y + k, c.YELLOW, c.WHITE, c.GREEN, c.RED),
        )
        for x in (-1, 0, 1)
        for y in range(3)
    ]
    return [
        box((w, d, 0.009), (0, 0, 0), body),
        box((w - 0.008, d - 0.01, 0.0012), (0, 0, 0.0088), glass),
        *(icons if k in (1, 4) else []),
        box((0.014, 0.003, 0.0008), (0, d * 0.46, 0.0098), c.GREY),
    ]


def pencil(k: int) -> Part:
    """Lying, along y."""
    paint = pick(k, c.YELLOW, c.RED, c.BLUE, c.GREEN, c.ORANGE, c.PURPLE)
    r, length = 0.0042, pick(k, 0.19, 0.16, 0.175)
    parts = [
        lathe([(0, 0), (r, 0), (r, 0.012)], c.PINK, 6),
        lathe([(r, 0.012), (r, 0.022)], c.STEEL, 6),
        lathe([(r, 0.022), (r, length - 0.02)], paint, 6),
        lathe([(r, length - 0.02), (0.0012, length - 0.004)], c.PALE_WOOD, 6),
        lathe([(0.0014, length - 0.005), (0, length)], c.DARK, 6),
    ]
    return turned(parts, "x", 90)


def pen(k: int) -> Part:
    """Lying, along y, with a clip."""
    body, cap = pick(
        k,
        (c.WHITE, c.BLUE),
        (c.DARK, c.BRASS),
        (c.STEEL, c.STEEL),
        (c.BLUE, c.BLUE),
        (c.RED, c.WHITE),
        (c.GREEN, c.DARK),
    )
    r, length = 0.005, pick(k, 0.145, 0.135)
    parts = [
        lathe([(0, 0), (r, 0.002), (r, 0.06)], cap, 8),
        lathe(
            [(r * 0.92, 0.055), (r * 0.92, length - 0.015), (0.0015, length), (0, length)], body, 8
        ),
        box((0.003, 0.003, 0.045), (0, -r - 0.0012, 0.006), c.STEEL if cap != c.STEEL else c.DARK),
    ]
    return turned(parts, "x", 90)


def book(k: int) -> Part:
    """Lying closed (0, 3), a pile (1, 4), open (2), standing (5)."""
    cover, other, third = pick(
        k,
        (c.RED, c.BLUE, c.GREEN),
        (c.NAVY, c.CREAM, c.ORANGE),
        (c.DARK_WOOD, c.WHITE, c.RED),
        (c.GREEN, c.RED, c.BLUE),
        (c.PURPLE, c.YELLOW, c.TEAL),
        (c.BLUE, c.WHITE, c.DARK),
    )
    if k == 2:
        left = _closed_book(0.15, 0.22, 0.012, cover)
        pages = [slab([(0.0, -0.1), (0.14, -0.1), (0.14, 0.1), (0.0, 0.1)], 0.012, c.CREAM, 0.005)]
        return [
            box((0.3, 0.22, 0.004), (0, 0, 0), cover),
            *turned(pages, "y", -3),
            *turned(turned(pages, "y", -3), "z", 180),
            *[
                box((0.1, 0.004, 0.001), (side * 0.07, 0.07 - 0.02 * i, 0.0205), c.GREY)
                for side in (-1, 1)
                for i in range(7)
            ],
            *left[:0],
        ]
    one = _closed_book(
        pick(k, 0.15, 0.16, 0.14), pick(k, 0.22, 0.23, 0.2), pick(k, 0.035, 0.03), cover, third
    )
    if k in (1, 4):
        two, three = (
            _closed_book(0.14, 0.21, 0.025, other, cover),
            _closed_book(0.13, 0.19, 0.04, third, other),
        )
        return [
            *one,
            *moved(turned(two, "z", 12), (0, 0, 0.03)),
            *moved(turned(three, "z", -8), (0, 0, 0.055)),
        ]
    return turned(one, "y", 90) if k == 5 else one


def _closed_book(w: float, d: float, h: float, cover: Rgb, title: Rgb = c.WHITE) -> Part:
    return [
        box((w, d, 0.003), (0, 0, 0), cover),
        box((w, d, 0.003), (0, 0, h - 0.003), cover),
        box((0.004, d, h), (-w / 2, 0, 0), cover),
        box((w - 0.008, d - 0.01, h - 0.006), (-0.003, 0, 0.003), c.CREAM),
        box((w * 0.6, d * 0.12, 0.001), (0, d * 0.22, h - 0.0004), title),
        box((w * 0.35, d * 0.3, 0.001), (0, -d * 0.12, h - 0.0004), title),
    ]


def candle(k: int) -> Part:
    """In a holder, in a glass, or by itself."""
    wax = pick(k, c.CREAM, c.RED, c.WHITE, c.GREEN, c.PURPLE, c.YELLOW)
    r, h = pick(k, (0.035, 0.1), (0.012, 0.2), (0.04, 0.07))
    stick = [
        cylinder(r, r * 0.97, h, wax, 14),
        cylinder(0.0015, 0.0015, 0.012, c.DARK, 5, (0, 0, h)),
        ball((0.01, 0.01, 0.024), (0, 0, h + 0.008), c.ORANGE, 6, 6),
    ]
    if k % 3 == 0:
        return [*stick, cylinder(r * 1.6, r * 1.7, 0.008, pick(k, c.BRASS, c.STEEL, c.WOOD), 16)]
    if k % 3 == 1:
        metal = pick(k, c.DARK, c.BRASS, c.STEEL)
        return [
            lathe(
                [
                    (0, 0),
                    (0.045, 0),
                    (0.045, 0.006),
                    (0.01, 0.015),
                    (0.008, 0.06),
                    (0.018, 0.07),
                    (0.018, 0.085),
                    (0, 0.085),
                ],
                metal,
                14,
            ),
            *moved(stick, (0, 0, 0.08)),
        ]
    return [
        *moved(stick, (0, 0, 0.006)),
        *vessel([(0.045, 0), (0.047, 0.075)], pick(k, c.TEAL, (0.7, 0.8, 0.82)), None, 0.003, 16),
    ]


def newspaper(k: int) -> Part:
    """Folded (even) or rolled (odd), lying."""
    paper = pick(k, (0.86, 0.85, 0.8), (0.9, 0.89, 0.86), (0.88, 0.82, 0.74))
    if k % 2:
        roll = turned(
            [
                cylinder(0.03, 0.03, 0.3, paper, 14, (0, 0, -0.15)),
                cylinder(0.0305, 0.0305, 0.02, pick(k, c.RED, c.RED, c.BLUE), 14, (0, 0, -0.01)),
            ],
            "y",
            90,
        )
        lines = [
            box((0.1, 0.002, 0.004), (x, -0.03, z), c.GREY)
            for x in (-0.08, 0.08)
            for z in (-0.008, 0, 0.008)
        ]
        return roll + lines
    w, d = pick(k, 0.28, 0.0, 0.3, 0.0, 0.26), 0.22
    parts = [
        box((w, d, 0.006), (0, 0, 0), paper),
        box((w, d * 0.97, 0.006), (0.004, 0.003, 0.006), paper),
        box((w * 0.86, 0.026, 0.001), (0, d * 0.38, 0.0118), c.DARK),
        box((w * 0.4, d * 0.35, 0.001), (-w * 0.23, 0.0, 0.0118), pick(k, c.GREY, c.BLUE, c.GREEN)),
    ]
    parts += [
        box((w * 0.4, 0.004, 0.001), (w * 0.23, d * 0.22 - 0.011 * i, 0.0118), c.GREY)
        for i in range(13)
    ]
    return parts + [
        box((w * 0.4, 0.004, 0.001), (-w * 0.23, -d * 0.24 - 0.011 * i, 0.0118), c.GREY)
        for i in range(4)
    ]


def watch(k: int) -> Part:
    """A wrist watch, closed and standing on its strap."""
    strap, case, face = pick(
        k,
        (c.DARK, c.STEEL, c.WHITE),
        (c.DARK_WOOD, c.BRASS, c.CREAM),
        (c.STEEL, c.STEEL, c.NAVY),
        (c.BLUE, c.DARK, c.DARK),
        (c.RED, c.STEEL, c.WHITE),
        (c.GREEN, c.BRASS, c.DARK),
    )
    band = scaled([tube(arc((0, 0, 0), 0.03, 0, 360, "yz", 20), 0.0025, strap, 4)], (4, 0.85, 1))
    dial = [
        cylinder(0.02, 0.02, 0.008, case, 18),
        cylinder(0.0165, 0.0165, 0.0012, face, 18, (0, 0, 0.008)),
        box((0.0025, 0.012, 0.001), (0, 0.005, 0.0092), c.RED),
        box((0.01, 0.0025, 0.001), (0.004, 0, 0.0092), c.GREY),
        box((0.006, 0.005, 0.004), (0.021, 0, 0.002), case),
    ]
    return [*band, *moved(dial, (0, 0, 0.029))]


def cd(k: int) -> Part:
    """A disc (even) or a case (odd), lying."""
    tint = pick(k, (0.75, 0.8, 0.85), c.BLUE, (0.8, 0.75, 0.85), c.RED, (0.85, 0.82, 0.6), c.TEAL)
    disk = [
        *vessel([(0.02, 0), (0.06, 0), (0.06, 0.0015), (0.02, 0.0016)], tint, None, 0.001, 28),
        lathe([(0.022, 0.0022), (0.0075, 0.0022)], c.WHITE, 20),
        lathe([(0.0075, 0.0022), (0, 0.0021)], c.DARK, 12),
    ]
    if k % 2 == 0:
        shine = [
            slab(
                [(0.024, -0.004), (0.058, -0.011), (0.058, 0.011), (0.024, 0.004)],
                0.0006,
                colour,
                0.0018,
            )
            for colour in (c.PINK, c.GREEN)
        ]
        return [*disk, *turned(shine[:1], "z", 40), *turned(shine[1:], "z", 220)]
    return [
        box((0.142, 0.125, 0.01), (0, 0, 0), c.GREY),
        box((0.125, 0.12, 0.001), (0.006, 0, 0.0095), tint),
        box((0.07, 0.02, 0.001), (0, 0.03, 0.0102), c.WHITE),
        cylinder(0.025, 0.025, 0.001, c.YELLOW, 14, (0.01, -0.02, 0.01)),
    ]
