"""Meshes of beds, each variant a type of its own; the head is at the back."""

from functools import partial

from hil_sim.scenes.furniture.shapes import palette as c
from hil_sim.scenes.furniture.shapes.palette import Rgb
from hil_sim.scenes.furniture.shapes.primitives import Part, arc, box, moved, pick, shade, tube
from hil_sim.scenes.furniture.shapes.soft import padded
from hil_sim.scenes.furniture.shapes.soft import pillow as cushion

LONG_M = 2.02  # the mattress
COLOURS: tuple[tuple[Rgb, Rgb], ...] = (  # blanket and pillows
    (c.NAVY, c.WHITE), (c.ROSE, c.CREAM), (c.ASH, c.WHITE), (c.MUSTARD, c.LINEN), (c.FOREST, c.SKY),
    (c.WHITE, c.ASH),
    (c.TEAL, c.PINK), (c.CHARCOAL, c.CREAM),
)  # fmt: skip


def _bedding(w: float, z: float, k: int, drawn: float = 0.62, thick: float = 0.2) -> Part:
    """A mattress at height `z`, a blanket over a share of it, turned down, and pillows."""
    blanket, soft = pick(k, *COLOURS)
    long = LONG_M * drawn
    parts = [
        padded((w, LONG_M, thick), (0, 0, z), shade(c.WHITE, 0.95), 0.05),
        padded((w + 0.05, long, thick * 0.7), (0, (long - LONG_M) / 2 - 0.02, z + thick * 0.36),
               blanket, 0.04),
        padded((w + 0.06, 0.24, thick * 0.2), (0, long - LONG_M / 2 - 0.1, z + thick), soft, 0.02),
    ]  # fmt: skip
    across = (0.0,) if w < 1.2 else (-w / 4, w / 4)
    for row in range(1 + k % 2):
        for x in across:
            size = (min(0.7, w / len(across) - 0.06), 0.42, 0.15)
            at = (x, LONG_M / 2 - 0.3 - 0.18 * row, z + thick + 0.02 + 0.1 * row)
            parts += cushion(size, at, (soft, blanket)[row], 14 + 30 * row)
    return parts


def _legs(w: float, d: float, h: float, colour: Rgb, thick: float = 0.07) -> Part:
    return [
        box((thick, thick, h), (x * (w - thick) / 2, y * (d - thick) / 2, 0), colour)
        for x in (-1, 1) for y in (-1, 1)
    ]  # fmt: skip


def _wooden(w: float, k: int, wood: Rgb, head: float, foot: float) -> Part:
    """A frame of boards on four legs, its head and foot boards so high."""
    d = LONG_M + 0.1
    parts = [*_legs(w + 0.1, d, 0.3, wood), box((w + 0.1, d, 0.12), (0, 0, 0.2), wood)]
    for high, y in ((head, d / 2), (foot, -d / 2)):
        if high > 0.35:
            parts.append(box((w + 0.14, 0.05, high), (0, y, 0), shade(wood, 0.92)))
    return [*parts, *_bedding(w, 0.28, k)]


def _upholstered(w: float, k: int, cloth: Rgb, high: float) -> Part:
    """A padded frame, its head buttoned in panels."""
    d, n = LONG_M + 0.12, max(2, round(w / 0.4))
    each = (w + 0.2) / n
    parts = [
        padded((w + 0.16, d, 0.26), (0, 0, 0.06), cloth, 0.05),
        *_legs(w, d - 0.1, 0.08, c.IRON),
    ]
    for i in range(n):
        at = ((i - (n - 1) / 2) * each, d / 2 + 0.03, 0.1)
        parts.append(padded((each - 0.01, 0.12, high - 0.1), at, shade(cloth, 0.95), 0.05))
    return [*parts, *_bedding(w, 0.3, k, thick=0.26)]


