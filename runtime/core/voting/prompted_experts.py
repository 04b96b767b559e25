"""Experts that reason in words, for large models: a brief becomes a conversation, and the reply, a
reason and a set of frontiers, becomes a vote. No model here.

What may be answered is told twice, as a JSON schema (for servers) and as a GBNF grammar (for
llama.cpp): `{"reason": "...", "frontiers": [2, 5]}` with a non-empty subset of the brief's
frontiers, or `"frontiers": "abstain"`. A model that was held to neither is read as leniently as
can be done without guessing.
"""

import base64
import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from runtime.core.mapping.framing import marked
from runtime.core.types import Absence, Brief, FrontierBrief, InImage, Missing, Vote

FRONTIERS_TOLD = 16  # the nearest; a prompt must fit a small context
OBJECTS_TOLD = 8  # of each, the nearest
REASON_CHARS = 240
NAME_CHARS = 60
REPLY_CHARS = 20_000  # of a reply that are looked at
SURE = 0.5  # an object or a room that is told without a number
SIDES = ("on the left", "in the middle", "on the right")  # of a picture
RANGE_STEP_M = 0.5
ABSTAIN = "abstain"

_MARKERS = str.maketrans(dict.fromkeys("<>[]{}|｜", " "))  # what templates make their marks of
_TASK = {
    "o2f": "Judge only by the objects that were seen near each frontier.",
    "r2f": "Judge only by the type of room that each frontier seems to lead to.",
    "both": "Judge by the objects near each frontier and by its type of room.",
    "sle": (
        "Judge by the picture taken toward each frontier{mark}, and by the objects and the type of "
        "room there."
    ),
}
_MARK = ", in which a red dot with a white rim marks the place"
_SYSTEM = """\
You guide a robot that looks for an object in a home that it has never seen before. It has mapped \
a part of the home. A frontier is a place where the mapped part ends and unexplored space begins. \
Recommend every frontier behind which the object is likely to be found, and only those. {task} \
Answer with one JSON object: {{"reason": "...", "frontiers": [...]}}, the reason in one short \
sentence, the frontiers by number. If nothing speaks for one frontier rather than another, answer \
with "frontiers": "abstain"."""


@dataclass(frozen=True)
class Message:
    """What is said by `role`; parts in order, text as str and JPEG images as bytes."""

    role: str
    parts: tuple[str | bytes, ...]


@dataclass(frozen=True)
class Prompt:
    """A conversation and the ids that its answer may name, sorted."""

    expert: str
    messages: tuple[Message, ...]
    ids: tuple[int, ...]

    @property
    def images(self) -> int:
        return sum(isinstance(part, bytes) for m in self.messages for part in m.parts)

    @property
    def text_bytes(self) -> int:
        """UTF-8 bytes of all text: no tokenizer makes more tokens than that of it."""
        texts = (part for m in self.messages for part in m.parts if isinstance(part, str))
        return sum(len(text.encode()) for text in texts)


def compose(expert: str, brief: Brief, images: bool = True, marks: bool = True) -> Prompt | Missing:
    """The question that one expert is asked; Missing when it has nothing to go by. Without
    `images` there are none in it, and an expert of images has nothing to go by. Without `marks` it
    is told in words where in its image a frontier is, so that images stay what they are."""
    if len(brief.frontiers) < 2:
        return Missing(expert, Absence.NO_EVIDENCE)  # one frontier is no choice
    shown = images and expert == "sle"
    if expert == "sle" and not images:
        return Missing(expert, Absence.PRIVACY, "no image may be sent")
    near = sorted(brief.frontiers, key=lambda f: (f.distance_m, f.id))[:FRONTIERS_TOLD]
    told = sorted(near, key=lambda f: f.id)
    if not any(_evidence(expert, f) for f in told):
        return Missing(expert, Absence.NO_IMAGES if expert == "sle" else Absence.NO_EVIDENCE)
    goal = _word(brief.goal)
    parts: list[str | bytes] = [f"The robot looks for: {goal}.\n"]
    for frontier in told:
        parts.append(_told(expert, frontier, marks))
        if shown and frontier.image:
            parts.append(_marked(frontier) if marks else frontier.image)
    parts.append(f"\nWhich frontiers should the robot explore to find: {goal}?")
    task = _TASK[expert].format(mark=_MARK if marks else "")
    system = Message("system", (_SYSTEM.format(task=task),))
    return Prompt(expert, (system, Message("user", _joined(parts))), tuple(f.id for f in told))


