"""Keep-out zones: drawn by people over the bus, kept in a file, and put on the map of each search.

They are told in the frame of odometry, as `rfnav/map` is, and kept in the frame of what is saved.
After a restart odometry begins elsewhere: until somebody knows where, they lie nowhere, and no goal
is taken, for the robot would drive where it must not.
"""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Protocol

from runtime.core.mapping.zones import Zone
from runtime.core.types import Pose
from runtime.errors import ConfigError, SavedError
from runtime.private_files import state_directory
from runtime.robot.wire import Stamped
from runtime.service.bounds import CHARS, GoalBounds, PlaceOf, named, read_bounds, read_zone
from runtime.service.saved import save, saved
from runtime.toml_values import unknown

FILE: Final = "zones.json"
MOST_ZONES: Final = 64
MOST_BYTES: Final = 1 << 20
DOES: Final = ("add", "remove", "clear", "list")
SAY_WHERE: Final = "(rfnav/status): say where it is (rfnav/places)"
NOT_SEEN: Final = "where the robot was said to be is not seen to be so yet"
HERE: Final = Pose(0.0, 0.0, 0.0)

Binding = Callable[[], Pose | None]
"""The saved frame's pose in the map of now; None: nobody knows."""


@dataclass(frozen=True)
class Surroundings:
    """What zones need of the robot: where it is in the map, and where in odometry's frame that
    begins. `binding`: None for no memory of where it is: what another process kept stays unbound.
    `place`: by name, where it is in the map; `sure`: whether what `binding` tells is seen to be so.
    """

    pose: Callable[[], Pose | None]
    origin_xy: Callable[[], tuple[float, float]]
    binding: Binding | None = None
    place: PlaceOf = lambda name: None
    sure: Callable[[], bool] = lambda: True


class ZonedBus(Protocol):
    """The bus, as far as zones need it; see `Bus`."""

    def pose(self) -> tuple[Stamped[Pose], float] | None: ...

    def origin_xy(self) -> tuple[float, float]: ...


def zones_beside(bus: ZonedBus, kept: bool) -> "Zones":
    """The zones of the robot on a bus, in the file that they are `kept` in."""

    def pose() -> Pose | None:
        found = bus.pose()
        return found[0].value if found is not None else None

    path = state_directory() / FILE if kept else None
    return Zones(path, Surroundings(pose, bus.origin_xy))


class Zones:
    """The zones of a robot; one thread's. `path`: None for none that are kept."""

    def __init__(self, path: Path | None, around: Surroundings) -> None:
        self._path, self._around = path, around
        kept, self._lost = _kept(path) if path is not None else ((), "")
        self._zones: dict[str, Zone] = {zone.name: zone for zone in kept}
        self._fresh = not self._zones  # of this process: they lie where they were drawn
        self._placed: tuple[Pose, tuple[Zone, ...]] | None = None

    def __len__(self) -> int:
        return len(self._zones)

    def bind(self, binding: Binding, place: PlaceOf, sure: Callable[[], bool]) -> None:
        """A memory of where it is, and of places, is there: see `Surroundings`."""
        self._around = replace(self._around, binding=binding, place=place, sure=sure)

    def now(self) -> tuple[Zone, ...]:
        """Where they lie on the map; none while nobody knows."""
        at = self._frame()
        if at is None:
            return ()
        if self._placed is None or self._placed[0] != at:
            self._placed = at, tuple(_moved(zone, at) for zone in self._zones.values())
        return self._placed[1]

    def unbound(self) -> str:
        """Why no goal can be taken; "" where one can."""
        if self._lost or not self._zones or self._frame() is not None:
            return self._lost
        return (
            f"keep-out zones ({len(self._zones)}) were drawn before the last start, and it is not "
            f"known where the robot is {SAY_WHERE}, or remove them (rfnav/zones)"
        )

    def bounds(self, body: Mapping[str, Any], rooms: Sequence[str]) -> GoalBounds:
        """Where a goal binds the robot to; ConfigError."""
        return read_bounds(body, rooms, self._around.origin_xy(), self._around.place)

    def moved(
        self, before: GoalBounds, body: Mapping[str, Any], rooms: Sequence[str]
    ) -> GoalBounds:
        """The same again, where the saved map may lie elsewhere than `before`; ConfigError."""
        return self.bounds(body, rooms)

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
        if self._around.binding is not None:
            return self._around.binding()
        return HERE if self._fresh else None

    def _changed(self, body: Mapping[str, Any]) -> str:
        """Do what is asked; a warning, or ""."""
        for name in body:
            if name not in (*DOES, "polygon"):
                raise ConfigError(f"{name[:CHARS]!r}: {unknown(name, (*DOES, 'polygon'))}")
        if sum(name in body for name in DOES) != 1:
            raise ConfigError(f"must have one of {', '.join(DOES)}")
        if "add" in body:
            return self._add(named(body["add"], "add"), body.get("polygon"))
        if "polygon" in body:
            raise ConfigError("polygon: only of a zone to add")
        if "remove" in body:
            self._remove(named(body["remove"], "remove"))
        elif "clear" in body:
            self._put({})
        return ""

    def _add(self, name: str, polygon: object) -> str:
        at = self._frame()
        if self._lost or at is None:
            lost = f"it is not known where the robot is {SAY_WHERE}"
            raise ConfigError(self.unbound() or f"{lost}, or begin a search: it looks round")
        if not self._around.sure():  # or it would move when that is set right
            raise ConfigError(f"{NOT_SEEN}: have it look round in a search, and draw it then")
        if name not in self._zones and len(self._zones) >= MOST_ZONES:
            raise ConfigError(f"{MOST_ZONES} zones are there, and no more can be: remove one")
        zone, here = read_zone(name, polygon, self._around.origin_xy()), self._around.pose()
        self._put({**self._zones, name: _moved(zone, _inverse(at))})
        if here is not None and zone.outside_m((here.x_m, here.y_m)) < 0:
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
        at, (x_m, y_m) = self._frame() or HERE, self._around.origin_xy()
        told: list[dict[str, object]] = []
        for zone in self._zones.values():
            corners = _moved(zone, at).corners_xy
            places = [[round(x + x_m, 4), round(y + y_m, 4)] for x, y in corners]
            told.append({"name": zone.name, "polygon": places})
        return told


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
            name = named(one.get("name"), "name")
            found[name] = read_zone(name, one.get("polygon"))
        except ConfigError as error:
            raise ValueError(f"zone {len(found) + 1}: {error}") from error
    if len(found) > MOST_ZONES:
        raise ValueError(f"has {len(found)} zones, must have at most {MOST_ZONES}")
    return tuple(found.values())


def _moved(zone: Zone, at: Pose) -> Zone:
    """From a frame into the one that it lies in, at a pose."""
    if at == HERE:
        return zone
    c, s = math.cos(at.yaw_rad), math.sin(at.yaw_rad)
    corners = tuple((at.x_m + c * x - s * y, at.y_m + s * x + c * y) for x, y in zone.corners_xy)
    return Zone(zone.name, corners, zone.area)


def _inverse(at: Pose) -> Pose:
    c, s = math.cos(at.yaw_rad), math.sin(at.yaw_rad)
    return Pose(-c * at.x_m - s * at.y_m, s * at.x_m - c * at.y_m, -at.yaw_rad)
