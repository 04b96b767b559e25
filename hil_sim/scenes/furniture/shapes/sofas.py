"""Meshes of sofas, each variant a type of its own; they look along -y."""

from collections.abc import Callable
from functools import partial

import numpy as np

from hil_sim.scenes.furniture.shapes import palette as c
from hil_sim.scenes.furniture.shapes.palette import Rgb
from hil_sim.scenes.furniture.shapes.primitives import (
    Part,
    ball,
    box,
    cylinder,
    moved,
    pick,
    shade,
    tube,
    turned,
)
from hil_sim.scenes.furniture.shapes.soft import leaning, padded, pillow, swept

SEAT_M = 0.42


def stubs(w: float, d: float, h: float, wood: Rgb, thick: float = 0.05, splay: float = 0) -> Part:
    """Four tapered legs; `splay` is how far each foot stands out."""
    return [
        tube(
            [(x * w / 2 + sx, y * d / 2 + sy, 0), (x * w / 2, y * d / 2, h)],
            (thick * 0.35, thick / 2),
            wood,
            8,
        )
        for x, y, sx, sy in ((a, b, a * splay, b * splay * 0.6) for a in (-1, 1) for b in (-1, 1))
    ]


def _seat_row(w: float, d: float, n: int, cloth: Rgb, z: float, y: float, h: float = 0.15) -> Part:
    """`n` cushions side by side, their undersides at `z`."""
    each = w / n
    return [
        padded((each - 0.008, d, h), ((i - (n - 1) / 2) * each, y, z), cloth, 0.045)
        for i in range(n)
    ]


def _back_row(
    w: float,
    n: int,
    cloth: Rgb,
    z: float,
    y: float,
    h: float,
    thick: float = 0.17,
    lean: float = 12,
) -> Part:
    """`n` upright cushions that lean against the back."""
    each = w / n
    parts: Part = []
    for i in range(n):
        soft = ball((each - 0.004, thick, h), (0, 0, 0), cloth, 8, 16, 0.32)
        parts += moved(leaning([soft], y, z, lean), ((i - (n - 1) / 2) * each, 0, 0))
    return parts


