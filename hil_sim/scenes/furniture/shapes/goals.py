"""Meshes of the things that robots are most often sent for: RoboTHOR's small goals."""

from collections.abc import Sequence

import numpy as np

from hil_sim.scenes.furniture.shapes import palette as c
from hil_sim.scenes.furniture.shapes.palette import Rgb
from hil_sim.scenes.furniture.shapes.primitives import (
    Array,
    Part,
    arc,
    ball,
    box,
    cylinder,
    disc,
    lathe,
    lathe_grid,
    moved,
    painted,
    pick,
    scaled,
    surface,
    tube,
    turned,
    vessel,
)
from hil_sim.scenes.furniture.soup import Soup

Profile = Sequence[tuple[float, float]]
"""Radius and height, from below."""
SEGMENTS = {"0": "abcdef", "1": "bc", "2": "abged", "3": "abgcd", "4": "fgbc", "5": "afgcd",
            "6": "afgecd", "7": "abc", "8": "abcdefg", "9": "abfgcd"}  # fmt: skip


def digits(text: str, height: float, colour: Rgb) -> Part:
    """Seven-segment digits on the plane y = 0, seen from -y, their middle on the origin."""
    w, t, thin = height * 0.5, height * 0.13, 0.002
    bars = {"a": (0, height - t), "g": (0, height / 2 - t / 2), "d": (0, 0),
            "f": (-1, height / 2), "b": (1, height / 2), "e": (-1, 0), "c": (1, 0)}  # fmt: skip
    parts: Part = []
    advance = [w * 1.45 if sign != ":" else w * 0.6 for sign in text]
    x = -sum(advance) / 2
    for char, step in zip(text, advance, strict=True):
        middle = x + step / 2
        x += step
        if char == ":":
            parts += [box((t, thin, t), (middle, 0, height * f), colour) for f in (0.25, 0.62)]
        for name in SEGMENTS.get(char, ""):
            side, z = bars[name]
            flat = side == 0
            size = (w, thin, t) if flat else (t, thin, height / 2)
            parts.append(box(size, (middle + side * (w - t) / 2, 0, z), colour))
    return moved(parts, (0, 0, -height / 2))


