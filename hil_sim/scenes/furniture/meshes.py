"""From OBJ files as people publish them to what the simulator draws: Z up, front along -y, metres,
few triangles, one texture a part."""

import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.furniture.catalog import CatalogError, Model
from hil_sim.scenes.furniture.decimation import simplify
from hil_sim.scenes.furniture.obj import read_obj, textured
from hil_sim.scenes.furniture.shapes.named import BUILTINS, SHAPES
from hil_sim.scenes.furniture.soup import Array, Material, Soup, bounds

VERSION = 7  # of the conversion: a change makes the cache convert anew
TRIANGLES = 1000  # a part
TEXTURE_PX = 256
PALETTE = 16  # colours a side


@dataclass(frozen=True)
class Part:
    """One OBJ with one texture."""

    obj: Path
    texture: Path


@dataclass(frozen=True)
class Mesh:
    """A converted model: parts share one frame, origin at the centre of the footprint's underside;
    `size_m` is width (x), depth (y), height (z)."""

    parts: tuple[Part, ...]
    size_m: tuple[float, float, float]


def load_mesh(model: Model, store: Path) -> Mesh:
    """A catalogue model, from the cache when it was converted before."""
    return convert(model.path, model.rotation, model.size_m, store)


def convert(
    path: Path,
    rotation: tuple[float, ...] | None,
    size_m: tuple[float, float, float] | None,
    store: Path,
) -> Mesh:
    """Read an OBJ (Y up), rotate, fit its bounding box to `size_m` (None: as it is, metres)."""

    def build(out: Path) -> tuple[float, float, float]:
        soups = read_obj(path)
        if not soups:
            raise CatalogError(f"{path}: holds no triangles")
        _stand_up(soups, rotation, size_m)
        _write_parts(soups, out)
        low, high = bounds(soups)
        width, depth, height = (high - low).tolist()
        return width, depth, height

    stat = path.stat()
    key = f"{VERSION}|{path}|{stat.st_size}|{stat.st_mtime_ns}|{rotation}|{size_m}"
    return _cached(store, key, build)


def builtin(name: str, store: Path) -> Mesh:
    """A mesh of simple geometry by name, stood on the origin; CatalogError lists the known ones."""
    if name not in BUILTINS:
        raise CatalogError(
            f"builtin:{name}: unknown; known are {', '.join(sorted(SHAPES))}; each as NAME.0, ..."
        )
    soups = BUILTINS[name]()
    _stand(soups, None)
    # Named by content, not by name: an edited shape is never found under its old form.
    digest = hashlib.sha256()
    for soup in soups:
        digest.update(repr(soup.material.colour).encode())
        digest.update(np.round(soup.corners, 5).tobytes())

    def build(out: Path) -> tuple[float, float, float]:
        _write_parts(soups, out)
        low, high = bounds(soups)
        width, depth, height = (high - low).tolist()
        return width, depth, height

    return _cached(store, f"{VERSION}|builtin|{digest.hexdigest()}", build)


def _cached(store: Path, key: str, build: Callable[[Path], tuple[float, float, float]]) -> Mesh:
    folder = store / hashlib.sha256(key.encode()).hexdigest()[:20]
    card = folder / "mesh.json"
    if not card.is_file():
        store.mkdir(parents=True, exist_ok=True)
        work = Path(tempfile.mkdtemp(dir=store))
        try:
            size = build(work)
            names = sorted(p.stem for p in work.glob("*.obj"))
            (work / "mesh.json").write_text(json.dumps({"size_m": size, "parts": names}))
            try:
                os.rename(work, folder)
            except OSError:  # another process was faster
                if not card.is_file():
                    raise
        finally:
            shutil.rmtree(work, ignore_errors=True)
    table = json.loads(card.read_text())
    parts = tuple(Part(folder / f"{n}.obj", folder / f"{n}.png") for n in table["parts"])
    width, depth, height = table["size_m"]
    return Mesh(parts, (width, depth, height))


# -- shaping -------------------------------------------------------------------------------------


def _stand_up(
    soups: list[Soup],
    rotation: tuple[float, ...] | None,
    size_m: tuple[float, float, float] | None,
) -> None:
    """Rotate, Y up -> Z up (x, y, z) -> (x, -z, y), fit to the size, stand on the origin."""
    turn = np.array(rotation or (1, 0, 0, 0, 1, 0, 0, 0, 1), float).reshape(3, 3)
    up = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float)
    for soup in soups:
        soup.corners = soup.corners @ (up @ turn).T
    _stand(soups, size_m)


