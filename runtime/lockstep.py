"""The loop under a harness: one observation in, one action out; simulated time waits meanwhile.

Episodes begin with a request on `goal` and end with one on `cancel`, which is answered when the
journal and the map have been written.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import Any, Protocol

import numpy as np

from runtime import navigate
from runtime.config import Config
from runtime.core.types import U8, Action, Decision, Detections, Observation
from runtime.core.world import Command, World
from runtime.edge.bus import Bus, Request
from runtime.edge.clock import Clock, Deadline
from runtime.edge.journal import Journal, write_map
from runtime.edge.labels import read_labels
from runtime.edge.panel import Panel
from runtime.errors import ConfigError, RfNavError, SensorError
from runtime.goal import Goal

LABELS_S = 10.0  # to the labels of an image, in lockstep


class Mind(Protocol):
    """The models, as the loop needs them."""

    rooms: tuple[str, ...]

    def accept(self, goal: str, config: Config) -> tuple[Goal, Panel]:
        """Understand a goal, set the detector's vocabulary, seat and warm the experts."""

    def detect(self, rgb: U8) -> Detections: ...

    def notice(self, goal: str, names: tuple[str, ...]) -> None:
        """Objects that are on the map by now: score them in the background."""

    def rung(self) -> str:
        """Which rung of the ladder answers the experts."""


@dataclass
class Search:
    """One episode: its world, journal and timings (seconds by stage, summed)."""

    goal: Goal
    config: Config
    panel: Panel
    journal: Journal
    log_dir: Path
    world: World | None = None
    decisions: int = 0
    seconds: dict[str, float] = field(default_factory=dict)

    def timed(self, stage: str, since_s: float) -> float:
        """Book the time since `since_s`; returns now."""
        now_s = perf_counter()
        self.seconds[stage] = self.seconds.get(stage, 0.0) + now_s - since_s
        return now_s


class Lockstep:
    """Answers requests and observations until it is told to end.

    A goal may bring settings of its own: `configure` makes the search's configuration of them.
    """

    def __init__(
        self, bus: Bus, mind: Mind, configure: Callable[[Sequence[str]], Config], clock: Clock
    ) -> None:
        self._bus, self._mind, self._configure, self._clock = bus, mind, configure, clock
        self._search: Search | None = None
        self._names: tuple[str, ...] = ()

    def run(self, until: Callable[[], bool]) -> None:
        """Serve until `until()`; SensorError ends it when the first frame can never be used."""
        try:
            while not until():
                request = self._bus.request()
                if request is not None:
                    self._answer(request)
                    continue
                obs = self._bus.next(0.5)
                if obs is not None and self._search is not None:
                    self._step(self._search, obs)
        finally:
            self._end("the runtime ends")  # what was found out is not lost

    # -- requests ------------------------------------------------------------------------------

    def _answer(self, request: Request) -> None:
        if request.kind == "status":
            request.reply(self._status())
        elif request.kind == "goal":
            request.reply(self._accept(request.body))
        elif request.kind == "cancel":
            request.reply(self._end(str(request.body.get("reason", "cancelled"))))

    def _status(self) -> dict[str, object]:
        health = self._bus.health()
        return {
            "state": "searching" if self._search else "ready",
            "goal": self._search.goal.text if self._search else None,
            "rung": self._mind.rung(),
            "streams": {t: vars(h) for t, h in health.items()},
        }

    def _accept(self, body: Mapping[str, Any]) -> dict[str, object]:
        try:
            config = self._configure(_settings(body))
            goal, panel = self._mind.accept(_text(body, "goal"), config)
            log_dir = Path(_text(body, "log_dir"))
            if self._search is not None:
                self._end("preempted")
            journal_path = log_dir / "decisions.jsonl"
            journal_path.unlink(missing_ok=True)
            journal = Journal(journal_path)
        except RfNavError as error:
            return {"accepted": False, "error": str(error)}
        self._bus.flush()
        self._names = tuple(names[0] for names in goal.classes)
        self._search = Search(goal, config, panel, journal, log_dir)
        journal.write(
            "goal", text=goal.text, name=goal.name, how=goal.how, episode=body.get("episode")
        )
        return {"accepted": True, "name": goal.name, "how": goal.how}

    def _end(self, reason: str) -> dict[str, object]:
        search, self._search = self._search, None
        if search is None:
            return {"ended": False, "error": "no search is under way"}
        search.journal.write("end", reason=reason)
        search.journal.close()
        if search.world is not None:
            write_map(search.log_dir, *_map_of(search.world, search.goal))
        return {
            "ended": True,
            "steps": search.world.step if search.world else 0,
            "decisions": search.decisions,
            "seconds": search.seconds,
            "collisions": search.world.collisions if search.world else 0,
        }

    # -- one step --------------------------------------------------------------------------------

    def _step(self, search: Search, obs: Observation) -> None:
        cfg = search.config.navigate
        began_s = perf_counter()
        world = search.world
        if world is None:
            world = World.begin(
                search.goal.name,
                self._names,
                self._mind.rooms,
                obs.pose,
                cfg.explore.first_looks,
                cfg.robot.radius_m,
                cfg.map,
            )
            search.world = world
        detections = self._detect(search, obs)
        now_s = search.timed("detect", began_s)
        known = len(world.semantic.instances)
        navigate.perceive(world, obs, detections, search.config.camera, cfg)
        if len(world.semantic.instances) != known:
            names = sorted({i.name for i in world.semantic.instances.values()})
            self._mind.notice(search.goal.name, tuple(names))
        now_s = search.timed("map", now_s)
        why = navigate.due(world, cfg)
        if why:
            self._decide(search, world, why)
        now_s = search.timed("decide", now_s)
        command = navigate.act(world, cfg)
        search.timed("plan", now_s)
        self._publish(search, world, command, obs, perf_counter() - began_s)

    def _decide(self, search: Search, world: World, why: str) -> None:
        cfg = search.config.navigate
        snap = navigate.snapshot(world, why, cfg)
        decision = navigate.decide(snap, search.panel, self._deadline(search), cfg)
        navigate.adopt(world, decision, cfg)
        search.decisions += 1
        report = _explain(decision, world)
        search.journal.write("decision", brief=snap.brief, **report)
        self._bus.publish_decision(report)

    def _detect(self, search: Search, obs: Observation) -> Detections:
        if search.config.detector.source == "model":
            return self._mind.detect(obs.rgb)
        labels = self._bus.labels(obs.stamp_ns, LABELS_S)
        if labels is None:
            raise SensorError(f"detections: none came for an image in {LABELS_S:g} s")
        return read_labels(labels, self._names, self._mind.rooms)

    def _deadline(self, search: Search) -> Deadline:
        """Simulated time stands still while the runtime thinks: without `budget_in_lockstep`
        experts run to completion, and runs repeat."""
        panel = search.config.panel
        if panel.budget_in_lockstep:
            return Deadline.after(panel.decide_budget_s, self._clock)
        return Deadline.never(self._clock)

    def _publish(
        self, search: Search, world: World, command: Command, obs: Observation, took_s: float
    ) -> None:
        state: dict[str, object] = {
            "stamp_ns": obs.stamp_ns,
            "step": world.step,
            "action": command.action.value,
            "mode": command.mode,
            "reason": command.reason,
            "toward_xy": command.toward_xy,
            "frontier": world.decision.frontier if world.decision else None,
            "frontiers": len(world.frontiers),
            "objects": len(world.semantic.instances),
            "collisions": world.collisions,
            "rung": self._mind.rung(),
        }
        twist = command.twist if search.config.navigate.control.mode == "velocity" else None
        if twist is not None:
            state |= {"v_mps": round(twist.v_mps, 4), "w_radps": round(twist.w_radps, 4)}
        pose = [round(v, 4) for v in (obs.pose.x_m, obs.pose.y_m, obs.pose.yaw_rad)]
        search.journal.write("step", pose=pose, **state)
        self._bus.publish_state({**state, "took_s": took_s, "seconds": search.seconds})
        self._bus.publish_action(obs.stamp_ns, command.action, twist)


