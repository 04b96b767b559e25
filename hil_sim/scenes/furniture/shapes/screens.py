"""Meshes of things with a screen, a key or a loudspeaker."""

from hil_sim.scenes.furniture.shapes import palette as c
from hil_sim.scenes.furniture.shapes.palette import Rgb
from hil_sim.scenes.furniture.shapes.primitives import (
    Part,
    ball,
    box,
    cylinder,
    disc,
    lathe,
    moved,
    pick,
    ring,
    tube,
    turned,
)

SCREEN: Rgb = (0.12, 0.13, 0.16)


PICTURES = (
    (SCREEN, (0.17, 0.18, 0.22), (0.14, 0.15, 0.18)),
    ((0.3, 0.55, 0.85), (0.25, 0.55, 0.25), c.WHITE),
    ((0.1, 0.15, 0.4), (0.75, 0.3, 0.2), c.YELLOW),
    (SCREEN, (0.2, 0.21, 0.25), SCREEN),
    ((0.85, 0.6, 0.3), (0.35, 0.2, 0.3), (0.95, 0.9, 0.6)),
    ((0.1, 0.35, 0.38), (0.85, 0.85, 0.8), c.ORANGE),
)
"""Upper part, lower part and a shape in front: what a screen shows; a dark one is off."""


def screen(k: int, w: float, h: float) -> Part:
    """A picture w x h that looks along -y, its underside's middle on the origin."""
    above, below, shape = PICTURES[k % len(PICTURES)]
    return [
        box((w, 0.004, h), (0, 0, 0), above),
        box((w, 0.002, h * 0.38), (0, -0.003, 0), below),
        box((w * 0.24, 0.002, h * 0.4), (w * pick(k, -0.2, 0.15, 0.25), -0.0045, h * 0.25), shape),
    ]


def television(k: int) -> Part:
    """Flat on a foot (0, 2), on two feet (1), for a wall (3), with a sound bar (5); a tube (4)."""
    if k == 4:
        return _tube_television()
    w, h, frame = pick(k, (1.0, 0.58, c.DARK), (1.24, 0.72, c.DARK), (0.8, 0.47, c.STEEL),
                       (1.1, 0.64, c.DARK), (1.0, 0.58, c.DARK), (0.95, 0.56, c.WHITE))  # fmt: skip
    foot = 0.0 if k == 3 else 0.06
    parts = [box((w, 0.05, h), (0, 0, foot), frame)]
    parts += moved(screen(pick(k, 0, 1, 2, 3, 4, 5), w - 0.05, h - 0.06), (0, -0.027, foot + 0.03))
    if k in (0, 2):
        parts += [
            box((w * 0.4, 0.22, 0.02), (0, 0, 0), frame),
            box((0.08, 0.04, 0.06), (0, 0.01, 0.01), frame),
        ]
    elif k == 1:
        for side in (-0.4, 0.4):
            leg = [(side * w, -0.12, 0.008), (side * w, 0, foot), (side * w, 0.12, 0.008)]
            parts.append(tube(leg, 0.008, c.STEEL, 6))
    elif k == 5:
        parts += [
            box((w * 0.8, 0.1, 0.055), (0, -0.02, 0), c.DARK),
            box((0.3, 0.2, 0.012), (0, 0.03, 0), c.DARK),
        ]
    return parts


def _tube_television() -> Part:
    back = turned([lathe([(0, 0), (0.36, 0), (0.22, 0.22), (0, 0.22)], c.GREY, 4)], "z", 45)
    return [
        box((0.62, 0.2, 0.52), (0, 0, 0), c.GREY),
        *moved(turned(back, "x", -90), (0, 0.1, 0.26)),
        ball((0.5, 0.06, 0.38), (-0.03, -0.1, 0.08), SCREEN, 8, 16, 0.35),
        box((0.05, 0.012, 0.34), (0.26, -0.104, 0.1), c.DARK),
        *moved([disc(0.016, 0.02, c.STEEL, 10),
                *moved([disc(0.016, 0.02, c.STEEL, 10)], (0, 0, 0.07))],
               (0.26, -0.115, 0.3)),
        *[tube([(0, 0.02, 0.5), (side * 0.2, 0.02, 0.78)], 0.003, c.STEEL, 4) for side in (-1, 1)],
    ]  # fmt: skip


