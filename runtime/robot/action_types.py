"""ROS 2 types of an action: three services and two topics, of its goal, result and feedback."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Self

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import get_types_from_msg

from runtime.robot import wire

CANCEL: Final = "action_msgs/srv/CancelGoal"
STATUS: Final = "action_msgs/msg/GoalStatusArray"
GOAL_INFO: Final = "action_msgs/msg/GoalInfo"
GOAL_STATUS: Final = "action_msgs/msg/GoalStatus"
UUID: Final = "unique_identifier_msgs/msg/UUID"
TIME: Final = "builtin_interfaces/msg/Time"


def _register(kind: str, *fields: tuple[str, Any]) -> None:
    made: Any = {kind: ([], list(fields))}
    wire.STORE.register(made)


def _named(kind: str) -> Any:
    return Nodetype.NAME, kind


def _base(name: str) -> Any:
    return Nodetype.BASE, (name, 0)


_register(f"{CANCEL}_Request", ("goal_info", _named(GOAL_INFO)))
_register(
    f"{CANCEL}_Response",
    ("return_code", _base("int8")),
    ("goals_canceling", (Nodetype.SEQUENCE, (_named(GOAL_INFO), 0))),
)


@dataclass(frozen=True)
class ActionType:
    """`kind`: `pkg/action/Name`; its parts are in `wire.STORE` as `KIND_Goal`, `KIND_Result`,
    `KIND_Feedback`."""

    kind: str

    @classmethod
    def define(cls, kind: str, goal: str, result: str, feedback: str) -> Self:
        """An action of fields as an .action file has them, one a line."""
        for part, fields in (("Goal", goal), ("Result", result), ("Feedback", feedback)):
            wire.STORE.register(get_types_from_msg(fields, f"{kind}_{part}"))
        id = ("goal_id", _named(UUID))
        _register(f"{kind}_SendGoal_Request", id, ("goal", _named(f"{kind}_Goal")))
        _register(f"{kind}_SendGoal_Response", ("accepted", _base("bool")), ("stamp", _named(TIME)))
        _register(f"{kind}_GetResult_Request", id)
        _register(
            f"{kind}_GetResult_Response",
            ("status", _base("int8")),
            ("result", _named(f"{kind}_Result")),
        )
        _register(f"{kind}_FeedbackMessage", id, ("feedback", _named(f"{kind}_Feedback")))
        return cls(kind)

    def new(self, part: str, *values: Any, **named: Any) -> Any:
        """A message of one of its types: "Goal", "Result", "FeedbackMessage", ..."""
        return wire.STORE.types[f"{self.kind}_{part}"](*values, **named)

    def blank(self, part: str) -> Any:
        """The same with zeros and nothing in it."""
        return _blank(f"{self.kind}_{part}")

    def filled(self, part: str, values: Mapping[str, Any], made: Mapping[str, Any]) -> Any:
        """The same with what there is for it, by its fields' names: `values` as JSON has them, each
        within what its field can hold, and messages that are `made`."""
        kind = f"{self.kind}_{part}"
        fields = wire.STORE.fielddefs[kind][1]
        return wire.STORE.types[kind](
            *(
                made[name] if name in made else _fitting(values.get(name), *desc)
                for name, desc in fields
            )
        )


def _blank(kind: str) -> Any:
    values = [_blank_field(*desc) for _, desc in wire.STORE.fielddefs[kind][1]]
    return wire.STORE.types[kind](*values)


def _fitting(value: Any, node: Any, what: Any) -> Any:
    """A value of JSON in a field, which stays blank where it does not fit."""
    name = what[0] if node == Nodetype.BASE else ""
    if name == "string":
        return value if isinstance(value, str) else ""
    if name == "bool":
        return value is True
    if not name or isinstance(value, bool) or not isinstance(value, int | float):
        return _blank_field(node, what)
    holds = np.finfo(name) if name.startswith("float") else np.iinfo(name)
    least, most = np.array([holds.min, holds.max]).tolist()
    return np.dtype(name).type(min(max(value, least), most))


def _blank_field(node: Any, what: Any) -> Any:
    if node == Nodetype.NAME:
        return _blank(what)
    if node == Nodetype.BASE:
        name = what[0]
        return "" if name == "string" else False if name == "bool" else np.dtype(name).type(0)
    (inner, of), count = what
    count = count if node == Nodetype.ARRAY else 0  # of a sequence it is the most
    if inner == Nodetype.BASE and of[0] != "string":
        return np.zeros(count, of[0])
    return [_blank_field(inner, of) for _ in range(count)]
