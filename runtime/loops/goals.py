"""The life of a goal: taken on, waited for, paused, ended, and what is told of that. In the thread
that owns the world.

A goal that fails, or is not found, is followed by the next that waits; one that is cancelled by no
name takes those along, and so does one that a newer takes the place of.
"""

import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Literal

from runtime.config import Config
from runtime.core.types import SearchState
from runtime.errors import RfNavError, SavedError
from runtime.experts.hindsight import Hindsight
from runtime.log import say
from runtime.loops.drive import Drive
from runtime.loops.feedback import Feedback
from runtime.loops.goal_request import STRICT, Terms, cancel_reason
from runtime.loops.leaving import Leaving
from runtime.loops.means import Means
from runtime.loops.order import Order, alone, hear_all, understand
from runtime.loops.process import Garbage
from runtime.loops.search import Search
from runtime.record import Record
from runtime.robot.requests import ENDS, Request
from runtime.service.bounds import tells_where
from runtime.service.goal_queue import AskedGoal, GoalFile, GoalQueue, is_id, new_id
from runtime.service.outcomes import FailCause, GoalEnd, Refusal, failed_for, refused, refused_for
from runtime.service.results import GoalResults

TRIES: Final = 3  # searches for one goal, restarts between them
ASKED_ON: Final = "rfnav/pause"
NOTHING_ON: Final = "no search is under way"


@dataclass(frozen=True)
class Custom:
    """What is usual with goals here. `file`: where they are kept for a restart, if anywhere;
    `after_restart`: what becomes of those then; `new_id`: what the next is called."""

    terms: Terms
    file: GoalFile | None = None
    after_restart: Literal["fail", "resume"] = "fail"
    new_id: Callable[[], str] = new_id


USUAL: Final = Custom(STRICT)


