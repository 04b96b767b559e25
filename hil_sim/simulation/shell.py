"""Walls, floor and ceiling of a scene: their solids, and how they are painted."""

import math
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.colours import rgb_of
from hil_sim.scenes.format import Hole, Point, Scene, Wall, on_wall, room_at
from hil_sim.scenes.furniture.obj import textured
from hil_sim.scenes.holes import levels, sides, trapezoids

PAINT_M = 0.02  # of floor under a pixel of its texture
PLAIN_WALL = "#e8e4da"
PLAIN_FLOOR = "#a08a70"
PIT = "#8d8377"
TILE_M, PLANK_M = 0.4, 0.14

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Surface:
    """Triangles (N, 3, 3) m with texture coordinates (N, 3, 2)."""

    triangles: Array
    uv: Array

    def write(self, path: Path, texture: Path) -> None:
        """As an OBJ with a normal for each triangle."""
        a, b, c = (self.triangles[:, i] for i in range(3))
        normal = np.cross(b - a, c - a)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        lines = [*textured(path, texture)]
        lines += [f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in self.triangles.reshape(-1, 3)]
        lines += [f"vt {u:.4f} {v:.4f}" for u, v in self.uv.reshape(-1, 2)]
        lines += [f"vn {x:.4f} {y:.4f} {z:.4f}" for x, y, z in normal]
        for i in range(len(self.triangles)):
            corner = [f"{3 * i + k + 1}/{3 * i + k + 1}/{i + 1}" for k in range(3)]
            lines.append("f " + " ".join(corner))
        path.write_text("\n".join(lines) + "\n")


@dataclass(frozen=True)
class Piece:
    """A cuboid of wall: centre and half extents (along the wall, across, up), m."""

    centre_m: tuple[float, float, float]
    half_m: tuple[float, float, float]
    yaw_rad: float

    @property
    def triangles(self) -> Array:
        """(12, 3, 3) m, outward."""
        x, y, z = self.half_m
        corner = np.array(
            [[i * x, j * y, k * z] for k in (-1, 1) for j in (-1, 1) for i in (-1, 1)], float
        )
        quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
        index = [t for a, b, e, f in quads for t in ((a, b, e), (a, e, f))]
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        moved: Array = (corner @ turn.T + np.array(self.centre_m))[np.array(index)]
        return moved


def wall_pieces(scene: Scene) -> list[Piece]:
    """The solid parts of all walls: beside doors, and above them."""
    return [piece for wall in scene.walls for piece in _pieces(scene, wall)]


def _pieces(scene: Scene, wall: Wall) -> list[Piece]:
    (x0, y0), (x1, y1) = wall.start, wall.end
    length, yaw = math.dist(wall.start, wall.end), math.atan2(y1 - y0, x1 - x0)
    ux, uy = (x1 - x0) / length, (y1 - y0) / length

    def along(point: Point) -> float:
        return (point[0] - x0) * ux + (point[1] - y0) * uy

    def piece(a: float, b: float, low: float, high: float) -> Piece:
        middle = (a + b) / 2
        centre = (x0 + ux * middle, y0 + uy * middle, (low + high) / 2)
        return Piece(centre, ((b - a) / 2, wall.thickness_m / 2, (high - low) / 2), yaw)

    gaps = sorted(
        (*sorted((along(d.start), along(d.end))), d.height_m)
        for d in scene.doors
        if on_wall(d, wall)
    )
    found, at, half = [], -wall.thickness_m / 2, wall.thickness_m / 2
    for begin, end, height in gaps:
        if begin > at:
            found.append(piece(at, begin, 0.0, scene.wall_height_m))
        if height < scene.wall_height_m:
            found.append(piece(begin, end, height, scene.wall_height_m))
        at = max(at, end)
    if length + half > at:
        found.append(piece(at, length + half, 0.0, scene.wall_height_m))
    return found


def walls(scene: Scene, out: Path) -> list[tuple[Surface, Path]]:
    """One surface a wall colour: each side of a wall is painted as the room that it faces."""
    painted: dict[str, list[Array]] = {}
    for piece in wall_pieces(scene):
        for triangle_pair in piece.triangles.reshape(6, 2, 3, 3):
            for strip, colour in _facing(scene, triangle_pair):
                painted.setdefault(colour, []).append(strip)
    found = []
    for n, (colour, strips) in enumerate(sorted(painted.items())):
        triangles = np.concatenate(strips)
        along = np.hypot(triangles[..., 0], triangles[..., 1])
        uv = np.stack([along, triangles[..., 2]], axis=-1) / 2.0
        path = out / f"wall{n}.png"
        cv2.imwrite(str(path), _plaster(colour))
        found.append((Surface(triangles, uv), path))
    return found


def _facing(scene: Scene, quad: Array) -> Iterable[tuple[Array, str]]:
    """A quad's triangles cut into strips, each with the colour of the room in front of it."""
    a, b, c, d = quad[0][0], quad[0][1], quad[0][2], quad[1][2]
    normal = np.cross(b - a, c - a)
    normal = normal / max(float(np.linalg.norm(normal)), 1e-9)
    side = b - a if abs(b[2] - a[2]) < 1e-6 else d - a  # the quad's level edge
    other = d - a if side is not None and abs(b[2] - a[2]) < 1e-6 else b - a
    strips = max(1, round(float(np.linalg.norm(side)) / 0.5)) if abs(normal[2]) < 0.5 else 1
    colours = []
    for n in range(strips):
        middle = a + side * (n + 0.5) / strips + other / 2 + normal * 0.1
        room = room_at(scene, float(middle[0]), float(middle[1]))
        colours.append((room.wall if room else None) or PLAIN_WALL)
    begin = 0
    for n in range(1, strips + 1):
        if n == strips or colours[n] != colours[begin]:
            p, q = a + side * begin / strips, a + side * n / strips
            corners = [p, q, q + other, p + other]
            if np.dot(np.cross(q - p, other), normal) < 0:
                corners.reverse()
            i, j, k, m = corners
            yield np.array([[i, j, k], [i, k, m]]), colours[begin]
            begin = n


