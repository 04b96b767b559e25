"""Meshes of furniture that the catalogues have few of."""

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
    PALE_WOOD,
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
    ring,
    scaled,
    surface,
    tube,
    turned,
    vessel,
)


def _legs(w: float, d: float, h: float, thick: float, colour: Rgb) -> Part:
    x, y = w / 2 - thick, d / 2 - thick
    return [box((thick, thick, h), (sx * x, sy * y, 0), colour) for sx in (-1, 1) for sy in (-1, 1)]


def _drawers(
    w: float,
    front: float,
    low: float,
    high: float,
    rows: int,
    face: Rgb,
    knob: Rgb,
    columns: int = 1,
) -> Part:
    step, wide = (high - low) / rows, w / columns
    parts: Part = []
    for i in range(rows):
        for j in range(columns):
            x = (j - (columns - 1) / 2) * wide
            parts.append(
                box(
                    (wide * 0.93, 0.02, step * 0.88),
                    (x, front - 0.006, low + step * (i + 0.06)),
                    face,
                )
            )
            parts.append(
                box((wide * 0.28, 0.025, 0.018), (x, front - 0.022, low + step * (i + 0.5)), knob)
            )
    return parts


def nightstand(k: int) -> Part:
    """One to three drawers, on legs or not."""
    body, face, knob = pick(
        k,
        (WOOD, PALE_WOOD, DARK),
        (WHITE, WHITE, STEEL),
        (DARK_WOOD, DARK_WOOD, BRASS),
        (GREY, WHITE, DARK),
        (PALE_WOOD, TEAL, DARK),
        (DARK, WOOD, BRASS),
    )
    w, d, h = pick(k, (0.45, 0.4, 0.55), (0.4, 0.38, 0.5), (0.5, 0.42, 0.6))
    legs = pick(k, 0.15, 0.03, 0.28)
    rows = pick(k, 2, 3, 1)
    return [
        *_legs(w, d, legs, 0.04, body),
        box((w, d, h - legs), (0, 0, legs), body),
        *_drawers(w, -d / 2, legs + 0.03, h - 0.03, rows, face, knob),
    ]


def dresser(k: int) -> Part:
    """A chest of drawers."""
    body, face, knob = pick(
        k,
        (WHITE, WHITE, STEEL),
        (WOOD, PALE_WOOD, DARK),
        (DARK_WOOD, DARK_WOOD, BRASS),
        (PALE_WOOD, WHITE, DARK),
        (GREY, GREY, WHITE),
        (NAVY, NAVY, BRASS),
    )
    w, d, h, rows, columns = pick(
        k, (0.8, 0.45, 1.0, 4, 1), (1.2, 0.48, 0.8, 3, 2), (1.0, 0.45, 0.9, 4, 2)
    )
    return [
        *_legs(w, d, 0.1, 0.05, body),
        box((w, d, h - 0.13), (0, 0, 0.1), body),
        box((w + 0.04, d + 0.03, 0.03), (0, 0, h - 0.03), body),
        *_drawers(w, -d / 2, 0.12, h - 0.05, rows, face, knob, columns),
    ]


def toilet(k: int) -> Part:
    """A bowl with a seat, its lid down or up, and a cistern."""
    china, seat = pick(
        k,
        (WHITE, WHITE),
        (CREAM, WOOD),
        (WHITE, DARK),
        ((0.8, 0.86, 0.84), WHITE),
        (WHITE, PALE_WOOD),
        (PINK, WHITE),
    )
    tall = pick(k, 0.36, 0.3, 0.4)
    foot = scaled(
        [lathe([(0, 0), (0.6, 0), (0.5, 0.3), (0.62, 0.55), (1, 0.9), (1, 1), (0, 1)], china, 18)],
        (0.19, 0.24, 0.38),
    )
    rim = moved(scaled([cylinder(1, 1, 0.025, seat, 20)], (0.2, 0.25, 1)), (0, -0.1, 0.385))
    parts = [
        *moved(foot, (0, -0.09, 0)),
        *rim,
        box((0.24, 0.3, 0.36), (0, 0.12, 0), china),
        box((0.4, 0.19, tall), (0, 0.24, 0.38), china),
        box((0.42, 0.21, 0.03), (0, 0.24, 0.38 + tall), china),
        box(
            (0.05, 0.03, 0.015),
            (pick(k, 0, -0.14), 0.24 if k % 2 == 0 else 0.14, 0.4 + tall),
            STEEL,
        ),
    ]
    if k % 2 == 0:
        return [
            *parts,
            *moved(
                scaled([lathe([(0, 0), (1, 0), (1, 0.02), (0, 0.035)], seat, 20)], (0.2, 0.25, 1)),
                (0, -0.1, 0.412),
            ),
        ]
    lid = moved(
        turned(scaled([cylinder(1, 1, 0.02, seat, 20)], (0.2, 0.25, 1)), "x", -80), (0, 0.1, 0.65)
    )
    water = moved(
        scaled([cylinder(1, 1, 0.004, (0.55, 0.68, 0.74), 18)], (0.13, 0.17, 1)), (0, -0.11, 0.409)
    )
    return [*parts, *lid, *water]