def laptop(k: int) -> Part:
    """Opened, its screen looking along -y."""
    body, keys = pick(k, (c.STEEL, c.DARK), (c.DARK, c.GREY), (c.WHITE, c.STEEL),
                      ((0.8, 0.7, 0.58), c.DARK),
                      (c.NAVY, c.DARK), (c.GREY, c.WHITE))  # fmt: skip
    w, d = pick(k, (0.34, 0.235), (0.38, 0.26), (0.31, 0.215))
    tilt = pick(k, 18, 12, 28, 20, 8, 24)
    parts = [
        box((w, d, 0.016), (0, 0, 0), body),
        box(
            (w * 0.3, d * 0.28, 0.002), (0, -d * 0.3, 0.0155), c.GREY if body != c.GREY else c.STEEL
        ),
    ]
    for row in range(5):
        at = (0, d * (0.4 - 0.11 * row), 0.016)
        parts.append(box((w * 0.88, d * 0.085, 0.003), at, keys))
    lid = [
        box((w, 0.008, d * 0.95), (0, 0, 0), body),
        *moved([box((w * 0.95, 0.003, d * 0.86), (0, 0, 0), c.DARK)], (0, -0.005, 0.008)),
    ]
    lid += moved(screen(pick(k, 1, 5, 4, 2, 1, 4), w * 0.9, d * 0.78), (0, -0.0085, 0.014))
    return [*parts, *moved(turned(lid, "x", -tilt), (0, d / 2 - 0.004, 0.014))]


def computer_monitor(k: int) -> Part:
    """On a foot, some with a keyboard before it."""
    frame = pick(k, c.DARK, c.STEEL, c.WHITE, c.DARK, c.GREY, c.DARK)
    w, h = pick(k, (0.54, 0.33), (0.62, 0.37), (0.5, 0.32), (0.8, 0.36))
    parts = [
        box((w, 0.03, h), (0, 0, 0.14), frame),
        *moved(screen(pick(k, 1, 5, 2, 4, 0, 5), w - 0.03, h - 0.04), (0, -0.017, 0.16)),
        box((0.05, 0.03, 0.2), (0, 0.025, 0.02), frame),
    ]
    parts += (
        [box((0.24, 0.2, 0.012), (0, 0.01, 0), frame)]
        if k % 2
        else [cylinder(0.11, 0.1, 0.014, frame, 20)]
    )
    return [*parts, *(moved(keyboard(k), (0, -0.24, 0)) if k in (1, 4) else [])]


def keyboard(k: int) -> Part:
    """A computer's keyboard."""
    body, key = pick(
        k,
        (c.DARK, c.GREY),
        (c.WHITE, c.STEEL),
        (c.STEEL, c.DARK),
        (c.GREY, c.WHITE),
        (c.DARK, c.TEAL),
        (c.NAVY, c.WHITE),
    )
    rows = [box((0.4, 0.018, 0.006), (0, 0.045 - 0.022 * i, 0.016), key) for i in range(4)] + [
        box((0.16, 0.018, 0.006), (-0.02, -0.043, 0.016), key)
    ]
    gaps = [box((0.004, 0.13, 0.0015), (-0.19 + 0.02 * i, 0, 0.0212), body) for i in range(20)]
    return [box((0.44, 0.14, 0.017), (0, 0, 0), body), *rows, *gaps[::2]]


def printer(k: int) -> Part:
    """Paper behind, a tray before."""
    body, trim = pick(
        k,
        (c.WHITE, c.DARK),
        (c.DARK, c.GREY),
        (c.GREY, c.WHITE),
        (c.STEEL, c.DARK),
        (c.CREAM, c.GREY),
        (c.DARK, c.WHITE),
    )
    w, d, h = pick(k, (0.44, 0.34, 0.18), (0.42, 0.36, 0.25), (0.4, 0.3, 0.15))
    sheet = moved(
        turned([box((0.22, 0.004, 0.2), (0, 0, 0), c.WHITE)], "x", -20), (0, d * 0.4, h - 0.02)
    )
    return [
        ball((w, d, h), (0, 0, 0), body, 8, 20, 0.2),
        box(
            (w * 0.68, 0.02, h * 0.28),
            (0, -d / 2 + 0.005, h * 0.2),
            c.DARK if body != c.DARK else c.GREY,
        ),
        box((w * 0.6, 0.14, 0.012), (0, -d / 2 - 0.05, h * 0.2), trim),
        box((0.2, 0.12, 0.002), (0, -d / 2 - 0.04, h * 0.2 + 0.012), c.WHITE),
        *sheet,
        box((w * 0.18, 0.05, 0.008), (-w * 0.33, -d * 0.36, h - 0.003), (0.2, 0.5, 0.7)),
        *[
            ball(
                (0.018, 0.018, 0.012),
                (w * 0.24 + 0.03 * i, -d * 0.36, h - 0.006),
                pick(i, c.GREEN, c.RED),
                4,
                8,
            )
            for i in range(3)
        ],
        box((w * 0.9, d * 0.5, 0.006), (0, d * 0.04, h - 0.002), trim),
    ]


