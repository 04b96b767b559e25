"""What others draw of a search: map, zones, path, frontiers, objects, what was seen, diagnostics;
and the scene of an operator's page, which is all of that in one.

The thread that owns the world hands over what is due, copied where it would change; one of its own,
of low priority, makes messages of it and publishes them. Neither control nor the loop waits for it.
"""

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Final, Protocol

import numpy as np

from runtime.clock import Clock
from runtime.core.geometry import GridFrame
from runtime.core.mapping.zones import Zone
from runtime.core.objects.instances import Instance, size_m
from runtime.core.types import Detections, Frontier
from runtime.core.world import Command, World
from runtime.loops.worker_thread import WorkerThread
from runtime.robot import drawn_messages
from runtime.robot.diagnostics import DIAGNOSTICS, Diagnostics
from runtime.robot.dialects.dialect import Qos, RosTopic
from runtime.robot.drawn_messages import DrawnObject, Stamp
from runtime.robot.drawn_scene import SCENE, WAY_MOST, DrawnScene, coarser, encode_scene
from runtime.robot.frame_names import ODOM
from runtime.robot.ros_node import Publisher
from runtime.robot.streams import StreamHealth

EVERY_S: Final = {
    "map": 1.0, "path": 0.5, "frontiers": 1.0, "objects": 1.0, "detections": 0.2, "zones": 1.0,
    "scene": 0.5,
}  # fmt: skip
DIAGNOSE_S: Final = 1.0
TOPICS: Final = {
    "map": RosTopic("rfnav/map", drawn_messages.OCCUPANCY_GRID, Qos(latched=True, depth=1)),
    "path": RosTopic("rfnav/path", drawn_messages.PATH),
    "frontiers": RosTopic("rfnav/frontiers", drawn_messages.MARKERS),
    "objects": RosTopic("rfnav/objects", drawn_messages.MARKERS),
    "detections": RosTopic("rfnav/detections", drawn_messages.DETECTIONS),
    "zones": RosTopic("rfnav/keep_out", drawn_messages.MARKERS),
    "diagnostics": RosTopic("diagnostics", DIAGNOSTICS),
}


class DrawingBus(Protocol):
    """The bus, as far as drawing is concerned; see `Bus`."""

    def publisher(self, topic: RosTopic) -> Publisher: ...

    def frame_of(self, stream: str, otherwise: str) -> str: ...

    def origin_xy(self) -> tuple[float, float]: ...

    def health(self) -> Mapping[str, StreamHealth]: ...


class Drawer(Protocol):
    """Who draws beside a drive; see `Drawings`. Only the thread that owns the world calls it."""

    def note(self, world: World, command: Command | None) -> None: ...

    def seen(self, stamp_ns: int, detections: Detections, names: Sequence[str]) -> None: ...


class NoDrawings:
    """Nobody draws."""

    def note(self, world: World, command: Command | None) -> None:
        pass

    def seen(self, stamp_ns: int, detections: Detections, names: Sequence[str]) -> None:
        pass