def floor(scene: Scene, out: Path) -> tuple[Surface, Path]:
    """One quad under everything, painted room by room; without what lies in holes."""
    low, high = _extent(scene)
    # OpenGL reads rows of whole words: a texture's width must be a multiple of 4
    size = (np.ceil((high - low) / PAINT_M / 4) * 4).astype(int)
    high = low + size * PAINT_M
    image = np.zeros((size[1], size[0], 3), np.uint8)
    image[:] = _bgr(PLAIN_FLOOR)
    for room in scene.rooms:
        outline = np.round((np.array(room.polygon) - low) / PAINT_M).astype(np.int32)
        mask = np.zeros(image.shape[:2], np.uint8)
        cv2.fillPoly(mask, [outline], 1)
        image[mask > 0] = _pattern(room.floor or PLAIN_FLOOR, image.shape[:2])[mask > 0]
    path = out / "floor.png"
    cv2.imwrite(str(path), image[::-1])
    if not scene.holes:
        return _level(low, high, 0.0, up=True), path
    (x0, y0), (x1, y1) = low, high
    whole = ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
    corners = _flat(trapezoids([whole, *(hole.polygon for hole in scene.holes)]), 0.0)
    return Surface(corners, (corners[..., :2] - low) / (high - low)), path


def pits(holes: Sequence[Hole], out: Path) -> tuple[Surface, Path]:
    """What is seen in holes: treads and ground, and the sides."""
    grounds = [_flat(trapezoids([part]), -depth) for hole in holes for part, depth in levels(hole)]
    triangles = np.concatenate([*grounds, sides(holes).reshape(-1, 3, 3)])
    upright = np.ptp(triangles[..., 2], axis=1) > 1e-6
    along = np.hypot(triangles[..., 0], triangles[..., 1])
    level = np.stack([triangles[..., 0], triangles[..., 1]], axis=-1)
    wall = np.stack([along, triangles[..., 2]], axis=-1)
    path = out / "pits.png"
    cv2.imwrite(str(path), _plaster(PIT))
    return Surface(triangles, np.where(upright[:, None, None], wall, level) / 2.0), path


def _flat(quads: Array, z_m: float) -> Array:
    """(N, 4, 2) m, counter-clockwise -> (2 N, 3, 3), upward."""
    corners = np.concatenate([quads, np.full((*quads.shape[:2], 1), z_m)], axis=2)
    triangles: Array = corners[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
    return triangles


def ceiling(scene: Scene, out: Path) -> tuple[Surface, Path]:
    """One pale quad over everything."""
    low, high = _extent(scene)
    path = out / "ceiling.png"
    cv2.imwrite(str(path), np.full((8, 8, 3), 242, np.uint8))
    return _level(low, high, scene.wall_height_m, up=False), path


def _extent(scene: Scene) -> tuple[Array, Array]:
    points = [p for w in scene.walls for p in (w.start, w.end)]
    points += [p for r in scene.rooms for p in r.polygon]
    xy = np.array(points, float)
    return xy.min(axis=0) - 0.2, xy.max(axis=0) + 0.2


def _level(low: Array, high: Array, z: float, up: bool) -> Surface:
    a, b = (low[0], low[1], z), (high[0], low[1], z)
    c, d = (high[0], high[1], z), (low[0], high[1], z)
    corners = np.array([[a, b, c], [a, c, d]] if up else [[a, c, b], [a, d, c]], float)
    uv = (corners[..., :2] - low) / (high - low)
    return Surface(corners, uv)


def _bgr(colour: str) -> tuple[int, int, int]:
    r, g, b = (round(255 * v) for v in rgb_of(colour))
    return b, g, r


def _plaster(colour: str) -> NDArray[np.uint8]:
    rng = np.random.default_rng(zlib.crc32(colour.encode()))
    coarse = cv2.resize(rng.normal(0, 3, (16, 16)), (128, 128), interpolation=cv2.INTER_CUBIC)
    noise = coarse + rng.normal(0, 1.5, (128, 128))
    return np.clip(np.array(_bgr(colour)) + noise[..., None], 0, 255).astype(np.uint8)


def _pattern(colour: str, shape: tuple[int, int]) -> NDArray[np.uint8]:
    """Planks for brown colours, tiles for pale and grey ones."""
    rng = np.random.default_rng(zlib.crc32(colour.encode()))
    r, _, b = rgb_of(colour)
    rows, cols = np.indices(shape)
    if r - b > 0.12:
        width = max(2, round(PLANK_M / PAINT_M))
        plank = rows // width
        start = rng.integers(0, 60, plank.max() + 1)[plank]
        board = (cols + start) // 60
        shade = rng.normal(0, 9, (plank.max() + 1, board.max() + 1))[plank, board]
        seam = (rows % width == 0) | ((cols + start) % 60 == 0)
    else:
        width = max(2, round(TILE_M / PAINT_M))
        shade = rng.normal(0, 3, (rows.max() // width + 1, cols.max() // width + 1))
        shade = shade[rows // width, cols // width]
        seam = (rows % width == 0) | (cols % width == 0)
    shade = shade + rng.normal(0, 2.5, shape) - 22.0 * seam
    image: NDArray[np.uint8] = np.clip(np.array(_bgr(colour)) + shade[..., None], 0, 255).astype(
        np.uint8
    )
    return image
