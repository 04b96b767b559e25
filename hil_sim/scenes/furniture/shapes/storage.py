"""Meshes of furniture that holds things."""

from hil_sim.scenes.furniture.shapes import palette as c
from hil_sim.scenes.furniture.shapes.palette import Rgb
from hil_sim.scenes.furniture.shapes.primitives import (
    Part,
    around,
    box,
    cylinder,
    disc,
    lathe,
    legs,
    moved,
    pick,
    shade,
    tube,
)


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
        (c.WOOD, c.PALE_WOOD, c.DARK),
        (c.WHITE, c.WHITE, c.STEEL),
        (c.DARK_WOOD, c.DARK_WOOD, c.BRASS),
        (c.GREY, c.WHITE, c.DARK),
        (c.PALE_WOOD, c.TEAL, c.DARK),
        (c.DARK, c.WOOD, c.BRASS),
    )
    w, d, h = pick(k, (0.45, 0.4, 0.55), (0.4, 0.38, 0.5), (0.5, 0.42, 0.6))
    foot = pick(k, 0.15, 0.03, 0.28)
    rows = pick(k, 2, 3, 1)
    return [
        *legs(w, d, foot, 0.04, body),
        box((w, d, h - foot), (0, 0, foot), body),
        *_drawers(w, -d / 2, foot + 0.03, h - 0.03, rows, face, knob),
    ]


def dresser(k: int) -> Part:
    """A chest of drawers."""
    body, face, knob = pick(
        k,
        (c.WHITE, c.WHITE, c.STEEL),
        (c.WOOD, c.PALE_WOOD, c.DARK),
        (c.DARK_WOOD, c.DARK_WOOD, c.BRASS),
        (c.PALE_WOOD, c.WHITE, c.DARK),
        (c.GREY, c.GREY, c.WHITE),
        (c.NAVY, c.NAVY, c.BRASS),
    )
    w, d, h, rows, columns = pick(
        k, (0.8, 0.45, 1.0, 4, 1), (1.2, 0.48, 0.8, 3, 2), (1.0, 0.45, 0.9, 4, 2)
    )
    return [
        *legs(w, d, 0.1, 0.05, body),
        box((w, d, h - 0.13), (0, 0, 0.1), body),
        box((w + 0.04, d + 0.03, 0.03), (0, 0, h - 0.03), body),
        *_drawers(w, -d / 2, 0.12, h - 0.05, rows, face, knob, columns),
    ]


def tv_stand(k: int) -> Part:
    """Low and wide: open shelves and doors."""
    body, face = pick(
        k,
        (c.WOOD, c.PALE_WOOD),
        (c.WHITE, c.WHITE),
        (c.DARK_WOOD, c.DARK_WOOD),
        (c.DARK, c.GREY),
        (c.PALE_WOOD, c.WHITE),
        (c.GREY, c.WOOD),
    )
    w, d, h = pick(k, (1.4, 0.42, 0.5), (1.1, 0.4, 0.55), (1.6, 0.45, 0.45), (0.95, 0.4, 0.7))
    t, foot = 0.025, pick(k, 0.12, 0.0, 0.15)
    frame = [box((w, d, t), (0, 0, z), body) for z in (foot, h - t)] + [
        box((t, d, h - foot), (s * (w - t) / 2, 0, foot), body) for s in (-1, 1)
    ]
    frame += [
        box((w, 0.01, h - foot), (0, d / 2 - 0.005, foot), c.DARK_WOOD),
        box((w * 0.36, d * 0.9, t), (0, 0, (h + foot) / 2), body),
    ]
    doors = [
        box(
            (w * 0.31, d * 0.97, h - foot - 2 * t - 0.01), (s * w * 0.33, 0, foot + t + 0.005), face
        )
        for s in (-1, 1)
    ]
    knobs = [
        box((0.02, 0.03, 0.08), (s * w * 0.2, -d / 2 - 0.002, (h + foot) / 2), c.STEEL)
        for s in (-1, 1)
    ]
    player = [box((w * 0.24, d * 0.5, 0.05), (0, -0.02, foot + t), c.DARK)] if k % 2 == 0 else []
    return [
        *(legs(w * 0.94, d, foot, 0.045, body) if foot else []),
        *frame,
        *doors,
        *knobs,
        *player,
    ]


