"""Decisions and stops read back from a search's journal, to be told again. What is in a file may be
anything: each line is bounded, and each value checked."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from runtime.core.belief import Belief, Expected, Kind, Said, Taken
from runtime.core.motion.stops import BaseStop
from runtime.core.types import (
    Absence,
    Ballot,
    Brief,
    Decision,
    FrontierBrief,
    Missing,
    NearbyObject,
    Vote,
)
from runtime.core.voting.in_full import ToldDecision
from runtime.errors import RecordingError, SensorError
from runtime.robot.json_text import parse_json
from runtime.service.recollection import is_stop, stop_of

LINE_BYTES: Final = 16 << 20  # a decision's has what each frontier's view looks like, in numbers
LONGEST: Final = 10_000  # of any list in a line
KINDS: Final[tuple[Kind, ...]] = ("frontier", "surface", "room")


def told_decisions(path: Path) -> Iterator[ToldDecision]:
    """Those of a journal, in order. RecordingError, one line, for a file or a line that is none."""
    goal, number = "", 0
    for place, line in _lines(path):
        if line.get("kind") == "goal":
            goal = _text(line, "text", place)
        if line.get("kind") == "decision":
            number += 1
            yield _decision(line, goal, number, place)


def told_stops(path: Path) -> Iterator[BaseStop]:
    """The same of stops; times are of the machine's clock as it was then."""
    open_stop, number = None, 0
    for place, line in _lines(path):
        if line.get("kind") != "standing":
            continue
        at_s, now = _number(line, "at_s", place), _text(line, "now", place)
        state, _, cause = now.partition(": ")
        if open_stop is not None:
            yield replace(open_stop, ended_s=at_s, then=now)
            open_stop = None
        if is_stop(state, cause):
            number += 1
            open_stop = stop_of(number, state, cause, at_s)
    if open_stop is not None:
        yield open_stop


def _lines(path: Path) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Each line and how its place is called; a torn last one is left out."""
    try:
        with path.open("rb") as file:
            number = 0
            while raw := file.readline(LINE_BYTES + 1):
                number += 1
                place = f"{path}: line {number}"
                if not raw.endswith(b"\n"):
                    if len(raw) > LINE_BYTES:
                        raise RecordingError(f"{place}: is no line of a journal: it has no end")
                    return
                try:
                    yield place, parse_json(raw, place, LINE_BYTES)
                except SensorError as error:
                    raise RecordingError(str(error)) from error
    except (OSError, ValueError) as error:  # ValueError: a name with a zero byte in it
        why = getattr(error, "strerror", None) or error
        raise RecordingError(f"{path}: cannot be read ({why})") from error


def _decision(line: Mapping[str, Any], goal: str, number: int, place: str) -> ToldDecision:
    ballot = Ballot(
        tuple(_vote(vote, place) for vote in _tables(line, "votes", place)),
        tuple(_missing(missing, place) for missing in _tables(line, "missing", place)),
        _seconds(line, place),
    )
    decision = Decision(
        _whole_or_none(line, "frontier", place),
        _text(line, "rule", place),
        _ids(line, "chosen", place),
        _whole_or_none(line, "closest", place),
        ballot,
        0,
        _text(line, "why", place),
        _without(line, place),
        _ids(line, "order", place) if "order" in line else (),
        _belief(line, place),
        taken=_taken(line, place),
    )
    brief = line.get("brief")
    if not isinstance(brief, dict):
        raise _wrong(place, "brief")
    frontiers = tuple(_frontier(one, place) for one in _tables(brief, "frontiers", place))
    at = {}
    for one in _tables(line, "frontiers", place):
        (x_m, y_m), *_ = _pairs({"at": [one.get("goal_xy")]}, "at", place)
        at[_whole(one, "id", place)] = float(x_m), y_m
    heads_for = _whole_or_none(line, "heads_for", place)
    return ToldDecision(number, goal, decision, Brief(goal, 0, frontiers), at, heads_for)


def _taken(line: Mapping[str, Any], place: str) -> Taken | None:
    """None where it was not told, as in journals of before."""
    told = line.get("taken")
    if told is None:
        return None
    if not isinstance(told, dict):
        raise _wrong(place, "taken")
    return Taken(
        _number(told, "way_m", place),
        None if told.get("unknown_m2") is None else _number(told, "unknown_m2", place),
        tuple(
            Said(_text(one, "expert", place), _number(one, "nats", place), bool(one.get("earlier")))
            for one in _tables(told, "said", place)
        ),
        None if told.get("share") is None else _number(told, "share", place),
        _whole(told, "place", place),
        _whole(told, "planned", place),
    )


def _belief(line: Mapping[str, Any], place: str) -> Belief | None:
    """None where none was worked out, as in journals of before."""
    told = line.get("belief")
    if told is None:
        return None
    if not isinstance(told, dict):
        raise _wrong(place, "belief")
    return Belief(
        tuple(_expected(one, place) for one in _tables(told, "places", place)),
        _number(told, "others", place),
    )


def _expected(one: Mapping[str, Any], place: str) -> Expected:
    kind = next((kind for kind in KINDS if kind == one.get("kind")), None)
    id = one.get("id")
    if kind is None or isinstance(id, bool) or not isinstance(id, int | str):
        raise _wrong(place, "belief")
    ((x_m, y_m),) = _pairs({"xy": [one.get("xy")]}, "xy", place)
    return Expected(kind, id, (x_m, y_m), _number(one, "p", place), _text(one, "why", place))


def _vote(vote: Mapping[str, Any], place: str) -> Vote:
    reasons = []
    for pair in _list(vote, "reasons", place):
        if not (isinstance(pair, list) and len(pair) == 2 and isinstance(pair[1], str)):
            raise _wrong(place, "reasons")
        reasons.append((_whole({"id": pair[0]}, "id", place), pair[1]))
    probabilities = tuple((int(i), p) for i, p in _pairs(vote, "probabilities", place))
    return Vote(
        _text(vote, "expert", place),
        _ids(vote, "frontiers", place),
        probabilities,
        _text(vote, "reason", place),
        _text(vote, "rung", place),
        _ids(vote, "against", place),
        tuple(reasons),
    )


def _missing(missing: Mapping[str, Any], place: str) -> Missing:
    """The cause is told in words alone, which a missing model's are, too."""
    cause = _text(missing, "cause", place)
    return Missing(_text(missing, "expert", place), Absence.NO_MODEL, cause)


