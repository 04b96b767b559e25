"""The models embedded in a drawing, rewritten as OBJ, MTL and textures beside the scene.

Only names made here are written; what the archive's entries are called never is.
"""

import hashlib
import math
import re
import tempfile
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.colours import rgb_of
from hil_sim.scenes.format import SceneError
from hil_sim.scenes.furniture.catalog import CatalogError
from hil_sim.scenes.furniture.obj import read_obj
from hil_sim.scenes.furniture.soup import Soup, bounds
from hil_sim.scenes.sweethome.archive import Archive, ModelFiles
from hil_sim.scenes.sweethome.drawing import Drawn
from hil_sim.scenes.sweethome.words import plain

FOLDER = "meshes"
MAX_TRIANGLES = 500_000
PLAIN = "#c8b89c"
Array = NDArray[np.float64]

COLOURS = {
    "white": "#f2f2f2", "black": "#1a1a1a", "grey": "#808080", "gray": "#808080",
    "silver": "#c0c0c4", "blonde": "#c9a66b", "yellow": "#d9c55a", "amber": "#c98a2e",
    "bone": "#e4dcc4", "brown": "#7a5232", "tan": "#c8a878", "wood": "#9a6b3f",
    "red": "#b03030", "green": "#4f8a4f", "blue": "#3f5f9f", "iris": "#5a5a9a",
    "orange": "#d07a30", "pink": "#d49aa4", "flesh": "#d9a98c", "glass": "#cfe0e4",
    "mirror": "#d8e0e4", "metal": "#a8a8ac", "chrome": "#c4c8cc", "gold": "#c8a648",
    "leaf": "#4f8a4f", "skin": "#8a6b4a",
}  # fmt: skip
"""For materials that a model names but does not define: many of Sweet Home 3D's own do that."""


