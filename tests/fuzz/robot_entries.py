"""Bytes that come over the bus: messages, requests."""

import io
import json
import struct
import threading
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr
from typing import Any

import numpy as np
from answers import REFUSALS, refused, refused_in_a_line, scratch
from goal_bench import Bench
from kept_entries import asked_of_places
from lived_in import lived_in
from manual_clock import ManualClock
from other_half import (
    battery_state,
    camera_info,
    flag,
    hazards,
    laser_scan,
    odometry_of,
    slam_pose,
    tf,
)
from rover_bytes import rover_bytes

from models.words.vocabulary import load_vocabulary
from runtime.clock import Deadline
from runtime.config import load
from runtime.core.goal_phrase import in_turn
from runtime.core.types import Intrinsics, Pose
from runtime.errors import RfNavError, SensorError
from runtime.loops.goal_request import STRICT, Terms, cancel_reason
from runtime.perception.heard_goal import hear, hear_each, words_of
from runtime.robot import wire
from runtime.robot.body_senses import BodySenses
from runtime.robot.calibration import decode_lens
from runtime.robot.odometry import BaseOdometry
from runtime.robot.requests import QUERIES, Requests
from runtime.robot.session import BusConfig, SensesConfig, TopicsConfig
from runtime.robot.streams import SensorStreams
from runtime.robot.sync import RawMessage
from runtime.robot.told_votes import read_votes
from runtime.robot.transforms import TF, CameraConfig
from runtime.service.atlas import asked_name, atlas_of
from runtime.service.bounds import read_bounds
from runtime.service.telemetry import Telemetry, untold
from runtime.service.zones import Surroundings, Zones

S = 10**9

# -- messages --------------------------------------------------------------------------------------

RGB, DEPTH = np.zeros((12, 16, 3), np.uint8), np.full((12, 16), 2.0, np.float32)
CAMERA = Intrinsics(20.0, 20.0, 8.0, 6.0, 16, 12)
STREAMS = {
    "color": [wire.encode_color(RGB, 5 * S), wire.encode_color(RGB, 5 * S, encoding="bgr8")],
    "depth": [wire.encode_depth(DEPTH, 5 * S), wire.encode_depth(DEPTH, 5 * S, encoding="16UC1")],
    "camera_info": [wire.encode_camera_info(CAMERA, 5 * S)],
    "odom": [wire.encode_odometry(Pose(1.0, 2.0, 0.5), 5 * S)],
    "scan": [laser_scan([1.0, 2.0, 3.0], 5 * S)],
}
SENSES = {
    "teleop": [wire.encode_twist(0.1, 0.2), wire.encode_twist_stamped(0.1, 0.2, 5 * S)],
    "battery": [battery_state(0.5, 5 * S)],
    "bumper": [flag(True)],
    "cliff": [
        b"\0\1\0\0" + struct.pack("<iII4sB3xffff", 5, 0, 3, b"cl\0\0", 1, 0.1, 0.0, 0.3, 0.05)
    ],
    "hazards": [hazards([("bump_left", 1), ("cliff_left", 2)], 5 * S)],
}
OPTICAL = (-0.5, 0.5, -0.5, 0.5)
TELLING = {
    "told": [
        odometry_of((1.0, 2.0, 0.5), OPTICAL, 5 * S, "camera_optical_frame"),
        odometry_of((5e5, 4e6, 0.0), (0.0, 0.0, 0.0, 1.0), 5 * S),
    ],
    "info": [
        camera_info((16, 12), (20.0, 20.0, 8.0, 6.0), (-0.2, 0.1, 0.0, 0.0, 0.0)),
        camera_info((16, 12), (20.0, 20.0, 8.0, 6.0), (0.1, 0.0, 0.0, 0.0), "equidistant"),
    ],
}


def slam(payload: bytes, topic: str) -> object:
    """The pose that a SLAM tells."""
    return BaseOdometry(topic, slam=True, tell=lambda line: None).read(RawMessage(0, payload, 0.0))


