"""Replays a recording: the loop that drove it runs again on what it was given then."""

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from runtime.config import Config
from runtime.core.mapping.zones import Zone
from runtime.errors import RecordingError, RfNavError
from runtime.loops.goal_request import Terms
from runtime.loops.goals import Custom
from runtime.loops.lockstep import Lockstep
from runtime.loops.process import Garbage
from runtime.loops.realtime import RealTime
from runtime.recording.exact import read
from runtime.replay.control import FilmControl
from runtime.replay.differences import Differences
from runtime.replay.models_again import ModelsAgain
from runtime.replay.reflex_again import ReflexAgain
from runtime.replay.script import Script, Turn
from runtime.replay.stand_ins import Film, FilmBus, FilmClock, FilmDecisions, FilmLooks, FilmModels
from runtime.service.bounds import ANYWHERE, GoalBounds
from runtime.service.goal_queue import new_id
from runtime.service.telemetry import Telemetry, untold
from runtime.tracing.budgets import read_budgets
from runtime.tracing.tracer import Tracer


@dataclass(frozen=True)
class Replayed:
    """How a replay went. `stopped`: why it could not go on to the end; `elected`: the frontiers
    that were decided for; `ended`: how each search ended that did."""

    differences: Differences
    turns: int
    seconds: float
    skipped: int = 0  # frames before the first goal
    stopped: str = ""
    elected: tuple[int | None, ...] = ()
    ended: tuple[str, ...] = ()

    @property
    def equal(self) -> bool:
        return not self.differences.found and not self.stopped


ALWAYS: Final = 'research.control_mode="velocity"'  # in real time, as `rfnav run` has it


def replay(
    script: Script,
    path: Path | None = None,
    settings: Sequence[str] = (),
    again: ModelsAgain | None = None,
    reflex: ReflexAgain | None = None,
) -> Replayed:
    """Feed a recording through the loop that drove it, with a configuration file and settings over
    the recorded ones; `again` are asked beside it, `reflex` in place of the recorded one.
    RecordingError when nothing of it can be replayed."""
    script.check_robot(path, settings)
    account, clock, stopped = _Account(script), FilmClock(), ""
    film = Film(script, clock, account.played)
    always = () if script.lockstep else (ALWAYS,)

    def configure(more: Sequence[str]) -> Config:
        return script.config(path, (*settings, *more, *always))

    account.models = FilmModels(film, clock, again)
    with tempfile.TemporaryDirectory() as folder:
        bus = FilmBus(film, Path(folder), reflex.sweeps if reflex else lambda *_: None)
        terms = Terms(script.harness, lambda: Path(folder), FilmZones(film))
        try:
            if script.lockstep:
                loop = Lockstep(bus, account.models, configure, clock, film.record, terms)
                loop.run(film.over)
            else:
                _in_real_time(film, bus, account, configure, clock, terms, reflex)
        except RfNavError as error:
            if film.coming() or not script.recording.cut:  # else it only lacks what was cut off
                stopped = str(error)
    if not account.differences.compared.get("command"):
        raise RecordingError(_nothing(script, account.skipped, stopped))
    return Replayed(
        account.differences,
        film.turn.number,
        film.turn.at_s,
        account.skipped,
        stopped,
        tuple(account.elected),
        tuple(account.ended),
    )


@dataclass
class _Account:
    """What becomes of the turns."""

    script: Script
    differences: Differences = field(default_factory=Differences)
    elected: list[int | None] = field(default_factory=list)
    ended: list[str] = field(default_factory=list)
    skipped: int = 0  # frames of a search that began before the recording
    models: FilmModels | None = None
    control: FilmControl | None = None

    def played(self, turn: Turn, made: dict[str, list[Any]]) -> None:
        """The loop is done with a turn."""
        if self.models is not None and self.models.accepted:
            self.elected.extend(told["frontier"] for told in made["decision"])
            self.ended.extend(str(told["ended"]) for told in made["command"] if told["ended"])
            self.differences.compare_turn(turn, made, self.script.recording.cut)
        else:
            self.skipped += turn.kind == "frame"
        if self.control is not None:
            self.control.drive(turn)


class FilmZones:
    """What was kept out of then, and what goals were bound to."""

    def __init__(self, film: Film) -> None:
        self._film, self._zones = film, tuple[Zone, ...]()

    def now(self) -> tuple[Zone, ...]:
        told = self._film.given("zones")
        if told is not None:
            self._zones = tuple(read(one, Zone) for one in told)
        return self._zones

    def unbound(self) -> str:
        told = self._film.turn.heard["lost"]
        return str(told[0]) if told else ""

    def bounds(self, body: Mapping[str, Any], rooms: Sequence[str]) -> GoalBounds:
        told = self._film.turn.heard["bounds"]
        return read(told[0], GoalBounds) if told else ANYWHERE

    def moved(
        self, before: GoalBounds, body: Mapping[str, Any], rooms: Sequence[str]
    ) -> GoalBounds:
        told = self._film.given("moved")
        return read(told, GoalBounds) if told is not None else before


def _in_real_time(
    film: Film,
    bus: FilmBus,
    account: _Account,
    configure: Callable[[Sequence[str]], Config],
    clock: FilmClock,
    terms: Terms,
    reflex: ReflexAgain | None,
) -> None:
    budgets, models = read_budgets(None), account.models
    assert models is not None
    tracer = Tracer(budgets, clock.now_s)
    looked = frozenset(account.script.heard("looked"))
    account.control = FilmControl(film, configure(()), tracer, account.differences, reflex)
    loop = RealTime(
        bus, account.control, models, configure, clock, tracer, budgets, Garbage(clock),
        film.record, FilmDecisions(film), FilmLooks(film, looked, models.again),
        Custom(terms, new_id=lambda: str(film.given("id") or new_id())),
        telemetry=Telemetry(clock, tell=untold),
    )  # fmt: skip
    loop.run(film.over)


def _nothing(script: Script, skipped: int, stopped: str) -> str:
    """Why nothing was replayed."""
    path = script.recording.path
    if stopped:
        return f"{path}: nothing can be replayed: {stopped}"
    if skipped:
        return f"{path}: begins in the midst of a search: it can be looked at, or asked --goal"
    return f"{path}: no search is in it"
