"""The loop on a robot: four rates in one process. The control loop drives 20 times a second, this
thread surveys every newest frame and plans; one worker looks at images, another decides, while the
robot keeps going.

This thread owns the world. A search begins with a request on `goal` and ends when it is found, when
nothing is left to explore, or by a request on `cancel`.
"""

import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from runtime.clock import Clock
from runtime.config import Config
from runtime.core.types import Detections, SearchState
from runtime.errors import InternalError, RfNavError
from runtime.experts.hindsight import Hindsight
from runtime.log import say
from runtime.loops.decision_worker import DecisionWorker
from runtime.loops.desk import NOTHING_ELSE, Answering, Desk
from runtime.loops.detector_worker import DetectorWorker, Surveyed
from runtime.loops.drawings import Drawer, NoDrawings
from runtime.loops.drive import Drive, Means
from runtime.loops.feedback import Feedback
from runtime.loops.goal_request import STRICT, Terms, cancel_reason
from runtime.loops.ports import Control, Decisions, LoopDetector, RealTimeBus
from runtime.loops.process import Garbage
from runtime.loops.search import Order, Search, SearchModels, seen, understand
from runtime.loops.shedding import Shedding
from runtime.record import Record, unrecorded
from runtime.robot.battery import Battery
from runtime.robot.bus import Request
from runtime.service.telemetry import Telemetry
from runtime.tracing.budgets import Budgets
from runtime.tracing.stages import Stage
from runtime.tracing.tracer import Tracer

