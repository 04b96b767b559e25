"""Where a goal binds the robot to: an area to search in, a type of room, a place to go to."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from runtime.core.destination import Destination
from runtime.core.mapping.zones import FAR_M, Zone, wrong_corners
from runtime.core.types import Pose
from runtime.errors import ConfigError
from runtime.toml_values import unknown

AREA: Final = "the area of the search"
ABOUT_M: Final = 3.0  # round a place that is an area
SIDES: Final = 16  # of the polygon that such an area is
CHARS: Final = 60  # of a name
FULL_TURN_RAD: Final = 7.0  # a yaw beyond was not meant in radians
BINDS: Final = ("area", "go_to")

PlaceOf = Callable[[str], Pose | None]
"""Where a place of that name is in the map of now; None for none."""


@dataclass(frozen=True)
class GoalBounds:
    """In the map frame. Of an `area` the robot is kept within; `room`: the type that is searched,
    "" for all; `to`: where it goes to, and looks for nothing; `then_to`: where it goes
    afterwards."""

    area: Zone | None = None
    room: str = ""
    to: Destination | None = None
    then_to: Destination | None = None


ANYWHERE: Final = GoalBounds()


def read_bounds(
    body: Mapping[str, Any], rooms: Sequence[str], origin_xy: tuple[float, float], place: PlaceOf
) -> GoalBounds:
    """What a goal request has of `BINDS`, and a place in its `afterwards`, told in the frame of
    odometry, in which the map begins at `origin_xy`; ConfigError says what is wrong with it."""
    area, room = None, ""
    if "area" in body:
        area, room = _area(body["area"], rooms, origin_xy, place)
    to = _place(body["go_to"], "go_to", origin_xy, place) if "go_to" in body else None
    then = body.get("afterwards")
    then_to = None
    if isinstance(then, Mapping):
        then_to = _place(then["place"], "afterwards", origin_xy, place)
    return GoalBounds(area, room, to, then_to)


def read_zone(
    name: str, polygon: object, origin_xy: tuple[float, float] = (0.0, 0.0), area: bool = False
) -> Zone:
    """A polygon as people tell it, [[x, y], ...] in m, closed or not; ConfigError."""
    if not isinstance(polygon, list) or not all(map(_is_place, polygon)):
        raise ConfigError("polygon: must be a list of corners, [x, y] in m each")
    corners = tuple((float(x) - origin_xy[0], float(y) - origin_xy[1]) for x, y in polygon)
    if len(corners) > 1 and corners[0] == corners[-1]:
        corners = corners[:-1]
    if wrong := wrong_corners(corners):
        raise ConfigError(f"polygon: {wrong}")
    return Zone(name, corners, area)


def named(told: object, what: str) -> str:
    """A name as people give it; ConfigError."""
    if isinstance(told, str) and told.isprintable() and 0 < len(told) <= CHARS:
        return told
    raise ConfigError(f"{what}: must be a name of at most {CHARS} letters")


def place_words(told: object) -> str:
    """What a place to go to is called, before anybody knows where it is."""
    return f"go to {told}"[:CHARS] if isinstance(told, str) else "go to a place"


def tells_where(body: Mapping[str, Any]) -> bool:
    """Whether a goal request is bound by metres, which mean nothing in an odometry that began
    since."""
    area = body.get("area")
    return isinstance(body.get("go_to"), dict) or (isinstance(area, dict) and "polygon" in area)


def names_place(binds: Mapping[str, Any]) -> bool:
    """Whether it is a saved place that says where to."""
    area, named = binds.get("area"), isinstance(binds.get("go_to"), str)
    return named or "afterwards" in binds or (isinstance(area, dict) and "place" in area)


def _area(
    told: object, rooms: Sequence[str], origin_xy: tuple[float, float], place: PlaceOf
) -> tuple[Zone | None, str]:
    if not isinstance(told, dict) or len(told) != 1:
        raise ConfigError("goal request: area: must have one of polygon, room, place")
    ((kind, value),) = told.items()
    try:
        if kind == "polygon":
            return read_zone(AREA, value, origin_xy, area=True), ""
        if kind == "room":
            return None, _room(value, rooms)
        if kind == "place":
            return _round(_at(named(value, "place"), place)), ""
        raise ConfigError(unknown(str(kind)[:CHARS], ("polygon", "room", "place")))
    except ConfigError as error:
        raise type(error)(f"goal request: area: {error}") from error


def _round(at: Pose) -> Zone:
    """The area about a place."""
    turns = (math.tau * n / SIDES for n in range(SIDES))
    x, y, r = at.x_m, at.y_m, ABOUT_M
    return Zone(AREA, tuple((x + r * math.cos(a), y + r * math.sin(a)) for a in turns), area=True)


def _room(told: object, rooms: Sequence[str]) -> str:
    name = named(told, "room").casefold()
    if name in rooms:
        return name
    if not rooms:
        raise ConfigError("room: the detector tells no types of rooms: give a polygon")
    raise ConfigError(f"room: {name!r}: {unknown(name, rooms)}; there are {', '.join(rooms)}")


def _place(told: object, what: str, origin_xy: tuple[float, float], place: PlaceOf) -> Destination:
    try:
        if isinstance(told, str):
            at = _at(named(told, "place"), place)
            return Destination(told, (at.x_m, at.y_m), at.yaw_rad)
        if not isinstance(told, dict):
            raise ConfigError('must be the name of a place, or {"x_m", "y_m", "yaw_rad"}')
        for name in told:
            if name not in ("x_m", "y_m", "yaw_rad"):
                raise ConfigError(unknown(str(name)[:CHARS], ("x_m", "y_m", "yaw_rad")))
        x_m = _number(told, "x_m", FAR_M, origin_xy[0])
        y_m = _number(told, "y_m", FAR_M, origin_xy[1])
        yaw_rad = _number(told, "yaw_rad", FULL_TURN_RAD) if "yaw_rad" in told else None
    except ConfigError as error:
        raise type(error)(f"goal request: {what}: {error}") from error
    return Destination(f"({told['x_m']:.1f}, {told['y_m']:.1f})", (x_m, y_m), yaw_rad)


def _at(name: str, place: PlaceOf) -> Pose:
    at = place(name)
    if at is None:
        raise ConfigError(f"place {name!r} is not known: name it first (rfnav/places)")
    return at


def _number(told: Mapping[str, Any], name: str, most: float, less: float = 0.0) -> float:
    value = told.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigError(f"{name}: must be a number")
    if not abs(value) < 1e9 or not abs(value - less) <= most:
        raise ConfigError(f"{name}: is {str(value)[:20]}, must be {-most:g} to {most:g} of the map")
    return float(value) - less


def _is_place(told: object) -> bool:
    return (
        isinstance(told, list)
        and len(told) == 2
        and all(isinstance(v, int | float) and not isinstance(v, bool) for v in told)
        and all(abs(v) < 1e9 for v in told)
    )
