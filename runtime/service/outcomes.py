"""How goals end, and why they are refused: closed lists, each entry with a number of a range that
is ours, 4700 to 4799, and a sentence."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Final

from runtime.core.types import SearchState
from runtime.errors import NotLocalisedError, RfNavError


class FailCause(StrEnum):
    """What a goal failed of."""

    BATTERY = "battery"
    DISTANCE = "distance"
    FAULT = "fault"
    RESTART = "restart"
    NOT_LOCALISED = "not_localised"


class Refusal(StrEnum):
    """Why a goal is not taken at all."""

    REQUEST = "request"
    BUSY = "busy"
    FULL = "full"
    BATTERY = "battery"
    NOT_LOCALISED = "not_localised"


@dataclass(frozen=True)
class Listed:
    """An entry of the lists: its number, and what it means."""

    code: int
    meaning: str


RESULTS: Final[Mapping[SearchState | FailCause, Listed]] = {
    SearchState.FOUND: Listed(0, "the robot stands before what was asked for"),
    SearchState.ARRIVED: Listed(0, "the robot is where it was asked to go"),
    SearchState.NOT_FOUND: Listed(4701, "all that could be reached was searched"),
    SearchState.UNREACHABLE: Listed(4702, "it is believed to be seen, and no way leads there"),
    SearchState.CANCELLED: Listed(4703, "somebody cancelled it"),
    SearchState.PREEMPTED: Listed(4704, "a newer goal took its place"),
    SearchState.TIMED_OUT: Listed(4705, "its limit of time came first"),
    SearchState.AREA_LEFT: Listed(4706, "the robot left the area that it was bound to"),
    FailCause.BATTERY: Listed(4710, "the battery is too low to go on"),
    FailCause.DISTANCE: Listed(4711, "its limit of distance came first"),
    FailCause.FAULT: Listed(4712, "the runtime met an error"),
    FailCause.RESTART: Listed(4713, "the runtime ended or was started anew"),
    FailCause.NOT_LOCALISED: Listed(4714, "the robot does not know where it is on the saved map"),
}  # fmt: skip
"""How a goal that was taken ends; by its cause where it failed."""
IN_THE_END: Final = (SearchState.NOT_FOUND, SearchState.UNREACHABLE)
"""Only of these it is known where no way leads: others end while ways are still looked for."""
REFUSALS: Final[Mapping[Refusal, Listed]] = {
    Refusal.REQUEST: Listed(4720, "the request, or its words, cannot be used"),
    Refusal.BUSY: Listed(4721, "another goal is under way, and this one was not to take its place"),
    Refusal.FULL: Listed(4722, "too many goals wait already"),
    Refusal.BATTERY: Listed(4723, "the battery is too low to begin"),
    Refusal.NOT_LOCALISED: Listed(4724, "the robot does not know where it is on the saved map"),
}


def refused(refusal: Refusal, error: str) -> dict[str, object]:
    """The answer to a goal that is not taken."""
    return {"accepted": False, "code": REFUSALS[refusal].code, "error": error}


def refused_for(error: RfNavError) -> dict[str, object]:
    """The same, of what was found wrong with it."""
    lost = isinstance(error, NotLocalisedError)
    return refused(Refusal.NOT_LOCALISED if lost else Refusal.REQUEST, str(error))


def failed_for(error: RfNavError) -> FailCause:
    """What a goal that was taken fails of, where that is found when its turn comes."""
    return FailCause.NOT_LOCALISED if isinstance(error, NotLocalisedError) else FailCause.FAULT


@dataclass(frozen=True)
class GoalEnd:
    """How a goal ends. `reason`: as the loop says it; `cause`: what it failed of; `at_xy`: where
    what was found is, or cannot be reached, in the map; `returned`: whether it is back where it
    began, or at the place `returned_to`; None where it was not to go anywhere."""

    state: SearchState
    reason: str
    cause: FailCause | None = None
    at_xy: tuple[float, float] | None = None
    returned: bool | None = None
    returned_to: str = ""

    @property
    def result(self) -> SearchState:
        """Of the closed list."""
        return SearchState.FAILED if self.cause is not None else self.state

    @property
    def code(self) -> int:
        return RESULTS[self.cause or self.state].code

    def told(self, id: str, goal: str, facts: Mapping[str, Any]) -> dict[str, object]:
        """As it is told everywhere. `facts`: what else is known of the search, if there was one;
        see `GoalLife`."""
        told: dict[str, object] = {
            "id": id,
            "goal": goal,
            "result": self.result,
            "code": self.code,
            "sentence": self.sentence(goal, facts),
            "reason": self.reason,
        }
        told |= {"cause": self.cause} if self.cause is not None else {}
        told |= {"at_xy": [round(v, 2) for v in self.at_xy]} if self.at_xy is not None else {}
        told |= {"returned": self.returned} if self.returned is not None else {}
        return told | dict(facts)

    def sentence(self, goal: str, facts: Mapping[str, Any]) -> str:
        """For people."""
        parts = [self._head(goal), *self._parts(facts)]
        if self.returned is not None:
            to = self.returned_to
            there = f"the robot is at {to}" if to else "the robot is back where it began"
            lost = f"no way led to {to}" if to else "no way led back to where it began"
            parts.append(there if self.returned else lost)
        return "; ".join(parts)

    def _head(self, goal: str) -> str:
        where = "" if self.at_xy is None else " at ({:.1f}, {:.1f})".format(*self.at_xy)
        if self.cause is not None:
            return f'"{goal}" failed: {self.reason}'
        match self.state:
            case SearchState.FOUND:
                return f'"{goal}" was found{where}'
            case SearchState.ARRIVED:
                return f'"{goal}": the robot has arrived{where}'
            case SearchState.NOT_FOUND:
                return f'"{goal}" was not found'
            case SearchState.PREEMPTED:
                return f'"{goal}" gave way to another goal'
            case SearchState.TIMED_OUT:
                return f'"{goal}" ran out of time'
            case SearchState.CANCELLED:
                why = "" if self.reason == "cancelled" else f": {self.reason}"
                return f'"{goal}" was cancelled{why}'
            case _:
                return f'"{goal}": {self.state.replace("_", " ")}: {self.reason}'

    def _parts(self, facts: Mapping[str, Any]) -> list[str]:
        told = []
        in_vain = self.code != 0
        if in_vain and (searched := facts.get("searched")):
            rooms = ", ".join(f"{name} {m2:g}" for name, m2 in searched["rooms_m2"].items())
            floor = f"{searched['floor_m2']:g} m2 of floor were seen, {searched['near_m2']:g} of it"
            told.append(f"{floor} from near{f' ({rooms})' if rooms else ''}")
        searched_all = self.cause is None and self.state in IN_THE_END
        if searched_all and (shut := facts.get("unreached")):
            places = ", ".join("({:.1f}, {:.1f})".format(*place["xy"]) for place in shut)
            told.append(f"no way led to {places}")
        if self.result is SearchState.NOT_FOUND and (left := facts.get("in_doubt")):
            places = ", ".join(map(_doubt, left))
            told.append(f"by the detector's recall at its size most likely missed: {places}")
        if "elapsed_s" in facts:
            took, way = facts["elapsed_s"], facts["driven_m"]
            told.append(f"it took {_span(took)} and {way:.1f} m")
        return told


def _span(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.1f} min"


def _doubt(place: Mapping[str, Any]) -> str:
    x, y = place["xy"]
    on = f"the {place['on']}" if place["on"] else "what stands"
    seen = "" if place["seen_m"] is None else f", seen from {place['seen_m']:g} m"
    return f"{on} at ({x:.1f}, {y:.1f}){seen} (about {100 * place['chance']:.0f} %)"
