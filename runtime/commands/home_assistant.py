"""What a robot is to Home Assistant over MQTT: discovery messages, how it stands, what is asked of
it. Names and payloads alone, as Home Assistant's MQTT integration has them."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from runtime.commands.status_screen import printable
from runtime.errors import ConfigError, SensorError
from runtime.robot.json_text import parse_json

PAYLOAD_BYTES: Final = 1024
STATE_CHARS: Final = 255  # of a sensor's state
GOAL_CHARS: Final = 80
ONLINE, OFFLINE = "online", "offline"
NAME: Final = re.compile(r"[A-Za-z0-9_-]{1,40}")
TOPIC: Final = re.compile(r"[A-Za-z0-9_/-]{1,80}")
FEATURES: Final = ("start", "pause", "stop", "return_home", "status", "send_command")
TROUBLED: Final = ("fault", "stopped")
Table = Mapping[str, Any]


@dataclass(frozen=True)
class Topics:
    """By which names a robot of that `id` is known; `discovery`: Home Assistant's prefix."""

    id: str
    discovery: str = "homeassistant"

    def __post_init__(self) -> None:
        if not NAME.fullmatch(self.id):
            raise ConfigError(f"--id {self.id!r}: 1 to 40 of a-z, A-Z, 0-9, - and _")
        if not TOPIC.fullmatch(self.discovery):
            raise ConfigError(f"--discovery {self.discovery!r}: is no prefix of topics")

    def of(self, name: str) -> str:
        """One of the robot's own."""
        return f"rfnav/{self.id}/{name}"

    @property
    def heard(self) -> tuple[str, ...]:
        """What is listened to."""
        return *map(self.of, ("command", "send", "goal/set")), f"{self.discovery}/status"

    def discoveries(self) -> dict[str, str]:
        """Topic -> payload of the entities: the robot as a vacuum cleaner, the goal as a text, the
        last result and the battery as sensors."""
        return {
            f"{self.discovery}/{kind}/rfnav_{self.id}/{name}/config": json.dumps(
                {
                    "unique_id": f"rfnav_{self.id}_{name}",
                    "availability_topic": self.of("availability"),
                    "device": {"identifiers": [f"rfnav_{self.id}"], "name": self.id,
                               "manufacturer": "RF-NAV", "model": "rfnav run"},
                    **told,
                }
            )
            for kind, name, told in self._entities()
        }  # fmt: skip

    def _entities(self) -> tuple[tuple[str, str, dict[str, object]], ...]:
        return (
            ("vacuum", "robot", {
                "name": None, "supported_features": FEATURES,
                "state_topic": self.of("state"), "command_topic": self.of("command"),
                "send_command_topic": self.of("send"),
                "json_attributes_topic": self.of("attributes"),
            }),
            ("text", "goal", {
                "name": "Goal", "icon": "mdi:magnify", "max": GOAL_CHARS,
                "state_topic": self.of("goal"), "command_topic": self.of("goal/set"),
            }),
            ("sensor", "last", {
                "name": "Last find", "icon": "mdi:map-marker-check",
                "state_topic": self.of("last"),
                "json_attributes_topic": self.of("last/attributes"),
            }),
            ("sensor", "battery", {
                "name": "Battery", "device_class": "battery", "unit_of_measurement": "%",
                "state_topic": self.of("battery"),
            }),
        )  # fmt: skip

    def states(self, status: Table, returning: str, goal: str, said: str) -> dict[str, str]:
        """Topic -> payload of how it stands. `status`: the answer on `rfnav/status`; `returning`:
        id of a goal that was asked for to go back; `goal`: what is looked for next; `said`: what
        became of what was asked last, "" for nothing."""
        last, base = _table(status, "last"), _table(status, "base")
        runtime = _table(status, "runtime")
        about = {
            "runtime": runtime.get("state"), "cause": runtime.get("cause"), "said": said,
            **{name: status.get(name) for name in
               ("goal", "id", "does", "decisions", "paused", "refuses")},
            "waiting": len(status.get("queue") or ()),
        }  # fmt: skip
        result = {
            name: last.get(name)
            for name in ("result", "goal", "id", "at_xy", "elapsed_s", "driven_m", "usd")
        }
        battery = base.get("battery_percent")
        return {
            self.of("availability"): ONLINE,
            self.of("state"): json.dumps({"state": vacuum_state(status, returning)}),
            self.of("attributes"): json.dumps(about),
            self.of("goal"): goal,
            self.of("last"): printable(str(last.get("sentence") or "nothing yet"), STATE_CHARS),
            self.of("last/attributes"): json.dumps(result),
            self.of("battery"): "None" if battery is None else f"{battery:.0f}",
        }


def vacuum_state(status: Table, returning: str) -> str:
    """One of a vacuum cleaner's: cleaning is searching."""
    if _table(status, "runtime").get("state") in TROUBLED:
        return "error"
    if not status.get("goal"):
        return "idle"
    if status.get("paused"):
        return "paused"
    return "cleaning" if searches(status, returning) else "returning"


def searches(status: Table, returning: str) -> bool:
    """Whether a goal is under way, paused or not, and the robot not on its way back."""
    at_home = status.get("id") == returning or status.get("mode") == "return"
    return bool(status.get("goal")) and not at_home


@dataclass(frozen=True)
class Wished:
    """What somebody asks for: "start", "pause", "stop" or "return", a goal to be "found" at once,
    or one to be "kept" for the next start; "again": Home Assistant has begun anew."""

    what: str
    goal: str = ""


def wish(topics: Topics, topic: str, payload: bytes) -> Wished:
    """What a message asks for; SensorError, one line, for what cannot be read."""
    if len(payload) > PAYLOAD_BYTES:
        raise SensorError(f"mqtt: {topic}: {len(payload)} bytes: at most {PAYLOAD_BYTES}")
    try:
        text = payload.decode().strip()
    except UnicodeDecodeError as error:
        raise SensorError(f"mqtt: {topic}: is no text") from error
    if topic == f"{topics.discovery}/status":
        return Wished("again" if text == ONLINE else "nothing")
    if topic == topics.of("goal/set"):
        return Wished("kept", _goal(text, topic))
    if topic == topics.of("send"):
        return _sent(text, topic)
    known = {"start": "start", "pause": "pause", "stop": "stop", "return_to_base": "return"}
    if text not in known:
        raise SensorError(f"mqtt: {topic}: {printable(text, 40)!r}: know {', '.join(known)}")
    return Wished(known[text])


def _sent(text: str, topic: str) -> Wished:
    """{"command": "find", "goal": "mug"}, or find mug."""
    told: Table = {}
    if text.startswith("{"):
        told = parse_json(text, f"mqtt: {topic}", PAYLOAD_BYTES)
    else:
        command, _, goal = text.partition(" ")
        told = {"command": command, "goal": goal}
    if told.get("command") != "find" or not isinstance(told.get("goal"), str):
        raise SensorError(f'mqtt: {topic}: send {{"command": "find", "goal": "mug"}}')
    return Wished("found", _goal(told["goal"], topic))


def _goal(text: str, topic: str) -> str:
    goal = " ".join(text.split())
    if not goal or len(goal) > GOAL_CHARS or not goal.isprintable():
        raise SensorError(f"mqtt: {topic}: a goal is 1 to {GOAL_CHARS} printable characters")
    return goal


def _table(table: Table, name: str) -> Table:
    value = table.get(name)
    return value if isinstance(value, dict) else {}