def _frontier(one: Mapping[str, Any], place: str) -> FrontierBrief:
    objects = tuple(
        NearbyObject(
            _text(thing, "name", place),
            _number(thing, "confidence", place),
            _number(thing, "distance_m", place),
        )
        for thing in _tables(one, "objects", place)
    )
    rooms = []
    for room in _list(one, "rooms", place):
        if not (isinstance(room, list) and len(room) == 2 and isinstance(room[0], str)):
            raise _wrong(place, "rooms")
        rooms.append((room[0], _number({"p": room[1]}, "p", place)))
    return FrontierBrief(
        _whole(one, "id", place),
        _number(one, "distance_m", place),
        objects,
        tuple(rooms),
        doorway=one.get("doorway") is True,
        unknown_m2=_number(one, "unknown_m2", place),
    )


def _seconds(line: Mapping[str, Any], place: str) -> dict[str, float]:
    told = line.get("latency_s")
    if not isinstance(told, dict):
        raise _wrong(place, "latency_s")
    return {name: _number(told, name, place) for name in told}


def _without(line: Mapping[str, Any], place: str) -> tuple[tuple[str, int | None], ...]:
    told = line.get("without")
    if not isinstance(told, dict):
        raise _wrong(place, "without")
    return tuple((name, _whole_or_none(told, name, place)) for name in told)


# -- values ----------------------------------------------------------------------------------------


def _wrong(place: str, name: str) -> RecordingError:
    return RecordingError(f"{place}: {name}: is not as rfnav writes it: is this a journal?")


def _text(table: Mapping[str, Any], name: str, place: str) -> str:
    value = table.get(name)
    if not isinstance(value, str):
        raise _wrong(place, name)
    return value


def _number(table: Mapping[str, Any], name: str, place: str) -> float:
    value = table.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise _wrong(place, name)
    return float(value)


def _whole(table: Mapping[str, Any], name: str, place: str) -> int:
    value = table.get(name)
    if isinstance(value, bool) or not isinstance(value, int):
        raise _wrong(place, name)
    return value


def _whole_or_none(table: Mapping[str, Any], name: str, place: str) -> int | None:
    return None if table.get(name) is None else _whole(table, name, place)


def _list(table: Mapping[str, Any], name: str, place: str) -> list[Any]:
    value = table.get(name)
    if not isinstance(value, list) or len(value) > LONGEST:
        raise _wrong(place, name)
    return value


def _tables(table: Mapping[str, Any], name: str, place: str) -> list[Mapping[str, Any]]:
    value = _list(table, name, place)
    if not all(isinstance(item, dict) for item in value):
        raise _wrong(place, name)
    return value


def _ids(table: Mapping[str, Any], name: str, place: str) -> tuple[int, ...]:
    return tuple(_whole({name: item}, name, place) for item in _list(table, name, place))


def _pairs(table: Mapping[str, Any], name: str, place: str) -> list[tuple[float, float]]:
    """Lists of two numbers."""
    value = _list(table, name, place)
    if not all(isinstance(pair, list) and len(pair) == 2 for pair in value):
        raise _wrong(place, name)
    numbers = [[_number({name: n}, name, place) for n in pair] for pair in value]
    return [(first, second) for first, second in numbers]
