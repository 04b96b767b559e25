"""Sweet Home 3D furniture catalogues: what models there are, and how each is to be read."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from runtime.errors import RfNavError

_FILE = "PluginFurnitureCatalog.properties"
_UNIT = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


class CatalogError(RfNavError):
    """Furniture that is missing or cannot be read."""


@dataclass(frozen=True)
class Model:
    """One catalogue entry. `size_m`: width, depth, height; `rotation` row-major 3x3, applied to the
    file's vertices (Y up) before anything else."""

    id: str
    name: str
    path: Path
    size_m: tuple[float, float, float]
    rotation: tuple[float, ...]
    creator: str
    catalogue: str
    licence: str


@dataclass(frozen=True)
class Catalog:
    """All models under a directory that holds one unpacked folder a catalogue."""

    root: Path

    @cached_property
    def models(self) -> dict[str, Model]:
        """By id, e.g. "Scopia#bathroom3"."""
        found: dict[str, Model] = {}
        for path in sorted(self.root.glob(f"*/{_FILE}")):
            found.update((m.id, m) for m in _read(path))
        return found

    def model(self, id: str) -> Model:
        """CatalogError when there is none of that id."""
        if id not in self.models:
            raise CatalogError(f"{id}: no such model in the furniture catalogues at {self.root}")
        return self.models[id]

    def attribution(self, ids: Iterable[str]) -> str:
        """One Markdown line a model: name, creator, catalogue, licence."""
        rows = [self.model(id) for id in sorted(set(ids)) if not id.startswith("builtin:")]
        return "\n".join(
            f"- {m.name} (`{m.id}`), by {m.creator or 'unknown'}, {m.catalogue}: {m.licence}"
            for m in rows
        )


def parse_properties(text: str) -> dict[str, str]:
    """Java properties -> keys and values: comments, continued lines, `\\uXXXX` escapes."""
    joined = re.sub(r"(?<!\\)((?:\\\\)*)\\\r?\n[ \t]*", r"\1", text)
    table: dict[str, str] = {}
    for line in joined.splitlines():
        line = line.strip()
        if not line or line[0] in "#!":
            continue
        key, _, value = line.partition("=")
        table[key.strip()] = re.sub(r"\\(u[0-9a-fA-F]{4}|.)", _unescape, value.strip())
    return table


def _unescape(match: re.Match[str]) -> str:
    code = match.group(1)
    if code[0] == "u" and len(code) == 5:
        return chr(int(code[1:], 16))
    return {"n": "\n", "t": "\t", "r": "\r"}.get(code, code)


def _read(path: Path) -> list[Model]:
    table = parse_properties(path.read_text(encoding="latin-1"))
    licence = "CC0 1.0" if "CC-0" in path.parent.name else "CC BY 3.0"
    models = []
    for key, name in table.items():
        head, _, n = key.partition("#")
        model = table.get(f"model#{n}", "")
        if head != "name" or not n or not model.lower().endswith(".obj"):
            continue
        rotation = tuple(float(v) for v in table.get(f"modelRotation#{n}", "").split())
        size = tuple(float(table[f"{axis}#{n}"]) / 100 for axis in ("width", "depth", "height"))
        models.append(
            Model(
                table.get(f"id#{n}", f"{path.parent.name}#{n}"),
                name,
                path.parent / model.lstrip("/"),
                (size[0], size[1], size[2]),
                rotation if len(rotation) == 9 else _UNIT,
                table.get(f"creator#{n}", ""),
                table.get("name", path.parent.name),
                licence,
            )
        )
    return models