def _barred(w: float, k: int, metal: Rgb) -> Part:
    """A frame of metal tubes, its head and foot curved."""
    d, parts = LONG_M + 0.06, Part()
    for y, high in ((d / 2, 1.05), (-d / 2, 0.7)):
        curve = arc((0, 0, 0), w / 2, 0, 180, "xz", 12) * (1, 1, 0.25)
        parts += moved([tube(curve, 0.018, metal, 6)], (0, y, high - w / 8))
        for i in range(7):
            x = (i / 3 - 1) * w / 2
            top = high - w / 8 + (max(0.0, (w / 2) ** 2 - x * x)) ** 0.5 * 0.25
            thick = 0.022 if i in (0, 6) else 0.01
            parts.append(tube([(x, y, 0 if i in (0, 6) else 0.3), (x, y, top)], thick, metal, 6))
        parts.append(tube([(-w / 2, y, 0.32), (w / 2, y, 0.32)], 0.016, metal, 6))
    parts += [tube([(s * w / 2, -d / 2, 0.3), (s * w / 2, d / 2, 0.3)], 0.02, metal, 6)
              for s in (-1, 1)]  # fmt: skip
    return [*parts, *_bedding(w - 0.04, 0.32, k)]


def _bunk(k: int, wood: Rgb) -> Part:
    """Two beds on top of each other, with a ladder and a rail."""
    w, d = 0.92, LONG_M + 0.1
    parts = _legs(w + 0.1, d, 1.65, wood, 0.08)
    for z, which in ((0.25, k), (1.15, k + 1)):
        parts.append(box((w + 0.08, d, 0.1), (0, 0, z), wood))
        parts += moved(_bedding(w - 0.04, 0.0, which, thick=0.14), (0, 0, z + 0.1))
    for z in (1.38, 1.54):
        parts.append(box((0.03, d * 0.72, 0.07), (-w / 2 - 0.03, 0.25, z), wood))
        parts.append(box((0.03, d, 0.07), (w / 2 + 0.03, 0, z), wood))
    for z in (0.35, 0.65, 0.95, 1.25):
        parts.append(box((0.04, 0.42, 0.04), (-w / 2 - 0.08, -d / 2 + 0.3, z), wood))
    parts += [box((0.04, 0.05, 1.5), (-w / 2 - 0.08, -d / 2 + y, 0), wood) for y in (0.08, 0.52)]
    return parts


def _day(k: int, wood: Rgb) -> Part:
    """A single bed with a board on three sides and a row of cushions."""
    w, d = 0.9, LONG_M + 0.08
    blanket, soft = pick(k, *COLOURS)
    boards = [((0.04, d, 0.8), (w / 2 + 0.03, 0)), ((w + 0.08, 0.04, 0.66), (0, d / 2)),
              ((w + 0.08, 0.04, 0.66), (0, -d / 2))]  # fmt: skip
    parts = [box((w + 0.06, d, 0.14), (0, 0, 0.18), wood), *_legs(w + 0.08, d, 0.3, wood)]
    parts += [box(size, (*at, 0.0), wood) for size, at in boards]
    parts.append(padded((w, LONG_M, 0.18), (0, 0, 0.3), blanket, 0.05))
    for i in range(4):
        at = (w / 2 - 0.16, (i - 1.5) * 0.48, 0.56)
        parts += cushion((0.46, 0.44, 0.14), at, (soft, shade(blanket, 0.8))[i % 2], 68, -90)
    return parts


def bed(k: int) -> Part:
    """Single, double with a foot board, queen, low platform, bars, bunk, day bed, box spring."""
    return pick(
        k,
        partial(_wooden, 0.92, k, c.PALE_WOOD, 0.85, 0.5),
        partial(_wooden, 1.42, k, c.DARK_WOOD, 1.05, 0.65),
        partial(_upholstered, 1.62, k, c.GREY, 1.3),
        partial(_wooden, 1.6, k, c.OAK, 0.6, 0.0),
        partial(_barred, 1.4, k, c.IRON),
        partial(_bunk, k, c.WOOD),
        partial(_day, k, c.WHITE),
        partial(_upholstered, 1.82, k, c.LINEN, 1.05),
    )()
