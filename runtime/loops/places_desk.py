"""`rfnav/places`: naming places, and telling a robot that has begun anew where it is."""

from collections.abc import Callable, Mapping
from typing import Any, Final

from runtime.core.geometry import placed, seen_from
from runtime.core.types import Pose
from runtime.errors import SavedError
from runtime.loops.remembering import HomeMemory
from runtime.robot.requests import Request
from runtime.service.places import place_name, place_pose

WAYS: Final = (
    '{"list": true}, {"name": NAME}, {"name": NAME, "at": [x_m, y_m, yaw_rad]}, {"remove": NAME}, '
    '{"i_am_at": NAME} or {"forget": true}'
)
NOT_KNOWN: Final = (
    'it is not known where the robot is ({}): say {{"i_am_at": NAME}} where it stands at a place, '
    "or begin a search and let it look around"
)


class PlacesDesk:
    """Answers requests about places. Poses are told, and taken, in odometry's frame, in which the
    map begins at `origin_xy`."""

    def __init__(
        self, memory: HomeMemory, origin_xy: Callable[[], tuple[float, float]] = lambda: (0.0, 0.0)
    ) -> None:
        self._memory, self._origin_xy = memory, origin_xy

    def answer(self, request: Request) -> dict[str, object]:
        try:
            self._do(request.body)
        except (ValueError, SavedError) as error:
            return {"accepted": False, "error": f"rfnav/places: {error}"}
        return {"accepted": True} | self._told()

    def _do(self, body: Mapping[str, Any]) -> None:
        memory = self._memory
        match sorted(body):
            case ["list"]:
                return
            case ["name"] | ["at", "name"]:
                name, transform = place_name(body["name"]), self._transform()
                here = self._said(body["at"]) if "at" in body else self._here()
                memory.places.put(name, seen_from(transform, here))
            case ["remove"]:
                if not memory.places.remove(place_name(body["remove"])):
                    raise ValueError(f"no place is called {body['remove']!r}")
            case ["i_am_at"]:
                name = place_name(body["i_am_at"])
                place = memory.places.of(name)
                if place is None:
                    raise ValueError(f"no place is called {name!r}")
                memory.said_at(name, place, self._here())
            case ["forget"] if body["forget"] is True:
                memory.forget()
            case _:
                raise ValueError(f"ask {WAYS}")

    def _told(self) -> dict[str, object]:
        transform, places = self._memory.binding.transform(), self._memory.places.listed()
        return {
            "memory": self._memory.binding.in_words(),
            "places": {
                name: self._listed(placed(transform, at)) if transform else None
                for name, at in places.items()
            },
        }

    def _transform(self) -> Pose:
        bound = self._memory.binding.bound()
        if bound is None or not bound.sure:
            raise ValueError(NOT_KNOWN.format(self._memory.binding.in_words()))
        return bound.transform

    def _here(self) -> Pose:
        here = self._memory.here()
        if here is None:
            raise ValueError("there is no odometry: where the robot is, nobody knows")
        return here

    def _said(self, value: object) -> Pose:
        at, (x_m, y_m) = place_pose(value), self._origin_xy()
        return Pose(at.x_m - x_m, at.y_m - y_m, at.yaw_rad)

    def _listed(self, pose: Pose) -> list[float]:
        x_m, y_m = self._origin_xy()
        return [round(v, 4) for v in (pose.x_m + x_m, pose.y_m + y_m, pose.yaw_rad)]
