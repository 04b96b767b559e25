"""Meshes of what one drinks from, eats from and cooks in."""

from hil_sim.scenes.furniture.shapes import palette as c
from hil_sim.scenes.furniture.shapes.palette import Rgb
from hil_sim.scenes.furniture.shapes.primitives import (
    Part,
    arc,
    ball,
    cylinder,
    lathe,
    moved,
    pick,
    tube,
    vessel,
)


def bottle(k: int) -> Part:
    """With a neck, a label and a cap."""
    body, label, cap = pick(
        k,
        (c.GREEN, c.CREAM, c.RED),
        (c.GLASS, c.BLUE, c.WHITE),
        (c.DARK_WOOD, c.YELLOW, c.BRASS),
        (c.WHITE, c.RED, c.RED),
        ((0.3, 0.45, 0.7), c.WHITE, c.NAVY),
        (c.ORANGE, c.DARK, c.DARK),
    )
    r, h = pick(k, (0.036, 0.27), (0.034, 0.22), (0.031, 0.23), (0.042, 0.24))
    shoulder = pick(k, 0.6, 0.7, 0.55)
    profile = [
        (0, 0),
        (r, 0),
        (r, h * shoulder),
        (0.014, h * (shoulder + 0.2)),
        (0.013, h * 0.92),
        (0, h * 0.92),
    ]
    band = [(r + 0.0007, h * 0.15), (r + 0.0007, h * (shoulder - 0.12))]
    return [
        lathe(profile, body, 16),
        lathe(band, label, 16),
        cylinder(0.015, 0.015, h * 0.08, cap, 12, (0, 0, h * 0.92)),
    ]


def wine_bottle(k: int) -> Part:
    """With a capsule over its cork."""
    glass, label, capsule = pick(
        k,
        ((0.08, 0.16, 0.08), c.CREAM, c.RED),
        ((0.1, 0.06, 0.05), c.WHITE, c.BRASS),
        ((0.45, 0.5, 0.2), c.CREAM, c.GREEN),
        ((0.1, 0.06, 0.05), c.BRASS, c.DARK),
        ((0.62, 0.25, 0.28), c.WHITE, c.PINK),
        ((0.08, 0.16, 0.08), c.NAVY, c.BRASS),
    )
    r = pick(k, 0.038, 0.042)
    low = [(0, 0), (r, 0.0), (r, 0.19), (0.016, 0.235), (0.0145, 0.25)]
    high = [(0.0155, 0.24), (0.0155, 0.3), (0, 0.3)]
    return [
        lathe(low, glass, 16),
        lathe(high, capsule, 12),
        lathe([(r + 0.0007, 0.05), (r + 0.0007, 0.14)], label, 16),
    ]


def wine_glass(k: int) -> Part:
    """On a stem."""
    colour = pick(k, c.GLASS, (0.6, 0.75, 0.8), (0.8, 0.82, 0.84))
    wine = pick(k, None, (0.4, 0.05, 0.1), (0.85, 0.78, 0.4))
    r, h = pick(k, (0.04, 0.2), (0.045, 0.22), (0.034, 0.21), (0.05, 0.17))
    foot = lathe(
        [
            (0, 0),
            (r * 0.9, 0),
            (r * 0.85, 0.004),
            (0.006, 0.012),
            (0.004, h * 0.45),
            (0.006, h * 0.5),
        ],
        colour,
        16,
    )
    bowl = [(0.006, 0), (r * 0.75, h * 0.1), (r, h * 0.24), (r * 0.8, h * 0.5)]
    parts = [foot, *moved(vessel(bowl, colour, None, 0.002, 16), (0, 0, h * 0.5))]
    if wine is not None:
        parts.append(lathe([(r * 0.96, h * 0.74), (0, h * 0.742)], wine, 16))
    return parts