def side_table(k: int) -> Part:
    """A small table: round on a stem, or square with a board below."""
    top, leg = pick(
        k,
        (c.WOOD, c.WOOD),
        (c.WHITE, c.PALE_WOOD),
        (c.DARK, c.BRASS),
        (c.PALE_WOOD, c.DARK),
        (c.DARK_WOOD, c.DARK_WOOD),
        (c.WHITE, c.STEEL),
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
        *legs(w, w, h - 0.03, 0.035, leg),
        box((w - 0.05, w - 0.05, 0.02), (0, 0, h * 0.28), top),
    ]


def shelving_unit(k: int) -> Part:
    """Open boards between uprights, a few things on them."""
    post, board = pick(
        k,
        (c.STEEL, c.STEEL),
        (c.DARK, c.WOOD),
        (c.WHITE, c.WHITE),
        (c.PALE_WOOD, c.PALE_WOOD),
        (c.DARK, c.PALE_WOOD),
        (c.BRASS, c.WHITE),
    )
    w, d, h, n = pick(k, (0.9, 0.4, 1.7, 5), (0.6, 0.35, 1.4, 4), (0.8, 0.32, 1.8, 6))
    parts = legs(w, d, h, 0.03, post)
    for i in range(n):
        parts.append(box((w, d, 0.025), (0, 0, 0.08 + (h - 0.12) * i / (n - 1)), board))
    for i in range(n - 1):
        z = 0.105 + (h - 0.12) * i / (n - 1)
        colour = pick(i + k, c.RED, c.CREAM, c.BLUE, c.GREEN, c.YELLOW)
        if (i + k) % 3 == 0:
            parts.append(box((w * 0.35, d * 0.7, h * 0.1), (w * 0.2, 0, z), (0.7, 0.55, 0.38)))
        elif (i + k) % 3 == 1:
            parts += [
                box(
                    (0.035, d * 0.6, h * (0.09 + 0.01 * (j % 3))),
                    (-w * 0.38 + 0.045 * j, 0, z),
                    pick(i + j, c.RED, c.BLUE, c.GREEN, c.CREAM, c.DARK),
                )
                for j in range(6)
            ]
        else:
            parts.append(cylinder(0.07, 0.09, 0.13, colour, 12, (-w * 0.15, 0, z)))
    return parts


def shelf(k: int) -> Part:
    """A board on brackets (even) or a wall box (odd), with a few books."""
    wood = pick(k, c.WOOD, c.WHITE, c.PALE_WOOD, c.DARK, c.DARK_WOOD, c.GREY)
    w = pick(k, 0.8, 0.6, 1.0)
    books = [
        box(
            (0.03, 0.15, 0.17 + 0.02 * (j % 3)),
            (-w * 0.4 + 0.036 * j, 0.02, 0.03),
            pick(j + k, c.RED, c.BLUE, c.GREEN, c.CREAM, c.NAVY),
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
    brackets = [box((0.02, 0.2, 0.02), (s * w * 0.35, 0.01, -0.02), c.DARK) for s in (-1, 1)] + [
        box((0.02, 0.02, 0.14), (s * w * 0.35, 0.1, -0.14), c.DARK) for s in (-1, 1)
    ]
    return [box((w, 0.22, 0.03), (0, 0, 0), wood), *brackets, *books]


def safe(k: int) -> Part:
    """A steel box with a dial (even) or keys (odd) and a handle."""
    body = pick(k, c.GREY, c.DARK, (0.25, 0.32, 0.3), c.CREAM, c.NAVY, c.STEEL)
    w, h = pick(k, 0.45, 0.38, 0.5), pick(k, 0.5, 0.32, 0.6)
    trim = c.STEEL if body in (c.DARK, c.GREY) else c.DARK
    if k % 2:
        lock = [box((0.09, 0.012, 0.11), (0, 0, 0), trim)]
        for i in range(9):
            at = (0.026 * (i % 3 - 1), -0.007, 0.02 + 0.028 * (i // 3))
            lock.append(box((0.018, 0.008, 0.018), at, c.WHITE))
    else:
        lock = [disc(0.05, 0.03, trim, 18), *moved([disc(0.02, 0.03, c.WHITE, 10)], (0, -0.02, 0))]
    handle = around([tube([(-0.06, 0, 0), (0.06, 0, 0)], 0.007, c.BRASS, 6)], "y", 3)
    return [
        box((w, 0.4, h), (0, 0, 0), body),
        box((w * 0.86, 0.02, h * 0.86), (0, -0.205, h * 0.07), shade(body, 1.2)),
        *moved(lock, (-w * 0.1, -0.226, h * 0.5)),
        *moved(handle, (w * 0.22, -0.245, h * 0.5)),
        *[box((0.02, 0.03, 0.07), (-w * 0.45, -0.205, h * z), c.STEEL) for z in (0.2, 0.68)],
    ]
