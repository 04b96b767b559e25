"""What the service publishes, for pages: the newest of each topic is kept in Zenoh's threads, and
read a few times a second in one of our own."""

import json
import struct
import threading
import time
import zlib
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any, Final

import cv2
import numpy as np

from runtime.errors import SensorError
from runtime.loops.drawings import TOPICS
from runtime.map_look import room_hue
from runtime.robot import drawn_messages, wire
from runtime.robot.dialects.choice import spoken
from runtime.robot.dialects.dialect import RosTopic
from runtime.robot.drawn_scene import SCENE
from runtime.robot.heard_topics import heard_topics
from runtime.robot.ros_node import RosNode
from runtime.robot.session import DECISION, FEEDBACK, STATE, BusConfig
from runtime.view.feed import Audience
from runtime.view.pictures import boxes_message, camera_message
from runtime.view.tiles import CELLS, FREE, OBSTACLE, UNKNOWN, TileGrid, TileMap
from runtime.view.told import belief_of, origin_of

NODE: Final = "rfnav_view"  # what others see us as
PICTURE_S: Final = 0.2  # between two images that are made small
IMAGE: Final = "color"
FAULTS: Final = (
    KeyError, TypeError, ValueError, AttributeError, IndexError, ArithmeticError,
    cv2.error, struct.error, zlib.error,
)  # fmt: skip
"""What a message of another shape than ours runs into: it is left out."""


def page_topics() -> dict[str, RosTopic]:
    """By what they are to a page."""
    ours = {"state": STATE, "feedback": FEEDBACK, "decision": DECISION}
    return {
        **{name: RosTopic(topic, wire.STRING) for name, topic in ours.items()},
        "scene": SCENE,
        "map": TOPICS["map"],
        "boxes": TOPICS["detections"],
    }


@dataclass
class Newest:
    """What was told last, read. `state_s`: when a state came, monotonic."""

    state: Mapping[str, Any] = field(default_factory=dict)
    feedback: Mapping[str, Any] = field(default_factory=dict)
    scene: Mapping[str, Any] = field(default_factory=dict)
    state_s: float = -1e9


class PageHearing:
    """`decided` is told of every decision that is published, in the thread that calls `turn`."""

    def __init__(
        self,
        bus: BusConfig,
        audience: Audience,
        tiles: TileMap,
        decided: Callable[[Mapping[str, Any]], None],
    ) -> None:
        self._bus, self._audience, self._tiles, self._decided = bus, audience, tiles, decided
        self._image = heard_topics(bus)[IMAGE]
        self._lock = threading.Lock()
        self._came: dict[str, tuple[bytes, float]] = {}
        self._decisions: list[bytes] = []
        self._image_px = (0, 0)
        self._pictured_s = -1e9
        self.newest = Newest()
        self.rooms: list[str] = []
        self.bad = 0  # messages that could not be read

    def listen(self, session: Any) -> closing[RosNode]:
        """Until that is closed: all but images."""
        node = RosNode(session, spoken(self._bus, NODE))
        for name, topic in page_topics().items():
            node.subscribe(topic, self._keeps(name))
        return closing(node)

    def watch(self, session: Any) -> closing[RosNode]:
        """Until that is closed: images, too."""
        node = RosNode(session, spoken(self._bus, f"{NODE}_camera"))
        node.subscribe(self._image, self._keeps(IMAGE))
        return closing(node)

    def forget(self) -> None:
        """Another process may answer from now on."""
        self.newest = Newest(scene=self.newest.scene)

    def turn(self) -> bool:
        """Read what came since the last turn, and tell it; whether the state has changed."""
        with self._lock:
            came, decisions = self._came, self._decisions
            self._decisions = []
            now_s = time.monotonic()
            rests = IMAGE in came and now_s - self._pictured_s < PICTURE_S
            self._came = {IMAGE: came.pop(IMAGE)} if rests else {}
        for name, (payload, arrival_s) in came.items():
            self._tried(name, payload, arrival_s)
        for payload in decisions:
            self._tried("decision", payload, now_s)
        return bool(came.keys() & {"state", "feedback"})

    def _keeps(self, name: str) -> Callable[[str, bytes], None]:
        def receive(topic: str, payload: bytes) -> None:
            with self._lock:
                if name == "decision":
                    self._decisions = [*self._decisions[-7:], payload]
                else:
                    self._came[name] = payload, time.monotonic()

        return receive

    def _tried(self, name: str, payload: bytes, arrival_s: float) -> None:
        try:
            self._read(name, payload, arrival_s)
        except (SensorError, *FAULTS):
            self.bad += 1

    def _read(self, name: str, payload: bytes, arrival_s: float) -> None:
        newest = self.newest
        if name == "state":
            newest.state, newest.state_s = wire.decode_json(payload, STATE), arrival_s
        elif name == "feedback":
            newest.feedback = wire.decode_json(payload, FEEDBACK)
        elif name == "decision":
            self._decided(wire.decode_json(payload, DECISION))
        elif name == "scene":
            newest.scene = wire.decode_json(payload, SCENE.name)
            self.tell_scene()
        elif name == "map":
            self._tiles.put(CELLS, grid_of(payload, "rfnav/map"))
            self._audience.mapped()
        elif name == "boxes":
            goal = str(newest.scene.get("goal", ""))
            self._audience.tell("boxes", boxes_message(payload, self._image_px, goal))
        else:
            self._picture(payload)

    def tell_scene(self) -> None:
        """The newest, with what is known beside it."""
        newest = self.newest
        if newest.scene:
            state = newest.state
            hues = [room_hue(name) for name in self.rooms]
            belief = belief_of(state, origin_of(state))
            beside = {"rooms": self.rooms, "hues": hues, "belief": belief}
            self._audience.tell("scene", {**newest.scene, **beside})

    def scene_json(self) -> str:
        """The same as text; "" before the first."""
        return json.dumps(self.newest.scene) if self.newest.scene else ""

    def _picture(self, payload: bytes) -> None:
        self._pictured_s = time.monotonic()
        packed = self._bus.is_packed(IMAGE)
        message, self._image_px = camera_message(payload, self._image.name, packed)
        self._audience.picture(message)


def grid_of(payload: bytes, topic: str) -> TileGrid:
    """OccupancyGrid -> cells of a page's map. SensorError for damage, ValueError for a shape that
    is none."""
    told_grid = wire.decode(payload, drawn_messages.OCCUPANCY_GRID, topic)
    info = told_grid.info
    data = np.asarray(told_grid.data, np.int8).reshape(info.height, info.width)
    cells = np.full(data.shape, UNKNOWN, np.uint8)
    cells[data >= 0] = FREE
    cells[data >= 50] = OBSTACLE
    corner = info.origin.position
    return TileGrid(cells, float(info.resolution), float(corner.x), float(corner.y))


def named_things(scene: Mapping[str, Any]) -> list[str]:
    """Of the things of a scene."""
    things = scene.get("things") or ()
    return [str(one.get("name")) for one in things if isinstance(one, Mapping)]