def cup(k: int) -> Part:
    """A tumbler (even) or a tea cup on its saucer (odd)."""
    colour = pick(k, (0.75, 0.35, 0.3), c.WHITE, c.TEAL, c.YELLOW, c.STEEL, c.PINK)
    if k % 2 == 0:
        r, h = pick(k, 0.04, 0.0, 0.038, 0.0, 0.042), pick(k, 0.12, 0.0, 0.1, 0.0, 0.14)
        rim = lathe(
            [(r + 0.0006, h * 0.8), (r + 0.0008, h * 0.9)], pick(k, c.CREAM, c.DARK, c.NAVY), 18
        )
        return [*vessel([(r * 0.75, 0), (r * 0.8, 0.01), (r, h)], colour, c.CREAM, 0.003, 18), rim]
    saucer = lathe(
        [(0, 0), (0.03, 0), (0.07, 0.012), (0.07, 0.015), (0.03, 0.006), (0, 0.006)], colour, 18
    )
    body = vessel(
        [(0.022, 0), (0.03, 0.012), (0.043, 0.045), (0.046, 0.06)], colour, c.WHITE, 0.003, 18
    )
    grip = tube(arc((0.042, 0, 0.036), 0.016, -90, 90, "xz", 6), 0.0035, colour, 5)
    tea = lathe([(0.041, 0.05), (0, 0.051)], c.DARK_WOOD, 18)
    return [saucer, *moved([*body, grip, tea], (0, 0, 0.006))]


def plate(k: int) -> Part:
    """Flat with a rim."""
    rim, middle = pick(
        k,
        (c.WHITE, c.WHITE),
        (c.BLUE, c.WHITE),
        (c.CREAM, c.CREAM),
        (c.TEAL, c.TEAL),
        (c.WHITE, c.RED),
        (c.DARK, c.GREY),
    )
    r = pick(k, 0.13, 0.12, 0.1, 0.135)
    low = [(0, 0), (r * 0.6, 0), (r, 0.018), (r, 0.022), (r * 0.68, 0.008)]
    return [
        lathe(low, rim, 24),
        lathe([(r * 0.68, 0.008), (r * 0.6, 0.005), (0, 0.005)], middle, 24),
    ]


def pot(k: int) -> Part:
    """Two ears and a lid (even), or a long handle (odd)."""
    body, trim = pick(
        k,
        (c.STEEL, c.DARK),
        (c.STEEL, c.DARK),
        (c.RED, c.DARK),
        (c.DARK, c.WOOD),
        (c.BLUE, c.CREAM),
        ((0.7, 0.4, 0.25), c.BRASS),
    )
    r, h = pick(k, (0.12, 0.13), (0.09, 0.09), (0.13, 0.12))
    outside = [(r * 0.96, 0), (r, 0.01), (r, h), (r * 1.03, h)]
    if k % 2:
        handle = tube(
            [(r, 0, h * 0.8), (r + 0.06, 0, h * 0.9), (r + 0.18, 0, h * 0.98)], 0.009, trim, 6
        )
        return [*vessel(outside, body, c.GREY, 0.004, 20), handle]
    lid = lathe(
        [(0, h), (r * 1.03, h), (r * 1.03, h + 0.006), (r * 0.5, h + 0.025), (0, h + 0.03)],
        pick(k, c.GLASS, c.GLASS, body),
        20,
    )
    ears = [tube(_ear(side, r, h), 0.007, trim, 6) for side in (-1, 1)]
    return [
        *vessel(outside, body, c.GREY, 0.004, 20),
        lid,
        *ears,
        ball((0.03, 0.03, 0.025), (0, 0, h + 0.028), trim, 6, 10),
    ]


def _ear(side: int, r: float, h: float) -> list[list[float]]:
    """The path of an ear at the side of a pot."""
    return [
        [side * (r - 0.004), -0.035, h * 0.75],
        [side * (r + 0.03), -0.03, h * 0.78],
        [side * (r + 0.03), 0.03, h * 0.78],
        [side * (r - 0.004), 0.035, h * 0.75],
    ]


