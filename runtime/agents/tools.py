"""What an agent may ask for: a list of tools, of goals and of what is known. None of them moves the
base by itself, and none raises a limit."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

WAIT_S: Final = 600.0
IF_BUSY: Final = ("refuse", "queue", "preempt")
NAME_CHARS: Final = 80
THINGS_MOST, THINGS_USUAL = 200, 50
Schema = Mapping[str, Any]
RETURN: Final[Schema] = {
    "type": "boolean", "default": False,
    "description": "Go back then to where it began; half of the limits is kept for that.",
}  # fmt: skip


@dataclass(frozen=True)
class AgentLimits:
    """What whoever starts the server allows its clients. `money_usd`: None leaves it to the robot's
    own cap; `area`: as a goal's, all goals are bound to it; `look`: whether images are given;
    `queue`: how many goals, whoever asked for them, wait at most when a client's is taken."""

    time_s: float = 900.0
    distance_m: float = 200.0
    money_usd: float | None = None
    area: Mapping[str, str] = field(default_factory=dict)
    look: bool = False
    queue: int = 4


@dataclass(frozen=True)
class AgentTool:
    """`takes`: JSON Schema by argument; `reads`: whether it only tells."""

    name: str
    title: str
    says: str
    takes: Mapping[str, Schema]
    needs: tuple[str, ...] = ()
    reads: bool = True

    def schema(self) -> dict[str, Any]:
        """Of its arguments."""
        return {
            "type": "object",
            "properties": {name: dict(schema) for name, schema in self.takes.items()},
            "required": list(self.needs),
            "additionalProperties": False,
        }


def agent_tools(limits: AgentLimits) -> dict[str, AgentTool]:
    """By name."""
    tools = [*_goals(limits), *QUESTIONS, *([LOOK] if limits.look else [])]
    return {tool.name: tool for tool in tools}


def _goals(limits: AgentLimits) -> tuple[AgentTool, ...]:
    goal = _goal_arguments(limits)
    spends = {"money_limit_usd": _number(0.0, _money(limits), "Most that clouds may cost, USD.")}
    room = {} if limits.area else {"room": _text("Look only in rooms of this type.")}
    find = AgentTool(
        "find_object",
        "Look for a thing",
        "Have the robot look for a thing in the home and drive to it. Answers at once with the "
        "goal's id, unless wait_s is given; then call status with a wait_s until it has ended. "
        'Several in turn: "a mug, then a chair". To give this call up cancels the goal.',
        {"thing": _text('What to look for, e.g. "a red mug".'), **goal, **spends, **room},
        ("thing",),
        reads=False,
    )
    go = AgentTool(
        "go_to_place",
        "Go to a place",
        "Have the robot drive to a place that has a name; list_rooms has the names. Waits and "
        "is given up as find_object.",
        {"place": _text("The place's name."), **goal},
        ("place",),
        reads=False,
    )
    return (find,) if "room" in limits.area else (find, go)  # of which type is the place's?


def _goal_arguments(limits: AgentLimits) -> dict[str, Schema]:
    busy = "Where another goal is under way: this one is refused, waits, or takes its place."
    back = {} if limits.area else {"then_return": RETURN}  # it may have begun outside
    return {
        "wait_s": _wait(),
        "if_busy": {"type": "string", "enum": list(IF_BUSY), "default": IF_BUSY[0],
                    "description": busy},
        "time_limit_s": _number(1.0, limits.time_s, "Most seconds that it may take."),
        "distance_limit_m": _number(0.1, limits.distance_m, "Most metres that it may drive."),
        **back,
    }  # fmt: skip


def _money(limits: AgentLimits) -> float:
    return 1e6 if limits.money_usd is None else limits.money_usd


def _wait() -> Schema:
    told = "Seconds to wait for its end; stay below your own time-out. 0 answers at once."
    return {**_number(0.0, WAIT_S, told), "default": 0}


def _text(told: str) -> Schema:
    return {"type": "string", "minLength": 1, "maxLength": NAME_CHARS, "description": told}


def _number(least: float, most: float, told: str, whole: bool = False) -> Schema:
    kind = "integer" if whole else "number"
    return {"type": kind, "minimum": least, "maximum": most, "description": told}


QUESTIONS: Final = (
    AgentTool(
        "status",
        "How it stands",
        "What the robot does now, or what came of the goal of that id. With wait_s it answers "
        "when that goal ends, or after so long, and tells of progress meanwhile.",
        {"id": _text("A goal's id; else the one under way."), "wait_s": _wait()},
    ),
    AgentTool(
        "cancel",
        "Cancel",
        "End the goal of that id, or all; the robot stands then.",
        {"id": _text("A goal's id; else all.")},
        reads=False,
    ),
    AgentTool(
        "why",
        "Why it did that",
        "Why the robot goes where it goes, and what held it last: the newest decision and stop, "
        "or those of a number.",
        {
            "decision": _number(1, 10**9, "Its number.", whole=True),
            "stop": _number(1, 10**9, "Its number.", whole=True),
        },
    ),
    AgentTool(
        "where_is",
        "Where a thing is",
        "Where a thing was seen, or where the search that is on expects it. The robot does not "
        "move for it.",
        {"thing": _text("Its name.")},
        ("thing",),
    ),
    AgentTool(
        "list_things",
        "Things seen",
        "Things on the robot's map, the surest first; x, y in metres of odometry's frame.",
        {
            "most": _number(1, THINGS_MOST, f"So many; else {THINGS_USUAL}.", whole=True),
            "room": _text("Only those in rooms of this type."),
        },
    ),
    AgentTool(
        "list_rooms",
        "Rooms and places",
        "Types of room that were seen, how much floor of each, and places that have names.",
        {},
    ),
    AgentTool(
        "map_image",
        "Map",
        "The map as a picture: floor, obstacles, things, frontiers, the way driven.",
        {},
    ),
)
"""What all may ask; a cancel is always taken."""
LOOK: Final = AgentTool("look", "Look", "What the robot's camera sees now, as a JPEG.", {})
