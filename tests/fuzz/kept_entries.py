"""What outlives the process, as it is found again."""

from answers import filed, refused, refused_in_a_line, scratch
from lived_in import lived_in
from manual_clock import ManualClock

from runtime.core.keepsake import keepsake_of
from runtime.core.types import Pose
from runtime.errors import SavedError
from runtime.loops.places_desk import PlacesDesk
from runtime.loops.remembering import HomeMemory
from runtime.robot.requests import Request
from runtime.robot.wire import Stamped
from runtime.service.memory_file import FILE_BYTES, packed, unpacked
from runtime.service.places import NamedPlaces
from runtime.service.saved import saved

A_MEMORY = packed(keepsake_of(lived_in(), Pose(1.0, 2.0, 0.5), "eyes"))
SOME_PLACES = b'{"version": 1, "places": {"kitchen table": [1.0, -2.0, 0.5], "dock": [0, 0, 0]}}'
PLACE_QUERIES = [
    {"list": True},
    {"name": "desk", "at": [1.0, 2.0, 0.5]},
    {"name": "here"},
    {"i_am_at": "here"},
    {"remove": "desk"},
    {"forget": True},
]


def memory(data: bytes) -> None:
    with refused_in_a_line(SavedError):
        saved(filed(data, "memory.zip"), unpacked, FILE_BYTES)


def places(data: bytes) -> None:
    path = filed(data, "places.json")
    with refused_in_a_line(SavedError):
        NamedPlaces(path.parent)


def asked_of_places(request: Request) -> dict[str, object]:
    """The answer, which is JSON whatever is asked."""
    for name in ("here", "desk"):
        MEMORY.places.put(name, Pose(0.0, 1.0, 2.0))
    answer = PlacesDesk(MEMORY).answer(request)
    if not answer["accepted"]:
        refused(str(answer["error"]))
    return answer


MEMORY = HomeMemory(
    scratch(), False, "", ManualClock(), lambda: (Stamped(0, Pose(1.0, 0.0, 0.0)), 0.0)
)