def washing_machine(k: int) -> Part:
    """A front loader."""
    body, door = pick(
        k,
        (WHITE, STEEL),
        (STEEL, DARK),
        (WHITE, DARK),
        (GREY, STEEL),
        (CREAM, STEEL),
        (DARK, STEEL),
    )
    h, r = pick(k, 0.85, 0.82), pick(k, 0.17, 0.19, 0.155)
    porthole = [
        *turned([ring(r, 0.025, door, "xy", 22, 6)], "x", 90),
        *moved([disc(r * 0.9, 0.03, (0.25, 0.3, 0.36), 20)], (0, 0, 0)),
    ]
    return [
        box((0.6, 0.58, h), (0, 0, 0), body),
        *moved(porthole, (0, -0.3, h * 0.45)),
        box((0.58, 0.01, 0.11), (0, -0.292, h - 0.13), GREY if body != GREY else WHITE),
        *moved(
            [disc(0.035, 0.03, STEEL if body != STEEL else DARK, 12)], (0.05, -0.305, h - 0.075)
        ),
        box((0.17, 0.012, 0.08), (-0.18, -0.296, h - 0.115), body),
        box((0.1, 0.012, 0.05), (0.2, -0.296, h - 0.1), (0.1, 0.3, 0.35)),
        box((0.54, 0.01, 0.08), (0, -0.29, 0.02), GREY),
    ]


def dishwasher(k: int) -> Part:
    """A front with a bar across, keys and a plinth."""
    body = pick(k, STEEL, WHITE, GREY, (0.75, 0.76, 0.78), CREAM, DARK)
    dark = DARK if body != DARK else GREY
    keys = [
        box(
            (0.025, 0.01, 0.012),
            (0.04 * i, -0.297, 0.775),
            pick(i, WHITE, WHITE, GREEN) if dark == DARK else WHITE,
        )
        for i in range(5)
    ]
    return [
        box((0.6, 0.56, 0.84), (0, 0.01, 0), body),
        box((0.58, 0.02, 0.1), (0, -0.285, 0), dark),
        box((0.6, 0.02, 0.62), (0, -0.28, 0.11), body),
        box((0.6, 0.025, 0.095), (0, -0.282, 0.74), dark),
        *keys,
        tube(
            [(-0.25, -0.325, 0.68), (0.25, -0.325, 0.68)],
            0.012,
            STEEL if body != STEEL else DARK,
            8,
        ),
        *[box((0.02, 0.04, 0.02), (s * 0.22, -0.305, 0.67), STEEL) for s in (-1, 1)],
        box((0.08, 0.01, 0.035), (-0.2, -0.296, 0.77), (0.1, 0.55, 0.6)),
    ]


def tv_stand(k: int) -> Part:
    """Low and wide: open shelves and doors."""
    body, face = pick(
        k,
        (WOOD, PALE_WOOD),
        (WHITE, WHITE),
        (DARK_WOOD, DARK_WOOD),
        (DARK, GREY),
        (PALE_WOOD, WHITE),
        (GREY, WOOD),
    )
    w, d, h = pick(k, (1.4, 0.42, 0.5), (1.1, 0.4, 0.55), (1.6, 0.45, 0.45), (0.95, 0.4, 0.7))
    t, legs = 0.025, pick(k, 0.12, 0.0, 0.15)
    frame = [box((w, d, t), (0, 0, z), body) for z in (legs, h - t)] + [
        box((t, d, h - legs), (s * (w - t) / 2, 0, legs), body) for s in (-1, 1)
    ]
    frame += [
        box((w, 0.01, h - legs), (0, d / 2 - 0.005, legs), DARK_WOOD),
        box((w * 0.36, d * 0.9, t), (0, 0, (h + legs) / 2), body),
    ]
    doors = [
        box(
            (w * 0.31, d * 0.97, h - legs - 2 * t - 0.01), (s * w * 0.33, 0, legs + t + 0.005), face
        )
        for s in (-1, 1)
    ]
    knobs = [
        box((0.02, 0.03, 0.08), (s * w * 0.2, -d / 2 - 0.002, (h + legs) / 2), STEEL)
        for s in (-1, 1)
    ]
    player = [box((w * 0.24, d * 0.5, 0.05), (0, -0.02, legs + t), DARK)] if k % 2 == 0 else []
    return [
        *(_legs(w * 0.94, d, legs, 0.045, body) if legs else []),
        *frame,
        *doors,
        *knobs,
        *player,
    ]


