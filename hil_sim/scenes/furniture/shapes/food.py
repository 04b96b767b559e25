"""Meshes of food, cutlery and shakers."""

import numpy as np

from hil_sim.scenes.furniture.shapes import palette as c
from hil_sim.scenes.furniture.shapes.palette import Rgb
from hil_sim.scenes.furniture.shapes.primitives import (
    Part,
    around,
    ball,
    box,
    lathe,
    moved,
    pick,
    scaled,
    slab,
    tube,
    turned,
)

MILL = (
    (0, 0), (0.03, 0), (0.03, 0.02), (0.018, 0.07), (0.026, 0.12), (0.026, 0.13),
    (0.016, 0.135), (0.028, 0.16), (0.02, 0.185), (0, 0.19),
)  # fmt: skip


def _shaker(k: int, colour: Rgb, band: Rgb) -> Part:
    h = pick(k, 0.1, 0.085, 0.11)
    cap = [(0.023, h * 0.76), (0.023, h * 0.88), (0.015, h), (0, h * 1.02)]
    hole = box((0.003, 0.003, 0.002), (0.008, 0, h * 1.005), c.DARK)
    return [
        lathe([(0, 0), (0.03, 0), (0.026, h * 0.5), (0.021, h * 0.78)], colour, 14),
        lathe(cap, c.STEEL if colour != c.STEEL else c.DARK, 14),
        lathe([(0.0285, h * 0.2), (0.0272, h * 0.4)], band, 14),
        *around([hole], "z", 5),
    ]


def salt_shaker(k: int) -> Part:
    """Pale, with holes above."""
    colour = pick(k, c.WHITE, c.GLASS, c.CREAM, c.STEEL, c.PINK, (0.7, 0.8, 0.9))
    return _shaker(k, colour, pick(k, c.BLUE, c.RED, c.TEAL))


def pepper_shaker(k: int) -> Part:
    """Dark, every other one a mill."""
    colour = pick(k, c.DARK, (0.2, 0.2, 0.22), c.DARK_WOOD, c.WOOD, c.GREY, c.RED)
    if k % 2 == 0:
        return _shaker(k, colour, c.WHITE)
    return [lathe(MILL, colour, 16), ball((0.014, 0.014, 0.014), (0, 0, 0.188), c.STEEL, 5, 8)]


def _grip(k: int) -> tuple[Rgb, Rgb]:
    return pick(
        k,
        (c.STEEL, c.STEEL),
        (c.STEEL, c.WOOD),
        (c.STEEL, c.DARK),
        (c.BRASS, c.BRASS),
        (c.STEEL, c.RED),
        (c.STEEL, c.BLUE),
    )


def fork(k: int) -> Part:
    """Lying, along y."""
    metal, handle = _grip(k)
    parts = [
        box((0.012, 0.1, 0.006), (0, 0.05, 0.001), handle),
        box((0.007, 0.04, 0.004), (0, -0.018, 0.002), metal),
        box((0.027, 0.022, 0.004), (0, -0.046, 0.001), metal),
    ]
    return parts + [
        box((0.004, 0.05, 0.003), (x, -0.08, 0.002), metal)
        for x in (-0.0115, -0.004, 0.004, 0.0115)
    ]


def spoon(k: int) -> Part:
    """Lying, along y."""
    metal, handle = _grip(k)
    bowl_ = lathe(
        [(0, 0), (0.6, 0.1), (0.95, 0.5), (1, 0.6), (0.85, 0.52), (0.5, 0.2), (0, 0.14)], metal, 14
    )
    return [
        box((0.012, 0.1, 0.005), (0, 0.05, 0.002), handle),
        box((0.006, 0.04, 0.004), (0, -0.018, 0.003), metal),
        *moved(scaled([bowl_], (0.02, 0.032, 0.012)), (0, -0.064, 0)),
    ]


def _blade(k: int, length: float, width: float, grip: float, tip: float) -> Part:
    metal, handle = c.STEEL, _grip(k)[1]
    edge = [
        (-width / 2, 0),
        (-width / 2, -length * 0.95),
        (width * tip, -length),
        (width / 2, -length * 0.75),
        (width / 2, 0),
    ]
    return [
        slab(edge[::-1] if _clockwise(edge) else edge, 0.003, metal, 0.004),
        box((width * 0.55, grip, 0.013), (0, grip / 2, 0), handle),
    ]


def _clockwise(outline: list[tuple[float, float]]) -> bool:
    x, y = np.array(outline).T
    return bool(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) < 0)


def knife(k: int) -> Part:
    """A kitchen knife, lying, along y."""
    return _blade(k + 1, pick(k, 0.19, 0.16, 0.21), pick(k, 0.042, 0.03, 0.048), 0.12, -0.4)


