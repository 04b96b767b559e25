"""More of RoboTHOR's small goals: profiles, handles, patterns and colours drawn by seed, in the
proportions that its things have. Varied homes and replicas show them."""

import colorsys
import random

import numpy as np

from hil_sim.scenes.furniture.shapes import palette as c
from hil_sim.scenes.furniture.shapes.goals import (
    Profile,
    bat,
    bat_band,
    bells,
    digital_case,
    digits,
    leaf,
)
from hil_sim.scenes.furniture.shapes.palette import Rgb
from hil_sim.scenes.furniture.shapes.primitives import (
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
    scaled,
    shade,
    tube,
    turned,
    vessel,
)

SIDES = 18

VASES: tuple[Profile, ...] = (
    ((0.55, 0), (0.62, 0.05), (0.95, 0.3), (1, 0.5), (0.8, 0.72), (0.45, 0.85), (0.6, 1)),
    ((0.5, 0), (0.46, 0.08), (0.62, 0.3), (0.92, 0.56), (1, 0.7), (0.5, 0.86), (0.62, 1)),
    ((0.75, 0), (1, 0.12), (0.98, 0.35), (0.6, 0.6), (0.36, 0.75), (0.36, 0.92), (0.5, 1)),
    ((0.6, 0), (0.72, 0.1), (0.95, 0.35), (1, 0.55), (0.9, 0.75), (0.68, 0.9), (0.76, 1)),
    ((0.62, 0), (0.5, 0.1), (0.6, 0.3), (0.92, 0.62), (1, 0.75), (0.66, 0.88), (0.9, 1)),
    ((0.8, 0), (1, 0.1), (1, 0.3), (0.62, 0.48), (0.76, 0.66), (0.6, 0.84), (0.68, 1)),
)
"""Radius and height as shares, from the foot to the lip."""
LOW_VASES: tuple[Profile, ...] = (
    ((0.5, 0), (0.86, 0.1), (1, 0.27), (0.84, 0.44), (0.36, 0.57), (0.27, 0.78), (0.4, 1)),
    ((0.6, 0), (1, 0.16), (0.96, 0.3), (0.56, 0.46), (0.27, 0.58), (0.24, 0.84), (0.34, 1)),
    ((0.5, 0), (0.8, 0.12), (1, 0.32), (0.9, 0.44), (0.4, 0.54), (0.28, 0.68), (0.36, 1)),
)
BOWLS: tuple[Profile, ...] = (
    ((0.42, 0), (0.44, 0.07), (0.66, 0.2), (0.86, 0.46), (0.96, 0.76), (1, 1)),
    ((0.5, 0), (0.52, 0.1), (0.78, 0.22), (0.94, 0.5), (0.98, 0.8), (1, 1)),
    ((0.36, 0), (0.38, 0.1), (0.55, 0.3), (0.72, 0.55), (0.88, 0.8), (1, 1)),
    ((0.6, 0), (0.85, 0.1), (0.97, 0.35), (1, 0.6), (0.98, 0.85), (0.95, 1)),
)
BALLS = (
    ((0.83, 0.4, 0.14), c.DARK), ((0.7, 0.27, 0.12), c.DARK), ((0.88, 0.47, 0.24), c.DARK),
    ((0.78, 0.34, 0.06), (0.2, 0.1, 0.06)),
)  # fmt: skip


def _dice(name: str, k: int) -> random.Random:
    return random.Random(f"{name}/{k}")


def _colour(rng: random.Random, strong: float = 0.6) -> Rgb:
    """Strong colours, and pale or earthen ones."""
    if rng.random() < strong:
        return colorsys.hsv_to_rgb(rng.random(), rng.uniform(0.3, 0.8), rng.uniform(0.25, 0.85))
    return colorsys.hsv_to_rgb(rng.gauss(0.09, 0.02), rng.uniform(0.0, 0.45), rng.uniform(0.4, 1))


