"""The faults of one run, as they come and go: what they change in the world, in what is sensed, on
the link and at the base."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from hil_sim.scenes.format import Scene
from hil_sim.simulation.body import Body, closed_door, opening_ahead, person_in, person_near, walk
from hil_sim.simulation.faults import Fault, Sensed, When
from hil_sim.simulation.noise import generator
from hil_sim.simulation.robot import Ground
from runtime.core.types import Pose

DOOR_CLEAR_M = 0.3
SILENT, SHIFTED = ("odometry-stop", "link-lost"), ("odometry-jump", "clock-step")
WITH_BODIES = ("person", "door-closes", "person-stands", "stairwell")
NO_IMAGE, NO_DEPTH = np.zeros((0, 0, 3), np.uint8), np.zeros((0, 0), np.float32)
Populate = Callable[[tuple[Body, ...]], None]


@dataclass
class Mishaps:
    """State of a run's faults. `populate` puts bodies into the world, and no others."""

    faults: tuple[Fault, ...]
    seed: int
    episode: str
    scene: Scene
    ground: Ground
    populate: Populate
    _since: dict[str, When] = field(default_factory=dict)
    bodies: tuple[Body, ...] = ()  # in the world now
    _began: dict[str, Sensed] = field(default_factory=dict)
    _person: Body | None = None
    _door: Body | None = None
    _opening: Body | None = None
    _walked_s: float = 0.0

    def active(self, name: str, when: When) -> Fault | None:
        """The fault of that name, while it lasts."""
        return next((f for f in self.faults if f.name == name and self._lasts(f, when)), None)

    def move_bodies(self, when: When, robot: Pose) -> None:
        """Let the person walk, the door close and the floor open, before the world is looked at."""
        if not any(fault.name in WITH_BODIES for fault in self.faults):
            return
        closed = self.active("door-closes", when)
        filled = closed or self.active("person-stands", when)
        if filled is None:
            self._door = None
        elif self._door is None:
            door = closed_door(self.scene, robot, DOOR_CLEAR_M)
            self._door = door if closed or door is None else person_in(door)
        if self.active("stairwell", when) is None:
            self._opening = None
        elif self._opening is None:
            self._opening = opening_ahead(robot, self.ground)
        others = tuple(body for body in (self._door, self._opening) if body)
        self.populate(others)
        person = self.active("person", when)
        rng = generator(self.seed, self.episode, when.step, "person")
        if person is None:
            self._person = None
        elif self._person is None:
            self._person = person_near(robot, self.ground, rng)
        else:
            way_m = person.size * max(0.0, when.now_s - self._walked_s)
            self._person = walk(self._person, way_m, self.ground, robot, rng)
        self._walked_s = when.now_s
        self.bodies = (*others, self._person) if self._person else others
        self.populate(self.bodies)

    def sense(self, when: When, sensed: Sensed) -> Sensed | None:
        """What is sent instead; None when nothing is."""
        found: Sensed | None = sensed
        for fault in self.faults:
            if fault.kind.spoil is None:
                continue
            if not self._lasts(fault, when):
                self._began.pop(fault.text, None)
                continue
            then = self._began.setdefault(fault.text, sensed)
            found = fault.kind.spoil(found, then, fault.size) if found is not None else None
        return found

    def odometry(self, when: When, pose: Pose, stamp_ns: int) -> tuple[Pose, int] | None:
        """An odometry message of its own, as real time has them; None when none is sent."""
        for fault in self.faults:
            if fault.name in SILENT and self._lasts(fault, when):
                return None
            if fault.name in SHIFTED and fault.kind.spoil and self._lasts(fault, when):
                now = Sensed(NO_IMAGE, NO_DEPTH, pose, stamp_ns)
                told = fault.kind.spoil(now, now, fault.size)
                assert told is not None
                pose, stamp_ns = told.odometry, told.stamp_ns
        return pose, stamp_ns

    def deaf(self, when: When) -> bool:
        """Whether the base ignores its command."""
        return self.active("base-deaf", when) is not None

    def _lasts(self, fault: Fault, when: When) -> bool:
        """Whether it has begun and not ended; asked at every observation."""
        if fault.at.of(when) < fault.at.value:
            return False
        since = self._since.setdefault(fault.text, when)
        return fault.lasts.of(when) - fault.lasts.of(since) < fault.lasts.value
