"""Episodes that cannot be driven in a home: why, and the file in OUT that keeps them."""

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

LEFT_OUT_FILE = "left_out.json"
NAMED = 5
"""A line names so many episodes, and counts the others."""


class Undrivable(Enum):
    """Why an episode cannot be driven."""

    INSIDE = "start inside furniture or a wall"
    OFF_FLOOR = "start off the free floor: too near an obstacle, or outside the home"
    NO_GOAL = "goal that is not in the home"
    UNRECOGNISED = "goal that a person would not recognise in the replica"
    UNSEEN = "goal that no free place sees from 1 m"
    CUT_OFF = "goal that no way leads to from the start"


@dataclass(frozen=True)
class StartCheck:
    """Whether an episode can be driven: `cause` says why not, None that it can."""

    episode: str
    cause: Undrivable | None


@dataclass(frozen=True)
class Survey:
    """What is known of an evaluation's starts. `unchecked`: episodes whose home could not be
    looked at; they are driven, and looked at again when the evaluation goes on."""

    left_out: tuple[StartCheck, ...] = ()
    unchecked: tuple[str, ...] = ()


def read_survey(out: Path) -> Survey | None:
    """What OUT keeps; None where no start of it was looked at."""
    path = out / LEFT_OUT_FILE
    if not path.is_file():
        return None
    kept = json.loads(path.read_text(encoding="utf-8"))
    rows = kept["left_out"]
    left = tuple(StartCheck(row["episode"], Undrivable[row["cause"]]) for row in rows)
    return Survey(left, tuple(kept["unchecked"]))


def save_survey(survey: Survey, out: Path) -> None:
    """Keep it in OUT, whole or not at all."""
    kept = {"left_out": rows_of(survey.left_out), "unchecked": list(survey.unchecked)}
    draft = (out / LEFT_OUT_FILE).with_suffix(".part")
    draft.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    os.replace(draft, out / LEFT_OUT_FILE)


def rows_of(left_out: Sequence[StartCheck]) -> list[dict[str, str]]:
    """Plain data, a row an episode."""
    return [
        {"episode": v.episode, "cause": v.cause.name, "why": v.cause.value}
        for v in left_out
        if v.cause is not None
    ]


def lines_of(left_out: Sequence[StartCheck]) -> list[str]:
    """For people: a line a cause, with the first few episodes' names."""
    lines = []
    for cause in Undrivable:
        names = [v.episode for v in left_out if v.cause is cause]
        if names:
            more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
            noun = "episode" if len(names) == 1 else "episodes"
            shown = ", ".join(names[:NAMED]) + more
            lines.append(f"{len(names)} {noun} left out, {cause.value}: {shown}")
    return lines
