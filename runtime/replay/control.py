"""The control loop of a replay: the same ticks, at the times and with the odometry of then."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from runtime.config import Config
from runtime.core.motion.caution import FREE, Caution
from runtime.core.motion.contact import NOTHING, Felt, Met
from runtime.core.motion.courses import STILL
from runtime.core.motion.safety import Halt, Odometry
from runtime.core.types import Pose, SearchState, Twist
from runtime.loops.control_loop import ControlLoop
from runtime.loops.plans import Plan, Tick, told_plan
from runtime.loops.standing import Change
from runtime.recording.exact import exact, read
from runtime.replay.differences import Differences
from runtime.replay.reflex_again import ReflexAgain
from runtime.replay.script import Turn
from runtime.replay.stand_ins import Film, FilmClock
from runtime.robot.base import WELL, BaseCondition, DriveOrder, Sent
from runtime.robot.wire import Stamped
from runtime.tracing.tracer import Tracer


class FilmControl:
    """As the thread that plans sees it. What it plans is driven by `drive`, when all of its turn is
    known."""

    def __init__(
        self,
        film: Film,
        config: Config,
        tracer: Tracer,
        differences: Differences,
        reflex: ReflexAgain | None = None,
    ) -> None:
        """`reflex`: one that is asked again; ticks are not compared then."""
        self._film, self._differences, self._reflex = film, differences, reflex
        self._base = _Base(reflex)
        self._clock = reflex.clock if reflex is not None else FilmClock()
        self._stopping: Callable[[], bool] = lambda: False
        self._loop = ControlLoop(
            self._base, self._base, self._clock, config.safety, config.realtime, tracer,
            stopping=lambda: self._stopping(), record=self._take,
        )  # fmt: skip
        self._tick: Tick | None = None
        self._plans: dict[int, Plan] = {}  # by the number that they had
        self._following = 0

    # -- for the thread that plans -------------------------------------------------------------

    def follow(self, plan: Plan) -> None:
        told = self._film.turn.made["plan"]
        made = self._film.made("plan")
        if made < len(told):  # when its frame came is the clock's word, not the loop's
            timed = replace(plan, frame_s=float(told[made]["frame_s"]))
            self._plans[told[made]["number"]] = timed
        self._film.record("plan", told_plan(0, plan))

    def rest(self, state: SearchState, report: Mapping[str, object]) -> None:
        self._film.record("rest", {"state": state})

    def asked_mps(self) -> float:
        return float(self._film.heard("asked_mps"))

    def held(self) -> bool:
        return bool(self._film.given("held"))  # recordings from before it counted have none

    def sent(self) -> Twist:
        return read(self._film.heard("sent"), Twist)

    def condition(self, forget: bool = True) -> BaseCondition:
        told = self._film.given("condition")
        return read(told, BaseCondition) if told is not None else WELL

    def met(self) -> tuple[Met, ...]:
        return tuple(read(one, Met) for one in self._film.given("met") or ())

    def check(self) -> None:
        """Nothing ends it."""

    def halted(self) -> str:
        return ""

    def halts(self) -> dict[str, int]:
        return {}

    def started(self) -> None:
        """Nobody watches."""

    def fault(self, reason: str) -> None:
        """Nobody watches."""

    def changes(self) -> tuple[Change, ...]:
        return ()

    def status(self) -> dict[str, object]:
        return {}

    def close(self) -> None:
        """There is no thread."""

    # -- the ticks -----------------------------------------------------------------------------

    def drive(self, turn: Turn) -> None:
        """What the control loop did in a turn."""
        if self._reflex is not None and turn.kind == "frame":
            self._reflex.show(turn)
        for kind, told in turn.controls:
            if kind == "rest":
                self._loop.rest(SearchState(told["state"]), {})
                self._following = 0
            else:
                self._turn(turn, told)

    def _turn(self, turn: Turn, told: Mapping[str, Any]) -> None:
        number = told["plan"]
        if number and number != self._following:
            if number not in self._plans:
                return  # the recording begins in the midst of it, or the replay has ended before
            self._loop.follow(self._plans[number])
            self._following = number
            for old in [n for n in self._plans if n < number]:
                del self._plans[old]
        self._clock.at_s = told["now_s"]
        odometry = told["odometry"]
        self._base.odometry = _odometry(odometry) if odometry else None
        self._base.frame_s = told["frame_s"]
        self._base.told = told
        self._stopping = self._withdraws if told["withdrawn"] else lambda: bool(told["stopping"])
        self._loop.tick()
        assert self._tick is not None
        if self._reflex is not None:
            self._reflex.note(self._tick)
            return
        made = {name: value for name, value in exact(self._tick).items() if name in told}
        if not number and told["sent"] in (None, exact(STILL)):
            for name in made.keys() & {"sent", "asked"}:
                made[name] = told[name]  # at rest: whether zero is still said does not matter
        if told["withdrawn"]:
            made["stopping"] = told["stopping"]
        self._differences.compare(turn, "tick", made, told)

    def _withdraws(self) -> bool:
        """The plan is taken away while the tick is under way."""
        self._loop.rest(SearchState.ENDED, {})
        self._following = 0
        return False

    def _take(self, kind: str, value: object) -> None:
        if isinstance(value, Tick):
            self._tick = value


class _Base:
    """The robot: what it said then; a `reflex` is asked again."""

    def __init__(self, reflex: ReflexAgain | None) -> None:
        self._reflex = reflex
        self.odometry: Odometry | None = None
        self.frame_s: float | None = None
        self.told: Mapping[str, Any] = {}  # the tick, as it was recorded

    def pose(self) -> tuple[Stamped[Pose], float] | None:
        told = self.odometry
        return (Stamped(told.stamp_ns, told.pose), told.arrival_s) if told else None

    def frame_arrival_s(self) -> float | None:
        return self.frame_s

    def felt(self) -> Felt:
        told = self.told.get("felt")
        return read(told, Felt) if told is not None else NOTHING

    def doubt(self, sent: Twist) -> Halt | None:
        told = self.told.get("doubt")
        return read(told, Halt) if told is not None else None

    def caution(self, twist: Twist) -> Caution:
        if self._reflex is not None:
            return self._reflex.caution(twist, self.odometry.pose if self.odometry else None)
        told = self.told.get("caution")
        return read(told, Caution) if told is not None else FREE

    def condition(self) -> BaseCondition:
        told = self.told.get("base")  # recordings from before bases said anything have none
        return read(told, BaseCondition) if told is not None else WELL

    def drive(self, order: DriveOrder) -> Sent:
        """What it is asked as then it answers as then; anything else it does."""
        assert math.isfinite(order.twist.v_mps)
        assert math.isfinite(order.twist.w_radps)
        if self.told.get("asked") != exact(order.twist):
            return Sent(order.twist)
        sent = self.told["sent"]
        return Sent(read(sent, Twist) if sent is not None else None)

    def publish_state(self, state: Mapping[str, object]) -> None:
        """Nobody listens."""


def _odometry(told: Mapping[str, Any]) -> Odometry:
    return Odometry(read(told["pose"], Pose), told["stamp_ns"], told["arrival_s"])
