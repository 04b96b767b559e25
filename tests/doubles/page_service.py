"""A service as a page's server finds it on the bus: real Zenoh, and answers that a test sets."""

import base64
import json
import threading
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
import zenoh

from runtime.robot import wire
from runtime.robot.session import BusConfig, open_session

KINDS = ("status", "why", "zones", "places", "map", "goal", "stop", "release", "where")


class PageService:
    """Listens on a port of this computer. `answers`: by kind; `asked`: what came; `teleop`: what
    was told on the sticks."""

    def __init__(self, port: int) -> None:
        self._session: Any = open_session(BusConfig(listen=(f"tcp/127.0.0.1:{port}",)))
        self.changed = threading.Condition()
        self.asked: list[tuple[str, dict[str, Any]]] = []
        self.teleop: list[tuple[float, float]] = []
        self.answers: dict[str, Mapping[str, Any]] = {
            "status": {"runtime": {"state": "ready", "cause": ""}, "goal": None, "id": None},
            "why": {"decision": None, "stop": None},
            "zones": {"accepted": True, "zones": [], "bound": True},
            "places": {"accepted": True, "places": {}, "memory": "none"},
            "stop": {"stopped": True},
            "goal": {"accepted": True, "id": "5f3a09c1"},
        }
        self._declared = [
            self._session.declare_queryable(f"rfnav/{kind}", self._answer) for kind in KINDS
        ]
        self._session.declare_subscriber("cmd_vel_teleop", self._steered)
        self._publishers: dict[str, Any] = {}

    def _answer(self, query: zenoh.Query) -> None:
        kind = str(query.key_expr).removeprefix("rfnav/")
        body = json.loads(query.payload.to_bytes()) if query.payload is not None else {}
        with self.changed:
            self.asked.append((kind, body))
            answer = self.answers.get(kind)
            self.changed.notify_all()
        if answer is not None:
            query.reply(str(query.key_expr), json.dumps(answer))
        query.drop()

    def _steered(self, sample: zenoh.Sample) -> None:
        with self.changed:
            self.teleop.append(wire.decode_twist(sample.payload.to_bytes(), "cmd_vel_teleop"))
            self.changed.notify_all()

    def publish(self, topic: str, payload: bytes) -> None:
        if topic not in self._publishers:
            self._publishers[topic] = self._session.declare_publisher(topic)
        self._publishers[topic].put(payload)

    def tell(self, topic: str, content: Mapping[str, Any]) -> None:
        self.publish(topic, wire.encode_json(content))

    def heard(self, topic: str) -> bool:
        """Whether anybody listens to it."""
        if topic not in self._publishers:
            self._publishers[topic] = self._session.declare_publisher(topic)
        return bool(self._publishers[topic].matching_status.matching)

    def close(self) -> None:
        self._session.close()


def told_rooms(rooms: np.ndarray, names: list[str]) -> dict[str, Any]:
    """An answer on `rfnav/map`."""
    rows, cols = rooms.shape
    packed = base64.b64encode(zlib.compress(rooms.astype(np.uint8).tobytes())).decode()
    size = {"rows": rows, "cols": cols, "resolution_m": 0.05, "origin_xy": [0.0, 0.0]}
    return {**size, "cells": packed, "rooms": packed, "room_names": names, "stamp_ns": 1}