class GoalLife:
    """`drive`: the search under way, if any."""

    def __init__(
        self,
        means: Means,
        configure: Callable[[Sequence[str]], Config],
        garbage: Garbage,
        record: Record,
        custom: Custom,
    ) -> None:
        self._means, self._configure, self._garbage = means, configure, garbage
        self._record, self._custom = record, custom
        self._queue = GoalQueue(custom.file.keep if custom.file is not None else lambda goals: None)
        self._results, self._hindsight = GoalResults(), Hindsight()
        self._last: tuple[Search, dict[str, object]] | None = None  # ended, and its summary
        self.drive: Drive | None = None

    # -- beginning -----------------------------------------------------------------------------

    def accept(self, body: Mapping[str, Any]) -> dict[str, object]:
        """Begin what is asked for, or have it wait; the answer."""
        charge = self._means.control.condition(forget=False).battery_percent
        if low := self._means.battery.refuses(charge):
            return refused(Refusal.BATTERY, low)
        if unbound := self._custom.terms.zones.unbound():
            return refused(Refusal.NOT_LOCALISED, unbound)
        try:
            asked = self._custom.terms.read(body)
            self._custom.terms.zones.bounds(asked.binds, self._means.models.rooms)
            goals = hear_all(asked, self._means.models, self._configure, self._record)
        except RfNavError as error:
            return refused_for(error)
        busy = self.drive is not None or bool(self._queue.waiting)
        if busy and asked.if_busy == "refuse":
            return refused(Refusal.BUSY, "another goal is under way, and if_busy is refuse")
        queued = busy and asked.if_busy == "queue"
        asked_for = [
            AskedGoal(self._new_id(), goal.text, alone(body, goal.text, n))
            for n, goal in enumerate(goals)
        ]
        first, *then = asked_for
        if full := self._queue.full(len(asked_for if queued else then), queued, asked.queue_most):
            return refused(Refusal.FULL, full)
        told: dict[str, object]
        if queued:
            told = {"name": goals[0].name, "how": goals[0].how, "log_dir": None}
            place = len(self._queue.waiting) + (self.drive is not None)
            self._queue.wait(asked_for)
        else:
            try:
                told, place = self._begin(first, then, preempts=True), 0
            except RfNavError as error:
                return refused_for(error)
        if then:
            names = [{"name": goal.name, "how": goal.how} for goal in goals[1:]]
            told["then"] = [{"id": g.id, **name} for g, name in zip(then, names, strict=True)]
        return {"accepted": True, "id": first.id, "queued": place, **told}

    def _new_id(self) -> str:
        id = self._custom.new_id()
        self._record("heard", {"name": "id", "value": id})
        return id

    def _begin(
        self, goal: AskedGoal, then: Sequence[AskedGoal] = (), preempts: bool = False
    ) -> dict[str, object]:
        """Search for it from now on, perhaps in place of all that was asked for before; what is
        told of that. RfNavError when it cannot be begun: then what is under way goes on, unless
        it is the journal that cannot be written."""
        means, before = self._means, self.newest()
        usd = means.spent_usd()  # what is accepted next has an account of its own
        charge = means.control.condition(forget=False).battery_percent
        with means.detector.paused():  # no look while the words change
            order = understand(
                goal.body, means.models, self._configure, self._custom.terms, goal.id
            )
            if preempts:
                self._give_way(usd)
            search = Search.begin(self._wiser(order), self._record)
            # Labels over the bus are of the newest image alone.
            means.detector.begin(newest_only=order.config.detector.source != "model")
        world = before.world if before is not None and order.config.goal.keep_map else None
        if world is not None and (means.memory is None or means.memory.holds(world)):
            search.inherit(world, means.models)
        if not order.config.realtime.keep_stages:
            means.tracer.clear()
        means.bus.sweeps(order.config.navigate, order.config.camera)
        now_s = means.clock.now_s()
        means.control.condition()  # a hand of before it is none of its own
        feedback = Feedback.of(search, now_s)
        way = Leaving(search, means.when_low == "return")
        drive = Drive(search, means, feedback, means.control.halts(), way, uncharged=charge is None)
        self.drive = drive
        self._queue.begin(goal, then)
        means.telemetry.began(order.goal.text, order.goal.how, goal.id)
        drive.plan(None, now_s, {"goal": order.goal.text, "mode": "wait"})
        if goal.paused:
            drive.pause(ASKED_ON)
        log_dir = str(order.log_dir) if order.log_dir else None
        return {"name": order.named, "how": order.goal.how, "log_dir": log_dir}

    def _give_way(self, usd: float) -> None:
        """To a newer goal. `usd`: what the one under way has cost."""
        if self.drive is not None:
            self.drive.usd = usd
        self.end(GoalEnd(SearchState.PREEMPTED, "preempted"))
        for goal in self._queue.drop():
            self._file(goal, GoalEnd(SearchState.PREEMPTED, "preempted"))

    def next(self) -> None:
        """Begin with the next goal that waits, if nothing is under way. While nobody knows where
        the robot is on its saved map, all wait."""
        if self.drive is not None or not self._queue.waiting or self._custom.terms.zones.unbound():
            return
        while self.drive is None and (goal := self._queue.next()) is not None:
            charge = self._means.control.condition(forget=False).battery_percent
            why, cause = self._means.battery.refuses(charge), FailCause.BATTERY
            try:
                if not why:
                    self._begin(goal)
            except RfNavError as error:
                why, cause = str(error), failed_for(error)
            except Exception as error:  # noqa: BLE001 -- said, and it ends no more than the goal
                why, cause = f"internal error: {error!r}", FailCause.FAULT
                say(f"goal: {why}\n{traceback.format_exc()}")
            if why:
                self._file(goal, GoalEnd(SearchState.FAILED, why, cause))
                self._queue.ended()

    def restore(self) -> None:
        """Take on again, or report as failed, what the process before has left."""
        custom = self._custom
        kept: tuple[AskedGoal, ...] = ()
        try:
            kept = custom.file.kept() if custom.file is not None else ()
        except SavedError as error:
            say(str(error))
        why = {goal.id: self._no_more(goal) for goal in kept}
        self._queue.wait(goal for goal in kept if not why[goal.id])
        for goal in kept:
            if why[goal.id]:
                self._file(goal, GoalEnd(SearchState.FAILED, why[goal.id], FailCause.RESTART))

    def _no_more(self, goal: AskedGoal) -> str:
        """Why it does not go on after a restart."""
        if self._custom.after_restart != "resume":
            return "the runtime was started anew, and goal.after_restart is fail"
        if goal.begun >= TRIES:
            return f"{goal.begun} searches for it ended with the runtime"
        if tells_where(goal.body):
            return (
                "the runtime was started anew, and where it was to be was told in metres of before"
            )
        return ""

    # -- while it lasts ------------------------------------------------------------------------

    def pause(self, request: Request) -> dict[str, object]:
        """Stand until told to go on: rfnav/pause."""
        return self._paused(request, ASKED_ON)

    def resume(self, request: Request) -> dict[str, object]:
        """Go on: rfnav/resume."""
        return self._paused(request, "")

    def _paused(self, request: Request, by: str) -> dict[str, object]:
        id, now = request.body.get("id"), self._queue.now
        if self.drive is None or now is None or id not in (None, now.id):
            return {"paused": False, "error": NOTHING_ON if id is None else _unknown(id)}
        self.drive.pause(by)
        self._queue.pause(bool(by))
        return {"paused": bool(by), "id": now.id}

    def result(self, request: Request) -> Mapping[str, object] | None:
        """Of the goal of that id, or of the newest; None: when it has ended. With {"wait": false}
        it is how it stands by now, else."""
        now, id = self._queue.now, request.body.get("id")
        if id is None:
            id = now.id if now is not None else (self._results.last or {}).get("id")
        if id is None:
            return {"error": "no goal was asked for yet"}
        if not is_id(id):
            return {"error": _unknown(id)}
        if (told := self._results.of(id)) is not None:
            return told
        ahead = [goal.id for goal in (*((now,) if now else ()), *self._queue.waiting)]
        if id not in ahead:
            return {"error": _unknown(id)}
        if request.body.get("wait") is False:
            newest = self.drive.feedback.newest if self.drive and now and id == now.id else {}
            return {"id": id, "result": None, "ahead": ahead.index(id), "feedback": newest}
        self._results.wait(id, request)
        return None

    def told(self) -> dict[str, object]:
        """For rfnav/status."""
        search = self.drive.search if self.drive else None
        latest = self.newest()
        return {
            "goal": search.goal.text if search else None,
            "id": search.order.id if search else None,
            "paused": self.drive.paused if self.drive else "",
            "refuses": self._custom.terms.zones.unbound(),
            "queue": self._queue.told(),
            "last": self._results.last,
            "decisions": latest.decisions if latest else 0,
            "journal_lost": latest.journal.lost if latest else "",
            "journal": latest.journal.path if latest else None,
            "elapsed_s": self.drive.elapsed_s() if self.drive else None,
            "driven_m": self.drive.feedback.way_m() if self.drive else None,
        }

    def newest(self) -> Search | None:
        """The newest search."""
        return self.drive.search if self.drive else self._last[0] if self._last else None

    def _wiser(self, order: Order) -> Order:
        """An order with what earlier searches taught of the experts."""
        config, cfg = order.config, order.config.navigate
        rule = self._hindsight.applied(cfg.consensus, config.panel.experts)
        return replace(order, config=replace(config, navigate=replace(cfg, consensus=rule)))

    # -- ending --------------------------------------------------------------------------------

    def cancel(self, request: Request) -> dict[str, object]:
        """The goal of that id, or all of them; what is left of the one under way."""
        id, now = request.body.get("id"), self._queue.now
        end = GoalEnd(SearchState.CANCELLED, cancel_reason(request.body))
        under_way = self.drive is not None and now is not None and id in (None, now.id)
        dropped = self._queue.drop(id)
        for goal in dropped:
            self._file(goal, end)
        if under_way:
            return self.end(end)
        if dropped:
            return {"ended": True, "cancelled": [goal.id for goal in dropped]}
        if id is None and self._last is not None:
            return self._last[1] | {"ended": False}
        return {"ended": False, "error": NOTHING_ON if id is None else _unknown(id)}

    def end(self, end: GoalEnd, goes_on: bool = False, **extra: object) -> dict[str, object]:
        """The base to rest, then everything written; the summary. `goes_on`: after a restart, and
        so it has no result yet."""
        drive, self.drive = self.drive, None
        if drive is None:
            return {}
        means, search, state = self._means, drive.search, end.state
        facts: dict[str, object] = {"halts": means.control.halts(), "state": state}
        facts |= {"frozen_frames": drive.camera.repeated, "rehearsals": search.rehearsals}
        facts["stages"], facts["shed"] = means.tracer.told(), means.shedding.told()
        if state is SearchState.FOUND and search.world is not None:
            experts = search.order.config.panel.experts
            facts["reliance"] = self._hindsight.learn(search.world, search.choices, experts)
        told: dict[str, object] = {}
        try:
            goal = {"goal": search.goal.text, "id": search.order.id}
            means.control.rest(state, {**drive.report, **goal, "reason": end.reason})
            if not goes_on:
                told = end.told(search.order.id, search.goal.text, drive.facts())
            drive.tell(state, end.reason, always=True, result=told)
        finally:
            if means.memory is not None:
                means.memory.ended(search)
            search.billed(means.models)
            left = facts | {name: value for name, value in told.items() if name != "reason"}
            summary = search.end(end.reason, **left, **extra) | left
            if state.over:  # not when another goal has taken its place, or a restart may go on
                means.models.finish()
        summary["elapsed_s"] = round(drive.feedback.elapsed_s(means.clock.now_s()), 3)
        self._last = search, summary
        if not goes_on:
            self._queue.ended()
            self._hear(told)
        self._garbage.collect_all()
        return summary

    def close(self, end: GoalEnd, **extra: object) -> None:
        """The runtime ends. What a restart goes on with has no result yet."""
        goes_on = self._custom.file is not None and self._custom.after_restart == "resume"
        self.end(end, goes_on, **extra)
        for goal in () if goes_on else self._queue.drop():
            self._file(goal, end)
        self._results.close(f"{ENDS}: the goal goes on when it is started again")

    def _file(self, goal: AskedGoal, end: GoalEnd) -> None:
        """A goal ends for which no search is under way."""
        told = end.told(goal.id, goal.text, {})
        self._means.bus.publish_feedback({"state": end.result, **told})
        self._hear(told)

    def _hear(self, told: Mapping[str, object]) -> None:
        """Whoever is to hear of a result does."""
        self._means.telemetry.ended(str(told["result"]), str(told["sentence"]), str(told["id"]))
        self._results.file(told)


def _unknown(id: object) -> str:
    return f"no goal {str(id)[:40]!r} is known"
