"""A recording as a page goes through it: read once, for what happened when and where in the file
each second is; then from any moment on."""

import json
import math
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from runtime.core.types import Ballot, Brief, Decision
from runtime.core.voting.in_full import ToldDecision, in_full
from runtime.errors import RecordingError
from runtime.recording.exact import read
from runtime.recording.messages import LOOP
from runtime.recording.reader import ChunkPlace, Recorded, Recording
from runtime.robot import wire
from runtime.view import told
from runtime.view.hearing import FAULTS

LEAD_NS: Final = 3_000_000_000  # before a moment, that is read for how it was then
RARE: Final = ("map", "scene", "path", "order", "decision")
"""Of these the last one before a moment counts, however long before that was."""
STEP_M: Final = 0.1  # between two places of the way that are kept
PLACES_MOST: Final = 20_000


@dataclass
class DriveMoments:
    """What happened when; times are of recording, ns, ascending."""

    chunks_ns: list[int] = field(default_factory=list)
    chunks: list[ChunkPlace] = field(default_factory=list)
    rare: dict[str, list[tuple[int, ChunkPlace]]] = field(default_factory=dict)
    goals: list[tuple[int, str]] = field(default_factory=list)
    decisions: list[tuple[int, dict[str, Any]]] = field(default_factory=list)
    stops: list[tuple[int, dict[str, Any]]] = field(default_factory=list)
    way: list[tuple[int, float, float, float]] = field(default_factory=list)
    """Time, x, y, and how far the robot had come by then, m."""
    color: str = ""
    first_ns: int = 0
    last_ns: int = 0


class DriveFilm:
    """RecordingError, one line, for what is none. One thread's."""

    def __init__(self, path: Path) -> None:
        self.recording = Recording(path)
        self.moments = DriveMoments()
        self._ballot: dict[str, Any] = {}
        self._questions: dict[int, dict[str, Any]] = {}  # by stamp
        for place, message in self.recording.placed():
            self._note(place, message)
        if not self.moments.chunks:
            raise RecordingError(f"{path}: nothing was recorded")

    @property
    def cut(self) -> bool:
        return self.recording.cut

    def since(self, at_ns: int) -> Iterator[Recorded]:
        """Every message from shortly before a moment on."""
        moments = self.moments
        first = max(0, bisect_right(moments.chunks_ns, at_ns - LEAD_NS) - 1)
        return (m for _, m in self.recording.placed(moments.chunks[first]))

    def before(self, at_ns: int) -> Iterator[Recorded]:
        """The last message of each of RARE that came by then, in the order of recording."""
        wanted: dict[ChunkPlace, dict[int, str]] = {}
        for kind, came in self.moments.rare.items():
            n = bisect_right(came, at_ns, key=lambda one: one[0])
            if n:
                when_ns, place = came[n - 1]
                wanted.setdefault(place, {})[when_ns] = kind
        for place in sorted(wanted):
            for at, message in self.recording.placed(place):
                if at != place:
                    break
                if _kind(message) == wanted[place].get(message.log_time_ns):
                    yield message

    def way_until(self, at_ns: int) -> tuple[list[list[float]], float]:
        """Where the robot had been by then since the search began, and how far it had come, m."""
        way = self.moments.way
        began_ns = self.goal_at(at_ns)[0]
        last = bisect_right(way, at_ns, key=lambda one: one[0])
        first = bisect_right(way, began_ns, key=lambda one: one[0])
        part = way[first:last]
        driven_m = part[-1][3] - part[0][3] if part else 0.0
        return [[x, y] for _, x, y, _ in part], driven_m

    def goal_at(self, at_ns: int) -> tuple[int, str]:
        """When the search of that moment began, and for what; "" before the first."""
        goals = self.moments.goals
        n = bisect_right(goals, at_ns, key=lambda one: one[0])
        return goals[n - 1] if n else (self.moments.first_ns, "")

    # -- the first reading -------------------------------------------------------------------------

    def _note(self, place: ChunkPlace, message: Recorded) -> None:
        moments, at_ns = self.moments, message.log_time_ns
        if not moments.chunks or moments.chunks[-1] != place:
            moments.chunks.append(place)
            moments.chunks_ns.append(at_ns)
        moments.first_ns = moments.first_ns or at_ns
        moments.last_ns = max(moments.last_ns, at_ns)
        if message.schema == wire.COMPRESSED_IMAGE and not moments.color:
            moments.color = message.topic
        kind = _kind(message)
        if kind in RARE:
            moments.rare.setdefault(kind, []).append((at_ns, place))
        if kind in ("order", "frame", "question", "ballot", "decision", "halt"):
            try:
                self._event(kind, at_ns, json.loads(message.payload))
            except FAULTS:
                return  # of another version: the rest is shown

    def _event(self, kind: str, at_ns: int, told_: dict[str, Any]) -> None:
        moments = self.moments
        if kind == "order":
            moments.goals.append((at_ns, str(told_["goal"]["text"])))
        elif kind == "frame":
            self._walk(at_ns, float(told_["pose"]["x_m"]), float(told_["pose"]["y_m"]))
        elif kind == "question":
            brief = told_["brief"]
            self._questions = {int(brief["stamp_ns"]): brief}
        elif kind == "ballot":
            self._ballot = told_
        elif kind == "decision":
            moments.decisions.append((at_ns, self._decision(at_ns, told_)))
        elif told_["kind"] and told_["driving"]:
            number = len(moments.stops) + 1
            words = {"halt": told_["kind"], "reason": told_["reason"]}
            moments.stops.append((at_ns, {"number": number, "state": "held", **words}))

    def _walk(self, at_ns: int, x_m: float, y_m: float) -> None:
        way = self.moments.way
        if not way:
            way.append((at_ns, x_m, y_m, 0.0))
            return
        _, x0_m, y0_m, far_m = way[-1]
        step_m = math.hypot(x_m - x0_m, y_m - y0_m)
        if step_m >= STEP_M and len(way) < PLACES_MOST:
            way.append((at_ns, round(x_m, 3), round(y_m, 3), far_m + step_m))

    def _decision(self, at_ns: int, told_: dict[str, Any]) -> dict[str, Any]:
        """As a page is told one; numbers go through the whole recording."""
        number, (began_ns, goal) = len(self.moments.decisions) + 1, self.goal_at(at_ns)
        report = {**told_, **_votes(self._ballot)}
        report["without"] = dict(told_.get("without") or ())
        brief = self._questions.get(int(told_["stamp_ns"]))
        words: tuple[str, ...] = (str(told_.get("in_words", "")),)
        if brief is not None:
            decision = read({**told_, "ballot": self._ballot}, Decision)
            about = read(brief, Brief)
            elapsed_s = (at_ns - began_ns) / 1e9
            known = ToldDecision(number, goal, decision, about, {}, decision.frontier, elapsed_s)
            words = in_full(known)
        return told.decision_of(report, number, goal, words)


def _votes(ballot: Mapping[str, Any]) -> dict[str, Any]:
    read(ballot, Ballot)  # what is none is told as such
    return {name: ballot[name] for name in ("votes", "missing", "latency_s")}


def _kind(message: Recorded) -> str:
    """Of what is ours; "" for what came over the wire."""
    return message.topic.removeprefix(LOOP) if message.topic.startswith(LOOP) else ""
