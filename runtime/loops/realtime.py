"""The loop on a robot: three rates in one process. The control loop drives 20 times a second, this
thread perceives every newest frame and plans, and a worker decides while the robot keeps going.

This thread owns the world. A search begins with a request on `goal` and ends when it is found, when
nothing is left to explore, or by a request on `cancel`.
"""

import math
import os
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from runtime import navigate
from runtime.clock import Clock, Deadline
from runtime.config import Config
from runtime.core.geometry import wrap_angle
from runtime.core.local_policy import as_sent, limited
from runtime.core.types import Ballot, Brief, Observation, SearchState
from runtime.core.voting import consensus, rehearsal
from runtime.core.world import Command, World
from runtime.errors import InternalError, RfNavError
from runtime.experts.hindsight import Hindsight
from runtime.loops.control_loop import ControlLoop, Plan
from runtime.loops.decision_worker import DecisionRequest, DecisionWorker
from runtime.loops.search import Order, Search, SearchModels, seen, understand
from runtime.robot.bus import Bus, Request

IDLE_S = 0.2  # how often the loop looks at what is not the bus
FEEDBACK_S = 1.0  # between messages on rfnav/feedback
LABELS_S = 0.2  # labels of an image, where they come over the bus
WORKER_NICE = 10
OVER = (SearchState.FOUND, SearchState.NOT_FOUND, SearchState.CANCELLED)
FROZEN_M, FROZEN_RAD = 0.05, 0.05  # a camera that moved so far sees something else


class _Nobody:
    """The panel before any expert was asked: the fallback decides."""

    def ask(self, brief: Brief, by: None) -> Ballot:
        return Ballot()


@dataclass
class _Drive:
    """A search on the road."""

    search: Search
    began_s: float
    report: dict[str, object] = field(default_factory=dict)  # of the newest step
    halts: dict[str, int] = field(default_factory=dict)  # by kind, as journaled last
    fresh: Observation | None = None  # the newest that showed something new
    frozen: int = 0  # frames that did not, although the robot had moved
    told_s: float = -1e9  # when feedback was published last
    told: tuple[object, ...] = field(default=())  # and what of it a change is worth a message


