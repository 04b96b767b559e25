"""What stands around the loop in a replay: it hands over what was recorded, turn by turn, and takes
down what the loop makes of it."""

import threading
from collections import defaultdict
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from runtime import navigate
from runtime.clock import Clock, Deadline
from runtime.config import Config
from runtime.core.mapping.attention import View
from runtime.core.mapping.keyframes import Keyframe
from runtime.core.objects.surfaces import Window, surfaces_window
from runtime.core.settings import NavigateConfig
from runtime.core.types import (
    F32,
    F64,
    U8,
    Action,
    Ballot,
    Brief,
    Decision,
    Detections,
    Observation,
    Twist,
)
from runtime.errors import ConfigError, RecordingError
from runtime.experts.panel import Panel
from runtime.loops.decision_worker import DecisionReply, DecisionRequest
from runtime.loops.detector_worker import Look, Surveyed
from runtime.perception.goal_words import Goal
from runtime.recording.exact import read, read_array
from runtime.recording.messages import told_decision
from runtime.replay.models_again import ModelsAgain
from runtime.replay.script import Script, Turn, observed
from runtime.robot.requests import Request
from runtime.robot.transforms import FIXED, CameraConfig

Sweeps = Callable[[NavigateConfig, CameraConfig], None]


class FilmClock:
    """Time as it was."""

    def __init__(self) -> None:
        self.at_s = 0.0

    def now_s(self) -> float:
        return self.at_s

    def wait(self, condition: threading.Condition, until_s: float) -> None:
        raise RecordingError("a replay waits for nobody")


class Film:
    """The turns of a script, and the one that is played. `played`: called with each when the loop
    is done with it, and with what it made."""

    def __init__(
        self, script: Script, clock: FilmClock, played: Callable[[Turn, dict[str, list[Any]]], None]
    ) -> None:
        self._turns: Iterator[Turn] = script.turns()
        self._clock, self._played = clock, played
        self.turn = next(self._turns)
        self._next: Turn | None = next(self._turns, None)
        self._made: dict[str, list[Any]] = defaultdict(list)

    def record(self, kind: str, value: object) -> None:
        """What the loop tells in the replay."""
        told = told_decision(value) if isinstance(value, Decision) else value
        self._made[kind].append(told)

    def made(self, kind: str) -> int:
        """How many values of a kind the loop has told in this turn."""
        return len(self._made[kind])

    def coming(self) -> str:
        """What the next turn begins with; "" after the last."""
        return self._next.kind if self._next is not None else ""

    def wait(self) -> bool:
        """Until what comes next is there; False when it already is."""
        there_s = self._next.told["now_s"] if self._next is not None else self._clock.at_s
        waited, self._clock.at_s = there_s > self._clock.at_s, there_s
        return waited

    def forward(self) -> Turn:
        """The turn is over: the next."""
        self._over()
        assert self._next is not None
        self.turn, self._next = self._next, next(self._turns, None)
        self._clock.at_s = self.turn.told.get("now_s", self._clock.at_s)
        return self.turn

    def over(self) -> bool:
        """Whether the last turn was played, which is then over."""
        if self._next is None:
            self._over()
            self._played = lambda turn, made: None
        return self._next is None

    def heard(self, name: str) -> Any:
        """What the loop was given then."""
        values = self.turn.heard[name]
        if not values:
            what = (
                f"turn {self.turn.number}: the loop asks for {name}, which was not asked for then"
            )
            raise RecordingError(what)
        return values.popleft()

    def given(self, name: str) -> Any:
        """The same of what was not always told; None where it was not."""
        values = self.turn.heard[name]
        return values.popleft() if values else None

    def _over(self) -> None:
        made, self._made = self._made, defaultdict(list)
        self._played(self.turn, made)


class FilmBus:
    """The bus: frames and requests in their order. Where a goal says where files go, they go to
    `log_dir`. `sweeps`: told which body a goal brings."""

    def __init__(self, film: Film, log_dir: Path, sweeps: Sweeps = lambda *_: None) -> None:
        self._film, self._log_dir, self.sweeps = film, log_dir, sweeps

    def request(self) -> Request | None:
        if self._film.coming() != "request":
            return None
        told = self._film.forward().told
        body = dict(told["body"])
        if "log_dir" in body:
            body["log_dir"] = str(self._log_dir)
        return Request(told["kind"], body, _Asker(), "replay")

    def next(self, timeout_s: float) -> Observation | None:
        return observed(self._film.forward()) if self._film.coming() == "frame" else None

    def delivered_s(self) -> float | None:
        return float(self._film.turn.told["arrival_s"])

    def cliffs_watched(self) -> bool:
        return bool(self._film.given("cliffs_watched"))

    def unstamped(self) -> tuple[str, ...]:
        return ()

    def wait_request(self, timeout_s: float) -> None:
        """Time passes, until the next frame was there; one that is not taken then is of no use to
        the loop, as it has no search."""
        if self._film.coming() == "frame" and not self._film.wait():
            self._film.forward()

    def labels(self, stamp_ns: int, timeout_s: float) -> dict[str, Any] | None:
        found: dict[str, Any] | None = self._film.heard("labels")
        return found

    def health(self) -> Mapping[str, Any]:
        return {}

    def flush(self) -> None:
        """Nothing waits."""

    def publish_decision(self, decision: Mapping[str, object]) -> None:
        """Nobody listens."""

    def publish_feedback(self, feedback: Mapping[str, object]) -> None:
        """Nobody listens."""

    def publish_state(self, state: Mapping[str, object]) -> None:
        """Nobody listens."""

    def publish_action(self, stamp_ns: int, action: Action, twist: Twist | None = None) -> None:
        """Nobody listens; the command was told before."""


