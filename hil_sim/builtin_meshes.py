"""Meshes of simple geometry, for what no catalogue has."""

from collections.abc import Callable, Sequence

import numpy as np

from hil_sim.meshes import Material, Soup

Rgb = tuple[float, float, float]
WHITE, WOOD, DARK, STEEL = (
    (0.92, 0.92, 0.9),
    (0.55, 0.38, 0.22),
    (0.06, 0.06, 0.07),
    (0.6, 0.62, 0.65),
)


def box(size: Sequence[float], at: Sequence[float], colour: Rgb) -> Soup:
    """A cuboid of size (w, d, h) whose underside's centre is `at`, m."""
    w, d, h = size
    x, y, z = at
    c = np.array(
        [
            [sx * w / 2 + x, sy * d / 2 + y, sz * h + z]
            for sz in (0, 1)
            for sy in (-1, 1)
            for sx in (-1, 1)
        ]
    )
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    tris = [t for a, b, e, f in quads for t in ((a, b, e), (a, e, f))]
    corners = c[np.array(tris)]
    return Soup(Material(colour), corners, np.zeros((len(tris), 3, 2)))


def cylinder(radius: float, top: float, height: float, colour: Rgb, sides: int = 20) -> Soup:
    """A (truncated) cone on the origin, closed at both ends."""
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    low = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=1)
    high = np.stack([top * np.cos(angle), top * np.sin(angle), 0 * angle + height], axis=1)
    tris = []
    for i in range(sides):
        tris += [(low[i], low[i + 1], high[i + 1]), (low[i], high[i + 1], high[i])]
        tris += [(low[i + 1], low[i], [0, 0, 0]), (high[i], high[i + 1], [0, 0, height])]
    corners = np.array([[np.asarray(v, float) for v in t] for t in tris])
    return Soup(Material(colour), corners, np.zeros((len(corners), 3, 2)))


def television() -> list[Soup]:
    """A flat screen on a foot, facing -y."""
    return [
        box((1.0, 0.05, 0.58), (0, 0, 0.06), DARK),
        box((0.94, 0.004, 0.52), (0, -0.027, 0.09), (0.12, 0.13, 0.16)),
        box((0.4, 0.22, 0.02), (0, 0, 0), DARK),
        box((0.08, 0.04, 0.06), (0, 0.01, 0.01), DARK),
    ]


def mirror() -> list[Soup]:
    """A framed pane."""
    return [
        box((0.6, 0.03, 0.9), (0, 0, 0), WOOD),
        box((0.52, 0.004, 0.82), (0, -0.017, 0.04), (0.72, 0.8, 0.85)),
    ]


def picture() -> list[Soup]:
    """A framed painting."""
    return [
        box((0.7, 0.03, 0.5), (0, 0, 0), WOOD),
        box((0.62, 0.004, 0.42), (0, -0.017, 0.04), (0.85, 0.8, 0.66)),
        box((0.3, 0.004, 0.2), (-0.1, -0.02, 0.1), (0.3, 0.45, 0.6)),
        box((0.2, 0.004, 0.12), (0.15, -0.02, 0.25), (0.75, 0.4, 0.25)),
    ]


def kitchen_counter() -> list[Soup]:
    """A base cabinet with a worktop, 0.6 m wide."""
    return [
        box((0.6, 0.56, 0.1), (0, 0.02, 0), DARK),
        box((0.6, 0.58, 0.76), (0, 0.01, 0.1), WHITE),
        box((0.6, 0.6, 0.04), (0, 0, 0.86), (0.45, 0.42, 0.4)),
        box((0.3, 0.02, 0.02), (0, -0.29, 0.75), STEEL),
    ]


BUILTINS: dict[str, Callable[[], list[Soup]]] = {
    "television": television,
    "mirror": mirror,
    "picture": picture,
    "kitchen_counter": kitchen_counter,
    "rug": lambda: [box((2.0, 1.4, 0.01), (0, 0, 0), (0.55, 0.3, 0.28))],
    "bathmat": lambda: [box((0.8, 0.5, 0.01), (0, 0, 0), (0.5, 0.65, 0.7))],
    "box": lambda: [box((0.4, 0.4, 0.4), (0, 0, 0), (0.7, 0.55, 0.38))],
    "trash_can": lambda: [cylinder(0.12, 0.15, 0.35, STEEL)],
    "door": lambda: [
        box((0.85, 0.04, 2.0), (0, 0, 0), WOOD),
        box((0.12, 0.08, 0.03), (0.34, 0, 1.0), STEEL),
    ],
    "wall_shelf": lambda: [box((0.8, 0.22, 0.03), (0, 0, 0), WOOD)],
}
