"""Named places: where the robot was, or somebody said, in a frame that outlives restarts."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from runtime.core.types import Pose
from runtime.errors import SavedError, SensorError
from runtime.robot.json_text import MESSAGE_BYTES, parse_json
from runtime.service.saved import save, saved

PLACES_FILE: Final = "places.json"
PLACES_KEPT: Final = 200
LETTERS: Final = 60  # of a name
FAR_M: Final = 1e4
VERSION: Final = 1


class NamedPlaces:
    """Kept in a file of a folder, each change at once. Names are compared without regard to case
    and blanks. SavedError when the file cannot be had, or written."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / PLACES_FILE
        self._places = saved(self.path, _read, MESSAGE_BYTES) or {}

    def __len__(self) -> int:
        return len(self._places)

    def of(self, name: str) -> Pose | None:
        """In the frame that they are saved in; None for one that nobody has named."""
        found = self._places.get(_key(name))
        return found[1] if found else None

    def listed(self) -> dict[str, Pose]:
        """By name, as it was given."""
        return dict(sorted(self._places.values()))

    def put(self, name: str, at: Pose) -> None:
        self._keep(self._places | {_key(name): (name, at)})

    def remove(self, name: str) -> bool:
        """Whether there was one."""
        left = {key: value for key, value in self._places.items() if key != _key(name)}
        if len(left) == len(self._places):
            return False
        self._keep(left)
        return True

    def _keep(self, places: dict[str, tuple[str, Pose]]) -> None:
        if len(places) > PLACES_KEPT:
            raise SavedError(f"{PLACES_KEPT} places are named: remove one first")
        told = {name: [at.x_m, at.y_m, at.yaw_rad] for name, at in places.values()}
        save(self.path, json.dumps({"version": VERSION, "places": told}, indent=1).encode())
        self._places = places


def place_name(value: object) -> str:
    """ValueError, in words, for what is no name of a place."""
    if not isinstance(value, str) or not value.strip() or not value.isprintable():
        raise ValueError("the name of a place must be printable text")
    if len(value) > LETTERS:
        raise ValueError(f"the name of a place has at most {LETTERS} letters")
    return " ".join(value.split())


def place_pose(value: object) -> Pose:
    """[x_m, y_m, yaw_rad]; ValueError, in words, for anything else."""
    if not isinstance(value, list) or len(value) != 3:
        raise ValueError("a place is [x_m, y_m, yaw_rad]")
    for number in value:
        if isinstance(number, bool) or not isinstance(number, int | float):
            raise ValueError("a place is [x_m, y_m, yaw_rad]")
        if not abs(number) <= FAR_M:
            raise ValueError(f"a place is no farther off than {FAR_M:g} m")
    if abs(value[2]) > 7.0:
        raise ValueError("a place's yaw is in radians, -7 to 7")
    return Pose(*(float(number) for number in value))


def _key(name: str) -> str:
    return " ".join(name.split()).casefold()


def _read(raw: bytes) -> dict[str, tuple[str, Pose]]:
    try:
        told: Mapping[str, Any] = parse_json(raw, PLACES_FILE)
    except SensorError as error:
        raise ValueError(str(error)) from error
    places = told.get("places")
    if told.get("version") != VERSION or not isinstance(places, dict):
        raise ValueError(f"no places of version {VERSION}")
    if len(places) > PLACES_KEPT:
        raise ValueError(f"more than {PLACES_KEPT} places")
    return {_key(place_name(name)): (name, place_pose(at)) for name, at in places.items()}
