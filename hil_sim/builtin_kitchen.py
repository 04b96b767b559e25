"""Meshes of what a kitchen has besides furniture: vessels, cutlery, food, small machines."""

import numpy as np

from hil_sim.builtin_shapes import (
    BLUE,
    BRASS,
    CREAM,
    DARK,
    DARK_WOOD,
    GREEN,
    GREY,
    NAVY,
    ORANGE,
    PINK,
    RED,
    STEEL,
    TEAL,
    WHITE,
    WOOD,
    YELLOW,
    Part,
    Rgb,
    arc,
    ball,
    box,
    cylinder,
    disc,
    lathe,
    moved,
    pick,
    scaled,
    slab,
    tube,
    turned,
    vessel,
)

GLASS: Rgb = (0.72, 0.82, 0.84)


def bottle(k: int) -> Part:
    """With a neck, a label and a cap."""
    body, label, cap = pick(
        k,
        (GREEN, CREAM, RED),
        (GLASS, BLUE, WHITE),
        (DARK_WOOD, YELLOW, BRASS),
        (WHITE, RED, RED),
        ((0.3, 0.45, 0.7), WHITE, NAVY),
        (ORANGE, DARK, DARK),
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
        ((0.08, 0.16, 0.08), CREAM, RED),
        ((0.1, 0.06, 0.05), WHITE, BRASS),
        ((0.45, 0.5, 0.2), CREAM, GREEN),
        ((0.1, 0.06, 0.05), BRASS, DARK),
        ((0.62, 0.25, 0.28), WHITE, PINK),
        ((0.08, 0.16, 0.08), NAVY, BRASS),
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
    colour = pick(k, GLASS, (0.6, 0.75, 0.8), (0.8, 0.82, 0.84))
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
    colour = pick(k, (0.75, 0.35, 0.3), WHITE, TEAL, YELLOW, STEEL, PINK)
    if k % 2 == 0:
        r, h = pick(k, 0.04, 0.0, 0.038, 0.0, 0.042), pick(k, 0.12, 0.0, 0.1, 0.0, 0.14)
        rim = lathe([(r + 0.0006, h * 0.8), (r + 0.0008, h * 0.9)], pick(k, CREAM, DARK, NAVY), 18)
        return [*vessel([(r * 0.75, 0), (r * 0.8, 0.01), (r, h)], colour, CREAM, 0.003, 18), rim]
    saucer = lathe(
        [(0, 0), (0.03, 0), (0.07, 0.012), (0.07, 0.015), (0.03, 0.006), (0, 0.006)], colour, 18
    )
    body = vessel(
        [(0.022, 0), (0.03, 0.012), (0.043, 0.045), (0.046, 0.06)], colour, WHITE, 0.003, 18
    )
    grip = tube(arc((0.042, 0, 0.036), 0.016, -90, 90, "xz", 6), 0.0035, colour, 5)
    tea = lathe([(0.041, 0.05), (0, 0.051)], DARK_WOOD, 18)
    return [saucer, *moved([*body, grip, tea], (0, 0, 0.006))]


def plate(k: int) -> Part:
    """Flat with a rim."""
    rim, middle = pick(
        k, (WHITE, WHITE), (BLUE, WHITE), (CREAM, CREAM), (TEAL, TEAL), (WHITE, RED), (DARK, GREY)
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
        (STEEL, DARK),
        (STEEL, DARK),
        (RED, DARK),
        (DARK, WOOD),
        (BLUE, CREAM),
        ((0.7, 0.4, 0.25), BRASS),
    )
    r, h = pick(k, (0.12, 0.13), (0.09, 0.09), (0.13, 0.12))
    outside = [(r * 0.96, 0), (r, 0.01), (r, h), (r * 1.03, h)]
    if k % 2:
        handle = tube(
            [(r, 0, h * 0.8), (r + 0.06, 0, h * 0.9), (r + 0.18, 0, h * 0.98)], 0.009, trim, 6
        )
        return [*vessel(outside, body, GREY, 0.004, 20), handle]
    lid = lathe(
        [(0, h), (r * 1.03, h), (r * 1.03, h + 0.006), (r * 0.5, h + 0.025), (0, h + 0.03)],
        pick(k, GLASS, GLASS, body),
        20,
    )
    ears = [tube(_ear(side, r, h), 0.007, trim, 6) for side in (-1, 1)]
    return [
        *vessel(outside, body, GREY, 0.004, 20),
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
        (DARK, GREY, DARK),
        (STEEL, DARK, STEEL),
        (RED, CREAM, DARK),
        (DARK, DARK, WOOD),
        (TEAL, GREY, DARK),
        ((0.7, 0.4, 0.25), STEEL, BRASS),
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
    """With a spout, a lid and a handle; some electric, on a base."""
    body, trim = pick(
        k, (STEEL, DARK), (WHITE, GREY), (RED, DARK), (DARK, STEEL), (CREAM, WOOD), (TEAL, DARK)
    )
    electric = k % 2 == 1
    r, h = (0.075, 0.2) if electric else (0.1, 0.14)
    base = 0.02 if electric else 0.0
    waist = [
        (0, 0),
        (r, 0),
        (r * 0.98, h * 0.3),
        (r * (0.78 if electric else 0.7), h * 0.85),
        (r * 0.4, h),
        (0, h),
    ]
    parts = moved(
        [lathe(waist, body, 20), ball((0.03, 0.03, 0.025), (0, 0, h), trim, 6, 10)], (0, 0, base)
    )
    if electric:
        parts += [
            cylinder(r * 1.05, r, 0.02, trim, 20),
            tube(
                [
                    (0, r * 0.8, base + h * 0.85),
                    (0, r + 0.045, base + h * 0.8),
                    (0, r + 0.045, base + h * 0.25),
                    (0, r * 0.95, base + h * 0.15),
                ],
                0.011,
                trim,
                6,
            ),
        ]
        return [
            *parts,
            tube(
                [(0, -r * 0.6, base + h * 0.78), (0, -r - 0.02, base + h * 0.92)],
                [0.03, 0.012],
                body,
                8,
            ),
        ]
    parts.append(
        tube(
            [(0, -r * 0.8, h * 0.4), (0, -r * 1.15, h * 0.6), (0, -r * 1.4, h * 0.95)],
            [0.022, 0.016, 0.01],
            body,
            8,
        )
    )
    return [*parts, tube(arc((0, 0, h * 0.8), r * 0.85, 10, 170, "yz", 10), 0.009, trim, 6)]


def teapot(k: int) -> Part:
    """A round pot with a spout and a looped handle."""
    body, lid = pick(
        k,
        (BLUE, WHITE),
        (WHITE, WHITE),
        (DARK_WOOD, DARK_WOOD),
        (GREEN, GREEN),
        (RED, CREAM),
        (YELLOW, DARK),
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


def toaster(k: int) -> Part:
    """Two slots above, a lever at its end."""
    body = pick(k, STEEL, RED, CREAM, DARK, TEAL, WHITE)
    w, h = pick(k, 0.28, 0.26), pick(k, 0.19, 0.18)
    parts = [
        box((w * 0.98, 0.15, 0.02), (0, 0, 0), DARK),
        ball((w, 0.17, h), (0, 0, 0.012), body, 10, 18, 0.3),
    ]
    top = h + 0.012
    slots = [
        box((w * 0.72, 0.028, 0.004), (0, side * 0.035, top - 0.002), DARK) for side in (-1, 1)
    ]
    bread = [box((w * 0.5, 0.016, 0.035), (0, 0.035, top), (0.8, 0.6, 0.35))] if k % 2 else []
    return [
        *parts,
        *slots,
        *bread,
        box((0.02, 0.035, 0.02), (w / 2 + 0.008, 0, h * 0.7), DARK),
        *moved([disc(0.016, 0.012, pick(k, DARK, STEEL), 10)], (w * 0.25, -0.088, h * 0.35)),
    ]


def coffee_machine(k: int) -> Part:
    """A tower with a jug (even) or an espresso machine (odd)."""
    body = pick(k, DARK, STEEL, WHITE, RED, GREY, CREAM)
    if k % 2:
        return [
            box((0.26, 0.28, 0.05), (0, 0, 0), GREY),
            box((0.26, 0.14, 0.2), (0, 0.07, 0.05), body),
            box((0.26, 0.28, 0.1), (0, 0, 0.22), body),
            cylinder(0.035, 0.03, 0.035, STEEL, 14, (0, -0.07, 0.185)),
            tube([(0, -0.09, 0.2), (0, -0.22, 0.19)], 0.012, DARK, 6),
            tube([(0.1, -0.1, 0.22), (0.11, -0.13, 0.1)], 0.006, STEEL, 5),
            *moved(
                vessel([(0.02, 0), (0.028, 0.045)], WHITE, DARK_WOOD, 0.003, 12), (0, -0.07, 0.051)
            ),
            *moved([disc(0.018, 0.01, RED if body != RED else STEEL, 12)], (-0.07, -0.145, 0.27)),
        ]
    jug = vessel(
        [(0.05, 0), (0.062, 0.03), (0.055, 0.1), (0.04, 0.12)], (0.25, 0.16, 0.12), None, 0.003, 16
    )
    grip = tube(arc((0, -0.055, 0.06), 0.035, 90, 270, "yz", 6), 0.006, DARK, 5)
    return [
        box((0.19, 0.24, 0.03), (0, 0, 0), body),
        box((0.19, 0.08, 0.28), (0, 0.08, 0.03), body),
        box((0.19, 0.24, 0.1), (0, 0, 0.24), body),
        box((0.08, 0.006, 0.04), (0, -0.122, 0.27), (0.3, 0.7, 0.5)),
        *moved([*jug, grip], (0, -0.04, 0.031)),
    ]


def microwave(k: int) -> Part:
    """With a dark door, a handle and keys."""
    body, door = pick(
        k, (WHITE, DARK), (STEEL, DARK), (DARK, GREY), (CREAM, DARK), (RED, DARK), (GREY, DARK)
    )
    w, d, h = pick(k, (0.48, 0.36, 0.28), (0.52, 0.4, 0.3), (0.45, 0.34, 0.26))
    parts = [
        box((w, d, h), (0, 0, 0), body),
        box((w * 0.68, 0.008, h * 0.84), (-w * 0.13, -d / 2 - 0.003, h * 0.08), door),
        box((w * 0.5, 0.004, h * 0.52), (-w * 0.15, -d / 2 - 0.008, h * 0.24), (0.16, 0.17, 0.19)),
        tube(
            [(w * 0.2, -d / 2 - 0.03, h * 0.15), (w * 0.2, -d / 2 - 0.03, h * 0.85)],
            0.008,
            STEEL,
            6,
        ),
        box((w * 0.19, 0.004, h * 0.14), (w * 0.36, -d / 2 - 0.002, h * 0.74), (0.1, 0.75, 0.5)),
    ]
    keys = [
        box(
            (w * 0.045, 0.005, h * 0.07),
            (w * (0.29 + 0.07 * i), -d / 2 - 0.002, h * (0.2 + 0.12 * j)),
            GREY if body != GREY else WHITE,
        )
        for i in range(3)
        for j in range(4)
    ]
    return parts + keys


def blender(k: int) -> Part:
    """A jug on a motor."""
    body = pick(k, DARK, WHITE, RED, STEEL, GREEN, CREAM)
    jug = lathe([(0.04, 0.14), (0.065, 0.32), (0, 0.32)], GLASS, 12)
    drink = lathe([(0.043, 0.143), (0.056, 0.24)], pick(k, PINK, ORANGE, GREEN, GLASS), 12)
    return [
        lathe([(0, 0), (0.08, 0), (0.075, 0.05), (0.05, 0.14), (0, 0.14)], body, 16),
        jug,
        *scaled([drink], (1.03, 1.03, 1)),
        cylinder(0.062, 0.05, 0.03, DARK, 14, (0, 0, 0.32)),
        *moved([disc(0.018, 0.012, STEEL, 12)], (0, -0.066, 0.07)),
        tube([(0.06, 0, 0.3), (0.1, 0, 0.28), (0.1, 0, 0.2), (0.05, 0, 0.17)], 0.008, body, 6),
    ]


def shaker(k: int, salt: bool) -> Part:
    """A shaker, its holes above; pepper comes in dark ones or as a mill."""
    colour = (
        pick(k, WHITE, GLASS, CREAM, STEEL, PINK, (0.7, 0.8, 0.9))
        if salt
        else pick(k, DARK, (0.2, 0.2, 0.22), DARK_WOOD, WOOD, GREY, RED)
    )
    if not salt and k % 2:
        mill = [
            (0, 0),
            (0.03, 0),
            (0.03, 0.02),
            (0.018, 0.07),
            (0.026, 0.12),
            (0.026, 0.13),
            (0.016, 0.135),
            (0.028, 0.16),
            (0.02, 0.185),
            (0, 0.19),
        ]
        return [lathe(mill, colour, 16), ball((0.014, 0.014, 0.014), (0, 0, 0.188), STEEL, 5, 8)]
    h = pick(k, 0.1, 0.085, 0.11)
    parts = [
        lathe([(0, 0), (0.03, 0), (0.026, h * 0.5), (0.021, h * 0.78)], colour, 14),
        lathe(
            [(0.023, h * 0.76), (0.023, h * 0.88), (0.015, h), (0, h * 1.02)],
            STEEL if colour != STEEL else DARK,
            14,
        ),
    ]
    holes = [
        box((0.003, 0.003, 0.002), (0.008 * np.cos(a), 0.008 * np.sin(a), h * 1.005), DARK)
        for a in np.radians((0, 72, 144, 216, 288))
    ]
    return [
        *parts,
        *holes,
        lathe(
            [(0.0285, h * 0.2), (0.0272, h * 0.4)], pick(k, BLUE, RED, TEAL) if salt else WHITE, 14
        ),
    ]


def salt_shaker(k: int) -> Part:
    """Pale."""
    return shaker(k, True)


def pepper_shaker(k: int) -> Part:
    """Dark, every other one a mill."""
    return shaker(k, False)


def _grip(k: int) -> tuple[Rgb, Rgb]:
    return pick(
        k, (STEEL, STEEL), (STEEL, WOOD), (STEEL, DARK), (BRASS, BRASS), (STEEL, RED), (STEEL, BLUE)
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
    metal, handle = STEEL, _grip(k)[1]
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
        for p in turned([ball((0.03, 0.01, 0.004), (0.017, 0, h * 0.985), GREEN, 4, 6)], "z", a)
    ]
    return [
        lathe([(a * r, b * h) for a, b in profile], skin, 16),
        *leaves,
        tube([(0, 0, h * 0.9), (0.003, 0, h * 1.15)], 0.003, GREEN, 5),
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
        k, CREAM, WHITE, (0.82, 0.62, 0.45), (0.7, 0.5, 0.36), (0.93, 0.9, 0.86), (0.75, 0.82, 0.8)
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


def paper_towel(k: int) -> Part:
    """A roll, some on a stand."""
    r, h = pick(k, 0.06, 0.055, 0.065), pick(k, 0.24, 0.26)
    base = [
        cylinder(0.08, 0.075, 0.012, pick(k, WOOD, STEEL, DARK), 18),
        cylinder(0.008, 0.008, 0.3, pick(k, WOOD, STEEL, DARK), 8),
    ]
    roll = vessel([(0.02, 0), (r, 0), (r, h), (0.02, h)], WHITE, None, 0.002, 20)
    sheet = box((0.05, 0.003, h), (r - 0.02, -r - 0.001, 0), WHITE)
    print_ = lathe([(r + 0.0006, h * 0.12), (r + 0.0006, h * 0.18)], pick(k, BLUE, PINK, GREEN), 20)
    core = lathe([(0.02, h), (0, h * 0.99)], (0.65, 0.5, 0.35), 12)
    return [
        *base,
        *moved([*roll, sheet, print_, core, *moved([print_], (0, 0, h * 0.6))], (0, 0, 0.012)),
    ]


def bucket(k: int) -> Part:
    """With a bail handle."""
    body = pick(k, BLUE, RED, STEEL, YELLOW, GREEN, GREY)
    return [
        *vessel([(0.1, 0), (0.14, 0.25), (0.146, 0.25), (0.146, 0.26)], body, None, 0.004, 20),
        tube(
            [
                (0.146 * np.cos(a), -0.12 * np.sin(a), 0.25 + 0.08 * np.sin(a))
                for a in np.linspace(0, np.pi, 12)
            ],
            0.004,
            STEEL if body != STEEL else DARK,
            5,
        ),
    ]
