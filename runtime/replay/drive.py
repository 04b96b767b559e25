"""Replays a recording: the loop that drove it runs again on what it was given then."""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from runtime.config import Config
from runtime.errors import RecordingError, RfNavError
from runtime.loops.lockstep import Lockstep
from runtime.loops.process import Garbage
from runtime.loops.realtime import RealTime
from runtime.replay.control import FilmControl
from runtime.replay.differences import Differences
from runtime.replay.models_again import ModelsAgain
from runtime.replay.script import Script, Turn
from runtime.replay.stand_ins import Film, FilmBus, FilmClock, FilmDecisions, FilmLooks, FilmModels
from runtime.tracing.budgets import read_budgets
from runtime.tracing.tracer import Tracer


@dataclass(frozen=True)
class Replayed:
    """How a replay went. `stopped`: why it could not go on to the end."""

    differences: Differences
    turns: int
    seconds: float
    skipped: int = 0  # frames before the first goal
    stopped: str = ""

    @property
    def equal(self) -> bool:
        return not self.differences.found and not self.stopped


ALWAYS: Final = 'research.control_mode="velocity"'  # in real time, as `rfnav run` has it


def replay(
    script: Script,
    path: Path | None = None,
    settings: Sequence[str] = (),
    again: ModelsAgain | None = None,
) -> Replayed:
    """Feed a recording through the loop that drove it, with a configuration file and settings over
    the recorded ones; `again` are asked beside it. RecordingError when nothing of it can be
    replayed."""
    script.check_robot(path, settings)
    differences, clock = Differences(), FilmClock()
    controls: list[FilmControl] = []

    def played(turn: Turn, made: dict[str, list[Any]]) -> None:
        differences.compare_turn(turn, made, script.recording.cut)
        for control in controls:
            control.drive(turn)

    film, stopped = Film(script, clock, played), ""
    with tempfile.TemporaryDirectory() as folder:
        bus, models = FilmBus(film, Path(folder)), FilmModels(film, clock, again)
        always = () if script.lockstep else (ALWAYS,)

        def configure(more: Sequence[str]) -> Config:
            return script.config(path, (*settings, *more, *always))

        try:
            if script.lockstep:
                Lockstep(bus, models, configure, clock, film.record).run(film.over)
            else:
                tracer = Tracer(read_budgets(None), clock.now_s)
                control = FilmControl(film, configure(()), tracer, differences)
                controls.append(control)
                beside = FilmDecisions(film), FilmLooks(film, again)
                loop = RealTime(
                    bus, control, models, configure, clock, tracer, read_budgets(None),
                    Garbage(clock), film.record, *beside,
                )  # fmt: skip
                loop.run(film.over)
        except RfNavError as error:
            if film.coming() or not script.recording.cut:  # else it only lacks what was cut off
                stopped = str(error)
    if not differences.compared.get("command"):
        raise RecordingError(_nothing(script, bus.unseen, stopped))
    return Replayed(differences, film.turn.number, film.turn.at_s, bus.unseen, stopped)


def _nothing(script: Script, unseen: int, stopped: str) -> str:
    """Why nothing was replayed."""
    path = script.recording.path
    if stopped:
        return f"{path}: nothing can be replayed: {stopped}"
    if unseen:
        return f"{path}: begins in the midst of a search: it can be looked at, or asked --goal"
    return f"{path}: no search is in it"
