"""What simple meshes are made of: boxes, lathed profiles, tubes, cushions, extrusions.

Everything is closed, wound outward, in metres, z up; a part is a list of one-coloured triangles.
"""

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.furniture.shapes.palette import Rgb
from hil_sim.scenes.furniture.soup import Material, Soup

Part = list[Soup]
Array = NDArray[np.float64]
T = TypeVar("T")


def pick(k: int, *choices: T) -> T:
    """The choice of variant `k`."""
    return choices[k % len(choices)]


def surface(grid: Array, colour: Rgb, only: NDArray[np.bool_] | None = None) -> Soup:
    """The quads of a (n, m, 3) grid of points, or the cells of it marked in `only` (n - 1, m - 1).

    Outward is (along m) x (along n).
    """
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    if only is not None:
        a, b, c, d = a[only], b[only], c[only], d[only]
    corners = np.concatenate(
        [np.stack(t, axis=-2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))]
    )
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    corners = corners[area > 1e-10]
    return Soup(Material(colour), corners, np.zeros((len(corners), 3, 2)))


def painted(grid: Array, colours: Sequence[Rgb], which: NDArray[np.int64]) -> Part:
    """A grid whose cells (n - 1, m - 1) are coloured by index."""
    return [surface(grid, c, which == i) for i, c in enumerate(colours) if (which == i).any()]


def box(size: Sequence[float], at: Sequence[float], colour: Rgb) -> Soup:
    """A cuboid of size (w, d, h) whose underside's centre is `at`."""
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
    return Soup(Material(colour), c[np.array(tris)], np.zeros((len(tris), 3, 2)))


def lathe_grid(
    profile: Sequence[tuple[float, float]], sides: int = 18, at: Sequence[float] = (0, 0, 0)
) -> Array:
    """(len(profile), sides + 1, 3): (radius, z) turned about the vertical through `at`."""
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    r, z = np.array(profile, float).T
    x, y = np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle))
    points: Array = np.stack([x, y, np.broadcast_to(z[:, None], x.shape)], axis=-1) + np.array(at)
    return points


def lathe(
    profile: Sequence[tuple[float, float]],
    colour: Rgb,
    sides: int = 18,
    at: Sequence[float] = (0, 0, 0),
) -> Soup:
    """A turned solid; the profile runs from the axis below, outside upward, back to the axis."""
    return surface(lathe_grid(profile, sides, at), colour)


def cylinder(
    radius: float,
    top: float,
    height: float,
    colour: Rgb,
    sides: int = 18,
    at: Sequence[float] = (0, 0, 0),
) -> Soup:
    """A (truncated) cone, closed at both ends, the centre of its underside at `at`."""
    return lathe([(0, 0), (radius, 0), (top, height), (0, height)], colour, sides, at)


def vessel(
    outside: Sequence[tuple[float, float]],
    colour: Rgb,
    inside: Rgb | None = None,
    wall: float = 0.004,
    sides: int = 18,
) -> Part:
    """An open hollow body: `outside` (radius, z) from the bottom's edge to the rim."""
    z0, (r1, z1) = outside[0][1], outside[-1]
    shell = [(0.0, z0), *outside]
    inner = [(max(r - wall, 0.001), max(z, z0 + wall)) for r, z in reversed(outside)]
    lining = [(r1, z1), *inner, (0.0, z0 + wall)]
    return [lathe(shell, colour, sides), lathe(lining, inside or colour, sides)]


def ball(
    size: Sequence[float],
    at: Sequence[float],
    colour: Rgb,
    rings: int = 10,
    sides: int = 16,
    square: float = 1.0,
) -> Soup:
    """An ellipsoid of size (w, d, h) whose underside's centre is `at`; `square` < 1 fills out
    its corners (superellipsoid)."""
    u = np.linspace(-np.pi / 2, np.pi / 2, rings + 1)[:, None]
    v = np.linspace(0, 2 * np.pi, sides + 1)[None, :]

    def power(a: Array) -> Array:
        a = np.where(np.abs(a) < 1e-9, 0.0, a)
        rounded: Array = np.sign(a) * np.abs(a) ** square
        return rounded

    grid = np.stack(
        [power(np.cos(u)) * power(np.cos(v)), power(np.cos(u)) * power(np.sin(v)),
         np.broadcast_to(power(np.sin(u)) + 1, (rings + 1, sides + 1))], axis=-1,
    )  # fmt: skip
    return surface(grid * np.array(size) / 2 + np.array(at), colour)


def cushion_grid(size: Sequence[float], n: int = 10) -> tuple[Array, Array]:
    """Upper and lower (n + 1, n + 1, 3) faces of a cushion that lies on its back."""
    w, d, h = size
    t = np.linspace(-1, 1, n + 1)
    y, x = np.meshgrid(t, t, indexing="ij")
    z = (np.clip(1 - x**4, 0, 1) * np.clip(1 - y**4, 0, 1)) ** 0.6
    pinch_x, pinch_y = 1 - 0.1 * (1 - y**2), 1 - 0.1 * (1 - x**2)
    flat = np.stack([x * pinch_x * w / 2, y * pinch_y * d / 2], axis=-1)
    upper = np.concatenate([flat, (h / 2 + z * h / 2)[..., None]], axis=-1)
    lower = np.concatenate([flat, (h / 2 - z * h / 2)[..., None]], axis=-1)
    return upper, lower[:, ::-1]