IDLE_S = 0.2  # how often the loop looks at what is not the bus
SURVEY_S = 0.1  # between two frames at least: of a faster camera the newest is taken
LABELS_S = 0.2  # labels of an image, where they come over the bus
WORKER_NICE = 10
OVER = (SearchState.FOUND, SearchState.NOT_FOUND, SearchState.CANCELLED)


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
        terms: Terms = STRICT,
        drawer: Drawer | None = None,
        answers: Mapping[str, Answering] = NOTHING_ELSE,
        telemetry: Telemetry | None = None,
    ) -> None:
        self._telemetry = telemetry or Telemetry(clock)
        self._record, self._terms = record, terms
        self._drawer = drawer or NoDrawings()
        self._bus, self._control, self._models = bus, control, models
        self._configure, self._clock = configure, clock
        self._drive: Drive | None = None
        self._last: tuple[Search, dict[str, object]] | None = None  # ended, and its summary
        self._hindsight = Hindsight()
        self._seen_s = 0.0  # when the last frame was taken
        self._tracer, self._garbage = tracer, garbage
        self._detector: LoopDetector = detector or DetectorWorker(
            self._look, tracer, clock, WORKER_NICE
        )
        self._decisions: Decisions = worker or DecisionWorker(WORKER_NICE, record)
        self._shedding = Shedding(budgets)
        low = configure(()).battery  # the robot's own, not a goal's
        self._battery, self._when_low = Battery(low), low.when_low
        ours: dict[str, Answering] = {
            "goal": lambda request: self._accept(request.body),
            "cancel": lambda request: self._cancel(cancel_reason(request.body)),
            "status": lambda request: self._status(),
            "why": self._telemetry.why,
        }
        self._desk = Desk(ours | dict(answers))

    def run(self, until: Callable[[], bool]) -> None:
        """Serve until `until()`. RfNavError when it cannot go on; InternalError for our own."""
        reason, trace = "the runtime ends", {}
        self._control.started()
        try:
            while not until():
                self._control.check()
                self._tell_changes()
                self._turn()
        except RfNavError as error:
            reason = str(error)
            self._control.fault(reason)
            raise
        except Exception as error:
            reason, trace = f"internal error: {error!r}", {"traceback": traceback.format_exc()}
            at = traceback.extract_tb(error.__traceback__)[-1]
            place = f"{Path(at.filename).name}:{at.lineno}"
            self._control.fault(f"{reason} at {place}")
            raise InternalError(f"internal error: {error!r} at {place}") from error
        finally:
            self._control.close()
            self._tell_changes()
            self._end(SearchState.ENDED, reason, **trace)
            self._detector.close()
            self._decisions.close()

    def _turn(self) -> None:
        request = self._bus.request()
        if request is not None:
            self._answer(request)  # and on: requests without end hold up no frame
        if self._garbage.due():
            with self._tracer.stage(Stage.GARBAGE):
                self._garbage.collect()
        if self._telemetry.due():
            self._telemetry.note(self._status())
        if self._drive is None:
            self._bus.wait_request(IDLE_S)
            return
        rests_s = self._seen_s + SURVEY_S - self._clock.now_s()
        if rests_s > 0:
            self._bus.wait_request(rests_s)
            return
        obs = self._bus.next(IDLE_S)
        self._drive.note_halt()
        if obs is not None:
            self._seen_s = self._clock.now_s()
            ends = self._drive.see(obs, self._bus.delivered_s() or self._seen_s)
            self._drive.note_overruns()
            if ends is not None and ends.ended is not None:
                self._end(ends.ended, ends.reason)

    def _tell_changes(self) -> None:
        """Log how the runtime's standing has changed, and journal it while a search is on."""
        for change in self._control.changes():
            was, now = change.before.in_words(), change.after.in_words()
            self._telemetry.stood(change.now_s, was, change.after.state, change.after.cause)
            if self._drive is not None:
                self._drive.search.journal.write("standing", at_s=change.now_s, was=was, now=now)

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
            self._end(SearchState.ENDED, f"a goal met an {told}")

    def _status(self) -> dict[str, object]:
        search = self._drive.search if self._drive else None
        latest = search or (self._last[0] if self._last else None)
        health = self._bus.health()
        return {
            **self._control.status(),
            "goal": search.goal.text if search else None,
            "decisions": latest.decisions if latest else 0,
            "rung": self._models.rung(),
            "detector": self._models.capabilities(),
            "models": self._models.health(),
            "streams": {t: vars(h) for t, h in health.items()},
            "stages": self._tracer.told(),
            "shed": self._shedding.told(),
            "journal_lost": latest.journal.lost if latest else "",
            "journal": latest.journal.path if latest else None,
            "elapsed_s": self._drive.elapsed_s() if self._drive else None,
            "driven_m": self._drive.feedback.driven_m if self._drive else None,
            **self._telemetry.told(),
        }

    def _accept(self, body: Mapping[str, Any]) -> dict[str, object]:
        before = self._drive.search if self._drive else self._last[0] if self._last else None
        charge = self._control.condition(forget=False).battery_percent
        if low := self._battery.refuses(charge):
            return {"accepted": False, "error": low}
        with self._detector.paused():  # no look while the words change
            try:
                order = understand(body, self._models, self._configure, self._terms)
                if self._drive is not None:
                    self._end(SearchState.PREEMPTED, "preempted")
                search = Search.begin(self._wiser(order), self._record)
            except RfNavError as error:
                return {"accepted": False, "error": str(error)}
            # Labels over the bus are of the newest image alone.
            self._detector.begin(newest_only=order.config.detector.source == "topic")
        if order.config.goal.keep_map and before is not None and before.world is not None:
            search.inherit(before.world, self._models)
        if not order.config.realtime.keep_stages:
            self._tracer.clear()
        self._bus.sweeps(order.config.navigate, order.config.camera)
        now_s = self._clock.now_s()
        self._control.condition()  # a hand of before it is none of its own
        drive = Drive(
            search, self._means(), Feedback(search, now_s), self._control.halts(),
            uncharged=charge is None,
        )  # fmt: skip
        self._drive = drive
        drive.plan(None, now_s, {"goal": order.goal.text, "mode": "wait"})
        self._telemetry.began(order.goal.text, order.goal.how)
        return {
            "accepted": True,
            "name": order.goal.name,
            "how": order.goal.how,
            "log_dir": str(order.log_dir) if order.log_dir else None,
        }

    def _means(self) -> Means:
        return Means(
            self._bus,
            self._control,
            self._models,
            self._clock,
            self._decisions,
            self._detector,
            self._tracer,
            self._shedding,
            self._battery,
            self._when_low,
            self._drawer,
            self._telemetry,
        )

    def _look(self, surveyed: Surveyed) -> Detections | None:
        """In the detectors' thread."""
        search = surveyed.asker
        assert isinstance(search, Search)
        return seen(search, surveyed.obs, self._models, self._bus, LABELS_S)

    def _wiser(self, order: Order) -> Order:
        """An order with what earlier searches taught of the experts."""
        config, cfg = order.config, order.config.navigate
        rule = self._hindsight.applied(cfg.consensus, config.panel.experts)
        return replace(order, config=replace(config, navigate=replace(cfg, consensus=rule)))

    def _cancel(self, reason: str) -> dict[str, object]:
        if self._drive is not None:
            return self._end(SearchState.CANCELLED, reason)
        if self._last is not None:
            return self._last[1]
        return {"ended": False, "error": "no search is under way"}

    def _end(self, state: SearchState, reason: str, **extra: object) -> dict[str, object]:
        """The base to rest, then everything written; the summary."""
        drive, self._drive = self._drive, None
        if drive is None:
            return {}
        facts: dict[str, object] = {"halts": self._control.halts(), "state": state}
        facts["frozen_frames"] = drive.frozen
        facts["rehearsals"] = drive.search.rehearsals
        facts["stages"], facts["shed"] = self._tracer.told(), self._shedding.told()
        world = drive.search.world
        if state is SearchState.FOUND and world is not None:
            choices, order = drive.search.choices, drive.search.order
            facts["reliance"] = self._hindsight.learn(world, choices, order.config.panel.experts)
        try:
            goal = drive.search.goal.text
            self._control.rest(state, {**drive.report, "goal": goal, "reason": reason})
            drive.tell(state, reason, always=True)
        finally:
            drive.search.billed(self._models)
            summary = drive.search.end(reason, **facts, **extra) | facts
            if state in OVER:  # not when another goal has taken its place, or a restart may go on
                self._models.finish()
        summary["elapsed_s"] = round(drive.feedback.elapsed_s(self._clock.now_s()), 3)
        self._last = drive.search, summary
        self._telemetry.ended(state, reason)
        self._garbage.collect_all()
        return summary