def single(brief: Brief, frontier: FrontierBrief) -> tuple[Message, ...]:
    """SLE's question about one frontier's picture, to be answered by yes or no. What changes from
    step to step is told coarsely, so that the same is asked again, and an answer can be kept."""
    goal = _word(brief.goal)
    question = (
        f"A robot in a home looks for: {goal}. In this picture, unexplored space begins "
        f"{_place(frontier.in_image)}. {_around(frontier)}"
        f"Is {goal} likely to be found there or beyond? Answer yes or no."
    )
    return (Message("user", (frontier.image, question)),)


def chat(messages: Iterable[Message]) -> list[dict[str, Any]]:
    """Messages as OpenAI-compatible endpoints and llama.cpp's handlers take them; images become
    data URLs."""
    return [{"role": m.role, "content": _content(m.parts)} for m in messages]


def schema(ids: Sequence[int]) -> dict[str, Any]:
    """JSON schema of an answer that names only these frontiers."""
    subset = {
        "type": "array",
        "items": {"type": "integer", "enum": list(ids)},
        "minItems": 1,
        "maxItems": len(ids),
    }
    return {
        "type": "object",
        "properties": {
            "reason": {"type": "string"},
            "frontiers": {"anyOf": [subset, {"type": "string", "enum": [ABSTAIN]}]},
        },
        "required": ["reason", "frontiers"],
        "additionalProperties": False,
    }


def grammar(ids: Sequence[int]) -> str:
    """GBNF of the same answer; a set is spelled in ascending order, so that none is named twice."""
    ordered = sorted(set(ids))
    lines = [
        'root ::= "{\\"reason\\": " text ", \\"frontiers\\": " ( set | none ) "}"',
        f'none ::= "\\"{ABSTAIN}\\""',
        # printable, without quote and backslash: nothing in it needs an escape
        f'text ::= "\\"" [^"\\\\\\x00-\\x1F\\x7F]{{1,{REASON_CHARS}}} "\\""',
        f'set ::= "[" ( {" | ".join(f"from{n}" for n in range(len(ordered)))} ) "]"',
    ]
    for n, number in enumerate(ordered):
        later = " | ".join(f"from{k}" for k in range(n + 1, len(ordered)))
        lines.append(f'from{n} ::= "{number}"' + (f' ( ", " ( {later} ) )?' if later else ""))
    return "\n".join(lines) + "\n"


def read(reply: str, expert: str, ids: Iterable[int], rung: str = "local") -> Vote | Missing:
    """A model's reply as a vote, by equal shares of its set; anything but a non-empty set of known
    frontiers is Missing, with the cause."""
    outcome = _read(reply, expert, ids, rung)
    return replace(outcome, reply=reply[:REPLY_CHARS])


def _read(reply: str, expert: str, ids: Iterable[int], rung: str) -> Vote | Missing:
    found = _answer(reply[:REPLY_CHARS])
    if found is None:
        return Missing(expert, Absence.NONSENSE, "no answer in the reply")
    reason, named = _line(found.get("reason"), REASON_CHARS), found["frontiers"]
    if isinstance(named, str) and named.strip().lower() == ABSTAIN:
        return Missing(expert, Absence.ABSTAINS, reason)
    numbers = [_number(item) for item in named] if isinstance(named, list) else [None]
    chosen = sorted({n for n in numbers if n is not None})
    if None in numbers:
        return Missing(expert, Absence.NONSENSE, f"frontiers are {_line(json.dumps(named), 60)}")
    known = sorted(set(ids))
    strangers = [n for n in chosen if n not in known]
    if strangers:
        told = _line(", ".join(map(str, strangers)), 60)
        return Missing(expert, Absence.NONSENSE, f"voted for unknown frontier {told}")
    if not chosen:
        return Missing(expert, Absence.NONSENSE, "voted for no frontier")
    shares = tuple((n, 1.0 / len(chosen) if n in chosen else 0.0) for n in known)
    return Vote(expert, tuple(chosen), shares, reason or "no reason given", rung)


def _answer(text: str) -> dict[str, Any] | None:
    """The last JSON object in a text that has "frontiers": models tend to think aloud first."""
    decoder, at, found = json.JSONDecoder(), 0, None
    while (at := text.find("{", at)) >= 0:
        try:
            value, end = decoder.raw_decode(text, at)
        except (ValueError, RecursionError):
            at += 1
            continue
        if isinstance(value, dict) and "frontiers" in value:
            found = value
        at = end
    return found


