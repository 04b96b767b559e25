"""Meshes of things with a screen or a plug: televisions, laptops, phones, ovens, lamps."""

from hil_sim.builtin_shapes import (
    DARK,
    GREY,
    NAVY,
    ORANGE,
    STEEL,
    WHITE,
    YELLOW,
    Part,
    Rgb,
    ball,
    box,
    disc,
    lathe,
    moved,
    pick,
    tube,
    turned,
)

SCREEN: Rgb = (0.12, 0.13, 0.16)
PICTURES = (
    (SCREEN, (0.17, 0.18, 0.22), (0.14, 0.15, 0.18)),
    ((0.3, 0.55, 0.85), (0.25, 0.55, 0.25), WHITE),
    ((0.1, 0.15, 0.4), (0.75, 0.3, 0.2), YELLOW),
    (SCREEN, (0.2, 0.21, 0.25), SCREEN),
    ((0.85, 0.6, 0.3), (0.35, 0.2, 0.3), (0.95, 0.9, 0.6)),
    ((0.1, 0.35, 0.38), (0.85, 0.85, 0.8), ORANGE),
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
    w, h, frame = pick(k, (1.0, 0.58, DARK), (1.24, 0.72, DARK), (0.8, 0.47, STEEL),
                       (1.1, 0.64, DARK), (1.0, 0.58, DARK), (0.95, 0.56, WHITE))  # fmt: skip
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
            parts.append(tube(leg, 0.008, STEEL, 6))
    elif k == 5:
        parts += [
            box((w * 0.8, 0.1, 0.055), (0, -0.02, 0), DARK),
            box((0.3, 0.2, 0.012), (0, 0.03, 0), DARK),
        ]
    return parts


def _tube_television() -> Part:
    back = turned([lathe([(0, 0), (0.36, 0), (0.22, 0.22), (0, 0.22)], GREY, 4)], "z", 45)
    return [
        box((0.62, 0.2, 0.52), (0, 0, 0), GREY),
        *moved(turned(back, "x", -90), (0, 0.1, 0.26)),
        ball((0.5, 0.06, 0.38), (-0.03, -0.1, 0.08), SCREEN, 8, 16, 0.35),
        box((0.05, 0.012, 0.34), (0.26, -0.104, 0.1), DARK),
        *moved([disc(0.016, 0.02, STEEL, 10), *moved([disc(0.016, 0.02, STEEL, 10)], (0, 0, 0.07))],
               (0.26, -0.115, 0.3)),
        *[tube([(0, 0.02, 0.5), (side * 0.2, 0.02, 0.78)], 0.003, STEEL, 4) for side in (-1, 1)],
    ]  # fmt: skip


def laptop(k: int) -> Part:
    """Opened, its screen looking along -y."""
    body, keys = pick(k, (STEEL, DARK), (DARK, GREY), (WHITE, STEEL), ((0.8, 0.7, 0.58), DARK),
                      (NAVY, DARK), (GREY, WHITE))  # fmt: skip
    w, d = pick(k, (0.34, 0.235), (0.38, 0.26), (0.31, 0.215))
    tilt = pick(k, 18, 12, 28, 20, 8, 24)
    parts = [
        box((w, d, 0.016), (0, 0, 0), body),
        box((w * 0.3, d * 0.28, 0.002), (0, -d * 0.3, 0.0155), GREY if body != GREY else STEEL),
    ]
    for row in range(5):
        at = (0, d * (0.4 - 0.11 * row), 0.016)
        parts.append(box((w * 0.88, d * 0.085, 0.003), at, keys))
    lid = [
        box((w, 0.008, d * 0.95), (0, 0, 0), body),
        *moved([box((w * 0.95, 0.003, d * 0.86), (0, 0, 0), DARK)], (0, -0.005, 0.008)),
    ]
    lid += moved(screen(pick(k, 1, 5, 4, 2, 1, 4), w * 0.9, d * 0.78), (0, -0.0085, 0.014))
    return [*parts, *moved(turned(lid, "x", -tilt), (0, d / 2 - 0.004, 0.014))]