@dataclass
class Models:
    """Writes models below `out`, each once. `boxed`: a line for each piece that got a box."""

    archive: Archive
    out: Path
    known: frozenset[str] = frozenset()
    """Catalogue ids whose meshes are in the cache, for pieces that embed no model."""
    boxed: list[str] = field(default_factory=list)
    _made: dict[str, tuple[str, tuple[float, float, float]] | None] = field(default_factory=dict)

    def mesh(self, piece: Drawn) -> tuple[str, tuple[float, float, float]]:
        """The piece's mesh, as scene files name it, and the size it is to have, m."""
        files = self.archive.model(piece.model) if piece.model else None
        if files is None:
            return self._unembedded(piece)
        if files.kind != "obj":
            return self._box(piece, f"its model is {files.kind}, not OBJ")
        key = _key(piece, files)
        try:
            if key not in self._made:
                self._made[key] = self._write(piece, files, key)
        except (CatalogError, ValueError, OSError) as error:
            return self._box(piece, f"its model cannot be read: {_brief(error)}")
        made = self._made[key]
        if made is None:
            return self._box(piece, "its model has nothing to be seen")
        name, size = made
        return name, size if any(piece.lean_rad) else piece.size_m

    def texture_colour(self, name: str | None) -> str | None:
        """The mean colour of a texture in the archive."""
        data = self.archive.image(name) if name else None
        image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR) if data else None
        if image is None:
            return None
        b, g, r = (round(float(v)) for v in np.asarray(image).reshape(-1, 3).mean(axis=0))
        return f"#{r:02x}{g:02x}{b:02x}"

    def _unembedded(self, piece: Drawn) -> tuple[str, tuple[float, float, float]]:
        if piece.catalog_id in self.known and not any(piece.lean_rad):
            return piece.catalog_id, piece.size_m
        return self._box(piece, "its model is not in the file")

    def _box(self, piece: Drawn, why: str) -> tuple[str, tuple[float, float, float]]:
        self.boxed.append(f"{piece.place}: drawn as a box: {why}")
        return self.box(self._paint(piece) or PLAIN), piece.size_m

    def box(self, colour: str) -> str:
        """The mesh of a cuboid in one colour."""
        name = f"box-{colour[1:]}"
        corners = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
        faces = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"]
        lines = [f"mtllib {name}.mtl", "usemtl paint"]
        lines += [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {face}" for face in faces]
        self._save(f"{name}.obj", "\n".join(lines) + "\n")
        self._save(f"{name}.mtl", f"newmtl paint\nKd {_kd(rgb_of(colour))}\n")
        return f"{FOLDER}/{name}.obj"

    def _paint(self, piece: Drawn) -> str | None:
        return piece.colour or self.texture_colour(piece.texture)

    def _write(
        self, piece: Drawn, files: ModelFiles, key: str
    ) -> tuple[str, tuple[float, float, float]] | None:
        with tempfile.TemporaryDirectory(prefix="rf-nav-import-") as scratch:
            soups = read_obj(_unpack(files, Path(scratch), self._paints(piece)))
            if not soups:
                return None
            if sum(len(soup.corners) for soup in soups) > MAX_TRIANGLES:
                raise CatalogError(f"more than {MAX_TRIANGLES} triangles")
            _inside(soups, Path(scratch))
            colour = self._paint(piece)
            for soup in soups if colour else ():
                soup.material.colour, soup.material.texture = rgb_of(colour or PLAIN), None
            size = _shape(soups, piece)
            name = f"{_slug(piece)}-{key[:8]}"
            self._write_obj(name, soups)
        return f"{FOLDER}/{name}.obj", size

    def _paints(self, piece: Drawn) -> dict[str, str]:
        """Material -> colour, where the drawing repaints one."""
        found = {m: colour or self.texture_colour(image) for m, colour, image in piece.paints if m}
        return {m: colour for m, colour in found.items() if colour}

    def _write_obj(self, name: str, soups: list[Soup]) -> None:
        lines, mtl, count = [f"mtllib {name}.mtl"], [], 0
        for n, soup in enumerate(soups):
            corners = np.concatenate([soup.corners.reshape(-1, 3), soup.uv.reshape(-1, 2)], axis=1)
            rows, index = np.unique(np.round(corners, 5), axis=0, return_inverse=True)
            lines += [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in rows[:, :3]]
            lines += [f"vt {u:.6g} {v:.6g}" for u, v in rows[:, 3:]] + [f"usemtl m{n}"]
            for a, b, c in index.reshape(-1, 3) + count + 1:
                lines.append(f"f {a}/{a} {b}/{b} {c}/{c}")
            count += len(rows)
            mtl += [f"newmtl m{n}", f"Kd {_kd(soup.material.colour)}", f"d {soup.material.opacity}"]
            if soup.material.texture:
                mtl.append(f"map_Kd {self._texture(soup.material.texture)}")
        self._save(f"{name}.mtl", "\n".join(mtl) + "\n")
        self._save(f"{name}.obj", "\n".join(lines) + "\n")

    def _texture(self, path: Path) -> str:
        data = path.read_bytes()
        name = f"texture-{hashlib.sha256(data).hexdigest()[:12]}.png"
        image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
        if image is None:
            image = np.full((4, 4, 3), 180, np.uint8)
        scale = min(1.0, 512 / max(image.shape[:2]))
        if scale < 1:
            image = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        _, png = cv2.imencode(".png", image)
        self._save(name, png.tobytes())
        return name

    def _save(self, name: str, content: str | bytes) -> None:
        path = self.out / FOLDER / name
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content.encode() if isinstance(content, str) else content)
        except OSError as error:
            raise SceneError(f"{path}: cannot be written ({error.strerror})") from None


def _key(piece: Drawn, files: ModelFiles) -> str:
    lean = (piece.lean_rad, piece.size_m) if any(piece.lean_rad) else ()
    how = (piece.rotation, piece.mirrored, lean, piece.colour, piece.texture, piece.paints)
    return hashlib.sha256(f"{piece.model}|{files.main}|{how}".encode()).hexdigest()


def _slug(piece: Drawn) -> str:
    return plain(piece.name).replace(" ", "-")[:30] or "piece"


def _brief(error: Exception) -> str:
    return re.sub(r"^\S*rf-nav-import-\w+/", "", str(error))[:160]