def _stand(soups: list[Soup], size_m: tuple[float, float, float] | None) -> None:
    """Fit to the size, the centre of the footprint's underside on the origin."""
    low, high = bounds(soups)
    scale = np.ones(3) if size_m is None else np.array(size_m) / np.maximum(high - low, 1e-9)
    origin = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])
    for soup in soups:
        soup.corners = (soup.corners - origin) * scale


def _write_parts(soups: list[Soup], out: Path) -> None:
    """All plain colours share one part with a palette; every texture has a part of its own."""
    plain = [s for s in soups if s.material.texture is None]
    groups: dict[Path, list[Soup]] = {}
    for soup in soups:
        if soup.material.texture is not None:
            groups.setdefault(soup.material.texture, []).append(soup)
    n = 0
    if plain:
        _write_part(_with_palette(plain, out / "0.png"), out / "0.obj")
        n = 1
    for texture in sorted(groups):
        image = cv2.imread(str(texture), cv2.IMREAD_UNCHANGED)
        if image is None:
            image = np.full((4, 4, 3), 180, np.uint8)
        cv2.imwrite(str(out / f"{n}.png"), _texture(np.asarray(image)))
        _write_part(groups[texture], out / f"{n}.obj")
        n += 1


def _with_palette(soups: list[Soup], path: Path) -> list[Soup]:
    colours = sorted({_shown(s.material) for s in soups})[: PALETTE * PALETTE]
    image = np.zeros((PALETTE * 4, PALETTE * 4, 3), np.uint8)
    place = {}
    for i, colour in enumerate(colours):
        row, col = divmod(i, PALETTE)
        rgb = [round(255 * c) for c in colour]
        image[row * 4 : row * 4 + 4, col * 4 : col * 4 + 4] = rgb[::-1]
        place[colour] = ((col + 0.5) / PALETTE, 1 - (row + 0.5) / PALETTE)
    cv2.imwrite(str(path), image)
    for soup in soups:
        soup.uv = np.broadcast_to(place.get(_shown(soup.material), (0, 0)), soup.uv.shape)
    return soups


def _shown(material: Material) -> tuple[float, float, float]:
    """Glass is drawn as a pale surface: the renderers' transparency is not to be relied on."""
    a = 1.0 if material.opacity > 0.6 else 0.5
    r, g, b = (round(a * c + (1 - a) * 0.85, 3) for c in material.colour)
    return r, g, b


def _texture(image: NDArray[Any]) -> NDArray[np.uint8]:
    if image.ndim == 2:
        image = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
    if image.dtype != np.uint8:
        image = (image / 257).astype(np.uint8)
    if image.shape[2] == 4:
        alpha = image[..., 3:].astype(np.float32) / 255
        image = (image[..., :3] * alpha + 200 * (1 - alpha)).astype(np.uint8)
    scale = min(1.0, TEXTURE_PX / max(image.shape[:2]))
    height, width = (max(4, round(n * scale / 4) * 4) for n in image.shape[:2])
    image = cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)  # rows of whole words
    return np.ascontiguousarray(image[..., :3], np.uint8)


def _write_part(soups: list[Soup], path: Path) -> None:
    corners = np.concatenate([s.corners for s in soups]).reshape(-1, 3)
    uv = np.concatenate([s.uv for s in soups]).reshape(-1, 2)
    rows = np.round(np.concatenate([corners, uv], axis=1), 5)
    vertices, index = np.unique(rows, axis=0, return_inverse=True)
    triangles = simplify(vertices, index.reshape(-1, 3), TRIANGLES)
    lines = [*textured(path, path.with_suffix(".png"))]
    lines += [f"v {v[0]:.5f} {v[1]:.5f} {v[2]:.5f}" for v in vertices]
    lines += [f"vt {v[3]:.5f} {v[4]:.5f}" for v in vertices]
    normals = _normals(vertices[:, :3], triangles)
    lines += [f"vn {n[0]:.4f} {n[1]:.4f} {n[2]:.4f}" for n in normals]
    for i, (a, b, c) in enumerate(triangles + 1):
        lines.append(f"f {a}/{a}/{i + 1} {b}/{b}/{i + 1} {c}/{c}/{i + 1}")
    path.write_text("\n".join(lines) + "\n")


def _normals(xyz: Array, triangles: NDArray[np.int64]) -> Array:
    a, b, c = (xyz[triangles[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    unit: Array = np.where(length > 1e-12, normal / np.maximum(length, 1e-12), [0.0, 0.0, 1.0])
    return unit
