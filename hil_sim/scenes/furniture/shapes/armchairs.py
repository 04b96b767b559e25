"""Meshes of armchairs, each variant a type of its own; they look along -y."""

from collections.abc import Callable
from functools import partial

import numpy as np

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
    shade,
    tube,
    turned,
)
from hil_sim.scenes.furniture.shapes.sofas import SEAT_M, airy, couch, stubs
from hil_sim.scenes.furniture.shapes.soft import bowed, leaning, padded, swept


def _club(hide: Rgb, wood: Rgb) -> Part:
    arm = (0.19, 0.84, 0.4)
    return [
        *stubs(0.66, 0.66, 0.1, wood, 0.06),
        padded((0.8, 0.82, 0.2), (0, 0, 0.08), hide, 0.04),
        padded((0.5, 0.66, 0.18), (0, -0.1, SEAT_M - 0.17), shade(hide, 1.08), 0.06),
        *[padded(arm, (s * 0.34, -0.01, 0.08), hide, 0.06) for s in (-1, 1)],
        *[tube([(s * 0.34, -0.42, 0.5), (s * 0.34, 0.36, 0.5)], 0.11, hide, 12) for s in (-1, 1)],
        *leaning([padded((0.76, 0.2, 0.66), (0, 0, 0), hide, 0.09, 3)], 0.28, 0.14, 5),
        *leaning([ball((0.52, 0.16, 0.42), (0, 0, 0), shade(hide, 1.08), 8, 16, 0.4)],
                 0.17, 0.4, 10),
    ]  # fmt: skip


def _wing(cloth: Rgb, wood: Rgb) -> Part:
    wing = [(0, 0, 0), (0, -0.17, 0.06), (0, -0.2, 0.3), (0, -0.1, 0.45), (0, 0, 0.47)]
    parts = [
        *stubs(0.6, 0.64, 0.2, wood, 0.055, 0.02),
        padded((0.68, 0.72, 0.13), (0, -0.02, 0.17), cloth, 0.03),
        padded((0.52, 0.6, 0.15), (0, -0.09, SEAT_M - 0.13), shade(cloth, 1.06), 0.05),
        *leaning([padded((0.6, 0.13, 0.86), (0, 0, 0), cloth, 0.06, 3)], 0.25, 0.24, 9),
        *leaning([ball((0.5, 0.1, 0.62), (0, 0, 0), shade(cloth, 1.06), 8, 16, 0.4)], 0.18, 0.4, 9),
    ]
    for s in (-1, 1):
        flank = np.array([[(s * x, y, z) for _, y, z in wing] for x in (0.26, 0.33)])
        parts += leaning([swept(flank, cloth)], 0.24, 0.6, 9)
        parts += [
            padded((0.1, 0.62, 0.32), (s * 0.31, -0.06, 0.25), cloth, 0.03),
            tube([(s * 0.325, -0.38, 0.59), (s * 0.325, 0.26, 0.6)], 0.065, cloth, 12),
        ]
    return parts


def _tub(cloth: Rgb, wood: Rgb) -> Part:
    rise = [(0.12, 0.6), (0.12, 0.64), (0.12, 0.74), (0.12, 0.76), (0.12, 0.74), (0.12, 0.64),
            (0.12, 0.6)]  # fmt: skip
    return [
        *stubs(0.46, 0.44, 0.14, wood, 0.045, 0.03),
        bowed((0.36, 0.36), 0.1, rise, (-42, 222), cloth, 0.02),
        lathe([(0, 0.12), (0.3, 0.12), (0.33, 0.16), (0.33, 0.3), (0, 0.3)], cloth, 20),
        lathe([(0, 0.28), (0.28, 0.28), (0.3, 0.32), (0.295, 0.4), (0.2, 0.43), (0, 0.435)],
              shade(cloth, 1.08), 20, (0, -0.05, 0)),
    ]  # fmt: skip