def side_table(k: int) -> Part:
    """A small table: round on a stem, or square with a board below."""
    top, leg = pick(
        k,
        (WOOD, WOOD),
        (WHITE, PALE_WOOD),
        (DARK, BRASS),
        (PALE_WOOD, DARK),
        (DARK_WOOD, DARK_WOOD),
        (WHITE, STEEL),
    )
    w, h = pick(k, 0.45, 0.5, 0.4), pick(k, 0.55, 0.5, 0.6)
    if k % 2 == 0:
        return [
            cylinder(w / 2, w / 2, 0.025, top, 24, (0, 0, h - 0.025)),
            lathe(
                [
                    (0, 0),
                    (w * 0.3, 0),
                    (w * 0.28, 0.02),
                    (0.03, 0.05),
                    (0.022, h * 0.5),
                    (0.035, h - 0.06),
                    (0.06, h - 0.025),
                ],
                leg,
                16,
            ),
        ]
    return [
        box((w, w, 0.03), (0, 0, h - 0.03), top),
        *_legs(w, w, h - 0.03, 0.035, leg),
        box((w - 0.05, w - 0.05, 0.02), (0, 0, h * 0.28), top),
    ]


def shelving_unit(k: int) -> Part:
    """Open boards between uprights, a few things on them."""
    post, board = pick(
        k,
        (STEEL, STEEL),
        (DARK, WOOD),
        (WHITE, WHITE),
        (PALE_WOOD, PALE_WOOD),
        (DARK, PALE_WOOD),
        (BRASS, WHITE),
    )
    w, d, h, n = pick(k, (0.9, 0.4, 1.7, 5), (0.6, 0.35, 1.4, 4), (0.8, 0.32, 1.8, 6))
    parts = _legs(w, d, h, 0.03, post)
    for i in range(n):
        parts.append(box((w, d, 0.025), (0, 0, 0.08 + (h - 0.12) * i / (n - 1)), board))
    for i in range(n - 1):
        z = 0.105 + (h - 0.12) * i / (n - 1)
        colour = pick(i + k, RED, CREAM, BLUE, GREEN, YELLOW)
        if (i + k) % 3 == 0:
            parts.append(box((w * 0.35, d * 0.7, h * 0.1), (w * 0.2, 0, z), (0.7, 0.55, 0.38)))
        elif (i + k) % 3 == 1:
            parts += [
                box(
                    (0.035, d * 0.6, h * (0.09 + 0.01 * (j % 3))),
                    (-w * 0.38 + 0.045 * j, 0, z),
                    pick(i + j, RED, BLUE, GREEN, CREAM, DARK),
                )
                for j in range(6)
            ]
        else:
            parts.append(cylinder(0.07, 0.09, 0.13, colour, 12, (-w * 0.15, 0, z)))
    return parts


def shelf(k: int) -> Part:
    """A board on brackets (even) or a wall box (odd), with a few books."""
    wood = pick(k, WOOD, WHITE, PALE_WOOD, DARK, DARK_WOOD, GREY)
    w = pick(k, 0.8, 0.6, 1.0)
    books = [
        box(
            (0.03, 0.15, 0.17 + 0.02 * (j % 3)),
            (-w * 0.4 + 0.036 * j, 0.02, 0.03),
            pick(j + k, RED, BLUE, GREEN, CREAM, NAVY),
        )
        for j in range(pick(k, 5, 3, 7))
    ]
    if k % 2:
        t = 0.02
        return [
            *[box((w, 0.22, t), (0, 0, z), wood) for z in (0, 0.26)],
            *[box((t, 0.22, 0.28), (s * (w - t) / 2, 0, 0), wood) for s in (-1, 1)],
            box((w, 0.01, 0.28), (0, 0.105, 0), wood),
            *moved(books, (0.03, 0, -0.008)),
        ]
    brackets = [box((0.02, 0.2, 0.02), (s * w * 0.35, 0.01, -0.02), DARK) for s in (-1, 1)] + [
        box((0.02, 0.02, 0.14), (s * w * 0.35, 0.1, -0.14), DARK) for s in (-1, 1)
    ]
    return [box((w, 0.22, 0.03), (0, 0, 0), wood), *brackets, *books]


