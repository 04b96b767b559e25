"""A feed from a recording: a playhead that pages move, and what was told when it passes by."""

import json
import threading
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np

from runtime.errors import RfNavError
from runtime.recording.exact import read_array
from runtime.recording.reader import Recorded
from runtime.tracing.budgets import Budgets
from runtime.view import told
from runtime.view.feed import Audience, Content
from runtime.view.hearing import FAULTS, PICTURE_S, grid_of
from runtime.view.pictures import camera_message, named_boxes
from runtime.view.recorded import DriveFilm
from runtime.view.scenes import planned, scene_marks
from runtime.view.tiles import CELLS, TileMap

SPEEDS: Final = (0.0, 8.0)
STATE_S: Final = 0.1  # between two states, of our time
AT_S: Final = 0.2
ONLY_SHOWN: Final = "this is a recording: it is looked at, and nothing is asked of it"


@dataclass
class _Then:
    """What was true at the playhead."""

    pose: list[float] | None = None
    twist: tuple[float, float] = (0.0, 0.0)
    halt: str = ""
    cause: str = ""
    command: Mapping[str, Any] = field(default_factory=dict)
    rest: str = ""
    frontier: object = None
    plan: list[list[float]] = field(default_factory=list)
    marks: Mapping[str, Any] = field(default_factory=dict)
    names: list[str] = field(default_factory=list)
    goal_name: str = ""
    image_px: tuple[int, int] = (0, 0)