def tube(
    path: Array | Sequence[Sequence[float]],
    radius: float | Array | Sequence[float],
    colour: Rgb,
    sides: int = 8,
) -> Soup:
    """A bar along a path of points, closed at both ends; a radius, or one a point."""
    p = np.array(path, float)
    r = np.broadcast_to(np.array(radius, float), (len(p),))
    ahead = np.gradient(p, axis=0)
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-9)
    side = np.cross(ahead[0], [0.0, 0.0, 1.0] if abs(ahead[0][2]) < 0.9 else [1.0, 0.0, 0.0])
    angle = np.linspace(0, 2 * np.pi, sides + 1)[:, None]
    rings = [np.broadcast_to(p[0], (sides + 1, 3))]
    for point, along, width in zip(p, ahead, r, strict=True):
        side = side - along * (side @ along)
        side /= max(float(np.linalg.norm(side)), 1e-9)
        other = np.cross(along, side)
        rings.append(point + width * (np.cos(angle) * side + np.sin(angle) * other))
    rings.append(np.broadcast_to(p[-1], (sides + 1, 3)))
    return surface(np.stack(rings), colour)


def arc(
    centre: Sequence[float], radius: float, start: float, end: float, plane: str, n: int = 10
) -> Array:
    """(n + 1, 3) points of a circle's part in "xy", "xz" or "yz", angles in degrees."""
    angle = np.radians(np.linspace(start, end, n + 1))
    points = np.zeros((n + 1, 3))
    points[:, "xyz".index(plane[0])] = radius * np.cos(angle)
    points[:, "xyz".index(plane[1])] = radius * np.sin(angle)
    around: Array = points + np.array(centre, float)
    return around


def slab(
    outline: Array | Sequence[Sequence[float]], height: float, colour: Rgb, z: float = 0.0
) -> Soup:
    """A flat plate with an outline (n, 2), counter-clockwise, that its middle sees all of."""
    p = np.array(outline, float)
    p = np.concatenate([p, p[:1]])
    centre = np.broadcast_to(p[:-1].mean(axis=0), p.shape)
    rings = [(centre, z), (p, z), (p, z + height), (centre, z + height)]
    grid = np.stack([np.c_[xy, np.full(len(xy), h)] for xy, h in rings])
    return surface(grid, colour)


def disc(radius: float, thick: float, colour: Rgb, sides: int = 18) -> Soup:
    """A round plate that looks along -y, its middle on the origin."""
    return turned([cylinder(radius, radius, thick, colour, sides, (0, 0, -thick / 2))], "x", 90)[0]


def ring(
    radius: float, thick: float, colour: Rgb, plane: str = "xy", n: int = 20, sides: int = 6
) -> Soup:
    """A torus about the origin."""
    return tube(arc((0, 0, 0), radius, 0, 360, plane, n), thick, colour, sides)


def turned(parts: Part, axis: str, degrees: float) -> Part:
    """Rotated about an axis through the origin."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    a, b = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    turn = np.eye(3)
    turn[[a, a, b, b], [a, b, a, b]] = c, -s, s, c
    return _with(parts, lambda corners: corners @ turn.T)


def moved(parts: Part, by: Sequence[float]) -> Part:
    """Shifted."""
    return _with(parts, lambda corners: corners + np.array(by, float))


def scaled(parts: Part, by: float | Sequence[float]) -> Part:
    """Stretched about the origin."""
    return _with(parts, lambda corners: corners * np.array(by, float))


def _with(parts: Part, change: Callable[[Array], Array]) -> Part:
    return [Soup(p.material, change(p.corners), p.uv) for p in parts]


def fit(parts: Part, size: Sequence[float | None]) -> Part:
    """Scaled to a size; None leaves an axis alone."""
    points = np.concatenate([p.corners.reshape(-1, 3) for p in parts])
    spans = np.ptp(points, axis=0)
    return scaled(parts, [1.0 if s is None else s / n for s, n in zip(size, spans, strict=True)])


def standing(parts: Part) -> Part:
    """Moved so that the centre of the footprint's underside is the origin."""
    points = np.concatenate([p.corners.reshape(-1, 3) for p in parts])
    low, high = points.min(axis=0), points.max(axis=0)
    return moved(parts, (-(low[0] + high[0]) / 2, -(low[1] + high[1]) / 2, -low[2]))


def around(parts: Part, axis: str, count: int) -> Part:
    """`count` copies, turned evenly about an axis."""
    return [p for i in range(count) for p in turned(parts, axis, 360 * i / count)]


def wheel(radius: float, thick: float, colour: Rgb, at: Sequence[float]) -> Part:
    """A disc that rolls along y, its middle at `at`."""
    return moved(turned([disc(radius, thick, colour, 14)], "z", 90), at)


def legs(w: float, d: float, h: float, thick: float, colour: Rgb) -> Part:
    """Four square legs under a rectangle."""
    x, y = w / 2 - thick, d / 2 - thick
    return [box((thick, thick, h), (sx * x, sy * y, 0), colour) for sx in (-1, 1) for sy in (-1, 1)]


def shade(colour: Rgb, factor: float) -> Rgb:
    """Darker or paler."""
    r, g, b = (min(1.0, factor * c + (0.03 if factor > 1 else 0.0)) for c in colour)
    return r, g, b