class FilmModels:
    """The models: what they said then. `again`: those that say it once more, to compare."""

    def __init__(self, film: Film, clock: Clock, again: ModelsAgain | None = None) -> None:
        self._film, self._clock, self.again = film, clock, again
        self.rooms: tuple[str, ...] = ()
        self.accepted = False  # a goal, since the beginning

    def accept(self, goal: str, config: Config) -> tuple[Goal, Panel]:
        if not self._film.turn.heard["order"]:
            raise ConfigError("this goal was refused then")
        told = self._film.heard("order")
        self.rooms, self.accepted = tuple(told["rooms"]), True
        if self.again is not None:
            self.again.accept(goal, config)
        return read(told["goal"], Goal), FilmPanel(self._film, self._clock, self.again)

    def hear(self, text: str, config: Config, several: bool) -> tuple[Goal, ...]:
        told = self._film.given("hears")
        if told is None:
            raise ConfigError("this goal was refused then")
        return tuple(read(one, Goal) for one in told)

    def afford(self, usd: float | None) -> None:
        """Nothing is spent."""

    def detect(self, rgb: U8, window: Callable[[], Window | None] = lambda: None) -> Detections:
        then = read(self._film.heard("detections"), Detections)
        if self.again is not None:
            self.again.look(self._film.turn.number, rgb, window, then)
        return then

    def likeness(self, embeddings: F32) -> F64:
        return np.asarray(read_array(self._film.heard("likeness")), np.float64)

    def notice(self, goal: str, names: tuple[str, ...]) -> None:
        """Nobody is asked ahead."""

    def hold(self, frames: Sequence[Keyframe]) -> None:
        """Nobody looks at them."""

    def capabilities(self) -> Mapping[str, object]:
        return {}

    def rung(self) -> str:
        return "replay"

    def health(self) -> Mapping[str, object]:
        return {}

    def bills(self) -> Sequence[object]:
        return ()

    def finish(self) -> None:
        """Nothing to end."""


class FilmPanel(Panel):
    """The experts: the ballot of then."""

    def __init__(self, film: Film, clock: Clock, again: ModelsAgain | None = None) -> None:
        super().__init__({}, clock)
        self._film, self._again = film, again

    def ask(self, brief: Brief, by: Deadline) -> Ballot:
        told = self._film.heard("ballot")
        then = read({name: told[name] for name in ("votes", "missing", "latency_s")}, Ballot)
        if self._again is not None:
            self._again.ask(self._film.turn.number, brief, then)
        return then


class FilmLooks:
    """Who looks beside the drive: what was seen comes in the turn in which it came. `looked`: the
    stamps of all images that were looked at then. Those are kept until they are taken, however
    long that was after they were offered; of no other one is anything wanted."""

    def __init__(
        self, film: Film, looked: Collection[int], again: ModelsAgain | None = None
    ) -> None:
        self._film, self._looked, self._again = film, looked, again
        self._offered: dict[int, Surveyed] = {}  # by stamp
        self.rest = 0.0

    def offer(self, surveyed: Surveyed, view: View, at_once: bool) -> None:
        if surveyed.obs.stamp_ns in self._looked:
            self._offered[surveyed.obs.stamp_ns] = surveyed

    def take(self) -> list[Look]:
        stamps, found = self._film.turn.heard["looked"], []
        while stamps:
            surveyed = self._offered.pop(stamps.popleft(), None)
            if surveyed is None:
                what = "what was looked at then was not offered"
                raise RecordingError(f"turn {self._film.turn.number}: {what}")
            then = read(self._film.heard("detections"), Detections)
            obs = surveyed.obs
            if self._again is not None:
                window = partial(surfaces_window, obs, obs.mount or FIXED)
                self._again.look(self._film.turn.number, obs.rgb, window, then)
            found.append(Look(surveyed, then, 0.0))
        return found

    def behind(self) -> bool:
        return bool(self._film.heard("behind"))

    def paused(self) -> AbstractContextManager[None]:
        return nullcontext()

    def begin(self, newest_only: bool) -> None:
        self._offered.clear()

    def close(self) -> None:
        """There is no thread."""


class FilmDecisions:
    """Who decides beside the drive: answers come in the turn in which they came."""

    def __init__(self, film: Film) -> None:
        self._film = film
        self._question: DecisionRequest | None = None

    @property
    def busy(self) -> bool:
        return bool(self._film.heard("busy"))

    @property
    def idle(self) -> bool:
        return False  # nothing is rehearsed: what came of it is in the ballots

    def ask(self, question: DecisionRequest) -> None:
        self._question = question

    def rehearse(self, question: DecisionRequest) -> None:
        raise RecordingError("a replay rehearses nothing")

    def take(self) -> DecisionReply | None:
        question = self._question
        if question is None or not self._film.turn.heard["ballot"]:
            return None
        rehearsal = self._film.turn.heard["ballot"][0]["rehearsal"]
        snap, cfg = question.snapshot, question.cfg
        self._film.record("question", {"why": snap.why, "brief": snap.brief})
        decision = navigate.decide(snap, question.panel, question.by, cfg)
        self._question = None
        return DecisionReply(question, decision, rehearsal)

    def close(self) -> None:
        """There is no thread."""


class _Asker:
    """A query that nobody waits for."""

    def reply(self, key: str, payload: str) -> None:
        """Nobody listens."""

    def drop(self) -> None:
        """Nothing is held."""