class RealTime:
    """Serves goals until it is told to end. Whatever ends it, the base is brought to rest first."""

    def __init__(
        self,
        bus: Bus,
        control: ControlLoop,
        models: SearchModels,
        configure: Callable[[Sequence[str]], Config],
        clock: Clock,
    ) -> None:
        self._bus, self._control, self._models = bus, control, models
        self._configure, self._clock = configure, clock
        self._drive: _Drive | None = None
        self._last: tuple[Search, dict[str, object]] | None = None  # ended, and its summary
        self._worker = DecisionWorker(WORKER_NICE)
        self._hindsight = Hindsight()
        self._rehearsed_s = -math.inf  # when the last rehearsal began

    def run(self, until: Callable[[], bool]) -> None:
        """Serve until `until()`. RfNavError when it cannot go on; InternalError for our own."""
        reason, trace = "the runtime ends", {}
        try:
            while not until():
                self._control.check()
                self._turn()
        except RfNavError as error:
            reason = str(error)
            raise
        except Exception as error:
            reason, trace = f"internal error: {error!r}", {"traceback": traceback.format_exc()}
            at = traceback.extract_tb(error.__traceback__)[-1]
            place = f"{Path(at.filename).name}:{at.lineno}"
            raise InternalError(f"internal error: {error!r} at {place}") from error
        finally:
            self._control.close()
            self._end(SearchState.ENDED, reason, **trace)
            self._worker.close()

    def _turn(self) -> None:
        request = self._bus.request()
        if request is not None:
            self._answer(request)
            return
        if self._drive is None:
            self._bus.wait_request(IDLE_S)
            return
        obs = self._bus.next(IDLE_S)
        self._note_halt(self._drive)
        if obs is not None:
            self._see(self._drive, obs)

    # -- requests ------------------------------------------------------------------------------

    def _answer(self, request: Request) -> None:
        if request.kind == "status":
            request.reply(self._status())
        elif request.kind == "goal":
            request.reply(self._accept(request.body))
        elif request.kind == "cancel":
            request.reply(self._cancel(str(request.body.get("reason", "cancelled"))))

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
        }

    def _accept(self, body: Mapping[str, Any]) -> dict[str, object]:
        try:
            order = understand(body, self._models, self._configure, _default_dir())
            before = self._drive.search if self._drive else None
            if self._drive is not None:
                self._end(SearchState.PREEMPTED, "preempted")
            before = before or (self._last[0] if self._last else None)
            search = Search.begin(self._wiser(order))
        except RfNavError as error:
            return {"accepted": False, "error": str(error)}
        if order.config.goal.keep_map and before is not None and before.world is not None:
            search.inherit(before.world, self._models)
        now_s = self._clock.now_s()
        self._drive = _Drive(search, now_s, halts=self._control.halts())
        self._plan(search, None, now_s, {"goal": order.goal.text, "mode": "wait"})
        return {
            "accepted": True,
            "name": order.goal.name,
            "how": order.goal.how,
            "log_dir": str(order.log_dir),
        }

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
        world = drive.search.world
        if state is SearchState.FOUND and world is not None:
            choices, order = drive.search.choices, drive.search.order
            facts["reliance"] = self._hindsight.learn(world, choices, order.config.panel.experts)
        try:
            goal = drive.search.goal.text
            self._control.rest(state, {**drive.report, "goal": goal, "reason": reason})
            self._tell(drive, state, reason, always=True)
        finally:
            drive.search.billed(self._models)
            summary = drive.search.end(reason, **facts, **extra) | facts
            if state in OVER:  # not when another goal has taken its place, or a restart may go on
                self._models.finish()
        summary["elapsed_s"] = round(self._clock.now_s() - drive.began_s, 3)
        self._last = drive.search, summary
        return summary

    # -- one frame -----------------------------------------------------------------------------

    def _see(self, drive: _Drive, obs: Observation) -> None:
        search, frame_s = drive.search, self._bus.delivered_s() or self._clock.now_s()
        cfg, began_s = search.config.navigate, perf_counter()
        if _frozen(drive.fresh, obs):
            drive.frozen += 1
            return  # the plan grows old, and that holds the base
        drive.fresh = obs
        obs = search.prepared(obs)
        detections = seen(search, obs, self._models, self._bus, LABELS_S)
        if detections is None:
            return
        now_s = search.timed("detect", began_s)
        if search.world is not None:
            search.world.body.asked_mps = self._control.asked_mps()
        world = search.perceive(obs, detections, self._models)
        now_s = search.timed("map", now_s)
        self._decide(search, world)
        now_s = search.timed("decide", now_s)
        command = navigate.act(world, cfg)
        search.timed("plan", now_s)
        self._follow(drive, world, command, frame_s)

    def _decide(self, search: Search, world: World) -> None:
        """Adopt what was decided meanwhile, and begin to decide when that is due. The robot does
        not wait for the first vote: the fallback's choice is followed until it comes."""
        cfg = search.config
        answer = self._worker.take()
        if answer is not None and answer.question.asker is search:
            brief = answer.question.snapshot.brief
            report = search.decided(answer.decision, brief, world, answer.rehearsal)
            self._bus.publish_decision(report)
            search.billed(self._models)
        why = "" if self._worker.busy else navigate.due(world, cfg.navigate)
        if not why:
            self._rehearse(search, world)
            return
        snap = navigate.snapshot(world, why, cfg.navigate)
        if world.standing.decision is None:
            first = navigate.decide(snap, _Nobody(), None, cfg.navigate)
            navigate.adopt(world, first)
        by = Deadline.after(cfg.panel.votes_s, self._clock)
        panel = search.order.panel
        self._worker.ask(DecisionRequest(search, snap, panel, by, cfg.navigate))

    def _rehearse(self, search: Search, world: World) -> None:
        """On the way to a frontier: the next decision, for the map without it. Only where votes
        are slow."""
        cfg, standing = search.config, world.standing.decision
        if standing is None or not self._worker.idle:
            return
        now_s = self._clock.now_s()
        rested = now_s - self._rehearsed_s >= rehearsal.EVERY_S
        if not rested or not rehearsal.worthwhile(standing.ballot):
            return
        aim = consensus.successor(standing, world.frontiers, cfg.navigate.consensus.rank)
        if aim is None:
            return
        self._rehearsed_s = now_s
        snap = navigate.snapshot(world, "rehearsal", cfg.navigate)
        brief = rehearsal.expected(snap.brief, aim)
        if len(brief.frontiers) < 2:
            return  # nothing to choose
        by = Deadline.after(cfg.panel.votes_s, self._clock)
        panel, snap = search.order.panel, replace(snap, brief=brief)
        question = DecisionRequest(search, snap, panel, by, cfg.navigate, without=aim)
        self._worker.rehearse(question)

    def _follow(self, drive: _Drive, world: World, command: Command, frame_s: float) -> None:
        """Have the control loop follow the command's course; booked is what it sent last."""
        command = world.body.told(as_sent(command, self._control.sent()))
        report = drive.search.stepped(world, command, self._models.rung())
        seconds = dict(drive.search.seconds)
        told = {"seconds": seconds, "models": self._models.health()}
        drive.report = report | {"goal": drive.search.goal.text, **told}
        if command.ended is not None:
            self._end(command.ended, command.reason)
            return
        self._plan(drive.search, command, frame_s, drive.report)
        self._tell(drive, SearchState.SEARCHING, command.reason)

    def _plan(
        self, search: Search, command: Command | None, frame_s: float, report: dict[str, object]
    ) -> None:
        cfg, world = search.config.navigate, search.world
        limits = limited(world, cfg) if world is not None else cfg.control
        course = command.course if command else None
        self._control.follow(Plan(course, frame_s, cfg.robot.radius_m, limits, report))

    # -- what others hear ----------------------------------------------------------------------

    def _tell(self, drive: _Drive, state: SearchState, reason: str, always: bool = False) -> None:
        """Feedback on the goal: at changes, and every now and then."""
        now_s, world = self._clock.now_s(), drive.search.world
        command = world.body.last if world else None
        told = state, command.mode if command else "", command.toward_xy if command else None
        rested = now_s - drive.told_s >= FEEDBACK_S
        if not (always or rested or told[:2] != drive.told[:2]):
            return
        drive.told, drive.told_s = told, now_s
        track = np.array(world.body.visited_xy) if world else np.zeros((0, 2))
        driven_m = float(np.hypot(*np.diff(track, axis=0).T).sum()) if len(track) > 1 else 0.0
        self._bus.publish_feedback(
            {
                "goal": drive.search.goal.text,
                "state": state,
                "mode": told[1],
                "reason": reason,
                "toward_xy": told[2],
                "elapsed_s": round(now_s - drive.began_s, 3),
                "driven_m": round(driven_m, 3),
                "decisions": drive.search.decisions,
            }
        )

    def _note_halt(self, drive: _Drive) -> None:
        """Journal when the base was held since the last look."""
        halts = self._control.halts()
        if halts != drive.halts:
            drive.search.journal.write("halt", halts=halts, reason=self._control.halted())
            drive.halts = halts


def _frozen(before: Observation | None, obs: Observation) -> bool:
    """Whether a camera shows, from elsewhere, exactly what it showed before."""
    if before is None or not np.array_equal(before.depth_m, obs.depth_m):
        return False
    a, b = before.pose, obs.pose
    moved = math.hypot(b.x_m - a.x_m, b.y_m - a.y_m) > FROZEN_M
    turned = abs(wrap_angle(b.yaw_rad - a.yaw_rad)) > FROZEN_RAD
    return (moved or turned) and np.array_equal(before.rgb, obs.rgb)


def _default_dir() -> Path:
    """Where a search that names no log_dir leaves its journal and map."""
    state = Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state")
    return state / "rf-nav" / "searches" / time.strftime("%Y%m%d-%H%M%S")
