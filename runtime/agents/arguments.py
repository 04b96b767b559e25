"""A call's arguments, read within what its tool takes."""

from collections.abc import Mapping
from typing import Any, Final

from runtime.agents.tools import AgentTool, Schema

WORD: Final = 40  # letters of a word that is told back


def read_arguments(tool: AgentTool, given: Mapping[str, Any] | None) -> dict[str, Any]:
    """As they were given; ValueError, one line, for what the tool does not take."""
    told = dict(given or {})
    for name in told:
        if name not in tool.takes:
            takes = ", ".join(tool.takes) or "nothing"
            raise ValueError(f"{tool.name}: {str(name)[:WORD]!r}: takes {takes}")
    for name in tool.needs:
        if name not in told:
            raise ValueError(f"{tool.name}: {name} is missing")
    for name, value in told.items():
        if wrong := _wrong(value, tool.takes[name]):
            raise ValueError(f"{tool.name}: {name}: {wrong}")
    return told


def _wrong(value: Any, schema: Schema) -> str:
    """What; "" for nothing."""
    match schema["type"]:
        case "boolean":
            return "" if isinstance(value, bool) else "must be true or false"
        case "string" if "enum" in schema:
            return "" if value in schema["enum"] else f"must be one of {', '.join(schema['enum'])}"
        case "string":
            most = schema["maxLength"]
            fine = isinstance(value, str) and 0 < len(value) <= most and value.isprintable()
            return "" if fine else f"must be 1 to {most} printable letters"
        case kind:
            return _wrong_number(value, schema, whole=kind == "integer")


def _wrong_number(value: Any, schema: Schema, whole: bool) -> str:
    least, most = schema["minimum"], schema["maximum"]
    number = isinstance(value, int if whole else int | float) and not isinstance(value, bool)
    if number and least <= value <= most:  # which NaN is not
        return ""
    return f"must be a {'whole ' if whole else ''}number from {least:g} to {most:g}"
