"""The loop on a robot: four rates in one process. The control loop drives 20 times a second, this
thread surveys every newest frame and plans; one worker looks at images, another decides, while the
robot keeps going.

This thread owns the world. A search begins with a request on `goal` and ends when it is found, when
nothing is left to explore, or by a request on `cancel`.
"""

import traceback
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from runtime.clock import Clock
from runtime.config import Config
from runtime.core.types import Detections, SearchState
from runtime.errors import InternalError, RfNavError
from runtime.log import say
from runtime.loops.decision_worker import DecisionWorker
from runtime.loops.desk import NOTHING_ELSE, Answering, Desk
from runtime.loops.detector_worker import DetectorWorker, Surveyed
from runtime.loops.drawings import Drawer, NoDrawings
from runtime.loops.goals import USUAL, Custom, GoalLife
from runtime.loops.known_desk import KnownDesk
from runtime.loops.means import Means
from runtime.loops.order import SearchModels
from runtime.loops.ports import Control, Decisions, LoopDetector, RealTimeBus
from runtime.loops.process import Garbage
from runtime.loops.remembering import HomeMemory
from runtime.loops.search import Search, seen
from runtime.loops.shedding import Shedding
from runtime.record import Record, unrecorded
from runtime.robot.battery import Battery
from runtime.robot.bus import Request
from runtime.service.atlas import ASK
from runtime.service.outcomes import FailCause, GoalEnd
from runtime.service.telemetry import Telemetry
from runtime.tracing.budgets import Budgets
from runtime.tracing.stages import Stage
from runtime.tracing.tracer import Tracer

IDLE_S = 0.2  # how often the loop looks at what is not the bus
SURVEY_S = 0.1  # between two frames at least: of a faster camera the newest is taken
LABELS_S = 0.2  # labels of an image, where they come over the bus
WORKER_NICE = 10


