"""Keep-out zones: drawn by people over the bus, kept in a file, and put on the map of each search.

They are told in the frame of odometry (`rfnav/map`), and kept in the frame of what is saved. After
a restart odometry begins elsewhere: until somebody knows where, they lie nowhere, and no goal is
taken, for the robot would drive where it must not.
"""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Protocol

from runtime.core.mapping.zones import Zone, wrong_corners
from runtime.core.types import Pose
from runtime.errors import ConfigError, SavedError
from runtime.private_files import state_directory
from runtime.robot.wire import Stamped
from runtime.service.saved import save, saved
from runtime.toml_values import unknown

FILE: Final = "zones.json"
MOST_ZONES: Final = 64
MOST_BYTES: Final = 1 << 20
NAME_CHARS: Final = 60
DOES: Final = ("add", "remove", "clear", "list")
HERE: Final = Pose(0.0, 0.0, 0.0)

Binding = Callable[[], Pose | None]
"""Where the frame of what is saved lies in odometry's of now; None: nobody knows."""


@dataclass(frozen=True)
class Surroundings:
    """What zones need of the robot. `binding`: None for no memory of where it is: what was saved by
    another process stays unbound. `origin_xy`: where in odometry's frame the map begins."""

    pose: Callable[[], Pose | None]
    origin_xy: Callable[[], tuple[float, float]]
    binding: Binding | None = None


class ZonedBus(Protocol):
    """The bus, as far as zones need it; see `Bus`."""

    def pose(self) -> tuple[Stamped[Pose], float] | None: ...

    def origin_xy(self) -> tuple[float, float]: ...


def zones_beside(bus: ZonedBus, kept: bool, binding: Binding | None = None) -> "Zones":
    """The zones of the robot on a bus, in the file that they are `kept` in."""

    def pose() -> Pose | None:
        found = bus.pose()
        return found[0].value if found is not None else None

    path = state_directory() / FILE if kept else None
    return Zones(path, Surroundings(pose, bus.origin_xy, binding))


class Zones:
    """The zones of a robot; one thread's. `path`: None for none that are kept."""

    def __init__(self, path: Path | None, around: Surroundings) -> None:
        self._path, self._around = path, around
        kept, self._lost = _kept(path) if path is not None else ((), "")
        self._zones: dict[str, Zone] = {zone.name: zone for zone in kept}
        self._fresh = not self._zones  # of this process: they lie where they were drawn
        self._placed: tuple[Pose, tuple[float, float], tuple[Zone, ...]] | None = None

    def now(self) -> tuple[Zone, ...]:
        """Where they lie on the map; none while nobody knows."""
        at = self._frame()
        if at is None:
            return ()
        x_m, y_m = self._around.origin_xy()
        placed = self._placed
        if placed is None or placed[:2] != (at, (x_m, y_m)):
            zones = (_moved(zone, at, (-x_m, -y_m)) for zone in self._zones.values())
            placed = self._placed = at, (x_m, y_m), tuple(zones)
        return placed[2]

    def unbound(self) -> str:
        """Why no goal can be taken; "" where one can."""
        if self._lost or self._frame() is not None:
            return self._lost
        return (
            f"{len(self._zones)} keep-out zones were drawn before the last start, and it is not "
            "known where the robot is since: say where (rfnav/places), or remove them (rfnav/zones)"
        )

    def answer(self, body: Mapping[str, Any]) -> dict[str, object]:
        """{"add": NAME, "polygon": [[x, y], ...]}, {"remove": NAME}, {"clear": true} or
        {"list": true}: all zones, as they are then; or what is wrong."""
        try:
            warning = self._changed(body)
        except (ConfigError, SavedError) as error:
            return {"accepted": False, "error": f"zones request: {error}"}
        return {"accepted": True, "zones": self._told(), "bound": self._frame() is not None} | (
            {"warning": warning} if warning else {}
        )

    # -- inside ------------------------------------------------------------------------------------

    def _frame(self) -> Pose | None:
        binding = self._around.binding
        return HERE if self._fresh else binding() if binding is not None else None

    def _changed(self, body: Mapping[str, Any]) -> str:
        """Do what is asked; a warning, or ""."""
        for name in body:
            if name not in (*DOES, "polygon"):
                raise ConfigError(f"{name[:NAME_CHARS]!r}: {unknown(name, (*DOES, 'polygon'))}")
        if sum(name in body for name in DOES) != 1:
            raise ConfigError(f"must have one of {', '.join(DOES)}")
        if "add" in body:
            return self._add(_named(body["add"]), body.get("polygon"))
        if "polygon" in body:
            raise ConfigError("polygon: only of a zone to add")
        if "remove" in body:
            self._remove(_named(body["remove"]))
        elif "clear" in body:
            self._put({})
        return ""

    def _add(self, name: str, polygon: object) -> str:
        at = self._frame()
        if at is None or self._lost:
            raise ConfigError(self.unbound())
        if name not in self._zones and len(self._zones) >= MOST_ZONES:
            raise ConfigError(f"{MOST_ZONES} zones are there, and no more can be: remove one")
        zone = read_zone(name, polygon)
        self._put({**self._zones, name: _moved(zone, _inverse(at))})
        here, (x_m, y_m) = self._around.pose(), self._around.origin_xy()
        if here is not None and zone.outside_m((here.x_m + x_m, here.y_m + y_m)) < 0:
            return f"the robot stands in {name}: once it drives, it leaves it first"
        return ""

    def _remove(self, name: str) -> None:
        if name not in self._zones:
            raise ConfigError(f"remove: {name!r}: {unknown(name, tuple(self._zones))}")
        self._put({n: zone for n, zone in self._zones.items() if n != name})

    def _put(self, zones: dict[str, Zone]) -> None:
        """SavedError, and nothing has changed, where they cannot be kept."""
        if self._path is not None:
            told = [{"name": z.name, "polygon": z.corners_xy} for z in zones.values()]
            save(self._path, json.dumps({"zones": told}, indent=1).encode())
        self._zones, self._placed, self._lost = zones, None, ""
        self._fresh = self._fresh or not zones

    def _told(self) -> list[dict[str, object]]:
        """In odometry's frame; where they are not bound, in the one that they were drawn in."""
        at = self._frame() or HERE
        moved = (_moved(zone, at) for zone in self._zones.values())
        return [
            {"name": z.name, "polygon": [[round(v, 4) for v in xy] for xy in z.corners_xy]}
            for z in moved
        ]


