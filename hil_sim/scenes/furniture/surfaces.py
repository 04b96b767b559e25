"""Where things stand or lie on a piece of furniture, from the measured `surfaces.json`."""

import functools
import json
from pathlib import Path

from hil_sim.scenes.format import SceneObject
from hil_sim.scenes.furniture.boxes import Box, box_of, has_top, offset

TABLE = Path(__file__).parent / "surfaces.json"
Shares = tuple[float, float, float, float, float]


def resting_place(obj: SceneObject) -> Box | None:
    """The level part of a table's top or of a bed's or sofa's seat, as a box whose upper side
    (`z1`) it is; None if nothing rests on such a thing. Unmeasured tops are all of their box."""
    if obj.size_m is None:
        return None
    if obj.mesh not in _table():
        return box_of(obj) if has_top(obj) else None
    shares = _table()[obj.mesh]
    if shares is None:
        return None
    x0, y0, x1, y1, z = shares
    (w, d, h), low = obj.size_m, obj.position_m[2]
    x, y = offset(obj, (x0 + x1) / 2 * w, (y0 + y1) / 2 * d)
    return Box(x, y, (x1 - x0) * w, (y1 - y0) * d, obj.yaw_rad, low, low + z * h)


def is_rest(mesh: str) -> bool:
    """Whether things can rest on a mesh, by what was measured."""
    return _table().get(mesh) is not None


def lies_on(thing: Box, place: Box, slack_m: float = 0.012) -> bool:
    """Whether a thing rests on a surface and does not hang over its edge."""
    if abs(thing.z0 - place.z1) > slack_m:
        return False
    return all(place.holds(x, y, 0.002) for x, y in thing.outline)


@functools.cache
def _table() -> dict[str, Shares | None]:
    rows = json.loads(TABLE.read_text(encoding="utf-8"))
    return {name: tuple(row) if row else None for name, row in rows.items()}