def odometry(payload: bytes, topic: str) -> object:
    """Odometry, perhaps of a camera."""
    return BaseOdometry(topic, tell=lambda line: None).read(RawMessage(0, payload, 0.0))


def votes(payload: bytes, topic: str) -> object:
    """What a harness votes for an expert."""
    return read_votes(wire.decode_json(payload, topic), ["r2f"])


VOTE = {"expert": "r2f", "frontiers": [4], "probabilities": [[4, 0.6], [3, 0.4]], "reason": "so"}
OTHERS: dict[Callable[[bytes, str], object], list[bytes]] = {
    slam: [slam_pose(Pose(1.0, 2.0, 0.5), 5 * S)],
    wire.decode_transforms: [tf(("base_link", "camera", (0.1, 0.0, 0.8), OPTICAL), stamp_ns=5 * S)],
    wire.decode_json: [wire.encode_json({"boxes": [[0, 0, 4, 4]], "names": ["bed"]})],
    votes: [wire.encode_json({"stamp_ns": 5, "votes": [VOTE]})],
    wire.decode_twist: [wire.encode_twist(0.1, 0.2)],
    wire.peek_stamp: [],
    odometry: TELLING["told"],
    decode_lens: TELLING["info"],
}
LABELS = {"stamp_ns": 5, "boxes": [[0, 0, 4, 4]], "names": ["bed"], "scores": [0.5], "room": None}


def messages(data: bytes) -> None:
    """A CDR message: the first byte says what it is taken for."""
    if not data:
        return
    number, payload = data[0], data[1:]
    names = [*STREAMS, *SENSES, "tf", "labels"]
    decoders = list(OTHERS)
    if number < len(names):
        _file(names[number], payload)
    else:
        with refused_in_a_line(SensorError):
            decoders[number % len(decoders)](payload, "topic")


def _file(name: str, payload: bytes) -> None:
    """As a bus does, which then looks for a frame."""
    clock, changed = ManualClock(1.0), threading.Condition()
    camera = CameraConfig(mount="tf", frame="camera")
    if name in SENSES:
        body = BodySenses(TopicsConfig(), SensesConfig(), clock)
        body.file(name, f"robot/{name}", payload)
        body.felt()
        return
    streams = SensorStreams(BusConfig(), clock, changed, False, camera)
    streams.file_transforms(TF, OTHERS[wire.decode_transforms][0])
    for other, (first, *_) in STREAMS.items():
        streams.file(other, payload if other == name else first)
    if name == "tf":
        streams.file_transforms(TF, payload)
    elif name == "labels":
        streams.file_labels("labels", payload)
    with redirect_stderr(io.StringIO()), changed:
        match = streams.wait_for_match(Deadline.after(0.0, clock), lambda: True)
    with redirect_stderr(io.StringIO()):
        obs = streams.observe(match) if match is not None else None
    if obs is None:
        REFUSALS.append(f"{name}: no frame")
    else:
        assert np.isfinite((obs.pose.x_m, obs.pose.y_m, obs.pose.yaw_rad)).all()
        assert np.isfinite(obs.depth_m).all()