def speaker(k: int) -> Part:
    """A box with two cones."""
    body, cone = pick(
        k,
        (c.DARK_WOOD, c.DARK),
        (c.DARK, c.GREY),
        (c.WOOD, c.DARK),
        (c.WHITE, c.DARK),
        (c.RED, c.DARK),
        (c.GREY, c.YELLOW),
    )
    w, d, h = pick(k, (0.22, 0.25, 0.38), (0.25, 0.3, 0.95), (0.18, 0.2, 0.28))
    r = w * 0.38
    parts = [box((w, d, h), (0, 0, 0), body)]
    for radius, z in ((r, h * 0.33), (r * 0.5, h * 0.78)):
        ring_ = turned([ring(radius, 0.008, c.STEEL, "xy", 20, 4)], "x", 90)
        parts += moved(
            [
                *ring_,
                disc(radius, 0.01, cone, 20),
                *moved(
                    [
                        ball(
                            (radius * 0.7, 0.02, radius * 0.7),
                            (0, 0, -radius * 0.35),
                            c.GREY if cone != c.GREY else c.DARK,
                            5,
                            10,
                        )
                    ],
                    (0, -0.006, 0),
                ),
            ],
            (0, -d / 2, z),
        )
    return parts


def radio(k: int) -> Part:
    """A portable one: a grille, a dial, knobs, a handle, an aerial."""
    body, grille = pick(
        k,
        (c.RED, c.CREAM),
        (c.WOOD, c.CREAM),
        (c.TEAL, c.WHITE),
        (c.DARK, c.STEEL),
        (c.CREAM, c.WOOD),
        (c.BLUE, c.GREY),
    )
    w, d, h = pick(k, (0.3, 0.1, 0.18), (0.26, 0.11, 0.16))
    slots = [
        box((w * 0.4, 0.006, 0.006), (-w * 0.22, -d / 2 - 0.006, h * (0.18 + 0.11 * i)), c.DARK)
        for i in range(6)
    ]
    knobs = moved(
        [disc(0.022, 0.03, c.STEEL, 12), *moved([disc(0.022, 0.03, c.STEEL, 12)], (0.07, 0, 0))],
        (w * 0.12, -d / 2 - 0.01, h * 0.28),
    )
    return [
        ball((w, d, h), (0, 0, 0), body, 8, 18, 0.25),
        box((w * 0.46, 0.012, h * 0.74), (-w * 0.22, -d / 2, h * 0.12), grille),
        *slots,
        box((w * 0.36, 0.012, h * 0.26), (w * 0.24, -d / 2, h * 0.56), (0.95, 0.9, 0.7)),
        box((0.004, 0.004, h * 0.2), (w * 0.2, -d / 2 - 0.008, h * 0.59), c.RED),
        *knobs,
        tube(
            [
                (-w * 0.35, 0, h - 0.01),
                (-w * 0.33, 0, h + 0.04),
                (w * 0.33, 0, h + 0.04),
                (w * 0.35, 0, h - 0.01),
            ],
            0.008,
            c.DARK,
            6,
        ),
        tube([(w * 0.4, 0.03, h - 0.01), (w * 0.62, 0.03, h + 0.22)], 0.003, c.STEEL, 5),
    ]


def game_console(k: int) -> Part:
    """A flat box with two pads."""
    body, light = pick(
        k,
        (c.DARK, c.BLUE),
        (c.WHITE, c.DARK),
        (c.GREY, c.GREEN),
        (c.DARK, c.RED),
        (c.WHITE, c.TEAL),
        (c.NAVY, c.YELLOW),
    )
    pads: Part = []
    for s in (-1, 1):
        pad = [
            box((0.09, 0.05, 0.025), (0, 0, 0.008), body),
            *[ball((0.05, 0.08, 0.035), (x, -0.015, 0), body, 5, 8) for x in (-0.05, 0.05)],
            *[
                cylinder(
                    0.009, 0.009, 0.012, c.GREY if body != c.GREY else c.DARK, 8, (x, -0.008, 0.03)
                )
                for x in (-0.025, 0.025)
            ],
            *[
                ball(
                    (0.01, 0.01, 0.008),
                    (0.05 + dx, 0.0 + dy, 0.03),
                    pick(i, c.RED, c.BLUE, c.YELLOW, c.GREEN),
                    4,
                    6,
                )
                for i, (dx, dy) in enumerate(((0.01, 0), (-0.01, 0), (0, 0.01), (0, -0.01)))
            ],
        ]
        pads += moved(turned(pad, "z", s * 15), (s * 0.1, -0.2, 0))
    return [
        box((0.3, 0.26, 0.055), (0, 0, 0), body),
        box((0.304, 0.264, 0.006), (0, 0, 0.025), light),
        box((0.14, 0.004, 0.006), (-0.05, -0.131, 0.04), c.GREY),
        *pads,
    ]