def _recliner(hide: Rgb) -> Part:
    pads = [((0.54, 0.2, 0.3), 0.0), ((0.54, 0.22, 0.26), 0.24), ((0.5, 0.2, 0.22), 0.45)]
    back = [ball(size, (0, 0, z), hide, 8, 16, 0.42) for size, z in pads]
    return [
        padded((0.7, 0.74, 0.22), (0, 0.02, 0.04), shade(hide, 0.85), 0.03),
        *[padded((0.2, 0.84, 0.52), (s * 0.35, -0.02, 0.05), hide, 0.07, 3) for s in (-1, 1)],
        *[ball((0.22, 0.7, 0.12), (s * 0.35, -0.06, 0.5), hide, 6, 16, 0.4) for s in (-1, 1)],
        ball((0.54, 0.66, 0.22), (0, -0.14, 0.26), hide, 8, 16, 0.4),
        *leaning([*back, padded((0.66, 0.1, 0.62), (0, 0.1, 0), hide, 0.05)], 0.24, 0.36, 17),
        *moved(turned([padded((0.5, 0.1, 0.3), (0, 0, 0), hide, 0.04)], "x", 28), (0, -0.42, 0.12)),
    ]


def _egg(cloth: Rgb, inside: Rgb) -> Part:
    rise = [(0.3, 0.6), (0.28, 0.68), (0.28, 0.95), (0.28, 1.06), (0.28, 0.95), (0.28, 0.68),
            (0.3, 0.6)]  # fmt: skip
    return [
        *around([tube([(0, 0, 0.05), (0, -0.3, 0.015)], (0.022, 0.015), c.CHROME, 6)], "z", 4),
        cylinder(0.028, 0.028, 0.28, c.CHROME, 10),
        lathe([(0, 0.24), (0.2, 0.26), (0.33, 0.34), (0.3, 0.38), (0, 0.38)], cloth, 20),
        bowed((0.35, 0.35), 0.06, rise, (-30, 210), cloth, 0.03),
        ball((0.54, 0.56, 0.13), (0, -0.08, 0.33), inside, 6, 18, 0.6),
        *leaning([ball((0.44, 0.1, 0.5), (0, 0, 0), inside, 8, 16, 0.6)], 0.2, 0.42, 8),
    ]


def _bent(cloth: Rgb, wood: Rgb) -> Part:
    """Two bent frames that spring, a long pad hung between them."""
    curve = [(0.36, 0.02), (-0.2, 0.015), (-0.34, 0.04), (-0.38, 0.12), (-0.36, 0.3), (-0.3, 0.5),
             (-0.22, 0.57), (0.16, 0.55), (0.24, 0.54)]  # fmt: skip
    line = [(-0.34, 0.43), (-0.25, 0.44), (0.1, 0.36), (0.17, 0.4), (0.36, 0.96), (0.4, 1.0)]
    thick, parts = 0.08, Part()
    for s in (-1, 1):
        path = [(s * 0.31, y, z) for y, z in curve]
        parts += [tube(path, 0.022, wood, 6)]
        parts += [tube([(s * 0.27, y, z - 0.06) for y, z in line], 0.018, wood, 6)]
    p = np.array(line)
    ahead = np.gradient(p, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    up = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1) * thick
    pad = np.stack(
        [np.c_[np.full(len(p), x), p + f * up]
         for x, f in ((-0.28, 0.25), (-0.25, 0), (0.25, 0), (0.28, 0.25), (0.28, 0.75),
                      (0.25, 1), (-0.25, 1), (-0.28, 0.75))], axis=1,
    )  # fmt: skip
    rails = [
        tube([(-0.31, y, z), (0.31, y, z)], 0.018, wood, 6) for y, z in ((0.34, 0.02), (0.17, 0.55))
    ]
    return [*parts, *rails, swept(pad - (0, 0, 0.03), cloth)]


ARMCHAIRS: tuple[Callable[[], Part], ...] = (
    partial(_club, c.COGNAC, c.DARK_WOOD),
    partial(_wing, c.TEAL, c.WOOD),
    partial(airy, 0.72, 0.8, 0.84, 1, c.GREY, c.PALE_WOOD),
    partial(_tub, c.PINK, c.OAK),
    partial(_recliner, c.BLACK),
    partial(couch, 0.98, 0.9, 0.8, 1, c.LINEN, (0.1, c.WALNUT), (0.2, 0.6), True, (), 0.03),
    partial(_egg, c.OXBLOOD, shade(c.OXBLOOD, 1.3)),
    partial(_bent, c.CREAM, c.OAK),
)


def armchair(k: int) -> Part:
    """Club, wing, open wooden, tub, recliner, block, egg on a swivel, bentwood."""
    return pick(k, *ARMCHAIRS)()