def alarm_clock(k: int) -> Part:
    """Twin-bell (0, 2, 4) and digital (1, 3, 5)."""
    return _digital_clock(k // 2) if k % 2 else _bell_clock(k // 2)


def _bell_clock(k: int) -> Part:
    body, trim = pick(k, (c.RED, c.STEEL), (c.TEAL, c.BRASS), (c.DARK, c.BRASS))
    r, z = 0.06, 0.085
    parts = [disc(r, 0.05, body, 20), *moved([disc(r * 0.86, 0.004, c.WHITE, 20)], (0, -0.027, 0))]
    for hour in range(0, 360, 30):
        a = np.radians(hour)
        at = (r * 0.72 * np.sin(a), -0.03, r * 0.72 * np.cos(a) - 0.004)
        parts.append(box((0.005, 0.002, 0.008), at, c.DARK))
    hands = [box((0.006, 0.002, r * 0.62), (0, -0.031, 0), c.DARK)]
    parts += turned(hands, "y", 60) + turned(
        [box((0.008, 0.002, r * 0.42), (0, -0.031, 0), c.DARK)], "y", -60
    )
    bell = lathe([(0, 0), (0.03, 0), (0.028, 0.012), (0.016, 0.024), (0, 0.028)], trim, 12)
    two = bells(bell, 32, (0.034, z + 0.054), ((0.028, z - 0.045), 0.05), trim)
    grip = [(-0.03, 0, z + 0.086), (0, 0, z + 0.105), (0.03, 0, z + 0.086)]
    return [*moved(parts, (0, 0, z)), *two, tube(grip, 0.004, trim, 5)]


def bells(
    bell: Soup, lean: float, at: tuple[float, float], leg: tuple[tuple[float, float], float],
    trim: Rgb,
) -> Part:  # fmt: skip
    """An alarm clock's two, `at` x and z, leaning outward by so many degrees; and its two legs,
    from x and z down to another x on the ground."""
    parts: Part = []
    (x, z), ((top_x, top_z), foot_x) = at, leg
    for side in (-1, 1):
        parts += moved(turned([bell], "y", side * lean), (side * x, 0, z))
        parts.append(tube([(side * top_x, 0, top_z), (side * foot_x, 0, 0)], 0.006, trim, 6))
    return parts


def _digital_clock(k: int) -> Part:
    case, light, time = pick(
        k,
        (c.DARK, (1.0, 0.15, 0.1), "7:30"),
        (c.WHITE, (0.1, 0.9, 0.4), "6:45"),
        (c.WOOD, c.WHITE, "12:08"),
    )
    size = pick(k, (0.19, 0.1, 0.085), (0.14, 0.09, 0.12), (0.2, 0.07, 0.09))
    return digital_case(size, (0.1, 0.8), case, digits(time, size[0] * 0.2, light))


def digital_case(
    size: tuple[float, float, float], face: tuple[float, float], case: Rgb, shown: Part
) -> Part:
    """A digital clock with a button: a dark face, as shares of the height its foot and how high it
    is, and what it shows."""
    w, d, h = size
    low, high = face
    return [
        box(size, (0, 0, 0), case),
        box((w * 0.92, 0.004, h * high), (0, -d / 2 - 0.001, h * low), c.DARK),
        *moved(shown, (0, -d / 2 - 0.0045, h * 0.5)),
        box((w * 0.4, d * 0.35, 0.012), (0, 0, h), c.GREY),
    ]


def apple(k: int) -> Part:
    """With a stalk and a leaf."""
    skin = pick(k, (0.78, 0.1, 0.1), (0.45, 0.68, 0.18), (0.88, 0.75, 0.25), (0.62, 0.06, 0.1),
                (0.86, 0.35, 0.2), (0.55, 0.72, 0.3))  # fmt: skip
    blush = pick(k, (0.88, 0.4, 0.16), (0.62, 0.78, 0.28), (0.85, 0.3, 0.15))
    r, h = pick(k, 0.042, 0.04, 0.045), pick(k, 0.078, 0.074, 0.07, 0.085)
    profile = [(0, 0.06), (0.35, 0), (0.62, 0.06), (0.9, 0.28), (1, 0.55), (0.92, 0.82),
               (0.62, 0.98), (0.3, 0.98), (0, 0.84)]  # fmt: skip
    grid = lathe_grid([(a * r, b * h) for a, b in profile], 16)
    which = np.zeros((8, 16), np.int64)
    which[2:6, 3:7] = 1
    return [
        *painted(grid, (skin, blush), which),
        tube([(0, 0, 0.8 * h), (0.002, 0, h), (0.008, 0, 1.2 * h)], 0.0025, c.DARK_WOOD, 5),
        *leaf(0.032, 25, h),
    ]


def leaf(length: float, up: float, h: float) -> Part:
    """Of an apple so high: from its stalk along x, by so many degrees upward."""
    blade = ball((length, length / 2, 0.004), (length / 2, 0, 0), c.GREEN, 4, 8)
    return moved(turned([blade], "y", -up), (0.004, 0, 1.08 * h))


def bat_on_end(k: int) -> Part:
    """A baseball bat, its knob on the ground, upright."""
    body, grip = pick(k, (c.PALE_WOOD, c.DARK), (c.STEEL, c.RED), (c.DARK_WOOD, c.CREAM),
                      (c.BLUE, c.DARK),
                      (c.WOOD, c.WHITE), (c.DARK, c.RED))  # fmt: skip
    length = pick(k, 0.86, 0.82, 0.9, 0.78)
    r = pick(k, 0.034, 0.033, 0.032)
    low = [(0, 0), (0.024, 0.002), (0.024, 0.014), (0.0135, 0.022), (0.0135, 0.26)]
    high = [(0.018, 0.42), (r * 0.88, 0.58), (r, 0.7), (r, length - 0.015)]
    return [*bat(low, high, length, body, grip), bat_band(r, length, 0.13, grip)]


def bat(low: Profile, high: Profile, length: float, body: Rgb, grip: Rgb) -> Part:
    """Its grip, and from there to its end the rest."""
    end = [(high[-1][0] * 0.75, length), (0, length)]
    return [lathe(low, grip, 14), lathe([low[-1], *high, *end], body, 14)]


def bat_band(r: float, length: float, below: float, colour: Rgb) -> Soup:
    """A band round a bat's thick end, from 0.2 m to so far below its tip."""
    return lathe([(r + 0.0008, length - 0.2), (r + 0.0008, length - below)], colour, 14)


def baseball_bat(k: int) -> Part:
    """Lying along x."""
    return turned(bat_on_end(k), "y", 90)


def baseball_bat_standing(k: int) -> Part:
    """Leaning back, as against a wall."""
    return turned(bat_on_end(k), "x", -9)


def basketball(k: int) -> Part:
    """With its eight panels."""
    skin, seam = pick(k, ((0.85, 0.38, 0.1), c.DARK), ((0.74, 0.3, 0.12), c.DARK),
                      ((0.9, 0.5, 0.2), c.DARK), ((0.62, 0.25, 0.12), (0.1, 0.05, 0.04)),
                      ((0.86, 0.33, 0.08), c.NAVY), ((0.8, 0.42, 0.16), c.DARK))  # fmt: skip
    r = pick(k, 0.12, 0.116, 0.12, 0.11)
    t = np.linspace(0, 2 * np.pi, 29)
    zero = np.zeros_like(t)
    lines = [np.stack([np.cos(t), np.sin(t), zero], 1), np.stack([np.cos(t), zero, np.sin(t)], 1)]
    for side in (-1, 1):
        y, z = 0.62 * np.cos(t), 0.86 * np.sin(t)
        lines.append(np.stack([side * np.sqrt(np.clip(1 - y**2 - z**2, 0, 1)), y, z], 1))
    parts = [ball((2, 2, 2), (0, 0, -1), skin, 12, 20)]
    for line in lines:
        parts.append(_ribbon(line, 1.006, 0.036, seam))
    return turned(turned(scaled(parts, r), "z", 25 + 40 * k), "x", 15 * k)


def _ribbon(line: Array, radius: float, half: float, colour: Rgb) -> Soup:
    """A band along a closed line on the unit ball."""
    along = np.roll(line[:-1], -1, axis=0) - np.roll(line[:-1], 1, axis=0)
    along = np.concatenate([along, along[:1]])
    side = np.cross(line, along)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    edges = [line * radius - side * half, line * radius + side * half]
    return surface(np.stack(edges), colour)


def bowl(k: int) -> Part:
    """Open above, on a foot."""
    outside, inside = pick(k, (c.BLUE, c.WHITE), (c.WHITE, c.CREAM), (c.RED, c.CREAM),
                           (c.PALE_WOOD, c.WOOD),
                           (c.TEAL, c.TEAL), (c.DARK, c.ORANGE))  # fmt: skip
    r, h = pick(
        k, (0.09, 0.075), (0.11, 0.07), (0.075, 0.08), (0.13, 0.09), (0.1, 0.065), (0.08, 0.085)
    )
    curve = [(0.4, 0), (0.42, 0.06), (0.62, 0.18), (0.84, 0.45), (0.95, 0.75), (1, 1)]
    steep = [(0.5, 0), (0.5, 0.08), (0.6, 0.12), (0.8, 0.3), (0.92, 0.62), (1, 1)]
    profile = [(a * r, b * h) for a, b in (curve if k % 2 == 0 else steep)]
    parts = vessel(profile, outside, inside, 0.006, 22)
    if k in (1, 4):
        band = [(r * 0.955, h * 0.72), (r * 1.002, h * 0.9)]
        parts.append(lathe(band, pick(k, c.BLUE, c.BLUE, c.RED, c.RED, c.CREAM), 22))
    return parts


def mug(k: int) -> Part:
    """With a handle; some with a band."""
    colour, band = pick(k, (c.WHITE, c.BLUE), (c.RED, c.CREAM), (c.BLUE, None), (c.YELLOW, c.DARK),
                        (c.DARK, c.ORANGE), (c.GREEN, c.CREAM))  # fmt: skip
    r, h = pick(k, (0.041, 0.096), (0.044, 0.09), (0.04, 0.105), (0.045, 0.1))
    waist = pick(k, 1.0, 0.92, 1.06)
    profile = [(r * 0.86, 0), (r * waist, h * 0.12), (r * waist, h * 0.85), (r, h)]
    parts = vessel(profile, colour, pick(k, c.WHITE, c.CREAM, c.WHITE), 0.004, 20)
    if band is not None:
        rb = r * waist + 0.0006
        parts.append(lathe([(rb, h * 0.3), (rb, h * pick(k, 0.45, 0.7))], band, 20))
    grip = arc((r * waist - 0.004, 0, h * 0.5), h * 0.3, -90, 90, "xz", 8)
    return [*parts, tube(grip, 0.006, colour, 6)]


def spray_bottle(k: int) -> Part:
    """A bottle with a trigger head, its nozzle along -y."""
    body, head = pick(k, ((0.2, 0.5, 0.85), c.WHITE), (c.WHITE, c.BLUE),
                      ((0.3, 0.7, 0.35), c.WHITE),
                      (c.PINK, c.PURPLE), ((0.9, 0.6, 0.15), c.DARK), (c.DARK, c.RED))  # fmt: skip
    shoulder = pick(k, 0.12, 0.14, 0.11)
    r = pick(k, 0.038, 0.034, 0.04)
    low = [(0, 0), (r, 0), (r, 0.05), (r * 0.86, 0.08), (r * 0.95, shoulder),
           (r * 0.6, shoulder + 0.035), (0.013, shoulder + 0.055)]  # fmt: skip
    z = shoulder + 0.055
    label = [(r + 0.0006, 0.008), (r + 0.0006, 0.045)]
    parts = scaled(
        [lathe(low, body, 16), lathe(label, pick(k, c.YELLOW, c.RED, c.WHITE), 16)], (0.8, 1, 1)
    )
    parts += [
        cylinder(0.016, 0.016, 0.02, head, 12, (0, 0, z)),
        box((0.022, 0.075, 0.028), (0, -0.012, z + 0.02), head),
        box((0.018, 0.03, 0.012), (0, 0.025, z + 0.012), head),
        box((0.014, 0.016, 0.016), (0, -0.055, z + 0.028), pick(k, c.RED, c.YELLOW, c.GREY)),
    ]
    trigger = tube([(0, -0.034, z + 0.022), (0, -0.044, z), (0, -0.038, z - 0.03)], 0.006,
                   pick(k, c.RED, c.YELLOW, c.GREY), 6)  # fmt: skip
    return [*parts, trigger]
