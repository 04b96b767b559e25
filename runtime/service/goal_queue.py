"""The goals that were accepted and have not ended: the one under way, and those that wait for it.
They are kept in a file, where they are to be, whenever that changes."""

import json
import secrets
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final

from runtime.errors import SavedError, SensorError
from runtime.log import say
from runtime.robot.json_text import MESSAGE_BYTES, parse_json
from runtime.service.saved import save, saved

WAITING: Final = 16  # goals that wait for the one under way
ID_CHARS: Final = 64
FILE: Final = "goals.json"
VERSION: Final = 1
FILE_BYTES: Final = 2 * MESSAGE_BYTES


@dataclass(frozen=True)
class AskedGoal:
    """`body`: the request for it alone, see `Terms.read`. `begun`: how often a search for it
    began."""

    id: str
    text: str
    body: Mapping[str, Any]
    paused: bool = False
    begun: int = 0


Keep = Callable[[tuple[AskedGoal, ...]], None]


class GoalQueue:
    """`keep`: told of all that have not ended when they have changed."""

    def __init__(self, keep: Keep = lambda goals: None) -> None:
        self._keep = keep
        self._waiting: deque[AskedGoal] = deque()
        self.now: AskedGoal | None = None

    @property
    def waiting(self) -> tuple[AskedGoal, ...]:
        return tuple(self._waiting)

    def full(self, more: int, behind: bool, most: int) -> str:
        """Why so many more may not wait, `behind` those that do or in their place, where `most`
        may; "" where they may."""
        wait = len(self._waiting) if behind else 0
        if wait + more <= most:
            return ""
        remedy = "ask again when the next has begun, or cancel one" if wait else "ask for fewer"
        return f"goals that wait: {wait} now, {wait + more} with this, {most} at most: {remedy}"

    def wait(self, goals: Iterable[AskedGoal]) -> None:
        """They come after those that wait already."""
        self._waiting.extend(goals)
        self._changed()

    def next(self) -> AskedGoal | None:
        """The one whose turn it is, which waits no more; None where none waits."""
        return self._waiting.popleft() if self._waiting else None

    def begin(self, goal: AskedGoal, then: Iterable[AskedGoal] = ()) -> None:
        """It is under way; `then`: those that were asked for with it."""
        self.now = replace(goal, begun=goal.begun + 1)
        self._waiting.extend(then)
        self._changed()

    def pause(self, paused: bool) -> None:
        """The one under way."""
        if self.now is not None:
            self.now = replace(self.now, paused=paused)
            self._changed()

    def ended(self) -> None:
        """The one under way has."""
        self.now = None
        self._changed()

    def drop(self, id: object = None) -> tuple[AskedGoal, ...]:
        """Those that wait, or the one of that id, wait no more."""
        gone = tuple(goal for goal in self._waiting if id in (None, goal.id))
        self._waiting = deque(goal for goal in self._waiting if goal not in gone)
        if gone:
            self._changed()
        return gone

    def told(self) -> list[dict[str, str]]:
        return [{"id": goal.id, "goal": goal.text} for goal in self._waiting]

    def _changed(self) -> None:
        self._keep((*((self.now,) if self.now is not None else ()), *self._waiting))


class GoalFile:
    """Where they are kept for a restart. What cannot be written is said, and the robot goes on."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / FILE

    def keep(self, goals: tuple[AskedGoal, ...]) -> None:
        text = json.dumps({"version": VERSION, "goals": [asdict(goal) for goal in goals]})
        try:
            save(self._path, text.encode())
        except SavedError as error:
            say(f"{error}: a restart will not know of {len(goals)} goals")
            with suppress(OSError):
                self._path.unlink()  # of before: those may have ended since

    def kept(self) -> tuple[AskedGoal, ...]:
        """Those of the process before that had not ended, the one under way first. SavedError."""
        return saved(self._path, read_goals, FILE_BYTES) or ()


def read_goals(raw: bytes) -> tuple[AskedGoal, ...]:
    """What `GoalFile.keep` wrote; ValueError for anything else."""
    try:
        told = parse_json(raw, FILE, FILE_BYTES)
    except SensorError as error:
        raise ValueError(str(error)) from error
    goals = told.get("goals")
    if told.get("version") != VERSION or not isinstance(goals, list) or len(goals) > WAITING + 1:
        raise ValueError(f"is no list of goals of version {VERSION}")
    return tuple(map(_goal, goals))


def _goal(told: object) -> AskedGoal:
    match told:
        case {
            "id": str(id), "text": str(text), "body": dict(body), "paused": bool(paused),
            "begun": int(begun),
        } if is_id(id) and 0 <= begun < 1000:  # fmt: skip
            return AskedGoal(id, text, body, paused, begun)
    raise ValueError(f"{str(told)[:80]!r} is no goal")


def new_id() -> str:
    """A goal's, as no other has it."""
    return secrets.token_hex(4)


def is_id(value: object) -> bool:
    """Whether it may be a goal's."""
    return isinstance(value, str) and value.isalnum() and value.isascii() and len(value) <= ID_CHARS