def _unpack(files: ModelFiles, scratch: Path, paints: dict[str, str]) -> Path:
    """Write a model's files below `scratch`, never outside it, with its repaints; the OBJ's path.
    Entries that climb out of their folder are left."""
    main = scratch / "model.obj"
    base = PurePosixPath(files.main).parent
    for name, data in files.files.items():
        path = PurePosixPath(name.replace("\\", "/"))
        if path.is_absolute() or ".." in path.parts or ":" in name or not path.is_relative_to(base):
            continue
        target = scratch / path.relative_to(base)
        if name != files.main and target != main:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(data)
    text = files.files[files.main].decode("utf-8", "replace")
    text = re.sub(r"(?m)^\s*mtllib\s+(?:/|\S:|.*\.\.).*$", "", text)
    defined = "".join(
        data.decode("utf-8", "replace")
        for name, data in files.files.items()
        if name.lower().endswith(".mtl")
    )
    has = {line.split(None, 1)[1].strip() for line in re.findall(r"(?m)^\s*newmtl \S.*$", defined)}
    used = {line.split(None, 1)[1].strip() for line in re.findall(r"(?m)^\s*usemtl \S.*$", text)}
    paints = {**{m: c for m in used - has if (c := _colour_named(m))}, **paints}
    rows = [f"newmtl {m}\nKd {_kd(rgb_of(c))}" for m, c in sorted(paints.items())]
    (scratch / "repaint.mtl").write_text("\n".join(rows) + "\n")
    main.write_text(text + "\nmtllib repaint.mtl\n")
    return main


def _colour_named(material: str) -> str | None:
    """A colour that the material's name tells of; dark and light ones are shaded."""
    name = material.lower()
    found = next((colour for word, colour in COLOURS.items() if word in name), None)
    if not found:
        return None
    shade = 0.6 if "dk" in name or "dark" in name else 1.3 if "lt" in name or "light" in name else 1
    return "#" + "".join(
        f"{min(255, round(int(found[i : i + 2], 16) * shade)):02x}" for i in (1, 3, 5)
    )


def _inside(soups: list[Soup], folder: Path) -> None:
    """Forget textures that an MTL takes from elsewhere on this machine."""
    for soup in soups:
        texture = soup.material.texture
        if texture and not texture.resolve().is_relative_to(folder.resolve()):
            soup.material.texture = None


def _shape(soups: list[Soup], piece: Drawn) -> tuple[float, float, float]:
    """Rotate and mirror the model in place (Y up), lean it over, fit it to the piece's size; what
    it measures then: width, depth, height, m."""
    turn = np.array(piece.rotation).reshape(3, 3)
    width, depth, height = piece.size_m
    with np.errstate(all="ignore"):
        for soup in soups:
            soup.corners = soup.corners @ turn.T
            if (np.linalg.det(turn) < 0) != piece.mirrored:
                soup.corners, soup.uv = soup.corners[:, ::-1], soup.uv[:, ::-1]
            if piece.mirrored:
                soup.corners = soup.corners * (-1, 1, 1)
        low, high = bounds(soups)
        scale = np.array([width, height, depth]) / np.maximum(high - low, 1e-9)
        lean = _lean(*piece.lean_rad)
        for soup in soups:
            soup.corners = ((soup.corners - (low + high) / 2) * scale) @ lean.T
        low, high = bounds(soups)
    if not np.isfinite([low, high]).all():
        raise CatalogError("its vertices are not finite numbers")
    x, y, z = (max(1e-3, float(v)) for v in high - low)
    return x, z, y


def _lean(pitch: float, roll: float) -> Array:
    """Turns about x, then z (Y up), clockwise as Sweet Home 3D counts them."""
    c, s = math.cos(pitch), math.sin(pitch)
    about_x = np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
    c, s = math.cos(roll), math.sin(roll)
    about_z = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    leaning: Array = about_z @ about_x
    return leaning


def _kd(rgb: tuple[float, float, float]) -> str:
    return " ".join(f"{v:.3f}" for v in rgb)
