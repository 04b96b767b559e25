"""One search for one goal: how it begins, what it remembers, what it leaves behind. Both loops, in
lockstep and in real time, are made of it."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any, Protocol

import numpy as np

from runtime import navigate
from runtime.config import Config
from runtime.core.mapping.floor_plane import mount_by_floor
from runtime.core.mapping.keyframes import Keyframe
from runtime.core.mapping.solid_depth import solid
from runtime.core.objects.recall import embedded, recall
from runtime.core.objects.surfaces import surfaces_window
from runtime.core.optics.upright import upright_mount
from runtime.core.purpose import purpose_of
from runtime.core.types import (
    F64,
    Brief,
    Decision,
    Detections,
    Hint,
    Observation,
)
from runtime.core.world import Command, World
from runtime.errors import ConfigError
from runtime.experts.hindsight import CHOICES_KEPT, Choice
from runtime.journal import Journal, write_map
from runtime.log import say
from runtime.loops.order import Order, SearchModels
from runtime.loops.reports import explain, map_of, told_belief, told_command
from runtime.loops.whereabouts import Whereabouts
from runtime.perception.goal_words import Goal
from runtime.record import Record, unrecorded
from runtime.robot.labels import read_labels
from runtime.service.bounds import ANYWHERE
from runtime.service.outcomes import GoalEnd

JOURNAL_FILE = "decisions.jsonl"


class LabelBus(Protocol):
    """The bus, as far as labels come over it."""

    def labels(self, stamp_ns: int, timeout_s: float) -> dict[str, Any] | None:
        """The message on `labels` of that stamp; None when it does not come in time."""


@dataclass
class Search:
    """A search under way: its world, journal and timings (seconds by stage, summed)."""

    order: Order
    journal: Journal
    world: World | None = None
    start_xy: tuple[float, float] | None = None  # where it began, in the map
    decisions: int = 0
    rehearsals: dict[str, int] = field(default_factory=lambda: {"used": 0, "missed": 0})
    in_words: str = ""  # the newest decision
    choices: deque[Choice] = field(default_factory=lambda: deque(maxlen=CHOICES_KEPT))
    seconds: dict[str, float] = field(default_factory=dict)
    record: Record = unrecorded
    whereabouts: Whereabouts = field(default_factory=Whereabouts)
    first_look: bool = True  # is still to come
    handed: Keyframe | None = None  # the newest that who sees was handed

    @classmethod
    def begin(cls, order: Order, record: Record = unrecorded) -> "Search":
        """With a journal of its own; ConfigError when that cannot be written."""
        goal, path = order.goal, order.log_dir / JOURNAL_FILE if order.log_dir else None
        try:
            if path is not None:
                path.unlink(missing_ok=True)
        except OSError as error:
            raise ConfigError(f"{path}: cannot be replaced ({error.strerror})") from error
        journal = Journal(path)
        asked = {"id": order.id, "episode": order.episode, "limits": order.limits.told()}
        journal.write("goal", text=goal.text, name=goal.name, how=goal.how, **asked)
        record("order", {"goal": goal, "rooms": order.rooms})
        if order.bounds != ANYWHERE:
            record("heard", {"name": "bounds", "value": order.bounds})
            journal.write("bounds", **vars(order.bounds))
        whereabouts = Whereabouts(order.zones, order.bounds, order.binds, order.rooms)
        return cls(order, journal, record=record, whereabouts=whereabouts)

    @property
    def config(self) -> Config:
        return self.order.config

    @property
    def goal(self) -> Goal:
        return self.order.goal

    def timed(self, stage: str, since_s: float) -> float:
        """Book the time since `since_s`; returns now."""
        now_s = perf_counter()
        self.seconds[stage] = self.seconds.get(stage, 0.0) + now_s - since_s
        return now_s

    def perceive(self, obs: Observation, detections: Detections, models: SearchModels) -> World:
        """Add one observation, `prepared`, to the world, which begins with the first."""
        outline = self.survey(obs)
        return self.place(obs, detections, outline, models)

    def astray(self, obs: Observation) -> str:
        """Why an observation is none of this map's: its pose is farther off than a map may reach.
        "" for one that is."""
        reach_m = navigate.reach_m(self.config.navigate)
        if self.world is None or self.world.may_reach(obs.pose, reach_m):
            return ""
        at = f"({obs.pose.x_m:.1f}, {obs.pose.y_m:.1f})"
        return f"odometry tells {at} m, farther off than a map reaches"

    def survey(self, obs: Observation, led: bool = False) -> F64:
        """Add what depth tells; returns the view's outline, (V, 2) m, for `place`. `led`: somebody
        else drives."""
        cfg = self.config.navigate
        if self.world is None:
            self.world = self._first(obs)
        if self.start_xy is None:
            self.start_xy = obs.pose.x_m, obs.pose.y_m
        self.whereabouts.keep(self.world, self.journal, self.record)
        return navigate.survey(self.world, obs, obs.mount or self.config.camera, cfg, led)

    def place(
        self,
        obs: Observation,
        detections: Detections,
        outline: F64,
        models: SearchModels,
        ahead: bool = True,
    ) -> World:
        """Add what the detector tells of an observation that was surveyed; where there is time
        `ahead`, experts hear early of objects that are new."""
        world, cfg = self.world, self.config.navigate
        assert world is not None  # it was surveyed
        self.record("heard", {"name": "looked", "value": obs.stamp_ns})
        self.record("detections", detections)
        known, newest = dict(world.semantic.instances), world.semantic.next_id
        navigate.place(world, obs, detections, outline, obs.mount or self.config.camera, cfg)
        gone = [i for id, i in known.items() if id not in world.semantic.instances]
        if gone:
            told = [{"id": i.id, "name": i.name, "xy": i.xy} for i in gone]
            self.journal.write("gone", objects=told)
        if ahead and world.semantic.next_id != newest:
            names = sorted({i.name for i in world.semantic.instances.values()})
            models.notice(self.goal.name, tuple(names))
        if ahead or self.first_look:
            self._hand_over(world.keyframes, models)
        return world

    def _hand_over(self, frames: Sequence[Keyframe], models: SearchModels) -> None:
        """Keyframes, to who sees, where there is a new one since the last time. At the first look
        in any case: those of the search before are forgotten, or go on."""
        newest = frames[-1] if frames else None
        if self.first_look or newest is not self.handed:
            models.hold(frames)
        self.first_look, self.handed = False, newest

    def act(self, world: World) -> Command:
        """What to do now, where it may."""
        return self.whereabouts.act(world, self.config.navigate)

    def passed(self, elapsed_s: float, driven_m: float) -> GoalEnd | None:
        """How it ends by now, whatever is seen: by its limits, or lost."""
        return self.order.limits.passed(elapsed_s, driven_m) or self.whereabouts.lost(self.record)

    def inherit(self, before: World, models: SearchModels) -> None:
        """Begin with another search's map and memory, of the same odometry frame: what it has seen
        that is the new goal is gone to at once, and looked at again."""
        names = self.order.names
        world = self.world = World.begin_from(before, self.goal.name, names)
        known = frozenset(world.semantic.instances)
        world.explored.hint = Hint(self.goal.near, self.goal.rooms, known)
        world.explored.closer.wanted = self.goal.wanted
        things, rows = embedded(world.semantic)
        likeness = models.likeness(rows) if things else np.zeros((0, len(names)))
        self.record("heard", {"name": "likeness", "value": likeness})
        goal = self.goal.name
        recalled = recall(world.semantic, goal, names, likeness)
        called = world.semantic.called(goal)
        told = [{"id": i.id, "xy": i.xy, "p": round(i.confidence_of(goal), 4)} for i in called]
        self.journal.write(
            "memory", objects=len(world.semantic.instances), renamed=recalled, goal=told
        )

    def decided(
        self, decision: Decision, brief: Brief, world: World, rehearsal: str = ""
    ) -> dict[str, object]:
        """Adopt a decision and journal it; returns what is to be published. `rehearsal`: "used",
        why the one that was made was not, or "" for none."""
        navigate.adopt(world, decision)
        self.record("decision", decision)
        self.decisions += 1
        self.choices.append(Choice.of(decision, world.frontiers))
        report = explain(decision, world, self.config.navigate.consensus.rank)
        self.in_words = str(report["in_words"])
        if rehearsal:
            report["rehearsal"] = rehearsal
            self.rehearsals["used" if rehearsal == "used" else "missed"] += 1
        self.journal.write("decision", brief=brief, **report)
        return report

    def stepped(self, world: World, command: Command, rung: str) -> dict[str, object]:
        """Journal a step; returns the state that is to be published."""
        decision = world.standing.decision
        state: dict[str, object] = {
            "stamp_ns": world.stamp_ns,
            "step": world.body.step,
            "action": command.action.value,
            "mode": command.mode,
            "purpose": purpose_of(world, command),
            "reason": command.reason,
            "toward_xy": command.toward_xy,
            "frontier": decision.frontier if decision else None,
            "frontiers": len(world.frontiers),
            "objects": len(world.semantic.instances),
            "collisions": world.body.collisions,
            "rung": rung,
        }
        twist = command.twist
        if twist is not None:
            state |= {"v_mps": round(twist.v_mps, 4), "w_radps": round(twist.w_radps, 4)}
        at = world.pose
        pose = [round(v, 4) for v in (at.x_m, at.y_m, at.yaw_rad)]
        self.journal.write("step", pose=pose, **state)
        self.record("command", told_command(world, command))
        self.record("world", world)
        return state | {"belief": told_belief(decision)}

    def billed(self, models: SearchModels) -> None:
        """Journal what was asked of a cloud, and what it cost."""
        for bill in models.bills():
            self.journal.write("cloud", call=bill)

    def end(self, reason: str, **extra: object) -> dict[str, object]:
        """Close the journal and write the map; returns the summary that a cancel is answered."""
        self.journal.write("end", reason=reason, **extra)
        self.journal.close()
        return self._left_behind() | {
            "ended": True,
            "steps": self.world.body.step if self.world else 0,
            "decisions": self.decisions,
            "seconds": self.seconds,
            "collisions": self.world.body.collisions if self.world else 0,
        }

    def _left_behind(self) -> dict[str, object]:
        """Write the map; what could not be written, "" each for nothing."""
        lost = ""
        if self.world is not None and self.order.log_dir is not None:
            try:
                write_map(self.order.log_dir, *map_of(self.world, self.goal))
            except OSError as error:
                lost = f"{self.order.log_dir}: the map cannot be written ({error.strerror})"
                say(lost)
        return {"journal_lost": self.journal.lost, "map_lost": lost}

    def prepared(self, obs: Observation) -> Observation:
        """An image as all that comes after takes it: without flying pixels, and with where the
        camera was."""
        depth_m = obs.solid_m if obs.solid_m is not None else solid(obs.depth_m)
        obs = replace(obs, depth_m=depth_m, solid_m=None)
        camera = upright_mount(self.config.camera)
        if obs.mount is not None and camera.mount == "tf":
            return obs
        if camera.mount == "floor":
            last = self.world.lens[1] if self.world and self.world.lens else camera
            return replace(obs, mount=mount_by_floor(obs.depth_m, obs.intrinsics, camera, last))
        return replace(obs, mount=camera)

    def _first(self, obs: Observation) -> World:
        cfg = self.config.navigate
        goal, radius_m = self.goal, cfg.robot.radius_m
        world = World.begin(goal.name, self.order.names, self.order.rooms, obs.pose, radius_m)
        world.explored.hint = Hint(goal.near, goal.rooms)
        world.explored.closer.wanted = goal.wanted
        return world


def seen(
    search: Search, obs: Observation, models: SearchModels, bus: LabelBus, labels_s: float
) -> Detections | None:
    """What is in the image, by the detector or by labels from the bus; None when those do not come
    in time."""
    source = search.config.detector.source
    if source == "model":
        mount = obs.mount or search.config.camera
        return models.detect(obs.rgb, lambda: surfaces_window(obs, mount))
    labels = bus.labels(obs.stamp_ns, labels_s)
    told = None if labels is None else read_labels(labels, search.order.names, models.rooms)
    if told is None or source == "topic":
        return told
    ours = models.detect(obs.rgb)
    return replace(told, rooms=ours.rooms, scene=ours.scene, features=ours.features)