def bench(k: int) -> Part:
    """A wooden bench, some with a back, some padded."""
    wood, pad = pick(
        k,
        (WOOD, None),
        (WHITE, GREY),
        (PALE_WOOD, None),
        (DARK_WOOD, RED),
        (DARK, CREAM),
        (PALE_WOOD, TEAL),
    )
    w, h = pick(k, 1.2, 1.0, 1.4), 0.45
    parts = (
        [box((w, 0.09, 0.035), (0, y, h - 0.035), wood) for y in (-0.14, 0, 0.14)]
        + _legs(w * 0.9, 0.36, h - 0.035, 0.06, wood)
        + [box((w * 0.82, 0.04, 0.06), (0, 0, 0.14), wood)]
    )
    if pad is not None:
        parts.append(ball((w * 0.98, 0.38, 0.09), (0, 0, h - 0.02), pad, 8, 18, 0.3))
    if k % 3 == 2:
        parts += [box((w, 0.03, 0.07), (0, 0.19, h + 0.1 + 0.13 * i), wood) for i in range(3)] + [
            box((0.05, 0.04, 0.42), (s * w * 0.42, 0.2, h - 0.03), wood) for s in (-1, 1)
        ]
    return parts


def ottoman(k: int) -> Part:
    """Round or square, padded, on short feet."""
    cloth, feet = pick(
        k,
        (TEAL, WOOD),
        (GREY, DARK),
        (ORANGE, WOOD),
        (CREAM, DARK_WOOD),
        (NAVY, BRASS),
        (PINK, PALE_WOOD),
    )
    w, h = pick(k, 0.55, 0.6, 0.45), pick(k, 0.42, 0.4)
    stubs = _legs(w * 0.75, w * 0.75, 0.07, 0.04, feet)
    seam = (cloth[0] * 0.7, cloth[1] * 0.7, cloth[2] * 0.7)
    if k % 2:
        return [
            *stubs,
            ball((w, w * 0.8, h - 0.05), (0, 0, 0.05), cloth, 10, 20, 0.25),
            box((w * 0.98, w * 0.79, 0.012), (0, 0, h * 0.62), seam),
            ball((0.03, 0.03, 0.014), (0, 0, h - 0.005), seam, 4, 8),
        ]
    r = w / 2
    return [
        *stubs,
        lathe(
            [(0, 0.05), (r * 0.93, 0.05), (r, 0.1), (r, h * 0.7), (r * 0.97, h * 0.72)], cloth, 22
        ),
        lathe([(r * 0.97, h * 0.72), (r * 1.02, h * 0.8), (r * 0.9, h * 0.96), (0, h)], cloth, 22),
        *moved([ring(r * 0.985, 0.008, seam, "xy", 22, 4)], (0, 0, h * 0.72)),
    ]