def butter_knife(k: int) -> Part:
    """A table knife with a round tip, lying, along y."""
    return _blade(k, 0.11, 0.02, 0.11, 0.1)


def bread(k: int) -> Part:
    """A loaf: long, boxed or round, with cuts across."""
    crust, cut = (
        pick(k, (0.72, 0.46, 0.22), (0.62, 0.36, 0.16), (0.8, 0.58, 0.32)),
        (0.93, 0.82, 0.6),
    )
    w, d, h = pick(k, (0.3, 0.12, 0.09), (0.24, 0.11, 0.12), (0.2, 0.2, 0.1), (0.5, 0.075, 0.06))
    loaf = ball((w, d, h), (0, 0, 0), crust, 10, 18, pick(k, 0.8, 0.35, 1.0, 0.8))
    cuts = [
        box((w * 0.03, d * 0.5, 0.004), (x * w, 0, h * z), cut)
        for x, z in ((-0.22, 0.95), (0, 0.985), (0.22, 0.95))
    ]
    return [loaf, *cuts]


def tomato(k: int) -> Part:
    """With its green star."""
    r, h = pick(k, (0.04, 0.062), (0.036, 0.06), (0.045, 0.065))
    skin = pick(k, (0.82, 0.14, 0.08), (0.9, 0.3, 0.1), (0.75, 0.08, 0.08), (0.86, 0.2, 0.12))
    profile = [(0, 0.03), (0.5, 0), (0.9, 0.25), (1, 0.55), (0.85, 0.85), (0.45, 1), (0, 0.9)]
    leaves = [
        p
        for a in range(0, 360, 72)
        for p in turned([ball((0.03, 0.01, 0.004), (0.017, 0, h * 0.985), c.GREEN, 4, 6)], "z", a)
    ]
    return [
        lathe([(a * r, b * h) for a, b in profile], skin, 16),
        *leaves,
        tube([(0, 0, h * 0.9), (0.003, 0, h * 1.15)], 0.003, c.GREEN, 5),
    ]


def lettuce(k: int) -> Part:
    """A head of wavy leaves."""
    green = pick(k, (0.45, 0.68, 0.25), (0.55, 0.75, 0.35), (0.35, 0.58, 0.2))
    parts: Part = [ball((0.11, 0.11, 0.1), (0, 0, 0.02), (0.75, 0.85, 0.5), 8, 12)]
    for layer, (n, tilt, size) in enumerate(((7, 58, 0.11), (6, 30, 0.1))):
        shade = (green[0] + 0.1 * layer, green[1] + 0.06 * layer, green[2] + 0.08 * layer)
        for i in range(n):
            leaf = moved(
                scaled([ball((1, 1, 1), (0, 0, 0), shade, 4, 6)], (size, 0.02, size)), (0, -0.02, 0)
            )
            leaf = moved(turned(leaf, "x", tilt), (0, -0.02 - 0.006 * (k % 3), 0.01))
            parts += turned(leaf, "z", 360 * i / n + 25 * layer + 13 * k)
    return parts


def potato(k: int) -> Part:
    """A lumpy ellipsoid with eyes."""
    skin = pick(k, (0.68, 0.52, 0.32), (0.75, 0.62, 0.38), (0.6, 0.4, 0.28), (0.62, 0.3, 0.28))
    w, d, h = pick(k, (0.1, 0.065, 0.06), (0.12, 0.07, 0.062), (0.09, 0.07, 0.065))
    body = ball((w, d, h), (0, 0, 0), skin, 9, 14)
    x, y = body.corners[..., 0] / w, body.corners[..., 1] / d
    body.corners = (
        body.corners * (1 + 0.07 * np.sin(6 * x + k) + 0.05 * np.cos(7 * y - k))[..., None]
    )
    eyes = [
        ball((0.01, 0.006, 0.006), (w * u, -d * v, h * z), (0.4, 0.28, 0.16), 3, 5)
        for u, v, z in ((-0.25, 0.4, 0.55), (0.1, 0.46, 0.7), (0.28, 0.36, 0.45), (0.0, 0.2, 0.95))
    ]
    return [body, *eyes]


def egg(k: int) -> Part:
    """One egg standing on its blunt end."""
    shell = pick(
        k,
        c.CREAM,
        c.WHITE,
        (0.82, 0.62, 0.45),
        (0.7, 0.5, 0.36),
        (0.93, 0.9, 0.86),
        (0.75, 0.82, 0.8),
    )
    profile = [
        (0, 0),
        (0.5, 0.04),
        (0.88, 0.2),
        (1, 0.4),
        (0.9, 0.62),
        (0.6, 0.86),
        (0.3, 0.97),
        (0, 1),
    ]
    return [lathe([(0.022 * a, pick(k, 0.057, 0.06) * b) for a, b in profile], shell, 16)]
