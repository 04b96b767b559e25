"""The robot as agents have it: each tool, and what it asks of the running service."""

import asyncio
import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, Final

import cv2

from runtime.agents.camera import camera_jpeg
from runtime.agents.goals import ANSWER_S, TAKEN_S, AgentGoals, Progress, goal_told
from runtime.agents.link import Connect, RobotLink
from runtime.agents.rooms import rooms_on
from runtime.agents.told import AgentAnswer, refused
from runtime.agents.tools import THINGS_USUAL, AgentLimits
from runtime.core.types import U8
from runtime.robot.session import BusConfig
from runtime.view.told import table

AT_ONCE, HURRIED_AT_ONCE = 4, 2  # questions to the service
MAP_PX: Final = 1024  # the longer side, at most
MAP_FRESH_S, LOOK_FRESH_S = 2.0, 0.5
FOUND_MOST: Final = 50  # places where a thing was seen
NOTHING: Final = "nothing is known yet: find_object has the robot look around"
Answer = Mapping[str, Any]
Draw = Callable[[Answer, Sequence[Answer], Sequence[Answer], Answer], U8]
"""Map, things, zones, places -> (H, W, 3) blue, green, red."""


@dataclass(frozen=True)
class AgentParts:
    """`connect`: a session to the service, BusError where nobody listens."""

    connect: Connect
    bus: BusConfig
    draw: Draw
    limits: AgentLimits = field(default_factory=AgentLimits)


class _Fresh:
    """What is costly to make is made by one call at a time, and serves all for a while."""

    def __init__(self, make: Callable[[], AgentAnswer], for_s: float) -> None:
        self._make, self._for_s = make, for_s
        self._lock, self._told, self._made_s = threading.Lock(), refused(NOTHING), -math.inf

    def told(self) -> AgentAnswer:
        with self._lock:
            if time.monotonic() - self._made_s >= self._for_s:
                self._told, self._made_s = self._make(), time.monotonic()
            return self._told


class AgentRobot:
    """Coroutines by a tool's name. RfNavError, one line, for what cannot be done."""

    def __init__(self, parts: AgentParts) -> None:
        self._parts, self._link = parts, RobotLink(parts.connect)
        self._usual = ThreadPoolExecutor(AT_ONCE, "agents")
        self._hurried = ThreadPoolExecutor(HURRIED_AT_ONCE, "cancel")
        self._images = {
            "map_image": _Fresh(self._map, MAP_FRESH_S),
            "look": _Fresh(self._look, LOOK_FRESH_S),
        }
        self._goals = AgentGoals(self._link, parts.limits, self._usual, self._hurried)

    async def do(self, tool: str, asked: Answer, progress: Progress) -> AgentAnswer:
        """`asked`: arguments that were read."""
        match tool:
            case "find_object" | "go_to_place":
                return await self._goals.ask(asked, progress)
            case "status" if "id" in asked or asked.get("wait_s"):
                return await self._followed(asked, progress)
            case "cancel":
                loop = asyncio.get_running_loop()
                return await loop.run_in_executor(self._hurried, self._cancel, asked)
            case _:
                loop = asyncio.get_running_loop()
                return await loop.run_in_executor(self._usual, self._told, tool, asked)

    def close(self) -> None:
        """What was given up is cancelled yet. Idempotent."""
        self._usual.shutdown(wait=False, cancel_futures=True)
        self._hurried.shutdown(wait=True)
        self._link.close()

    async def _followed(self, asked: Answer, progress: Progress) -> AgentAnswer:
        id = asked.get("id")
        if id is None:
            loop = asyncio.get_running_loop()
            status = await loop.run_in_executor(self._usual, self._ask, "status")
            if not status.get("id"):
                return status_told(status)
            id = str(status["id"])
        return await self._goals.follow(id, float(asked.get("wait_s", 0.0)), progress)

    # -- in threads --------------------------------------------------------------------------------

    def _cancel(self, asked: Answer) -> AgentAnswer:
        answer = self._link.ask("cancel", {"reason": "an agent", **asked}, TAKEN_S)
        if "error" in answer:
            return refused(str(answer["error"]))
        ended = bool(answer.get("ended"))
        facts = {"cancelled": ended or bool(answer.get("cancelled"))}
        return AgentAnswer(facts, goal_told(answer).untrusted) if ended else AgentAnswer(facts)

    def _told(self, tool: str, asked: Answer) -> AgentAnswer:
        match tool:
            case "status":
                return status_told(self._ask("status"))
            case "why":
                return why_told(self._ask("why", **asked))
            case "where_is":
                return where_told(self._ask("where", name=asked["thing"]))
            case "list_things":
                return things_told(self._ask("things"), asked)
            case "list_rooms":
                return self._rooms()
            case _:
                return self._images[tool].told()

    def _ask(self, kind: str, **body: object) -> dict[str, Any]:
        return self._link.ask(kind, body, ANSWER_S)

    def _rooms(self) -> AgentAnswer:
        rooms, places = rooms_on(self._ask("map")), self._ask("places", list=True)
        named = places.get("places") or {}
        return AgentAnswer(
            {"rooms": len(rooms), "places": len(named)}, {"rooms": rooms, "places": named}
        )

    def _look(self) -> AgentAnswer:
        jpeg = self._link.use(lambda robot: camera_jpeg(robot.session, self._parts.bus))
        return AgentAnswer({"image": "of the robot's camera, now"}, {}, jpeg, "image/jpeg")

    def _map(self) -> AgentAnswer:
        told = self._ask("map")
        if not told["rows"]:
            return refused(NOTHING)
        things = self._ask("things")["things"]
        zones = self._ask("zones", list=True).get("zones", ())
        places = self._ask("places", list=True).get("places", {})
        image = self._parts.draw(told, things, zones, places)
        high, wide = image.shape[:2]
        share = min(1.0, MAP_PX / max(high, wide))
        size = max(1, round(wide * share)), max(1, round(high * share))
        done, png = cv2.imencode(".png", cv2.resize(image, size, interpolation=cv2.INTER_AREA))
        assert done
        facts = {"image": "map, y up", "metres_a_pixel": _scale(told, high, wide, size)}
        return AgentAnswer(facts, {"things": len(things)}, png.tobytes(), "image/png")