def read_zone(name: str, polygon: object, area: bool = False) -> Zone:
    """A polygon as people tell it, [[x, y], ...] in m, closed or not; ConfigError says what is
    wrong with it."""
    if not isinstance(polygon, list) or not all(map(_is_place, polygon)):
        raise ConfigError("polygon: must be a list of corners, [x, y] in m each")
    corners = tuple((float(x), float(y)) for x, y in polygon)
    if len(corners) > 1 and corners[0] == corners[-1]:
        corners = corners[:-1]
    if wrong := wrong_corners(corners):
        raise ConfigError(f"polygon: {wrong}")
    return Zone(name, corners, area)


def _is_place(told: object) -> bool:
    return (
        isinstance(told, list)
        and len(told) == 2
        and all(isinstance(v, int | float) and not isinstance(v, bool) for v in told)
        and all(abs(v) < 1e9 for v in told)
    )


def _kept(path: Path) -> tuple[tuple[Zone, ...], str]:
    """The zones of a file, and what is to be said where they are lost. A robot that was told to
    keep out of somewhere does not drive there because a file broke."""
    why = f"{path}: is gone, and one that could not be read is beside it"
    try:
        kept = saved(path, _read, MOST_BYTES)
        if kept is not None or not any(path.parent.glob(f"{path.name}.aside-*")):
            return kept or (), ""
    except SavedError as error:
        why = str(error)
    return (), f'{why}: draw the keep-out zones again, after {{"clear": true}} to rfnav/zones'


def _named(name: object) -> str:
    if isinstance(name, str) and name.isprintable() and 0 < len(name) <= NAME_CHARS:
        return name
    raise ConfigError(f"add, remove: must be a name of at most {NAME_CHARS} letters")


def _read(raw: bytes) -> tuple[Zone, ...]:
    """What `_put` wrote. ValueError for anything else."""
    told = json.loads(raw)
    if not isinstance(told, dict) or not isinstance(told.get("zones"), list):
        raise ValueError("is no file of zones")
    found: dict[str, Zone] = {}
    for one in told["zones"]:
        if not isinstance(one, dict):
            raise ValueError("is no file of zones")
        try:
            name = _named(one.get("name"))
            found[name] = read_zone(name, one.get("polygon"))
        except ConfigError as error:
            raise ValueError(f"zone {len(found) + 1}: {error}") from error
    if len(found) > MOST_ZONES:
        raise ValueError(f"has {len(found)} zones, must have at most {MOST_ZONES}")
    return tuple(found.values())


def _moved(zone: Zone, at: Pose, by_xy: tuple[float, float] = (0.0, 0.0)) -> Zone:
    """From a frame into the one that it lies in, at a pose, and then aside."""
    if at == HERE and by_xy == (0.0, 0.0):
        return zone
    c, s = math.cos(at.yaw_rad), math.sin(at.yaw_rad)
    corners = tuple(
        (at.x_m + c * x - s * y + by_xy[0], at.y_m + s * x + c * y + by_xy[1])
        for x, y in zone.corners_xy
    )
    return Zone(zone.name, corners, zone.area)


def _inverse(at: Pose) -> Pose:
    c, s = math.cos(at.yaw_rad), math.sin(at.yaw_rad)
    return Pose(-c * at.x_m - s * at.y_m, s * at.x_m - c * at.y_m, -at.yaw_rad)
