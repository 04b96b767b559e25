"""What a replay made, beside what was recorded: which differs first, in words."""

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, Final

from runtime.core.types import SearchState
from runtime.recording.exact import exact
from runtime.replay.script import OUTPUTS, Turn

IGNORED: Final = {"tick": {"late_s", "plan", "withdrawn"}, "plan": {"number", "frame_s"}}
"""What depends on the clock of the machine, or counts from another beginning."""
ENDED: Final = SearchState.ENDED.value
NOTHING: Final = "nothing"
LONG: Final = 80  # characters of a value that is told


@dataclass(frozen=True)
class Difference:
    """Something that was made otherwise. `turn` is the frame or request since the beginning."""

    turn: int
    at_s: float
    what: str  # command.action
    recorded: object
    replayed: object

    def in_words(self) -> str:
        where = f"turn {self.turn}, {self.at_s:.2f} s"
        return f"{where}: {self.what} is {_short(self.replayed)}, was {_short(self.recorded)}"


@dataclass
class Differences:
    """All of them, in order, and how much was compared, by kind. Questions are compared one after
    the other, whenever they were told: before they were answered, or with the answer."""

    found: list[Difference] = field(default_factory=list)
    compared: dict[str, int] = field(default_factory=dict)
    _questions: tuple[deque[Any], deque[Any]] = field(default_factory=lambda: (deque(), deque()))

    def compare(self, turn: Turn, kind: str, replayed: object, recorded: object) -> None:
        """One value of a kind; None where the other side has one more."""
        self.compared[kind] = self.compared.get(kind, 0) + 1
        without = IGNORED.get(kind, set())
        for what, mine, theirs in _apart(kind, exact(replayed), recorded, without):
            self.found.append(Difference(turn.number, turn.at_s, what, theirs, mine))

    def compare_turn(self, turn: Turn, made: dict[str, list[Any]], cut: bool = False) -> None:
        """All that a turn made; `cut`: what the recording has of it may not be all."""
        for kind in OUTPUTS:
            mine, theirs = made.get(kind, []), turn.made.get(kind, [])
            if kind == "question":
                mine, theirs = self._pairs(mine, theirs)
            if kind == "rest":  # the end of the runtime is no command of the loop's
                mine, theirs = ([r for r in told if r["state"] != ENDED] for told in (mine, theirs))
            for n in range(len(theirs) if cut else max(len(mine), len(theirs))):
                one = mine[n] if n < len(mine) else None
                other = theirs[n] if n < len(theirs) else None
                self.compare(turn, kind, one, other)

    def _pairs(self, mine: list[Any], theirs: list[Any]) -> tuple[list[Any], list[Any]]:
        """The questions that both sides have come to by now."""
        for waiting, new in zip(self._questions, (mine, theirs), strict=True):
            waiting.extend(new)
        n = min(map(len, self._questions))
        first, second = ([waiting.popleft() for _ in range(n)] for waiting in self._questions)
        return first, second

    def in_words(self) -> str:
        """How much was compared."""
        counts = [f"{n} {kind}s" for kind, n in sorted(self.compared.items())]
        return ", ".join(counts) or NOTHING


def _apart(
    what: str, mine: Any, theirs: Any, without: Iterable[str] = ()
) -> Iterator[tuple[str, Any, Any]]:
    """Where two values of JSON differ: the path, and what is there."""
    if isinstance(mine, dict) and isinstance(theirs, dict):
        if "dtype" in mine and "dtype" in theirs:
            if mine != theirs:
                yield what, mine.get("values", "other cells"), theirs.get("values", "these")
            return
        for name in sorted(mine.keys() | theirs.keys()):
            if name not in without:
                yield from _apart(f"{what}.{name}", mine.get(name), theirs.get(name))
    elif isinstance(mine, list) and isinstance(theirs, list) and len(mine) == len(theirs):
        for n, (one, other) in enumerate(zip(mine, theirs, strict=True)):
            yield from _apart(f"{what}[{n}]", one, other)
    elif mine != theirs:
        yield what, mine, theirs


def _short(value: object) -> str:
    text = NOTHING if value is None else str(value)
    return text if len(text) <= LONG else text[: LONG - 1] + "…"