class ReplayFeed:
    """A `Feed`. RecordingError, one line, for a file that is none. It begins at rest, at the
    beginning."""

    def __init__(self, path: Path, budgets: Budgets) -> None:
        self._drive, self._path, self._budgets = DriveFilm(path), path, budgets
        self.tiles = TileMap()
        self._changed = threading.Condition()
        self._speed, self._seek_ns = 0.0, self._drive.moments.first_ns
        self._moved, self._pages, self._closed = True, 0, False
        self._then, self._at_ns = _Then(), self._seek_ns
        self._told_s = dict.fromkeys(("state", "at", "picture"), 0.0)
        self._number = 0  # of the decision that was told last
        self._mapped = False  # whether there was a map by then
        self._radius_m = self._read_radius_m()
        self._thread = threading.Thread(target=self._play, name="replay", daemon=True)

    def start(self, audience: Audience) -> None:
        self._audience = audience
        self._audience.tell("span", self._span())
        self._thread.start()

    def welcome(self) -> dict[str, Any]:
        can = {"teleop": False, "command": False, "camera": bool(self._drive.moments.color)}
        stages, most = told.budgets_of(self._budgets), {"max_v_mps": 0.0, "max_w_radps": 0.0}
        about = {
            "robot": {"radius_m": self._radius_m},
            "budgets": stages,
            "file": self._path.name,
        }
        return {"mode": "replay", "can": can, **most, **about}

    def attend(self, pages: int, cameras: int) -> None:
        with self._changed:
            self._pages = pages
            self._changed.notify_all()

    def ask(self, what: str, body: object) -> dict[str, Any]:
        number = body.get("number") if isinstance(body, dict) else None
        decisions = self._drive.moments.decisions
        if what != "decision":
            raise ValueError(ONLY_SHOWN)
        if not isinstance(number, int) or not 1 <= number <= len(decisions):
            raise ValueError(f"decision {str(number)[:20]}: there is none")
        at_ns, decision = decisions[number - 1]
        return {**decision, "t_s": at_ns / 1e9, "scene": None}

    def steer(self, who: int, order: Content) -> None:
        moments = self._drive.moments
        with self._changed:
            if order.get("kind") == "seek":
                first_s, last_s = moments.first_ns / 1e9, moments.last_ns / 1e9
                wanted_ns = int(max(first_s, min(last_s, told.number(order.get("t_s")))) * 1e9)
                self._seek_ns = max(moments.first_ns, min(moments.last_ns, wanted_ns))
                self._moved = True
            elif order.get("kind") == "play":
                least, most = SPEEDS
                self._speed = max(least, min(most, told.number(order.get("speed"))))
                if self._speed and self._at_ns >= moments.last_ns:
                    self._seek_ns, self._moved = moments.first_ns, True
            self._changed.notify_all()

    def gone(self, who: int) -> None:
        pass

    def close(self) -> None:
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        if self._thread.is_alive():
            self._thread.join(timeout=5.0)

    def _span(self) -> dict[str, Any]:
        moments = self._drive.moments
        names = "number", "frontier", "in_words"
        decisions = [
            {"t_s": at / 1e9, **{name: one.get(name) for name in names}}
            for at, one in moments.decisions
        ]
        return {
            "from_s": moments.first_ns / 1e9,
            "to_s": moments.last_ns / 1e9,
            "goals": [{"t_s": at / 1e9, "goal": goal} for at, goal in moments.goals],
            "decisions": decisions,
            "stops": [{"t_s": at / 1e9, **stop} for at, stop in moments.stops],
            "cut": self._drive.cut,
        }

    def _read_radius_m(self) -> float:
        for message in self._drive.since(self._drive.moments.first_ns):
            if message.topic == "/loop/configuration":
                values = told.table(json.loads(message.payload), "values")
                return told.number(values.get("robot.radius_m")) or 0.18
        return 0.18

    # -- the playhead, in its own thread -----------------------------------------------------------

    def _play(self) -> None:
        coming: Iterator[Recorded] = iter(())
        waiting: Recorded | None = None
        base_s = base_ns = 0.0  # our time at a moment of the recording
        speed = 0.0
        while True:
            with self._changed:
                while not (self._closed or self._moved or (self._speed and self._pages)):
                    speed = 0.0
                    self._changed.wait(1.0)
                if self._closed:
                    return
                moved, self._moved, wanted = self._moved, False, self._speed
                at_ns = self._seek_ns
            if moved:
                coming = self._jumped(at_ns)
                waiting, speed = next(coming, None), -1.0
            if wanted != speed:
                speed, base_s, base_ns = wanted, time.monotonic(), self._at_ns
                self._tell_at()
            if not speed:
                continue
            if waiting is None:
                self._ended()
                continue
            due_s = base_s + (waiting.log_time_ns - base_ns) / 1e9 / speed
            if due_s > time.monotonic():
                with self._changed:
                    if not (self._moved or self._closed or self._speed != speed):
                        self._changed.wait(min(0.1, due_s - time.monotonic()))
                continue
            self._at_ns = waiting.log_time_ns
            self._take(waiting, True)
            self._tell_due()
            waiting = next(coming, None)

    def _jumped(self, at_ns: int) -> Iterator[Recorded]:
        """What comes after a moment; how it was then is told."""
        self._then, self._number, self._mapped = _Then(), 0, False
        picture: Recorded | None = None
        for message in self._drive.before(at_ns):
            self._take(message, False)
        coming = self._drive.since(at_ns)
        first: list[Recorded] = []
        for message in coming:
            if message.log_time_ns > at_ns:
                first.append(message)
                break
            picture = message if message.topic == self._drive.moments.color else picture
            if message.topic != self._drive.moments.color:
                self._take(message, False)
        self._at_ns = at_ns
        if not self._mapped:
            self.tiles.clear()
            self._audience.mapped()
        if picture is not None:
            self._take(picture, True)
        self._tell_all()
        return (message for part in (first, coming) for message in part)

    def _ended(self) -> None:
        with self._changed:
            self._speed = 0.0
        self._tell_all()

    def _take(self, message: Recorded, tells: bool) -> None:
        """Read one message; what is of another version is left out."""
        kind = message.topic.removeprefix("/loop/")
        try:
            if message.topic == self._drive.moments.color:
                self._picture(message)
            elif kind != message.topic:
                self._ours(kind, message.payload, tells)
        except (RfNavError, *FAULTS):
            return

    def _ours(self, kind: str, payload: bytes, tells: bool) -> None:
        then = self._then
        if kind == "map":
            self.tiles.put(CELLS, grid_of(payload, "/loop/map"))
            self._mapped = True
            self._audience.mapped()
        elif kind == "scene":
            then.marks = scene_marks(payload)
            if tells:
                self._tell_scene()
        elif kind == "path":
            then.plan = planned(payload)
        elif kind in ("tick", "command", "halt", "rest", "order", "frame", "decision"):
            self._note(kind, json.loads(payload), tells)
        elif kind == "detections" and tells:
            self._boxes(json.loads(payload))

    def _note(self, kind: str, content: Mapping[str, Any], tells: bool) -> None:
        then = self._then
        if kind == "tick":
            pose = told.table(told.table(content, "odometry"), "pose")
            if pose:
                then.pose = [round(pose[name], 3) for name in ("x_m", "y_m", "yaw_rad")]
            sent = told.table(content, "sent")
            then.twist = told.number(sent.get("v_mps")), told.number(sent.get("w_radps"))
            then.halt = str(content.get("halt", ""))
        elif kind == "command":
            then.command, then.rest = content, ""
        elif kind == "halt":
            then.cause = str(content["reason"]) if content["driving"] else ""
        elif kind == "rest":
            then.rest, then.plan = str(content["state"]), []
        elif kind == "order":
            goal = content["goal"]
            then.names = [str(names[0]) for names in goal["classes"]]
            then.goal_name, then.rest, then.command = str(goal["name"]), "", {}
        elif kind == "frame":
            size = content["intrinsics"]
            then.image_px = int(size["width"]), int(size["height"])
        else:
            then.frontier = content.get("frontier")
            if tells:
                self._tell_decision()

    def _picture(self, message: Recorded) -> None:
        now_s = time.monotonic()
        if now_s - self._told_s["picture"] >= PICTURE_S or not self._speed:
            self._told_s["picture"] = now_s
            picture, _ = camera_message(message.payload, message.topic, True)
            self._audience.picture(picture)

    def _boxes(self, content: Mapping[str, Any]) -> None:
        then = self._then
        labels = np.asarray(read_array(content["labels"])).tolist()
        names = [then.names[n] for n in labels]
        found = read_array(content["boxes_px"]), read_array(content["scores"])
        boxes = named_boxes(*found, names, then.goal_name)
        size = {"width": then.image_px[0], "height": then.image_px[1]}
        self._tell("boxes", {"stamp_ns": self._at_ns, **size, "boxes": boxes})

    # -- what is told ------------------------------------------------------------------------------

    def _tell(self, kind: str, content: Content) -> None:
        self._audience.tell(kind, {"t_s": self._at_ns / 1e9, **content})

    def _tell_at(self) -> None:
        self._tell("at", {"speed": self._speed})

    def _tell_due(self) -> None:
        now_s = time.monotonic()
        for kind, every_s, tell in (
            ("state", STATE_S, self._tell_state), ("at", AT_S, self._tell_at),
        ):  # fmt: skip
            if now_s - self._told_s[kind] >= every_s:
                self._told_s[kind] = now_s
                tell()

    def _tell_all(self) -> None:
        self._tell_decision()
        self._tell_state()
        self._tell_scene()
        self._tell_at()

    def _tell_state(self) -> None:
        then, (began_ns, goal) = self._then, self._drive.goal_at(self._at_ns)
        searching = bool(goal) and not then.rest
        state = "held" if searching and then.halt else "searching" if searching else "ready"
        command = then.command if searching else {}
        _, driven_m = self._drive.way_until(self._at_ns)
        feedback: dict[str, Any] = {
            "id": str(began_ns), "goal": goal, "elapsed_s": (self._at_ns - began_ns) / 1e9,
            "driven_m": round(driven_m, 2), "decisions": self._number, "mode": command.get("mode"),
            "reason": command.get("reason"), "frontiers": len(command.get("frontiers") or ()),
        }  # fmt: skip
        if not searching:
            feedback = {"result": then.rest, "goal": goal, "sentence": then.rest} if goal else {}
        shown: dict[str, Any] = {
            "pose": then.pose, "v_mps": then.twist[0], "w_radps": then.twist[1],
            "runtime": {"state": state, "cause": then.cause if then.halt else ""},
            "halt": (then.cause or then.halt) if then.halt else "", "frontier": then.frontier,
            "toward_xy": command.get("toward_xy"),
        }  # fmt: skip
        beside = {"link": "ok", "why": "", "age_s": 0.0, "teleop": None}
        self._tell("state", {**beside, **told.state_of(shown, feedback, {})})

    def _tell_scene(self) -> None:
        then, marks = self._then, self._then.marks
        path, _ = self._drive.way_until(self._at_ns)
        away = dict(then.command.get("frontiers") or ())
        frontiers = [
            {**one, "distance_m": away.get(one["id"]), "elected": one["id"] == then.frontier}
            for one in marks.get("frontiers", ())
        ]
        things = [{**one, "goal": one["name"] == then.goal_name} for one in marks.get("things", ())]
        step = max(1, -(-len(path) // 500))
        drawn = {"plan": then.plan, "path": path[::-step][::-1], "area": None, "rooms": [],
                 "hues": []}  # fmt: skip
        told_scene = {"goal": then.goal_name, "frontiers": frontiers, "things": things, **drawn}
        self._tell("scene", {**told_scene, "belief": []})

    def _tell_decision(self) -> None:
        """The last that was made by now, if it is another than was told; 0 before the first."""
        decided = [one for one in self._drive.moments.decisions if one[0] <= self._at_ns]
        if not decided:
            self._tell("decision", {"number": 0})
        elif decided[-1][1]["number"] != self._number:
            at_ns, decision = decided[-1]
            self._number = decision["number"]
            self._tell("decision", {"t_s": at_ns / 1e9, **decision})