def _scale(told: Answer, high: int, wide: int, size: tuple[int, int]) -> float:
    """Of the picture; beside the map there is only a key below it."""
    return round(float(told["cols"]) * float(told["resolution_m"]) / size[0], 4)


def status_told(status: Answer) -> AgentAnswer:
    """Of an answer on `rfnav/status`."""
    names = ("id", "paused", "elapsed_s", "driven_m", "decisions")
    facts = {name: status[name] for name in names if status.get(name) is not None}
    standing, last = (table(status, name) for name in ("runtime", "last"))
    queue = status.get("queue")
    facts |= {"state": standing.get("state"), "waiting": len(queue) if queue else 0}
    battery = table(status, "base").get("battery_percent")
    facts |= {} if battery is None else {"battery_percent": battery}
    cloud = table(table(status, "models"), "cloud")
    facts |= {"day_usd": cloud["day_usd"]} if "day_usd" in cloud else {}
    if last:
        facts["last"] = {name: last.get(name) for name in ("id", "result", "code", "at_xy")}
    words = {
        "goal": status.get("goal"), "does": status.get("does"), "cause": standing.get("cause"),
        "refuses": status.get("refuses"), "last": last.get("sentence"),
    }  # fmt: skip
    return AgentAnswer(facts, {name: said for name, said in words.items() if said})


def why_told(answer: Answer) -> AgentAnswer:
    """Of an answer on `rfnav/why`."""
    decision, stop = (table(answer, name) for name in ("decision", "stop"))
    facts = {"decision": decision.get("number"), "stop": stop.get("number")}
    told = {"decision": decision, "stop": stop}
    words = {name: one.get("in_words") for name, one in told.items() if one}
    if "error" in answer:
        return AgentAnswer(facts, {"error": answer["error"]}, error=True)
    return AgentAnswer(facts, words)


def where_told(answer: Answer) -> AgentAnswer:
    """Of an answer on `rfnav/where`."""
    if answer.get("accepted") is False:
        return AgentAnswer({"found": 0}, {"error": answer.get("error")}, error=True)
    found, expected = answer["found"], answer["expected"]
    told = {"called": answer["called"], "found": [_thing(one) for one in found[:FOUND_MOST]]}
    told |= {"expected": expected} if expected else {}
    return AgentAnswer({"found": len(found), "expected": len(expected)}, told)


def things_told(answer: Answer, asked: Answer) -> AgentAnswer:
    """Of an answer on `rfnav/things`."""
    things, room = answer["things"], asked.get("room")
    fit = [one for one in things if room is None or one.get("room") == room]
    told = [_thing(one) for one in fit[: int(asked.get("most", THINGS_USUAL))]]
    facts = {"things": len(told), "left_off": len(fit) - len(told) + answer.get("left_off", 0)}
    return AgentAnswer(facts, {"things": told} | ({"said": NOTHING} if not things else {}))


def _thing(one: Answer) -> dict[str, Any]:
    names = ("name", "confidence", "xy", "size_m", "room")
    return {name: one.get(name) for name in names}