class Drawings:
    """A `Drawer`. `names`: of TOPICS, what is published beside the scene; `status`: the control
    loop's; `service`: what a query on `rfnav/status` was answered last."""

    def __init__(
        self,
        names: Iterable[str],
        bus: DrawingBus,
        status: Callable[[], Mapping[str, object]],
        clock: Clock,
        nice: int = 0,
        service: Callable[[], Mapping[str, Any]] = dict,
    ) -> None:
        self._bus, self._status, self._service, self._clock = bus, status, service, clock
        self._publishers = {name: bus.publisher(TOPICS[name]) for name in names}
        self._publishers["scene"] = bus.publisher(SCENE)
        self._due_s = dict.fromkeys(EVERY_S, 0.0)
        self._waiting: dict[str, Callable[[], bytes]] = {}
        self._drawn: dict[str, set[int]] = {"frontiers": set(), "objects": set(), "zones": set()}
        self._diagnostics = Diagnostics()
        self._thread = WorkerThread("drawings", self._work, nice)
        self._changed = self._thread.changed
        self._thread.start()

    def note(self, world: World, command: Command | None) -> None:
        """The world as it is now; no command while somebody else drives. Raises what went wrong in
        drawing."""
        self._thread.check()
        at = Stamp(world.stamp_ns, self._bus.frame_of("odom", ODOM), self._bus.origin_xy())
        if self._is_due("map"):
            copy = world.map.copied(world.map.known_window())
            self._hand("map", lambda: drawn_messages.encode_map(copy, at))
        if self._is_due("path"):
            path_xy = command.path_xy if command else np.zeros((0, 2))
            self._hand("path", lambda: drawn_messages.encode_path(path_xy, at))
        if self._is_due("frontiers"):
            frontiers, decision = world.frontiers, world.standing.decision
            elected = decision.frontier if decision else None
            self._hand("frontiers", lambda: self._frontiers(frontiers, elected, at))
        if self._is_due("objects"):
            frame, goal = world.map.frame, world.goal
            things = [_drawn(i, frame) for i in world.semantic.instances.values()]
            self._hand("objects", lambda: self._objects(things, goal, at))
        if self._is_due("zones"):
            zones = world.map.zones.zones
            self._hand("zones", lambda: self._zones(zones, at))
        if self._is_due("scene"):
            scene = _scene(world, command)
            self._hand("scene", lambda: encode_scene(scene, at))

    def seen(self, stamp_ns: int, detections: Detections, names: Sequence[str]) -> None:
        """What the detectors saw in the image of that stamp."""
        if self._is_due("detections"):
            at = Stamp(stamp_ns, self._bus.frame_of("color", "camera"))
            encode = drawn_messages.encode_detections
            self._hand("detections", lambda: encode(detections, names, at))

    def close(self) -> None:
        """Let the thread end. Idempotent."""
        self._thread.close(2.0)

    def _is_due(self, name: str) -> bool:
        """Whether it is time, and somebody listens or may come later."""
        publisher, now_s = self._publishers.get(name), self._clock.now_s()
        if publisher is None or now_s < self._due_s[name] or not publisher.heard():
            return False
        self._due_s[name] = now_s + EVERY_S[name]
        return True

    def _hand(self, name: str, encode: Callable[[], bytes]) -> None:
        with self._changed:
            self._waiting[name] = encode
            self._changed.notify_all()

    # -- in its own thread -----------------------------------------------------------------------

    def _work(self) -> None:
        diagnose_s = self._clock.now_s() + DIAGNOSE_S
        while True:
            with self._changed:
                while not self._thread.closed and not self._waiting:
                    if self._clock.now_s() >= diagnose_s:
                        break
                    self._clock.wait(self._changed, diagnose_s)
                if self._thread.closed:
                    return
                waiting, self._waiting = self._waiting, {}
            for name, encode in waiting.items():
                self._publishers[name].put(encode())
            if self._clock.now_s() >= diagnose_s:
                diagnose_s = self._clock.now_s() + DIAGNOSE_S
                self._diagnose()

    def _diagnose(self) -> None:
        publisher = self._publishers.get("diagnostics")
        if publisher is None or not publisher.heard():
            return
        status: Mapping[str, Any] = self._status()
        late, now_s = status.get("tick_late_ms", {}), self._clock.now_s()
        told = {f"tick late, {name} (ms)": value for name, value in late.items()}
        health = self._bus.health()
        known = status["runtime"], told, health, now_s, time.time_ns(), self._service()
        payload = self._diagnostics.encode(*known)
        publisher.put(payload)

    def _frontiers(self, frontiers: Sequence[Frontier], elected: int | None, at: Stamp) -> bytes:
        gone = self._gone("frontiers", {one.id for one in frontiers})
        return drawn_messages.encode_frontiers(frontiers, elected, gone, at)

    def _objects(self, things: Sequence[DrawnObject], goal: str, at: Stamp) -> bytes:
        gone = self._gone("objects", {one.id for one in things})
        return drawn_messages.encode_objects(things, goal, gone, at)

    def _zones(self, zones: Sequence[Zone], at: Stamp) -> bytes:
        gone = self._gone("zones", set(range(len(zones))))
        return drawn_messages.encode_zones(zones, gone, at)

    def _gone(self, name: str, ids: set[int]) -> list[int]:
        """Ids that were drawn last time and are not any more."""
        before, self._drawn[name] = self._drawn[name], ids
        return sorted(before - ids)


def _drawn(thing: Instance, frame: GridFrame) -> DrawnObject:
    """The box round its footprint's cells, along the map's axes."""
    half = frame.resolution_m / 2
    high_m = size_m(thing, frame.resolution_m)[2]
    low = thing.cells_xy.min(axis=0) - half if len(thing.cells_xy) else np.array(thing.xy) - half
    far = thing.cells_xy.max(axis=0) + half if len(thing.cells_xy) else np.array(thing.xy) + half
    (x0, y0), (x1, y1) = low.tolist(), far.tolist()
    middle = (x0 + x1) / 2, (y0 + y1) / 2, thing.low_m + high_m / 2
    size = x1 - x0, y1 - y0, max(high_m, frame.resolution_m)
    return DrawnObject(thing.id, thing.name, thing.confidence, middle, size)


def _scene(world: World, command: Command | None) -> DrawnScene:
    """Nothing of it changes when the world does."""
    decision, frame = world.standing.decision, world.map.frame
    areas = [zone.corners_xy for zone in world.map.zones.zones if zone.area]
    return DrawnScene(
        world.goal,
        world.frontiers,
        decision.frontier if decision else None,
        [_drawn(one, frame) for one in world.semantic.instances.values()],
        command.path_xy if command else np.zeros((0, 2)),
        np.array(coarser(world.body.visited_xy, WAY_MOST)).reshape(-1, 2),
        areas[0] if areas else None,
    )