def pan(k: int) -> Part:
    """A frying pan."""
    body, inside, grip = pick(
        k,
        (c.DARK, c.GREY, c.DARK),
        (c.STEEL, c.DARK, c.STEEL),
        (c.RED, c.CREAM, c.DARK),
        (c.DARK, c.DARK, c.WOOD),
        (c.TEAL, c.GREY, c.DARK),
        ((0.7, 0.4, 0.25), c.STEEL, c.BRASS),
    )
    r, h = pick(k, 0.13, 0.11, 0.14), pick(k, 0.045, 0.055)
    handle = tube(
        [(r * 0.98, 0, h * 0.8), (r + 0.05, 0, h + 0.01), (r + 0.2, 0, h + 0.03)],
        [0.007, 0.008, 0.011],
        grip,
        6,
    )
    return [*vessel([(r * 0.8, 0), (r * 0.85, 0.004), (r, h)], body, inside, 0.005, 22), handle]


def kettle(k: int) -> Part:
    """With a spout, a lid and a handle: for a stove (even) or electric, on a base (odd)."""
    body, trim = pick(
        k,
        (c.STEEL, c.DARK),
        (c.WHITE, c.GREY),
        (c.RED, c.DARK),
        (c.DARK, c.STEEL),
        (c.CREAM, c.WOOD),
        (c.TEAL, c.DARK),
    )
    return _electric_kettle(body, trim) if k % 2 else _stove_kettle(body, trim)


def _stove_kettle(body: Rgb, trim: Rgb) -> Part:
    waist = [(0, 0), (0.1, 0), (0.098, 0.042), (0.07, 0.119), (0.04, 0.14), (0, 0.14)]
    spout = [(0, -0.08, 0.056), (0, -0.115, 0.084), (0, -0.14, 0.133)]
    return [
        lathe(waist, body, 20),
        ball((0.03, 0.03, 0.025), (0, 0, 0.14), trim, 6, 10),
        tube(spout, [0.022, 0.016, 0.01], body, 8),
        tube(arc((0, 0, 0.112), 0.085, 10, 170, "yz", 10), 0.009, trim, 6),
    ]


def _electric_kettle(body: Rgb, trim: Rgb) -> Part:
    waist = [(0, 0.02), (0.075, 0.02), (0.073, 0.08), (0.058, 0.19), (0.03, 0.22), (0, 0.22)]
    grip = [(0, 0.06, 0.19), (0, 0.12, 0.18), (0, 0.12, 0.07), (0, 0.071, 0.05)]
    return [
        cylinder(0.079, 0.075, 0.02, trim, 20),
        lathe(waist, body, 20),
        ball((0.03, 0.03, 0.025), (0, 0, 0.22), trim, 6, 10),
        tube(grip, 0.011, trim, 6),
        tube([(0, -0.045, 0.176), (0, -0.095, 0.204)], [0.03, 0.012], body, 8),
    ]


def teapot(k: int) -> Part:
    """A round pot with a spout and a looped handle."""
    body, lid = pick(
        k,
        (c.BLUE, c.WHITE),
        (c.WHITE, c.WHITE),
        (c.DARK_WOOD, c.DARK_WOOD),
        (c.GREEN, c.GREEN),
        (c.RED, c.CREAM),
        (c.YELLOW, c.DARK),
    )
    pot_ = ball((0.16, 0.16, 0.13), (0, 0, 0.005), body, 10, 16)
    top = lathe([(0.045, 0.122), (0.042, 0.132), (0.02, 0.145), (0, 0.146)], lid, 14)
    return [
        cylinder(0.05, 0.05, 0.01, body, 14),
        pot_,
        top,
        ball((0.022, 0.022, 0.02), (0, 0, 0.143), lid, 6, 8),
        tube(
            [(-0.07, 0, 0.05), (-0.105, 0, 0.075), (-0.135, 0, 0.12)], [0.02, 0.014, 0.009], body, 8
        ),
        tube(arc((0.072, 0, 0.07), 0.042, -80, 80, "xz", 8), 0.008, body, 6),
    ]
