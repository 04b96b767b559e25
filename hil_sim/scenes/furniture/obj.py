"""OBJ and MTL files: the one reader, of those that people publish and of those that we write."""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.furniture.catalog import CatalogError
from hil_sim.scenes.furniture.soup import Array, Material, Soup

GLASS = 0.1
"""What is less opaque is left out."""


@dataclass(frozen=True)
class Geometry:
    """What an OBJ holds: points (V, 3), texture coordinates (T, 2), for each material (N, 3, 2)
    indices into both by triangle, -1 where a corner has no texture coordinate; and the MTLs."""

    points: Array
    uv: Array
    faces: dict[str, NDArray[np.int64]]
    libraries: tuple[Path, ...]

    @property
    def corners(self) -> NDArray[np.int64]:
        """(N, 3, 2) indices of all materials."""
        return np.concatenate(list(self.faces.values()))

    @property
    def triangles(self) -> Array:
        """(N, 3, 3) the same as points."""
        found: Array = self.points[self.corners[..., 0]]
        return found


def read_geometry(path: Path) -> Geometry:
    """Polygons become fans; negative indices are understood. CatalogError names the file, and the
    line that cannot be read."""
    vertices: list[list[float]] = []
    coordinates: list[list[float]] = []
    libraries: list[Path] = []
    faces: dict[str, list[tuple[tuple[int, int], ...]]] = {}
    current = ""
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise CatalogError(f"{path}: cannot be read ({error.strerror})") from error
    for number, line in enumerate(text.splitlines(), 1):
        head, _, rest = line.strip().partition(" ")
        try:
            if head == "v":
                vertices.append([float(v) for v in rest.split()[:3]])
            elif head == "vt":
                coordinates.append([float(v) for v in [*rest.split(), "0"][:2]])
            elif head == "f":
                corners = [_corner(c, len(vertices), len(coordinates)) for c in rest.split()]
                fans = faces.setdefault(current, [])
                fans += [(corners[0], b, c) for b, c in pairwise(corners[1:])]
            elif head == "usemtl":
                current = rest.strip()
            elif head == "mtllib":
                libraries.append(path.parent / rest.strip())
        except (ValueError, IndexError) as error:
            raise CatalogError(f"{path}:{number}: not an OBJ line: {line[:60]!r}") from error
    return Geometry(
        np.array(vertices, float).reshape(-1, 3),
        np.array(coordinates, float).reshape(-1, 2),
        {name: np.array(fans, np.int64).reshape(-1, 3, 2) for name, fans in faces.items()},
        tuple(libraries),
    )


def _corner(text: str, vertices: int, coordinates: int) -> tuple[int, int]:
    fields = text.split("/")
    v = int(fields[0])
    v = v - 1 if v > 0 else vertices + v
    if not 0 <= v < vertices:
        raise IndexError(text)
    t = int(fields[1]) if len(fields) > 1 and fields[1] else 0
    return v, (t - 1 if t > 0 else coordinates + t if t < 0 else -1)


def read_obj(path: Path) -> list[Soup]:
    """The triangles of an OBJ by material; what has no texture coordinate gets (0, 0), glass is
    left out."""
    geometry = read_geometry(path)
    materials: dict[str, Material] = {}
    for library in geometry.libraries:
        materials.update(_read_mtl(library))
    uv = np.concatenate([geometry.uv, [[0.0, 0.0]]])
    soups = []
    for name, index in sorted(geometry.faces.items()):
        material = materials.get(name, Material())
        if material.opacity < GLASS or len(index) == 0:
            continue
        soups.append(Soup(material, geometry.points[index[..., 0]], uv[index[..., 1]]))
    return soups


def _read_mtl(path: Path) -> dict[str, Material]:
    found: dict[str, Material] = {}
    if not path.is_file():
        return found
    current = Material()
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    for number, line in enumerate(lines, 1):
        head, _, rest = line.strip().partition(" ")
        try:
            if head == "newmtl":
                current = found[rest.strip()] = Material()
            else:
                _describe(current, head, rest, path.parent)
        except ValueError as error:
            raise CatalogError(f"{path}:{number}: not an MTL line: {line[:60]!r}") from error
    return found


def _describe(material: Material, head: str, rest: str, folder: Path) -> None:
    words = rest.split()
    if head == "Kd" and len(words) >= 3:
        r, g, b = (min(1.0, max(0.0, float(w))) for w in words[:3])
        material.colour = (r, g, b)
    elif head == "d" and words:
        material.opacity = float(words[-1])
    elif head == "Tr" and words:
        material.opacity = 1.0 - float(words[-1])
    elif head == "map_Kd" and words:
        image = folder / rest.strip().split("\\")[-1]
        if not image.is_file():
            image = folder / words[-1]
        material.texture = image if image.is_file() else None


def textured(path: Path, texture: Path) -> list[str]:
    """Write the MTL that gives `path`, an OBJ about to be written beside it, its texture; returns
    the OBJ's first lines."""
    mtl = path.with_suffix(".mtl")
    mtl.write_text(f"newmtl skin\nKd 1 1 1\nmap_Kd {texture.name}\n")
    return [f"mtllib {mtl.name}", "usemtl skin"]
