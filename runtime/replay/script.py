"""A recording as the loop lived through it: turn by turn, what it was given and what it made of
that.

A turn begins with a frame or a request that the loop was handed. All that the loop's own thread
told before the next one is of that turn; what the control loop did meanwhile stands in its order.
"""

import json
from collections import defaultdict, deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Self

import numpy as np

from runtime.config import Config, known_keys, load
from runtime.core.types import Intrinsics, Mount, Observation, Pose, Scan
from runtime.errors import RecordingError, SensorError
from runtime.recording.exact import read
from runtime.recording.messages import LOOP, color_topic, depth_topic
from runtime.recording.reader import Recorded, Recording
from runtime.robot.images.reading import decode_color, decode_depth
from runtime.robot.requests import QUERIES

OUTPUTS: Final = ("question", "decision", "command", "plan", "rest")
"""What the loop's thread makes of what it is given."""
INPUTS: Final = ("order", "detections", "ballot")
CONTROLS: Final = ("tick", "rest")  # in the order in which the control loop lived them
LOSSES: Final = ("wire", "picture")  # what a replay does not need
OURS: Final = ("robot.", "camera.")  # keys that say which robot it is


@dataclass
class Turn:
    """`kind`: what it began with, "frame" or "request" ("": before the first). `heard`: what the
    loop was given beside it, by name, in order. `made`: what it made, by kind."""

    number: int
    kind: str
    at_s: float  # since the recording began, by its time of day
    told: Mapping[str, Any] = field(default_factory=dict)
    color: bytes = b""
    depth: bytes = b""
    heard: dict[str, deque[Any]] = field(default_factory=lambda: defaultdict(deque))
    made: dict[str, list[Any]] = field(default_factory=lambda: defaultdict(list))
    controls: list[tuple[str, Any]] = field(default_factory=list)


class Script:
    """The turns of a recording, one after the other."""

    def __init__(self, recording: Recording) -> None:
        """RecordingError for a file that nothing was written into."""
        self.recording = recording
        self.lost: dict[str, int] = {}  # by kind, while it was recorded
        self._messages = iter(recording)
        first = next((m for m in self._messages if m.topic == f"{LOOP}configuration"), None)
        if first is None:
            raise RecordingError(f"{recording.path}: is empty: nothing was recorded")
        told = json.loads(first.payload)
        self.values: dict[str, Any] = told["values"]
        self.lockstep: bool = told["lockstep"]
        self.harness: bool = told.get("harness", True)  # before it was told, all was let in
        self.began_ns = first.log_time_ns

    @classmethod
    def open(cls, path: Path) -> Self:
        return cls(Recording(path))

    def config(self, path: Path | None = None, settings: Sequence[str] = ()) -> Config:
        """The recorded configuration, with those of a file and settings over it."""
        known = known_keys()
        values = {
            name: float(value)
            if name in known and isinstance(known[name].default, float)
            else value
            for name, value in self.values.items()
        }
        return load(path, settings, values)

    def check_robot(self, path: Path | None, settings: Sequence[str]) -> None:
        """RecordingError when these are of another robot."""
        recorded, config = self.config(), self.config(path, settings)
        for name, key in known_keys().items():
            mine, theirs = key.value(config), key.value(recorded)
            if name.startswith(OURS) and mine != theirs:
                what = f"{name} is {theirs} there, {mine} here"
                raise RecordingError(f"{self.recording.path}: of another robot: {what}")

    def check_colour(self) -> None:
        """RecordingError when it was recorded without."""
        if self.recording.about.get("colour") == "none":
            raise RecordingError(f"{self.recording.path}: has no colour: nothing can be looked at")

    def heard(self, name: str) -> Iterator[Any]:
        """All that the loop was given of that name; of its own accord, for `turns` tells of a cut
        only where it comes to it."""
        for message in Recording(self.recording.path):
            if message.topic == f"{LOOP}heard":
                told = json.loads(message.payload)
                if told["name"] == name:
                    yield told["value"]

    def turns(self) -> Iterator[Turn]:
        """One after the other, each when all of it was read."""
        topics = self.config().bus.topics
        images = {color_topic(topics): "color", depth_topic(topics): "depth"}
        turn, number = Turn(0, "", 0.0), 0
        seen: dict[str, Recorded] = {}
        for message in self._messages:
            if message.topic in images:
                seen[images[message.topic]] = message
            if not message.topic.startswith(LOOP) or not message.schema.startswith("rfnav."):
                continue
            kind, told = message.topic.removeprefix(LOOP), json.loads(message.payload)
            if kind == "frame" or (kind == "request" and QUERIES[told["kind"]].steers):
                yield turn
                number += 1
                turn = Turn(number, kind, (message.log_time_ns - self.began_ns) / 1e9, told)
                if kind == "frame":
                    _take_images(turn, seen)
            else:
                self._file(turn, kind, told)
        yield turn

    def _file(self, turn: Turn, kind: str, told: Any) -> None:
        if kind == "heard":
            turn.heard[told["name"]].append(told["value"])
        elif kind in INPUTS:
            turn.heard[kind].append(told)
        elif kind == "recorder":
            self.lost = {k: n for k, n in told["dropped"].items() if k not in LOSSES}
        if kind in OUTPUTS:
            turn.made[kind].append(told)
        if kind in CONTROLS:
            turn.controls.append((kind, told))


def observed(turn: Turn) -> Observation:
    """The observation of a turn that began with a frame. Without a recorded colour image it is
    black."""
    told = turn.told
    intrinsics = read(told["intrinsics"], Intrinsics)
    mount = read(told["mount"], Mount) if told["mount"] is not None else None
    size = intrinsics.height, intrinsics.width
    try:
        depth_m = decode_depth(turn.depth, "depth").value
        rgb = np.zeros((*size, 3), np.uint8)
        if turn.color:
            rgb = decode_color(turn.color, "colour", packed=True).value
    except SensorError as error:
        raise RecordingError(f"frame {turn.number}: {error}") from error
    pose = read(told["pose"], Pose)
    scan = read(told["scan"], Scan) if told.get("scan") is not None else None
    return Observation(told["stamp_ns"], rgb, depth_m, pose, intrinsics, mount, scan)


def _take_images(turn: Turn, seen: Mapping[str, Recorded]) -> None:
    """The images of a frame are those of its stamps."""
    for name, stamp in (("color", "color_stamp_ns"), ("depth", "stamp_ns")):
        image = seen.get(name)
        if image is not None and image.publish_time_ns == turn.told[stamp]:
            setattr(turn, name, image.payload)