class RealTime:
    """Serves goals until it is told to end. Whatever ends it, the base is brought to rest first.
    `answers`: of the kinds of requests that are answered without a search."""

    def __init__(
        self,
        bus: RealTimeBus,
        control: Control,
        models: SearchModels,
        configure: Callable[[Sequence[str]], Config],
        clock: Clock,
        tracer: Tracer,
        budgets: Budgets,
        garbage: Garbage,
        record: Record = unrecorded,
        worker: Decisions | None = None,
        detector: LoopDetector | None = None,
        custom: Custom = USUAL,
        drawer: Drawer | None = None,
        answers: Mapping[str, Answering] = NOTHING_ELSE,
        telemetry: Telemetry | None = None,
        memory: HomeMemory | None = None,
        known: KnownDesk | None = None,
    ) -> None:
        self._memory = memory
        self._telemetry = telemetry = telemetry or Telemetry(clock)
        self._bus, self._control, self._models, self._clock = bus, control, models, clock
        self._seen_s = 0.0  # when the last frame was taken
        self._tracer, self._garbage, self._shedding = tracer, garbage, Shedding(budgets)
        self._detector: LoopDetector = detector or DetectorWorker(
            self._look, tracer, clock, WORKER_NICE
        )
        self._decisions: Decisions = worker or DecisionWorker(WORKER_NICE, record)
        low = configure(()).battery  # the robot's own, not a goal's
        means = Means(
            bus, control, models, clock, self._decisions, self._detector, tracer, self._shedding,
            Battery(low), low.when_low, drawer or NoDrawings(), telemetry, memory,
        )  # fmt: skip
        self._goals = goals = GoalLife(means, configure, garbage, record, custom)
        ours: dict[str, Answering] = {
            "goal": lambda request: goals.accept(request.body),
            "cancel": goals.cancel,
            "pause": goals.pause,
            "resume": goals.resume,
            "result": goals.result,
            "status": lambda request: self._status(),
            "why": telemetry.why,
        }
        self._desk = Desk(ours | self._known(known) | dict(answers))

    def run(self, until: Callable[[], bool]) -> None:
        """Serve until `until()`. RfNavError when it cannot go on; InternalError for our own."""
        reason, cause, trace = "the runtime ends", FailCause.RESTART, {}
        self._control.started()
        try:
            self._goals.restore()
            while not until():
                self._control.check()
                self._tell_changes()
                self._turn()
        except RfNavError as error:
            reason, cause = str(error), FailCause.FAULT
            self._control.fault(reason)
            raise
        except Exception as error:
            cause = FailCause.FAULT
            reason, trace = f"internal error: {error!r}", {"traceback": traceback.format_exc()}
            at = traceback.extract_tb(error.__traceback__)[-1]
            place = f"{Path(at.filename).name}:{at.lineno}"
            self._control.fault(f"{reason} at {place}")
            raise InternalError(f"internal error: {error!r} at {place}") from error
        finally:
            self._control.close()
            self._tell_changes()
            self._goals.close(GoalEnd(SearchState.ENDED, reason, cause), **trace)
            self._detector.close()
            self._decisions.close()

    def _turn(self) -> None:
        if self._memory is not None:
            self._memory.turn()
        request = self._bus.request()
        if request is not None:
            self._answer(request)  # and on: requests without end hold up no frame
        if self._garbage.due():
            with self._tracer.stage(Stage.GARBAGE):
                self._garbage.collect()
        if self._telemetry.due():
            self._telemetry.note(self._status())
        goals = self._goals
        goals.next()
        if goals.drive is None:
            self._bus.wait_request(IDLE_S)
            return
        rests_s = self._seen_s + SURVEY_S - self._clock.now_s()
        if rests_s > 0:
            self._bus.wait_request(rests_s)
            return
        obs = self._bus.next(IDLE_S)
        goals.drive.note_halt()
        if obs is not None:
            self._seen_s = self._clock.now_s()
            ends = goals.drive.see(obs, self._bus.delivered_s() or self._seen_s)
            goals.drive.note_overruns()
            if self._memory is not None:
                self._memory.saw(goals.drive.search, self._models)
        else:
            ends = goals.drive.over(self._clock.now_s())
        if ends is not None:
            goals.end(ends)

    def _known(self, desk: KnownDesk | None) -> dict[str, Answering]:
        """Who answers what is asked of the home."""
        if desk is None:
            return {}
        desk.search = self._seen
        return dict.fromkeys(ASK, desk.answer)

    def _seen(self) -> Search | None:
        """The newest search, where its map is of the odometry of now."""
        search = self._goals.newest()
        if search is None or search.world is None or self._memory is None:
            return search
        return search if self._memory.holds(search.world) else None

    def _tell_changes(self) -> None:
        """Log how the runtime's standing has changed, and journal it while a search is on."""
        for change in self._control.changes():
            was, now = change.before.in_words(), change.after.in_words()
            self._telemetry.stood(change.now_s, was, change.after.state, change.after.cause)
            if (drive := self._goals.drive) is not None:
                drive.search.journal.write("standing", at_s=change.now_s, was=was, now=now)

    # -- requests ------------------------------------------------------------------------------

    def _answer(self, request: Request) -> None:
        """A goal that runs into a mistake of ours ends the search, and no more: what the models
        were told is not known then."""
        try:
            self._desk.answer(request)
        except Exception as error:
            if request.kind != "goal" or isinstance(error, RfNavError):
                raise
            told = f"internal error: {error!r}"
            say(f"goal: {told}\n{traceback.format_exc()}")
            why = f"a goal met an {told}"
            self._goals.end(GoalEnd(SearchState.ENDED, why, FailCause.FAULT))

    def _status(self) -> dict[str, object]:
        health = self._bus.health()
        return {
            **self._control.status(),
            **self._goals.told(),
            "rung": self._models.rung(),
            "detector": self._models.capabilities(),
            "models": self._models.health(),
            "streams": {t: vars(h) for t, h in health.items()},
            "stages": self._tracer.told(),
            "shed": self._shedding.told(),
            "memory": self._memory.in_words() if self._memory is not None else "none",
            **self._telemetry.told(),
        }

    def _look(self, surveyed: Surveyed) -> Detections | None:
        """In the detectors' thread."""
        search = surveyed.asker
        assert isinstance(search, Search)
        return seen(search, surveyed.obs, self._models, self._bus, LABELS_S)