def _number(item: object) -> int | None:
    """2, "2" and "frontier 2" are 2; True, 2.5 and "two" are nothing."""
    if isinstance(item, bool):
        return None
    if isinstance(item, int):
        return item
    if isinstance(item, str):
        digits = re.fullmatch(r"\s*(?:frontier\s*)?#?(\d{1,9})\s*", item, re.IGNORECASE | re.ASCII)
        return int(digits[1]) if digits else None
    return None


def _evidence(expert: str, frontier: FrontierBrief) -> bool:
    if expert == "sle":
        return bool(frontier.image)
    objects, rooms = bool(frontier.objects), bool(frontier.rooms)
    return {"o2f": objects, "r2f": rooms, "both": objects or rooms}[expert]


def _marked(frontier: FrontierBrief) -> bytes:
    return marked(frontier.image, frontier.in_image)


def _place(at: InImage | None) -> str:
    """Where something is in a picture, in words."""
    if at is None:
        return "somewhere in it"
    side = SIDES[min(int(at.column * len(SIDES)), len(SIDES) - 1)]
    return f"{side}, {max(RANGE_STEP_M, round(at.range_m / RANGE_STEP_M) * RANGE_STEP_M):g} m away"


def _told(expert: str, frontier: FrontierBrief, marks: bool) -> str:
    lines = [f"\nFrontier {frontier.id}, {frontier.distance_m:.1f} m away."]
    if expert != "o2f" and frontier.doorway:
        lines.append("It is a doorway: another room may lie behind it.")
    if expert != "r2f":
        lines.append(_objects(frontier))
    if expert != "o2f":
        lines.append(_rooms(frontier))
    if expert == "sle":
        lines.append(_introduced(frontier, marks))
    return " ".join(line for line in lines if line)


def _introduced(frontier: FrontierBrief, marks: bool) -> str:
    if not frontier.image:
        return "There is no picture of it."
    return "Its picture:" if marks else f"Its picture, in which it is {_place(frontier.in_image)}:"


def _around(frontier: FrontierBrief) -> str:
    """By their names alone."""
    sure = (_word(o.name) for o in frontier.objects if o.confidence >= SURE)
    near = list(dict.fromkeys(sure))[:OBJECTS_TOLD]
    room = max(frontier.rooms, key=lambda room: (room[1], room[0]), default=("", 0.0))
    told = f"Near it: {', '.join(near)}. " if near else ""
    return f"{told}The room seems to be: {_word(room[0])}. " if room[1] >= SURE else told


def _objects(frontier: FrontierBrief) -> str:
    if not frontier.objects:
        return "No object is known near it."
    seen = (
        f"{_word(o.name)} ({o.distance_m:.1f} m, {o.confidence:.0%} sure)"
        for o in frontier.objects[:OBJECTS_TOLD]  # they are sorted by distance
    )
    return f"Objects near it: {', '.join(seen)}."


def _rooms(frontier: FrontierBrief) -> str:
    likely = sorted(frontier.rooms, key=lambda room: (-room[1], room[0]))[:3]
    told = [f"{_word(name)} ({p:.0%})" for name, p in likely if p >= 0.05]
    return f"Room: {', '.join(told)}." if told else "Its type of room is not known."


def _joined(parts: Sequence[str | bytes]) -> tuple[str | bytes, ...]:
    """Texts beside each other made one."""
    out: list[str | bytes] = []
    for part in parts:
        if out and isinstance(part, str) and isinstance(last := out[-1], str):
            out[-1] = last + part
        else:
            out.append(part)
    return tuple(out)


def _content(parts: Sequence[str | bytes]) -> str | list[dict[str, Any]]:
    if len(parts) == 1 and isinstance(text := parts[0], str):
        return text
    return [
        {"type": "text", "text": part}
        if isinstance(part, str)
        else {"type": "image_url", "image_url": {"url": data_url(part)}}
        for part in parts
    ]


def data_url(jpeg: bytes) -> str:
    """RFC 2397."""
    return f"data:image/jpeg;base64,{base64.b64encode(jpeg).decode()}"


def _word(name: str) -> str:
    """A name from the map as it may stand in a prompt: one short line, in which no chat template
    sees the end of a turn, or the place of a picture."""
    return _line(name.translate(_MARKERS), NAME_CHARS)


def _line(text: object, limit: int) -> str:
    """Printable, on one line, not longer than `limit`."""
    if not isinstance(text, str):
        return ""
    line = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return line if len(line) <= limit else line[: limit - 1] + "…"