def _skin(rng: random.Random, profile: Profile, sides: int = SIDES) -> tuple[Part, Rgb]:
    """An outside in a pattern: plain, banded, dipped in another glaze, striped or chequered; and
    its main colour."""
    grid = lathe_grid([(0.0, profile[0][1]), *profile], sides)
    rows, cols = np.indices((len(profile), sides))
    kind = rng.randrange(6)
    which = (
        np.zeros_like(rows),
        (rows == rng.randrange(2, len(profile))).astype(int),
        (rows >= rng.randrange(2, len(profile))).astype(int),
        cols // 3 % 2,
        (rows + cols // 3) % 2,
        np.zeros_like(rows),
    )[kind]
    main, other = _colour(rng), _colour(rng)
    return painted(grid, (main, other), np.asarray(which, np.int64)), main


def _hollow(rng: random.Random, profile: Profile, inside: Rgb | None = None) -> tuple[Part, Rgb]:
    """An open body in a pattern, and its main colour."""
    skin, main = _skin(rng, profile)
    lining = vessel(profile, main, inside or shade(main, 1.15), 0.004, SIDES)[1]
    return [*skin, lining], main


def drawn_vase(k: int) -> Part:
    """Turned, of six forms, 17 to 32 cm high; some with two handles."""
    rng = _dice("vase", k)
    form = VASES[k % len(VASES)]
    r, h = rng.choice(((0.091, 0.188), (0.094, 0.244), (0.087, 0.295), (0.074, 0.288)))
    r, h = r * rng.uniform(0.96, 1.04), h * rng.uniform(0.92, 1.06)
    profile = [(a * r, b * h) for a, b in form]
    parts, main = _hollow(rng, profile, c.DARK)
    if form[4][0] < 0.5:
        for side in (-1, 1):
            ear = arc((side * 0.36 * r, 0, 0.75 * h), 0.14 * h, -80, 80, "xz", 6)
            ear[:, 0] = side * np.abs(ear[:, 0])
            parts.append(tube(ear, 0.006, main, 5))
    return parts


def drawn_low_vase(k: int) -> Part:
    """A globe of 8 cm with a neck, 7 cm high."""
    rng = _dice("low vase", k)
    r = rng.uniform(0.04, 0.043)
    profile = [(r * a, 0.07 * b) for a, b in LOW_VASES[k % len(LOW_VASES)]]
    return _hollow(rng, profile, c.DARK)[0]


def drawn_bowl(k: int) -> Part:
    """Open above, low to deep."""
    rng = _dice("bowl", k)
    r = rng.uniform(0.075, 0.12)
    form = k % len(BOWLS)
    deep = rng.choice((0.32, 0.4, 0.46, 0.55, 0.66, 0.74))
    h = 2 * r * min(deep, (0.74, 0.74, 0.46, 0.55)[form])
    profile = [(a * r, b * h) for a, b in BOWLS[form]]
    return _hollow(rng, profile, rng.choice((None, c.WHITE, c.CREAM)))[0]


def drawn_mug(k: int) -> Part:
    """Straight, waisted, bellied or tapered, with a round or a square handle."""
    rng = _dice("mug", k)
    r, h = rng.uniform(0.039, 0.05), rng.uniform(0.088, 0.106)
    low, middle = rng.choice(((1, 1), (0.98, 0.88), (0.8, 1.05), (0.78, 0.9)))
    profile = [(r * low, 0), (r * low, h * 0.08), (r * (low + middle) / 2, h * 0.28),
               (r * middle, h * 0.5), (r * (1 + middle) / 2, h * 0.78), (r, h)]  # fmt: skip
    parts, main = _hollow(rng, profile, rng.choice((None, c.WHITE, c.CREAM)))
    out, reach = r * middle - 0.003, rng.uniform(0.026, 0.034)
    round_ = arc((out, 0, h * 0.5), reach, -90, 90, "xz", 8)
    corners = ((out, 0.24), (out + reach, 0.26), (out + reach, 0.74), (out, 0.76))
    square = np.array([(x, 0.0, z * h) for x, z in corners])
    return [*parts, tube(round_ if rng.random() < 0.6 else square, 0.0055, main, 6)]


def drawn_apple(k: int) -> Part:
    """Red, green, yellow or of two colours, round to tall; every fourth lies on its side."""
    rng = _dice("apple", k)
    hue = rng.choice((0.0, 0.98, 0.99, 0.01, 0.14, 0.2, 0.24, 0.27))
    skin = colorsys.hsv_to_rgb(hue, rng.uniform(0.65, 0.95), rng.uniform(0.5, 0.85))
    blush = colorsys.hsv_to_rgb(rng.choice((0.02, 0.1, 0.18)), 0.7, 0.8)
    r, h = rng.uniform(0.04, 0.05), rng.uniform(0.082, 0.1)
    wide = rng.uniform(0.82, 0.96)
    profile = [(0, 0.07), (0.3, 0), (0.55, 0.04), (0.82, 0.24), (wide, 0.46), (1, 0.66),
               (0.9, 0.86), (0.62, 0.98), (0.3, 0.97), (0, 0.82)]  # fmt: skip
    which = np.zeros((9, 16), np.int64)
    which[2:7, 3 : rng.randrange(5, 10)] = 1
    parts = painted(lathe_grid([(a * r, b * h) for a, b in profile], 16), (skin, blush), which)
    parts.append(tube([(0, 0, 0.8 * h), (0.003, 0, 1.02 * h), (0.01, 0, 1.2 * h)], 0.0025,
                      c.DARK_WOOD, 5))  # fmt: skip
    if rng.random() < 0.5:
        parts += leaf(0.034, 20, h)
    return turned(parts, "y", 80) if k % 4 == 3 else parts


def _bat(k: int) -> Part:
    """On its knob, upright: wood or metal, with a wrapped grip and some with a band."""
    rng = _dice("bat", k)
    wood = colorsys.hsv_to_rgb(
        rng.uniform(0.06, 0.11), rng.uniform(0.35, 0.7), rng.uniform(0.35, 0.85)
    )
    body = wood if rng.random() < 0.6 else _colour(rng)
    grip = rng.choice((wood, c.DARK, c.WHITE, c.RED, c.NAVY))
    length, r = rng.uniform(0.84, 0.96), rng.uniform(0.036, 0.043)
    low = [(0, 0), (0.027, 0.003), (0.027, 0.016), (0.015, 0.026), (0.015, 0.27)]
    high = [(0.02, 0.43), (r * 0.86, 0.6), (r, 0.72), (r, length - 0.02)]
    below, parts = rng.uniform(0.1, 0.16), bat(low, high, length, body, grip)
    return [*parts, bat_band(r, length, below, _colour(rng))] if rng.random() < 0.6 else parts


def drawn_bat(k: int) -> Part:
    """Lying along x."""
    return turned(_bat(k), "y", 90)


def drawn_leaning_bat(k: int) -> Part:
    """Leaning back, as against a wall: by 4 to 20 degrees, the last one by 52."""
    return turned(_bat(k + 20), "x", -(4 + 4 * (k % 5) if k < 20 else 52))


def drawn_ball(k: int) -> Part:
    """A basketball, its seams two great circles and two arcs."""
    skin, seam = BALLS[k % len(BALLS)]
    rng, t = _dice("ball", k), np.linspace(0, 2 * np.pi, 25)
    y, z = rng.uniform(0.55, 0.67) * np.cos(t), 0.88 * np.sin(t)
    side = np.sqrt(np.clip(1 - y**2 - z**2, 0, 1))
    circle = np.stack([np.cos(t), np.sin(t), 0 * t], 1)
    lines = (circle, circle[:, [0, 2, 1]], np.stack([side, y, z], 1), np.stack([-side, y, z], 1))
    parts = [ball((0.24, 0.24, 0.24), (0, 0, -0.12), skin, 14, 20)]
    parts += [tube(0.12 * line, 0.003, seam, 4) for line in lines]
    return turned(turned(parts, "z", rng.uniform(0, 90)), "x", rng.uniform(0, 90))


def drawn_spray_bottle(k: int) -> Part:
    """Flat and slim, as a hand holds it: body, neck, trigger and a nozzle along -y."""
    rng = _dice("spray", k)
    body, head, trigger = (
        _colour(rng, 0.8),
        rng.choice((c.WHITE, c.DARK, _colour(rng))),
        _colour(rng),
    )
    high, deep = rng.uniform(0.16, 0.18), rng.uniform(0.041, 0.046)
    waist = deep * rng.uniform(0.86, 1)
    low = [(0, 0), (deep, 0), (deep, 0.01), (waist, high * 0.5), (deep, high * 0.75),
           (deep * 0.7, high * 0.92), (0.014, high), (0.014, high + 0.012)]  # fmt: skip
    label = [(deep + 0.001, high * 0.15), (deep * 0.99 + 0.001, high * 0.4)]
    z = high + 0.008
    return [
        *scaled([lathe(low, body, 16), lathe(label, _colour(rng), 16)], (0.39, 1, 1)),
        cylinder(0.0165, 0.0165, 0.02, head, 12, (0, 0, z)),
        box((0.026, 0.09, 0.026), (0, -0.014, z + 0.02), head),
        box((0.022, 0.04, 0.014), (0, 0.008, z + 0.046), head),
        box((0.018, 0.014, 0.018), (0, -0.065, z + 0.024), trigger),
        tube(
            [(0, -0.03, z + 0.022), (0, -0.05, z - 0.004), (0, -0.044, z - 0.04)], 0.006, trigger, 6
        ),
    ]


def drawn_alarm_clock(k: int) -> Part:
    """Round with bells (0, 3), a cube with a dial (1, 4), or long with digits (2, 5)."""
    rng = _dice("clock", k)
    case, trim = _colour(rng), rng.choice((c.STEEL, c.BRASS, c.DARK, c.WHITE))
    if k % 3 == 2:
        size = rng.uniform(0.2, 0.27), rng.uniform(0.07, 0.11), rng.uniform(0.1, 0.13)
        time = rng.choice(("7:30", "6:15", "10:24"))
        light = rng.choice(((1, 0.2, 0.1), (0.2, 0.95, 0.5), c.WHITE))
        return digital_case(size, (0.12, 0.76), case, digits(time, size[2] * 0.42, light))
    r, deep = 0.076, rng.choice((0.06, 0.1, 0.14))
    dial = moved(_dial(rng, r), (0, -deep / 2, 0))
    if k % 3 == 1:
        cube = [
            box((2.2 * r, deep, 2.2 * r), (0, 0, 0.012), case),
            *moved(dial, (0, 0, 0.012 + 1.1 * r)),
        ]
        feet = [box((0.02, 0.02, 0.012), (s * r * 0.9, 0, 0), trim) for s in (-1, 1)]
        return [*cube, *feet, box((0.05, 0.03, 0.014), (0, 0, 0.012 + 2.2 * r), trim)]
    parts = [*moved([disc(r * 1.12, deep, case, 20), *dial], (0, 0, 1.12 * r + 0.014))]
    top = 2.24 * r + 0.01
    bell = lathe([(0, 0), (0.034, 0), (0.031, 0.014), (0.018, 0.026), (0, 0.03)], trim, 12)
    parts += bells(bell, 28, (0.036, top - 0.004), ((0.03, 0.04), 0.055), trim)
    grip = [(-0.034, 0, top + 0.026), (0, 0, top + 0.044), (0.034, 0, top + 0.026)]
    return [*parts, tube(grip, 0.004, trim, 5)]


def _dial(rng: random.Random, r: float) -> Part:
    """A white face with twelve marks and two hands that looks along -y, at y = 0."""
    parts = moved([disc(r, 0.004, rng.choice((c.WHITE, c.CREAM)), 20)], (0, -0.002, 0))
    for hour in range(12):
        mark = box((0.007 if hour % 3 else 0.011, 0.002, 0.012), (0, -0.005, r * 0.74), c.DARK)
        parts += turned([mark], "y", 30 * hour)
    for length, degrees in ((0.66, rng.uniform(0, 360)), (0.45, rng.uniform(0, 360))):
        parts += turned([box((0.008, 0.002, r * length), (0, -0.007, 0), c.DARK)], "y", degrees)
    return parts


def closed_laptop(k: int) -> Part:
    """Shut: the lid a little smaller than the body, its badge, the hinge at the back."""
    rng = _dice("closed laptop", k)
    body = rng.choice((c.STEEL, c.DARK, c.WHITE, c.GREY, c.NAVY, (0.78, 0.7, 0.6)))
    w, d, h = rng.uniform(0.33, 0.42), rng.uniform(0.25, 0.29), 0.03
    lid = shade(body, 0.9)
    return [
        box((w, d, h * 0.5), (0, 0, 0.003), body),
        box((w * 0.985, d * 0.985, h * 0.06), (0, 0, 0.003 + h * 0.5), c.DARK),
        box((w, d, h * 0.3), (0, 0, 0.003 + h * 0.56), lid),
        *moved(turned([cylinder(0.007, 0.007, w * 0.7, c.DARK, 8)], "y", 90),
               (-w * 0.35, d / 2 - 0.004, h * 0.5)),
        cylinder(0.022, 0.022, 0.001, shade(body, 1.6) if body != c.WHITE else c.GREY, 14,
                 (0, 0, 0.003 + h * 0.86)),
        *[box((0.03, 0.02, 0.003), (sx * w * 0.4, sy * d * 0.4, 0), c.DARK)
          for sx in (-1, 1) for sy in (-1, 1)],
    ]  # fmt: skip
