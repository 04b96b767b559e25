"""What the service is asked for pages, again and again while somebody looks: what it does not
publish. In one thread, for an answer may take seconds."""

import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final, Protocol

from runtime.errors import BusError, SensorError
from runtime.service.told_map import unpacked
from runtime.tracing.budgets import Budgets
from runtime.view import told
from runtime.view.feed import Audience, Content
from runtime.view.hearing import FAULTS, PageHearing, named_things
from runtime.view.history import SearchHistory
from runtime.view.tiles import ROOMS, TileGrid, TileMap

EVERY_S: Final = {"status": 1.0, "zones": 3.0, "places": 3.0, "map": 2.0, "stops": 5.0}
UNKNOWN_S: Final = 30.0  # until what nobody answers is asked again
WITHIN_S: Final = 1.5
MOST_ROOMS: Final = 254
MAP_CELLS: Final = 1 << 22
WORDLESS: Final = 8  # decisions that wait for their words; of more the oldest are lost
ANEW_S: Final = 1.0  # that the service began later than before: it is another process


class AskedService(Protocol):
    """A runtime that may be there; see `commands.running.Running`."""

    @property
    def session(self) -> Any: ...

    def ask(self, kind: str, body: Mapping[str, object], within_s: float) -> dict[str, Any]:
        """BusError, one line, when nobody answers."""
        ...


@dataclass
class Answers:
    """What was answered last. `status_s`: when a status was, monotonic."""

    status: Mapping[str, Any] = field(default_factory=dict)
    before: Mapping[str, Any] = field(default_factory=dict)
    status_s: float = -1e9


class PageQuestions:
    """`wrong`: what of a status is not as it should be; `view`: how this process fares."""

    def __init__(
        self,
        audience: Audience,
        hearing: PageHearing,
        history: SearchHistory,
        tiles: TileMap,
        budgets: Budgets,
        wrong: Callable[[Content], Sequence[str]],
        view: Callable[[], Content],
    ) -> None:
        self._audience, self._hearing, self._history = audience, hearing, history
        self._tiles, self._budgets, self._wrong, self._view = tiles, budgets, wrong, view
        self._due_s = dict.fromkeys(EVERY_S, 0.0)
        self._told: dict[str, object] = {}
        self._stood: tuple[str, str] = ("", "")
        self._why: deque[Content] = deque(maxlen=WORDLESS)
        self._began_s: float | None = None  # the service, by its own clock
        self.answers = Answers()

    def decided(self, report: Content) -> None:
        """A decision was published, and its words are to be asked for; any thread."""
        self._why.append(report)

    def soon(self, kind: str) -> None:
        """Something has changed it."""
        if kind in self._due_s:
            self._due_s[kind] = 0.0

    def forget(self) -> None:
        """Another process may answer from now on."""
        self.answers, self._told = Answers(), {}
        self._due_s = dict.fromkeys(EVERY_S, 0.0)

    def turn(self, service: AskedService) -> None:
        """Ask what is due. What is not answered, or is nonsense, is left out."""
        runtime = told.table(self._hearing.newest.state, "runtime")
        stood = str(runtime.get("state", "")), str(self._hearing.newest.state.get("halt", ""))
        if (stood[0], bool(stood[1])) != (self._stood[0], bool(self._stood[1])):
            self._stood = stood
            self.soon("stops")
        while self._why:
            self._tried("decision", partial(self._words, service, self._why.popleft()))
        for kind, due_s in list(self._due_s.items()):
            now_s = time.monotonic()
            if now_s >= due_s:
                self._due_s[kind] = now_s + EVERY_S[kind]
                self._tried(kind, partial(self._ask, service, kind))

    def _tried(self, kind: str, asks: Callable[[], None]) -> None:
        try:
            asks()
        except BusError:
            if kind != "status":
                self._due_s[kind] = time.monotonic() + UNKNOWN_S
        except (SensorError, *FAULTS):
            self._hearing.bad += 1

    def _ask(self, service: AskedService, kind: str) -> None:
        if kind == "stops":
            self._take_why(service.ask("why", {}, WITHIN_S))
            return
        body = {"list": True} if kind in ("zones", "places") else {}
        answer = service.ask(kind, body, WITHIN_S)
        if answer.get("accepted") is False:
            self._due_s[kind] = time.monotonic() + UNKNOWN_S
        elif kind == "status":
            self._take_status(answer)
        elif kind == "map":
            self._take_rooms(answer)
        else:
            content = told.zones_of(answer) if kind == "zones" else told.places_of(answer)
            self._tell_changed(kind, content)

    def _take_status(self, answer: Content) -> None:
        held = self.answers
        self.answers = Answers(answer, held.status, time.monotonic())
        began_s = told.number(answer.get("now_s")) - told.number(answer.get("up_s"))
        before_s, self._began_s = self._began_s, began_s
        if before_s is not None and abs(began_s - before_s) > ANEW_S:
            self._history.forget()
            self._audience.tell("timeline", self._history.timeline())
        health = told.health_of(answer, held.status, self._budgets, self._wrong(answer))
        self._audience.tell("health", {**health, "view": self._view()})
        names = told.names_of(named_things(self._hearing.newest.scene), answer)
        self._tell_changed("names", {"names": names})

    def _take_rooms(self, answer: Content) -> None:
        names = [str(name) for name in answer.get("room_names") or ()][:MOST_ROOMS]
        if answer["rows"] == 0:
            return  # nothing is known yet
        rooms = unpacked(answer, "rooms", MAP_CELLS)
        x0_m, y0_m = answer["origin_xy"]
        grid = TileGrid(rooms, float(answer["resolution_m"]), float(x0_m), float(y0_m))
        self._tiles.put(ROOMS, grid)
        self._audience.mapped()
        if names != self._hearing.rooms:
            self._hearing.rooms = names
            self._hearing.tell_scene()

    def _take_why(self, answer: Content) -> None:
        stop, decision = answer.get("stop"), answer.get("decision")
        if isinstance(stop, Mapping):
            self._stop(told.stop_of(stop))
        if isinstance(decision, Mapping):
            self._tell_decision({}, decision)

    def _words(self, service: AskedService, report: Content) -> None:
        """Why that was decided, beside what was published of it."""
        number = int(report["number"])
        goal = str(self._hearing.newest.scene.get("goal", ""))
        short = {"number": number, "goal": goal, "in_words": [str(report.get("in_words", ""))]}
        try:
            answer = service.ask("why", {"decision": number}, WITHIN_S).get("decision")
        except (BusError, SensorError):
            answer = None
        self._tell_decision(report, answer if isinstance(answer, Mapping) else short)

    def _tell_decision(self, report: Content, decision: Content) -> None:
        number = int(decision["number"])
        content = told.decision_of(
            report,
            number,
            str(decision["goal"]),
            decision.get("in_words") or (),
            told.origin_of(self._hearing.newest.state),
        )
        content["id"] = str(report.get("id") or decision.get("id") or "")
        t_s = time.time() if report else None
        if not self._history.decided(content, self._hearing.scene_json(), t_s):
            return
        if number == self._history.last:
            self._audience.tell("decision", content)
        self._audience.tell("timeline", self._history.timeline())

    def _stop(self, stop: Content) -> None:
        if self._history.stopped(stop, time.time()):
            self._audience.tell("stop", stop)
            self._audience.tell("timeline", self._history.timeline())

    def _tell_changed(self, kind: str, content: Content) -> None:
        if self._told.get(kind) != content:
            self._told[kind] = content
            self._audience.tell(kind, content)