def couch(
    w: float,
    d: float,
    h: float,
    n: int,
    cloth: Rgb,
    foot: tuple[float, Rgb],
    arm: tuple[float, float],
    loose: bool = True,
    cushions: tuple[Rgb, ...] = (),
    round_m: float = 0.04,
    backs: int = 0,
) -> Part:
    """A plain sofa: `n` seats, arms (width, height), feet (height, colour), some cushions on it."""
    low, (arm_w, arm_h) = foot[0], arm
    inner = w - 2 * arm_w
    back = 0.2
    parts = [
        *stubs(w - 0.16, d - 0.16, low + 0.02, foot[1]),
        padded((w - 0.02, d - 0.04, SEAT_M - 0.14 - low), (0, 0, low), shade(cloth, 0.93), 0.02),
        *[
            padded((arm_w, d - 0.02, arm_h - low), (s * (w - arm_w) / 2, 0, low), cloth, round_m)
            for s in (-1, 1)
        ],
        *_seat_row(inner, d - back + 0.01, n, cloth, SEAT_M - 0.15, -back / 2 - 0.01),
    ]
    if loose:
        parts.append(
            padded((inner + 0.04, back, h - 0.1 - low), (0, (d - back) / 2, low), cloth, 0.05)
        )
        parts += _back_row(inner, backs or n, cloth, SEAT_M - 0.02, d / 2 - 0.27, h - SEAT_M + 0.02)
    else:
        parts.append(padded((w, back, h - low), (0, (d - back) / 2, low), cloth, round_m))
        tall = h - SEAT_M - 0.05
        parts += _back_row(inner, backs or n, cloth, SEAT_M, d / 2 - 0.23, tall, 0.1, 6)
    for i, colour in enumerate(cushions):
        side = (-1, 1)[i % 2]
        x = side * (inner / 2 - 0.26 - 0.2 * (i // 2))
        parts += pillow(
            (0.44, 0.42, 0.14), (x, d / 2 - 0.42 - 0.05 * (i // 2), SEAT_M + 0.19), colour, 66,
            side * -(12 + 9 * (i // 2)),
        )  # fmt: skip
    return parts


DEEP_M, LONG_M = 0.92, 0.88
"""Of a corner sofa: how deep the seats along the back are, how wide the long one is."""
LOW_M, BACK_M, ARM_M = 0.08, 0.2, 0.2
"""Of a corner sofa: its feet's height, thickness of the back and of the arm."""


def _corner_frame(w: float, d: float, h: float, cloth: Rgb, side: int) -> Part:
    """What an L's cushions lie on: feet, two bases, the back and the arm beside the short end."""
    x_long, y_seat = side * (w - LONG_M) / 2, d / 2 - DEEP_M / 2
    return [
        *moved(stubs(w - 0.2, DEEP_M - 0.2, LOW_M + 0.03, c.BLACK), (0, y_seat, 0)),
        *moved(stubs(LONG_M - 0.2, d - 0.2, LOW_M + 0.03, c.BLACK), (x_long, 0, 0)),
        padded((w, DEEP_M - 0.03, 0.22), (0, y_seat, LOW_M), shade(cloth, 0.93), 0.02),
        padded((LONG_M - 0.01, d - 0.02, 0.22), (x_long, 0, LOW_M), shade(cloth, 0.93), 0.02),
        padded((w, BACK_M, h - 0.12 - LOW_M), (0, d / 2 - BACK_M / 2, LOW_M), cloth, 0.05),
        padded((ARM_M, DEEP_M, 0.52), (-side * (w - ARM_M) / 2, y_seat, LOW_M), cloth, 0.05),
    ]


def _corner(
    w: float, d: float, h: float, cloth: Rgb, side: int, arm: bool, cushions: tuple[Rgb, ...]
) -> Part:
    """An L: a sofa along the back with a long seat at one end, with a back of its own (`arm`)."""
    wide, x_wide = w - LONG_M - ARM_M, side * (ARM_M - LONG_M) / 2
    rest = LONG_M - (BACK_M if arm else 0)
    x_rest = side * (w - LONG_M) / 2 - side * (BACK_M / 2 if arm else 0)
    y_seat = d / 2 - DEEP_M / 2 - BACK_M / 2
    low, tall = SEAT_M - 0.02, h - SEAT_M + 0.02
    short = _seat_row(wide, DEEP_M - BACK_M, 2, cloth, SEAT_M - 0.15, y_seat)
    parts = [
        *_corner_frame(w, d, h, cloth, side),
        *moved(short, (x_wide, 0, 0)),
        *moved(_back_row(wide, 2, cloth, low, d / 2 - 0.28, tall), (x_wide, 0, 0)),
        padded((rest, d - BACK_M, 0.15), (x_rest, -BACK_M / 2, SEAT_M - 0.15), cloth, 0.045),
        *moved(_back_row(rest, 1, cloth, low, d / 2 - 0.28, tall), (x_rest, 0, 0)),
    ]
    if arm:
        x = side * (w - BACK_M) / 2
        parts.append(padded((BACK_M, d - 0.02, h - 0.12 - LOW_M), (x, 0, LOW_M), cloth, 0.05))
        rows = _back_row(d - 0.5, 1, cloth, low, -0.08, tall)
        parts += moved(turned(rows, "z", -90 * side), (x - side * 0.08, -0.16, 0))
    for i, colour in enumerate(cushions):
        x = x_rest if i == 0 else x_wide - side * wide * 0.3
        parts += pillow(
            (0.46, 0.44, 0.15), (x, d / 2 - 0.46, SEAT_M + 0.19), colour, 64, 14 * side * (i - 0.5)
        )
    return parts


def _rolled(w: float, d: float, h: float, n: int, hide: Rgb, wood: Rgb) -> Part:
    """A chesterfield: back and arms one height, rolled outward, buttons in rows."""
    r, low = 0.1, 0.1
    inner = w - 4 * r - 0.04
    dark, z = shade(hide, 0.6), h - 2 * r
    front = -d / 2 + 0.04
    rolls = [
        tube([(s * (w / 2 - r), front, z + r), (s * (w / 2 - r), d / 2 - r, z + r)], r, hide, 14)
        for s in (-1, 1)
    ]
    faces = [
        moved(turned([cylinder(0.06, 0.05, 0.012, dark, 12)], "x", 90),
              (s * (w / 2 - r), front, z + r))[0]
        for s in (-1, 1)
    ]  # fmt: skip
    buttons = [
        ball((0.03, 0.02, 0.03), (x, d / 2 - 0.235 - 0.012 * row, SEAT_M + up), dark, 4, 6)
        for row, up in enumerate((0.08, 0.18))
        for x in np.arange(-inner / 2 + 0.1 + 0.07 * row, inner / 2 - 0.04, 0.15)
    ]  # fmt: skip
    return [
        *stubs(w - 0.25, d - 0.2, low + 0.02, wood, 0.09),
        padded((w - 2 * r, d - 0.06, SEAT_M - 0.13 - low), (0, 0, low), hide, 0.02),
        *[padded((0.17, d - 0.09, z + r - low), (s * (w / 2 - 0.135), 0, low), hide, 0.02)
          for s in (-1, 1)],
        padded((w - 0.2, 0.2, z + r - low), (0, d / 2 - 0.14, low), hide, 0.02),
        tube([(-w / 2 + r, d / 2 - r, z + r), (w / 2 - r, d / 2 - r, z + r)], r, hide, 14),
        *rolls,
        *faces,
        *buttons,
        *_seat_row(inner + 0.08, d - 0.25, n, shade(hide, 1.08), SEAT_M - 0.14, -0.1),
    ]  # fmt: skip


def airy(w: float, d: float, h: float, n: int, cloth: Rgb, wood: Rgb) -> Part:
    """A frame of thin wood: posts, a rail for the arm, splayed legs, cushions on top."""
    x = w / 2 - 0.025
    arm = 0.6
    side: Part = []
    for s in (-1, 1):
        side += [
            tube([(s * x, -d / 2 + 0.05, 0), (s * (x - 0.01), -d / 2 + 0.1, arm)], 0.021, wood, 8),
            tube([(s * x, d / 2 - 0.02, 0), (s * (x - 0.01), d / 2 - 0.14, arm)], 0.021, wood, 8),
            padded((0.05, d - 0.12, 0.028), (s * (x - 0.01), -0.04, arm - 0.01), wood, 0.012),
            box((0.03, d - 0.2, 0.06), (s * (x - 0.01), 0, 0.24), wood),
        ]
    inner = w - 0.11
    slats = [
        tube([(t, d / 2 - 0.2, 0.26), (t, d / 2 - 0.04, h - 0.08)], 0.012, wood, 6)
        for t in np.linspace(-inner / 2 + 0.06, inner / 2 - 0.06, 4 * n)
    ]
    return [
        *side,
        *slats,
        *[box((inner + 0.03, 0.03, 0.06), (0, y, 0.24), wood)
          for y in (-d / 2 + 0.12, d / 2 - 0.18)],
        box((inner, d - 0.3, 0.03), (0, 0, 0.26), wood),
        box((inner, 0.03, 0.05), (0, d / 2 - 0.045, h - 0.11), wood),
        *_seat_row(inner - 0.02, d - 0.18, n, cloth, 0.29, -0.07, 0.13),
        *_back_row(inner - 0.02, n, cloth, SEAT_M - 0.01, d / 2 - 0.26, h - SEAT_M, 0.14, 15),
    ]  # fmt: skip


def _chaise(cloth: Rgb, wood: Rgb, roll: Rgb) -> Part:
    """A daybed for one: a rolled head end, a back that falls away, a bolster."""
    w, d = 1.72, 0.78
    steps = np.linspace(-w / 2 + 0.25, w / 2 - 0.06, 9)
    top = SEAT_M - 0.02 + 0.36 * np.linspace(0, 1, 9) ** 0.8
    back = np.stack(
        [np.stack([steps, np.full(9, y), z], axis=1)
         for y, z in ((d / 2, np.full(9, 0.2)), (d / 2, top), (d / 2 - 0.1, top),
                      (d / 2 - 0.1, np.full(9, 0.2)))], axis=1,
    )  # fmt: skip
    return [
        *stubs(w - 0.25, d - 0.18, 0.2, wood, 0.06, 0.03),
        padded((w - 0.04, d - 0.02, 0.12), (0, 0, 0.17), shade(cloth, 0.93), 0.03),
        padded((w - 0.12, d - 0.1, 0.15), (-0.04, -0.05, SEAT_M - 0.15), cloth, 0.06),
        swept(back, cloth),
        *moved(turned([padded((0.14, d, 0.5), (0, 0, 0), cloth, 0.05)], "y", 14), (0.72, 0, 0.24)),
        tube([(w / 2 + 0.01, -d / 2, 0.73), (w / 2 + 0.01, d / 2, 0.73)], 0.085, cloth, 12),
        tube([(w / 2 - 0.26, y, 0.51) for y in (-d / 2 + 0.06, d / 2 - 0.12)], 0.09, roll, 12),
    ]  # fmt: skip


def _camel(w: float, d: float, h: float, cloth: Rgb, wood: Rgb) -> Part:
    """A settee whose back rises in the middle, with scrolled arms and turned legs."""
    t = np.linspace(-1, 1, 15)
    top = h - 0.16 + 0.16 * np.cos(t * np.pi / 2) ** 2
    back = np.stack(
        [np.stack([t * (w / 2 - 0.06), np.full(15, y), z], axis=1)
         for y, z in ((d / 2, np.full(15, 0.2)), (d / 2, top - 0.02), (d / 2 - 0.03, top),
                      (d / 2 - 0.1, top), (d / 2 - 0.14, top - 0.03),
                      (d / 2 - 0.19, np.full(15, 0.2)))], axis=1,
    )  # fmt: skip
    parts = [
        *stubs(w - 0.2, d - 0.16, 0.2, wood, 0.055, 0.015),
        padded((w - 0.08, d - 0.05, 0.13), (0, 0, 0.17), cloth, 0.02),
        padded((w - 0.3, d - 0.2, 0.14), (0, -0.1, SEAT_M - 0.13), shade(cloth, 1.06), 0.05),
        swept(back, cloth),
    ]
    for s in (-1, 1):
        x, front = s * (w / 2 - 0.09), -d / 2 + 0.03
        parts += [
            padded((0.09, d - 0.14, 0.4), (x, -0.03, 0.2), cloth, 0.03),
            tube([(x + s * 0.02, y, 0.6) for y in (front, d / 2 - 0.1)], 0.07, cloth, 12),
            tube([(x + s * 0.02, front + y, 0.6) for y in (-0.01, 0.01)], 0.035, wood, 10),
        ]
    return parts


def _lean(w: float, d: float, h: float, n: int, hide: Rgb, metal: Rgb) -> Part:
    """Square leather on a bright frame: thin arms, upright back, head rests."""
    parts = [
        *[box((0.03, 0.03, 0.2), (x * (w / 2 - 0.1), y * (d / 2 - 0.08), 0), metal)
          for x in (-1, 1) for y in (-1, 1)],
        box((w - 0.16, d - 0.1, 0.03), (0, 0, 0.17), metal),
        padded((w, d - 0.02, 0.1), (0, 0, 0.2), hide, 0.02),
        *_seat_row(w - 0.22, d - 0.2, n, hide, 0.29, -0.09, 0.13),
        padded((w, 0.16, h - 0.2), (0, d / 2 - 0.09, 0.2), hide, 0.025),
    ]  # fmt: skip
    for s in (-1, 1):
        parts.append(padded((0.1, d - 0.02, 0.4), (s * (w / 2 - 0.05), 0, 0.2), hide, 0.025))
    heads = _back_row(
        w - 0.24, n, shade(hide, 0.95), SEAT_M, d / 2 - 0.2, h - SEAT_M + 0.03, 0.1, 3
    )
    return parts + heads


SOFAS: tuple[Callable[[], Part], ...] = (
    partial(couch, 2.16, 0.94, 0.84, 3, c.ASH, (0.08, c.DARK_WOOD), (0.22, 0.62), True,
            (c.MUSTARD, c.TEAL)),
    partial(couch, 1.55, 0.85, 0.7, 2, c.CHARCOAL, (0.06, c.BLACK), (0.2, 0.7), False, (), 0.02),
    partial(_corner, 2.55, 1.7, 0.84, c.SAND, 1, True, (c.CREAM, c.COGNAC)),
    partial(_rolled, 2.14, 0.95, 0.75, 3, c.LEATHER, c.DARK_WOOD),
    partial(airy, 1.88, 0.82, 0.8, 3, c.MUSTARD, c.OAK),
    partial(couch, 2.36, 1.05, 0.8, 2, c.FOREST, (0.05, c.WALNUT), (0.17, 0.56), True,
            (c.PINK, c.CREAM, c.MUSTARD, c.FOREST), 0.06, 3),
    partial(_chaise, c.ROSE, c.WALNUT, c.CREAM),
    partial(_camel, 1.5, 0.84, 0.93, c.OXBLOOD, c.DARK_WOOD),
    partial(_lean, 1.86, 0.86, 0.74, 3, c.WHITE, c.CHROME),
    partial(_corner, 2.32, 1.52, 0.86, c.NAVY, -1, False, (c.SKY, c.WHITE)),
)  # fmt: skip


def sofa(k: int) -> Part:
    """Three seats, cube, corner, chesterfield, airy, deep, chaise, settee, leather, long end."""
    return pick(k, *SOFAS)()