def numbered() -> list[bytes]:
    told = [*STREAMS.values(), *SENSES.values(), OTHERS[wire.decode_transforms]]
    told.append([wire.encode_json(LABELS)])
    first = [bytes((n,)) + seed for n, seeds in enumerate(told) for seed in seeds]
    count = len(OTHERS)
    start = -(-len(told) // count) * count
    more = [bytes((start + n,)) + seed for n, seeds in enumerate(OTHERS.values()) for seed in seeds]
    return first + more


def mavlink(data: bytes) -> None:
    """What comes over a MAVLink link."""
    rover = rover_bytes(data)
    if not rover.heard or rover.inbox.bad:
        REFUSALS.append("mavlink: nothing of a rover, or broken messages")


# -- requests --------------------------------------------------------------------------------------


class _Asker:
    """A query."""

    def __init__(self, data: bytes) -> None:
        self.payload, self._data, self.answers = self, data, 0

    def to_bytes(self) -> bytes:
        return self._data

    def reply(self, key: str, answer: str) -> None:
        json.loads(answer)
        self.answers += 1

    def drop(self) -> None:
        pass


def no_likeness(texts: Sequence[str]) -> np.ndarray:
    """(N, 1): no text is like any other."""
    return np.zeros((len(texts), 1), np.float32)


GOAL_WORDS = words_of(load_vocabulary())


def asked_where(body: dict[str, Any]) -> dict[str, object]:
    """Of a home with a mug."""
    try:
        return KNOWN.told("where", asked_name(body))
    except ValueError as error:
        refused(str(error))
        return {"accepted": False, "error": str(error)}


def request(data: bytes) -> None:
    """A query of any kind, under a harness or not. It is answered whatever it says."""
    if not data:
        return
    number, asker = data[0], _Asker(data[1:])
    requests = Requests(threading.Condition(), lambda topic: topic)
    kind = QUERY_KINDS[number % HARNESS % len(QUERY_KINDS)]
    requests.file(kind, kind, asker)
    taken = requests.take()
    if taken is not None:
        terms = Terms(harness=True) if number >= HARNESS else STRICT
        answer: dict[str, object] = {"accepted": True}
        cancel_reason(taken.body)
        if kind == "why":
            answer = WATCH.why(taken)
        if kind in ("pause", "resume", "result"):
            answer |= getattr(IDLE.life, kind)(taken)
        if kind == "where":
            answer = asked_where(taken.body)
        if kind == "places":
            answer = asked_of_places(taken)
        if kind == "zones":
            nowhere = Surroundings(lambda: Pose(0.0, 0.0, 0.0), lambda: (0.0, 0.0))
            answer = Zones(None, nowhere).answer(taken.body)
        try:
            if kind == "goal":
                asked = terms.read(taken.body)
                read_bounds(asked.binds, ("kitchen",), (0.0, 0.0), lambda name: None)
                load(None, asked.settings)
                each = hear_each if asked.several == "in_turn" else hear
                for text in asked.texts[:2]:
                    for part in in_turn(text)[:2]:
                        each(part, GOAL_WORDS, no_likeness)
        except RfNavError as error:
            refused(str(error))
            answer = {"accepted": False, "error": str(error)}
        taken.reply(answer)
    assert asker.answers == 1


KNOWN = atlas_of(lived_in(), (("mug", "cup"),), "odom", (0.0, 0.0))
QUERY_KINDS = list(QUERIES)
HARNESS = 128  # and up, of the first byte
IDLE = Bench(scratch())
ZONES = [
    {"add": "stairs", "polygon": [[0, 0], [1.5, 0], [1, 1e3], [0, 1]]},
    {"remove": "stairs"},
    {"clear": True},
    {"list": True},
]
GOALS = [
    {"goal": "bed"},
    {"goal": "bed", "episode": "e1", "settings": ["goal.keep_map=true", "panel.experts=['o2f']"]},
    {
        "goal": "bed",
        "log_dir": "x/y",
        "settings": ["control.max_speed_mps=0.3", "bus.mode=peer"],
    },
    {"goal": "bed", "area": {"polygon": [[0, 0], [1.5, 0], [1, 1e3]]}},
    {"goal": "bed", "area": {"room": "kitchen"}},
    {"go_to": {"x_m": 1.0, "y_m": -2, "yaw_rad": 3.1}},
    {"goal": "please find the red mug on the kitchen table, not the cup"},
    {"goal": "wo ist mein Kühlschrank"},
    {
        "goal": ["a mug and a cup, then a chair", "bed"],
        "several": "in_turn",
        "if_busy": "queue",
        "limits": {"time_s": 60, "distance_m": 5.5, "money_usd": 0.01},
        "afterwards": "return",
    },
    {"id": "a1b2c3d4"},
    {"name": "the red mugs"},
    {"reason": "enough"},
    {"decision": 3},
    {"stop": 1},
]
WATCH = Telemetry(ManualClock(), tell=untold)
