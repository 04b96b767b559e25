"""Where on a mesh things can stand or lie: measures `surfaces.json` from its triangles.

Table tops are mostly smaller than the box around the table (round ones above all), and a bed's or
a sofa's seat lies lower than its back. Run `python -m
hil_sim.scenes.furniture.surface_stats` when furniture.json gains a table, bed or sofa; it needs the
furniture (`hil-sim assets pull`).
"""

import json
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.furniture.boxes import furniture
from hil_sim.scenes.furniture.obj import read_geometry

OUT = Path(__file__).parent / "surfaces.json"
SEATS = ("bed", "sofa", "armchair")
CELL_M = 0.02
FLAT_TOP_M, FLAT_SEAT_M = 0.02, 0.05
"""How far a surface may be from level, above and below."""
SEAT_M = (0.25, 0.75)
BIN_M = 0.03
LEAST_M = 0.2
"""A surface with a shorter side is none."""

Array = NDArray[np.float64]


def height_map(triangles: Array, size_m: tuple[float, float, float]) -> Array:
    """(N, 3, 3) m, centred on the footprint -> (rows, columns) m: the highest point of each cell
    of 2 cm, 0 where there is none; rows along y."""
    w, d, _ = size_m
    shape = (max(1, round(d / CELL_M)), max(1, round(w / CELL_M)))
    heights = np.zeros(shape)
    sides = triangles - np.roll(triangles, 1, axis=1)
    longest = np.sqrt((sides[..., :2] ** 2).sum(axis=-1)).max(axis=1)
    for steps in range(1, int(longest.max() / CELL_M * 2) + 2):
        mine = triangles[np.ceil(longest / CELL_M * 2).clip(1) == steps]
        if len(mine) == 0:
            continue
        i, j = np.meshgrid(np.arange(steps + 1), np.arange(steps + 1))
        a, b = i[i + j <= steps] / steps, j[i + j <= steps] / steps
        weights = np.stack([a, b, 1 - a - b], axis=1)
        points = np.einsum("pk,nkc->npc", weights, mine).reshape(-1, 3)
        rows = ((points[:, 1] + d / 2) / d * shape[0]).astype(int).clip(0, shape[0] - 1)
        cols = ((points[:, 0] + w / 2) / w * shape[1]).astype(int).clip(0, shape[1] - 1)
        np.maximum.at(heights, (rows, cols), points[:, 2])
    return heights


def largest_rectangle(mask: NDArray[np.bool_]) -> tuple[int, int, int, int]:
    """(row0, row1, col0, col1), ends excluded, of the largest rectangle of True cells."""
    best, area = (0, 0, 0, 0), 0
    runs = np.zeros(mask.shape[1] + 1, int)
    for row, line in enumerate(mask):
        runs[:-1] = (runs[:-1] + 1) * line
        open_: list[tuple[int, int]] = []
        for col, high in enumerate(runs.tolist()):
            start = col
            while open_ and open_[-1][1] >= high:
                start, tall = open_.pop()
                if tall * (col - start) > area:
                    area = tall * (col - start)
                    best = (row - tall + 1, row + 1, start, col)
            open_.append((start, high))
    return best


def surface(heights: Array, size_m: tuple[float, float, float], seat: bool) -> list[float] | None:
    """[x0, y0, x1, y1, z] as shares of the mesh's size, from its footprint's middle; None if it
    has no such surface."""
    flat = FLAT_SEAT_M if seat else FLAT_TOP_M
    high = min(SEAT_M[1], 0.9 * size_m[2]) if seat else size_m[2] + BIN_M / 2
    low = SEAT_M[0] if seat else 0.6 * high
    counts, edges = np.histogram(heights, bins=np.arange(high, low - BIN_M, -BIN_M)[::-1])
    level = edges[int(np.argmax(counts))] + BIN_M / 2
    row0, row1, col0, col1 = largest_rectangle(np.abs(heights - level) <= flat)
    rows, cols = heights.shape
    if (row1 - row0) * CELL_M < LEAST_M or (col1 - col0) * CELL_M < LEAST_M:
        return None
    top = float(np.percentile(heights[row0:row1, col0:col1], 90))
    shares = (col0 / cols - 0.5, row0 / rows - 0.5, col1 / cols - 0.5, row1 / rows - 0.5)
    return [round(value, 3) for value in (*shares, top / size_m[2])]


def measure(names: Iterable[tuple[str, bool]], assets: Assets) -> dict[str, list[float] | None]:
    """Surfaces by mesh id; `names` says of each whether it is a seat."""
    found: dict[str, list[float] | None] = {}
    for name, seat in names:
        mesh = assets.mesh(name)
        triangles = np.concatenate([read_geometry(part.obj).triangles for part in mesh.parts])
        found[name] = surface(height_map(triangles, mesh.size_m), mesh.size_m, seat)
    return found


def wanted() -> list[tuple[str, bool]]:
    """All meshes with a top, and all seats."""
    meshes = [(mesh, category in SEATS) for category, many in furniture().items() for mesh in many]
    return [(mesh.id, seat) for mesh, seat in meshes if seat or mesh.top]


if __name__ == "__main__":
    table = measure(wanted(), Assets())
    rows = ",\n".join(f"  {json.dumps(k)}: {json.dumps(v)}" for k, v in sorted(table.items()))
    OUT.write_text("{\n" + rows + "\n}\n", encoding="utf-8")
    print(f"{OUT}: {sum(map(bool, table.values()))} of {len(table)} meshes have a surface")