def safe(k: int) -> Part:
    """A steel box with a dial or keys and a handle."""
    body = pick(k, GREY, DARK, (0.25, 0.32, 0.3), CREAM, NAVY, STEEL)
    w, h = pick(k, 0.45, 0.38, 0.5), pick(k, 0.5, 0.32, 0.6)
    front = -0.21
    lock = [
        box(
            (0.09, 0.012, 0.11),
            (-w * 0.1, front - 0.015, h * 0.45),
            DARK if body != DARK else STEEL,
        ),
        *[
            box(
                (0.018, 0.008, 0.018),
                (-w * 0.1 + 0.026 * (i % 3 - 1), front - 0.022, h * 0.45 + 0.02 + 0.028 * (i // 3)),
                WHITE,
            )
            for i in range(9)
        ],
    ]
    dial = [
        *moved(
            [
                disc(0.05, 0.03, STEEL if body != STEEL else DARK, 18),
                *moved([disc(0.02, 0.03, DARK, 10)], (0, -0.02, 0)),
            ],
            (-w * 0.1, front - 0.02, h * 0.55),
        )
    ]
    handle = [
        p
        for a in (0, 60, 120)
        for p in turned([tube([(-0.06, 0, 0), (0.06, 0, 0)], 0.007, BRASS, 6)], "y", a)
    ]
    return [
        box((w, 0.4, h), (0, 0, 0), body),
        box((w * 0.86, 0.02, h * 0.86), (0, -0.205, h * 0.07), paler(body)),
        *(lock if k % 2 else dial),
        *moved(handle, (w * 0.22, front - 0.035, h * 0.5)),
        *[box((0.02, 0.03, 0.07), (-w * 0.45, -0.205, h * z), STEEL) for z in (0.2, 0.68)],
    ]


def paler(colour: Rgb) -> Rgb:
    """A shade paler."""
    return (
        min(1, colour[0] * 1.2 + 0.03),
        min(1, colour[1] * 1.2 + 0.03),
        min(1, colour[2] * 1.2 + 0.03),
    )


def desk_lamp(k: int) -> Part:
    """A jointed arm (even) or a shade on a stem (odd)."""
    metal, shade = pick(
        k, (DARK, DARK), (BRASS, CREAM), (RED, RED), (WOOD, WHITE), (STEEL, STEEL), (WHITE, TEAL)
    )
    if k % 2:
        h, r = pick(k, 0, 0.42, 0, 0.5, 0, 0.38), pick(k, 0, 0.14, 0, 0.16, 0, 0.12)
        return [
            lathe([(0, 0), (0.07, 0), (0.065, 0.015), (0.012, 0.03), (0.01, h * 0.6)], metal, 16),
            *moved(
                vessel([(r, 0), (r * 0.65, h * 0.38)], shade, (0.98, 0.93, 0.75), 0.003, 20),
                (0, 0, h * 0.6),
            ),
            ball((0.05, 0.05, 0.06), (0, 0, h * 0.66), (1.0, 0.95, 0.7), 5, 8),
        ]
    arm = [
        tube([(0, 0.0, 0.02), (0, 0.12, 0.24)], 0.008, STEEL if metal != STEEL else DARK, 6),
        tube([(0, 0.12, 0.24), (0, -0.1, 0.42)], 0.008, STEEL if metal != STEEL else DARK, 6),
        ball((0.03, 0.03, 0.03), (0, 0.12, 0.225), metal, 5, 8),
    ]
    head = moved(
        turned(
            [
                *vessel(
                    [(0.075, 0), (0.055, 0.06), (0.022, 0.11)], shade, (1.0, 0.96, 0.75), 0.004, 16
                ),
                cylinder(0.024, 0.02, 0.03, metal, 10, (0, 0, 0.105)),
            ],
            "x",
            -25,
        ),
        (0, -0.15, 0.33),
    )
    return [
        lathe([(0, 0), (0.085, 0), (0.08, 0.02), (0.02, 0.03), (0, 0.03)], metal, 18),
        *arm,
        *head,
    ]


def floor_lamp(k: int) -> Part:
    """A shade on a tall stem, a tripod, a bow, or a bowl that lights the ceiling."""
    metal, shade = pick(
        k,
        (STEEL, CREAM),
        (WOOD, WHITE),
        (DARK, DARK),
        (BRASS, TEAL),
        (DARK, CREAM),
        (STEEL, ORANGE),
    )
    h, r = pick(k, 1.6, 1.5, 1.75), pick(k, 0.2, 0.22, 0.18)
    warm: Rgb = (1.0, 0.94, 0.75)
    drum = vessel([(r, 0), (r * pick(k, 0.75, 0.95), 0.28)], shade, warm, 0.003, 22)
    if k % 3 == 1:
        feet = [
            tube([(0, 0, h - 0.25), (0.28 * np.cos(a), 0.28 * np.sin(a), 0)], 0.016, metal, 6)
            for a in np.radians((90, 210, 330))
        ]
        return [*feet, *moved(drum, (0, 0, h - 0.28))]
    foot = lathe([(0, 0), (0.15, 0), (0.145, 0.02), (0.015, 0.035)], metal, 20)
    if k % 3 == 2:
        bow = [
            (0, 0.25, 0.02),
            (0, 0.3, h * 0.6),
            (0, 0.22, h * 0.9),
            (0, 0.0, h),
            (0, -0.25, h * 0.93),
            (0, -0.33, h * 0.85),
        ]
        return [
            *moved([foot], (0, 0.25, 0)),
            tube(bow, 0.012, metal, 8),
            *moved(
                vessel([(0.15, 0), (0.13, 0.08), (0.03, 0.14)], shade, warm, 0.004, 18),
                (0, -0.33, h * 0.78),
            ),
        ]
    return [
        foot,
        tube([(0, 0, 0.02), (0, 0, h - 0.1)], 0.012, metal, 8),
        *moved(drum, (0, 0, h - 0.28)),
    ]


def clock(k: int) -> Part:
    """For a wall, round (even) or square (odd)."""
    rim, face, hand = pick(
        k,
        (DARK, WHITE, DARK),
        (WOOD, CREAM, DARK),
        (RED, WHITE, DARK),
        (STEEL, DARK, WHITE),
        (TEAL, CREAM, DARK),
        (WHITE, NAVY, WHITE),
    )
    r = pick(k, 0.15, 0.14, 0.18)
    if k % 2:
        body = [
            box((2 * r, 0.04, 2 * r), (0, 0, -r), rim),
            box((1.75 * r, 0.01, 1.75 * r), (0, -0.022, -0.875 * r), face),
        ]
    else:
        body = [disc(r, 0.04, rim, 26), *moved([disc(r * 0.88, 0.01, face, 26)], (0, -0.022, 0))]
    ticks = [
        p
        for a in range(0, 360, 30)
        for p in turned(
            [box((0.012 if a % 90 == 0 else 0.006, 0.004, 0.025), (0, -0.029, r * 0.66), hand)],
            "y",
            a,
        )
    ]
    hands = turned(
        [box((0.012, 0.004, r * 0.62), (0, -0.031, -0.02), hand)], "y", 30 + 47 * k
    ) + turned([box((0.016, 0.004, r * 0.42), (0, -0.034, -0.02), hand)], "y", -60 + 31 * k)
    return [
        *body,
        *ticks,
        *hands,
        *moved([disc(0.014, 0.01, RED if rim != RED else DARK, 8)], (0, -0.036, 0)),
    ]


def curtain(k: int) -> Part:
    """Two wings in folds on a rail."""
    cloth, rail = pick(
        k,
        (RED, BRASS),
        (CREAM, WOOD),
        (BLUE, STEEL),
        (GREEN, DARK),
        (GREY, STEEL),
        (TEAL, DARK_WOOD),
    )
    w, h = pick(k, 1.4, 1.2, 1.6), pick(k, 2.1, 1.9, 2.2)
    wing = pick(k, 0.34, 0.28, 0.46)
    t = np.linspace(0, 1, 31)
    parts = [
        tube([(-w * 0.54, 0, h - 0.03), (w * 0.54, 0, h - 0.03)], 0.014, rail, 8),
        *[ball((0.05, 0.05, 0.05), (s * w * 0.55, 0, h - 0.055), rail, 5, 8) for s in (-1, 1)],
    ]
    for side in (-1, 1):
        x = side * (w / 2 - wing * w * (1 - t)) if side > 0 else -w / 2 + wing * w * t
        y = 0.035 * np.sin(t * 2 * np.pi * 6)
        sheet = np.stack(
            [
                np.stack([x, y * f - 0.0, np.full_like(t, z)], 1)
                for z, f in ((0, 1.2), (h * 0.5, 1.0), (h - 0.03, 0.7))
            ]
        )
        parts += [surface(sheet, cloth), surface(sheet[:, ::-1] + np.array([0, 0.004, 0]), cloth)]
    return parts


def fireplace(k: int) -> Part:
    """A mantel around a dark opening, logs and fire in it."""
    stone, hearth = pick(
        k,
        (WHITE, GREY),
        ((0.6, 0.33, 0.25), DARK),
        (DARK_WOOD, GREY),
        (CREAM, DARK),
        (GREY, DARK),
        (PALE_WOOD, STEEL),
    )
    w, h = pick(k, 1.3, 1.2, 1.4), pick(k, 1.05, 1.15)
    fire = [
        lathe([(0.06, 0), (0.075, 0.06), (0.03, 0.16), (0, 0.22)], ORANGE, 8, (x, -0.04, 0.11))
        for x in (-0.12, 0.02, 0.14)
    ]
    logs = [
        tube(
            [(-0.22, -0.05 + 0.05 * i, 0.09 + 0.03 * i), (0.22, 0.02 - 0.04 * i, 0.09 + 0.03 * i)],
            0.035,
            DARK_WOOD,
            7,
        )
        for i in range(2)
    ]
    return [
        *[box((w * 0.22, 0.3, h - 0.15), (s * w * 0.38, 0, 0.04), stone) for s in (-1, 1)],
        box((w * 0.96, 0.3, h * 0.28), (0, 0, h * 0.72 - 0.1), stone),
        box((w, 0.38, 0.07), (0, -0.02, h - 0.09), stone),
        box((w, 0.42, 0.05), (0, -0.05, 0), hearth),
        box((w * 0.6, 0.02, h * 0.7), (0, 0.13, 0.03), DARK),
        *logs,
        *fire,
    ]


def shower(k: int) -> Part:
    """A tray, a pole with its head, and panes; some with a curtain."""
    tray, metal, wall = pick(
        k,
        (WHITE, STEEL, (0.75, 0.83, 0.85)),
        (CREAM, BRASS, (0.8, 0.85, 0.82)),
        (GREY, DARK, (0.7, 0.78, 0.8)),
    )
    w, h = pick(k, 0.9, 0.8), 2.0
    back = w / 2 - 0.01
    pole = [
        tube(
            [(0, back - 0.04, 0.9), (0, back - 0.04, h - 0.05), (0, back - 0.35, h)],
            0.012,
            metal,
            6,
        ),
        cylinder(0.1, 0.02, 0.05, metal, 16, (0, back - 0.36, h - 0.06)),
        box((0.18, 0.06, 0.05), (0, back - 0.05, 0.95), metal),
    ]
    frame = [
        box((0.03, 0.03, h), (sx * (w / 2 - 0.015), sy * (w / 2 - 0.015), 0.06), metal)
        for sx in (-1, 1)
        for sy in (-1, 1)
    ] + [box((w, 0.03, 0.03), (0, s * (w / 2 - 0.015), h + 0.03), metal) for s in (-1, 1)]
    side = box((0.012, w - 0.06, h - 0.02), (w / 2 - 0.015, 0, 0.08), wall)
    half = box((w * 0.42, 0.012, h - 0.02), (-w * 0.26, -w / 2 + 0.015, 0.08), wall)
    drain = cylinder(0.05, 0.05, 0.004, metal, 14, (0, 0, 0.065))
    return [
        box((w, w, 0.04), (0, 0, 0), tray),
        *[box((w, 0.05, 0.08), (0, s * (w / 2 - 0.025), 0), tray) for s in (-1, 1)],
        *[box((0.05, w, 0.08), (s * (w / 2 - 0.025), 0, 0), tray) for s in (-1, 1)],
        box((w, 0.012, h), (0, back, 0.06), (0.85, 0.9, 0.9)),
        *moved([drain], (0, 0, -0.022)),
        *pole,
        *frame,
        side,
        half,
        tube(arc((w * 0.02, -w / 2 + 0.01, 1.05), 0.06, 90, 270, "xz", 6), 0.008, metal, 5),
    ]


def piano(k: int) -> Part:
    """An upright with its keys."""
    wood = pick(k, DARK, DARK_WOOD, WOOD, WHITE, (0.4, 0.12, 0.08), GREY)
    h = pick(k, 1.2, 1.1)
    black = [
        box((0.016, 0.085, 0.015), (-0.59 + 0.0504 * i, -0.19, 0.712), DARK)
        for i in range(24)
        if i % 7 not in (2, 6)
    ]
    return [
        box((1.45, 0.34, h), (0, 0.12, 0), wood),
        box((1.48, 0.38, 0.03), (0, 0.11, h), wood),
        box((1.45, 0.26, 0.1), (0, -0.17, 0.59), wood),
        box((1.3, 0.15, 0.022), (0, -0.22, 0.689), WHITE),
        *black,
        *[box((0.08, 0.26, 0.16), (s * 0.685, -0.17, 0.6), wood) for s in (-1, 1)],
        *[box((0.07, 0.07, 0.6), (s * 0.66, -0.25, 0), wood) for s in (-1, 1)],
        box((0.6, 0.02, 0.22), (0, -0.06, h * 0.72), paler(wood)),
        *[box((0.03, 0.12, 0.02), (x, -0.1, 0.04), BRASS) for x in (-0.08, 0, 0.08)],
    ]
