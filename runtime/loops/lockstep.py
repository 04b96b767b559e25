"""The loop under a harness: one observation in, one action out; simulated time waits meanwhile.

Episodes begin with a request on `goal` and end with one on `cancel`, which is answered when the
journal and the map have been written.
"""

from collections.abc import Callable, Mapping, Sequence
from time import perf_counter
from typing import Any

from runtime import navigate
from runtime.clock import Clock, Deadline
from runtime.config import Config
from runtime.core.types import Observation, SearchState
from runtime.core.world import Command, World
from runtime.errors import ConfigError, RfNavError, SensorError
from runtime.loops.desk import NOTHING_ELSE, Answering, Desk
from runtime.loops.goal_request import STRICT, GoalRequest, Terms, cancel_reason
from runtime.loops.order import SearchModels, understand
from runtime.loops.ports import LockstepBus
from runtime.loops.search import Search, seen
from runtime.loops.told_panel import Asked, TellsVotes, ToldPanel
from runtime.record import Record, unrecorded
from runtime.service.limits import NO_LIMITS
from runtime.service.outcomes import GoalEnd, refused_for

LABELS_S = 10.0  # to the labels of an image, in lockstep


class Lockstep:
    """Answers requests and observations until it is told to end.

    A goal may bring settings of its own: `configure` makes the search's configuration of them.
    `answers`: of the kinds of requests that are answered without a search. `told`: who brings the
    votes of experts that are elsewhere.
    """

    def __init__(
        self,
        bus: LockstepBus,
        models: SearchModels,
        configure: Callable[[Sequence[str]], Config],
        clock: Clock,
        record: Record = unrecorded,
        terms: Terms = STRICT,
        answers: Mapping[str, Answering] = NOTHING_ELSE,
        told: TellsVotes | None = None,
    ) -> None:
        self._record, self._terms, self._told = record, terms, told
        self._bus, self._models, self._configure, self._clock = bus, models, configure, clock
        self._search: Search | None = None
        self._last: Search | None = None  # ended, for a goal that keeps its map
        ours: dict[str, Answering] = {
            "goal": lambda request: self._accept(request.body),
            "cancel": lambda request: self._cancel(cancel_reason(request.body)),
            "status": lambda request: self._status(),
        }
        self._desk = Desk(ours | dict(answers))

    def run(self, until: Callable[[], bool]) -> None:
        """Serve until `until()`; SensorError ends it when the first frame can never be used."""
        try:
            while not until():
                request = self._bus.request()
                if request is not None:
                    self._desk.answer(request)
                    continue
                obs = self._bus.next(0.5)
                if obs is not None and self._search is not None:
                    self._step(self._search, obs)
        finally:
            self._end("the runtime ends")  # what was found out is not lost

    # -- requests ------------------------------------------------------------------------------

    def _cancel(self, reason: str) -> dict[str, object]:
        summary = self._end(reason)
        self._models.finish()
        return summary

    def _status(self) -> dict[str, object]:
        health = self._bus.health()
        return {
            "state": SearchState.SEARCHING if self._search else SearchState.READY,
            "goal": self._search.goal.text if self._search else None,
            "rung": self._models.rung(),
            "detector": self._models.capabilities(),
            "models": self._models.health(),
            "streams": {t: vars(h) for t, h in health.items()},
        }

    def _accept(self, body: Mapping[str, Any]) -> dict[str, object]:
        try:
            _alone(self._terms.read(body))
            order = understand(body, self._models, self._configure, self._terms)
            if self._search is not None:
                self._end("preempted")
            search = Search.begin(order, self._record)
            if order.config.goal.keep_map and self._last is not None and self._last.world:
                search.inherit(self._last.world, self._models)
            self._search = search
        except RfNavError as error:
            return refused_for(error)
        self._bus.flush()
        return {"accepted": True, "name": order.named, "how": order.goal.how}

    def _end(self, reason: str) -> dict[str, object]:
        search, self._search = self._search, None
        if search is None:
            return {"ended": False, "error": "no search is under way"}
        self._last = search
        search.billed(self._models)
        end = GoalEnd(SearchState.CANCELLED, reason)
        last = search.world.body.last if search.world is not None else None
        if last is not None and last.ended is not None:
            end = GoalEnd(last.ended, last.reason, at_xy=last.toward_xy)
        told = {"result": end.result, "code": end.code}
        return search.end(reason, **told) | told

    # -- one step --------------------------------------------------------------------------------

    def _step(self, search: Search, obs: Observation) -> None:
        cfg = search.config.navigate
        if why := search.astray(obs):
            raise SensorError(why)
        began_s = perf_counter()
        obs = search.prepared(obs)
        detections = seen(search, obs, self._models, self._bus, LABELS_S)
        if detections is None:
            raise SensorError(f"detections: none came for an image in {LABELS_S:g} s")
        now_s = search.timed("detect", began_s)
        world = search.perceive(obs, detections, self._models)
        now_s = search.timed("map", now_s)
        why = navigate.due(world, cfg) if search.whereabouts.searching else ""
        if why:
            self._decide(search, world, why)
        now_s = search.timed("decide", now_s)
        command = navigate.steer(world, search.act(world), cfg)
        search.timed("plan", now_s)
        self._publish(search, world, command, perf_counter() - began_s)

    def _decide(self, search: Search, world: World, why: str) -> None:
        cfg = search.config.navigate
        snap = navigate.snapshot(world, why, cfg)
        self._record("question", {"why": why, "brief": snap.brief})
        panel: Asked = search.order.panel
        if (names := search.config.panel.told) and self._told is not None:
            panel = ToldPanel(panel, self._told, names, snap.frontiers)
        decision = navigate.decide(snap, panel, self._deadline(search), cfg)
        self._record("ballot", (decision.ballot, ""))
        self._bus.publish_decision(search.decided(decision, snap.brief, world))
        search.billed(self._models)

    def _deadline(self, search: Search) -> Deadline:
        """Simulated time stands still while the runtime thinks: without `budget_in_lockstep`
        experts run to completion, and runs repeat."""
        panel = search.config.panel
        if panel.budget_in_lockstep:
            return Deadline.after(panel.votes_s, self._clock)
        return Deadline.never(self._clock)

    def _publish(self, search: Search, world: World, command: Command, took_s: float) -> None:
        state = search.stepped(world, command, self._models.rung())
        told = {"took_s": took_s, "seconds": search.seconds, "models": self._models.health()}
        self._bus.publish_state({**state, **told})
        self._bus.publish_action(world.stamp_ns, command.action, command.twist)


def _alone(asked: GoalRequest) -> None:
    """ConfigError for what only real time has."""
    if len(asked.texts) > 1 or asked.limits != NO_LIMITS or asked.afterwards != "stay":
        raise ConfigError("goal request: one goal, without limits or afterwards, in lockstep")