def _text(body: Mapping[str, Any], key: str) -> str:
    value = body.get(key)
    if not isinstance(value, str):
        raise ConfigError(f"goal request: {key}: must be text")
    return value


def _settings(body: Mapping[str, Any]) -> tuple[str, ...]:
    value = body.get("settings", [])
    if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
        raise ConfigError('goal request: settings: must be a list of "KEY=VALUE"')
    return tuple(value)


def _explain(decision: Decision, world: World) -> dict[str, object]:
    """A decision as it is published and logged: what was elected, by whom, and why."""
    return {
        "step": world.step,
        "stamp_ns": decision.stamp_ns,
        "why": decision.why,
        "frontier": decision.frontier,
        "rule": decision.rule,
        "chosen": decision.chosen,
        "closest": decision.closest,
        "votes": decision.ballot.votes,
        "missing": decision.ballot.missing,
        "latency_s": {k: round(v, 4) for k, v in decision.ballot.latency_s.items()},
        "frontiers": [
            {
                "id": f.id,
                "goal_xy": f.goal_xy,
                "distance_m": f.distance_m,
                "cells": len(f.cells_xy),
            }
            for f in world.frontiers
        ],
    }


def _map_of(world: World, goal: Goal) -> tuple[dict[str, np.ndarray[Any, Any]], dict[str, object]]:
    """What `map.npz` holds: grids over one frame, and the rest as metadata."""
    arrays: dict[str, np.ndarray[Any, Any]] = {
        "occupied": world.map.occupied,
        "free": world.map.free,
        "rooms": world.semantic.rooms.astype(np.float16),
        "path_xy": np.array(world.visited_xy).reshape(-1, 2),
        "planned_xy": world.last.path_xy if world.last else np.zeros((0, 2)),
    }
    frame = world.map.frame
    found = world.last is not None and world.last.action is Action.STOP
    meta: dict[str, object] = {
        "goal": goal.text,
        "goal_name": goal.name,
        "frame": frame,
        "room_names": world.semantic.room_names,
        "pose": world.pose,
        "frontiers": [
            {"id": f.id, "cells_xy": f.cells_xy.round(3), "distance_m": f.distance_m}
            for f in world.frontiers
        ],
        "elected": world.decision.frontier if world.decision else None,
        "stopped_at": world.last.toward_xy if world.last is not None and found else None,
        "objects": [
            {
                "id": i.id,
                "name": i.name,
                "confidence": round(i.confidence, 4),
                "xy": i.xy,
                "z_m": i.z_m,
                "views": len(i.views),
                "rejections": i.rejections,
                "cells_xy": i.cells_xy.round(3),
            }
            for i in world.semantic.instances.values()
        ],
    }
    return arrays, meta
