"""What is remembered of decisions and of stops, so that "why?" can be answered: the newest of each,
bounded. One thread owns it."""

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from runtime.core.motion.safety import HaltKind
from runtime.core.motion.stops import BaseStop, stop_in_full
from runtime.core.types import Brief, Decision, Frontier
from runtime.core.voting.in_full import ToldDecision, in_full
from runtime.errors import ConfigError

DECISIONS_KEPT: Final = 64
STOPS_KEPT: Final = 64
STANDS: Final = ("fault", "stopped", "paused", "held")
"""Of `loops.standing.RunState`: while the base stands that was to be driven."""
ASKED: Final = ("decision", "stop")
HIGHEST: Final = 1_000_000_000


@dataclass(frozen=True)
class RememberedDecision:
    """In words alone: what it was made on takes thirty times the memory."""

    number: int
    id: str  # of its goal, "" where that has none
    goal: str
    in_words: tuple[str, ...]


class Recollection:
    """Times are monotonic seconds."""

    def __init__(self) -> None:
        self._decisions: deque[RememberedDecision] = deque(maxlen=DECISIONS_KEPT)
        self._stops: deque[BaseStop] = deque(maxlen=STOPS_KEPT)
        self._stopped = 0

    def decided(
        self,
        number: int,
        goal: str,
        decision: Decision,
        brief: Brief,
        frontiers: Sequence[Frontier],
        heads_for: int | None,
        elapsed_s: float,
        id: str = "",
    ) -> None:
        """A decision that was adopted: the `number`th of its search, on these frontiers; `id`: of
        its goal."""
        at = {f.id: (float(f.goal_xy[0]), float(f.goal_xy[1])) for f in frontiers}
        told = ToldDecision(number, goal, decision, brief, at, heads_for, elapsed_s)
        self._decisions.append(RememberedDecision(number, id, goal, in_full(told)))

    def stood(self, now_s: float, state: str, cause: str) -> None:
        """How the runtime stands from now on: `loops.standing.RunStanding`."""
        if self._stops and self._stops[-1].ended_s is None:
            then = f"{state}: {cause}" if cause else state
            self._stops[-1] = replace(self._stops[-1], ended_s=now_s, then=then)
        if is_stop(state, cause):
            self._stopped += 1
            self._stops.append(stop_of(self._stopped, state, cause, now_s))

    def why(self, body: Mapping[str, Any], now_s: float) -> dict[str, object]:
        """The answer to {} (the last decision and the last stop), {"decision": N} or {"stop": N}:
        {"decision": {...}, "stop": {...}}, each None where there is none; ConfigError, one line,
        for what cannot be answered."""
        for name in body:
            if name not in ASKED:
                raise ConfigError(f'why: {name[:40]!r}: ask {{}}, {{"decision": N}}, {{"stop": N}}')
        wanted = {name: _number(name, body[name]) for name in body} or dict.fromkeys(ASKED, None)
        answer: dict[str, object] = {}
        if "decision" in wanted:
            answer["decision"] = self._decision(wanted["decision"])
        if "stop" in wanted:
            answer["stop"] = self._stop(wanted["stop"], now_s)
        return answer

    def _decision(self, number: int | None) -> dict[str, object] | None:
        """Of several of that number the newest: each search counts from 1."""
        kept = [d for d in self._decisions if number in (None, d.number)]
        if kept:
            return vars(kept[-1])
        if number is None:
            return None
        raise ConfigError(
            f"why: decision {number}: {_range(number, [d.number for d in self._decisions])}"
        )

    def _stop(self, number: int | None, now_s: float) -> dict[str, object] | None:
        kept = [s for s in self._stops if number in (None, s.number)]
        if kept:
            return vars(kept[-1]) | {"in_words": stop_in_full(kept[-1], now_s)}
        if number is None:
            return None
        raise ConfigError(f"why: stop {number}: {_range(number, [s.number for s in self._stops])}")


def is_stop(state: str, cause: str) -> bool:
    """Whether the base stands that was to be driven; for a cancel, whoever asked knows why."""
    return state in STANDS and not cause.startswith(f"{HaltKind.CANCEL}: ")


def stop_of(number: int, state: str, cause: str, began_s: float) -> BaseStop:
    """A stop by its standing's words: the cause of one that is held begins with the halt's kind."""
    kind, _, reason = cause.partition(": ")
    if state == "held" and kind in tuple(HaltKind):
        return BaseStop(number, state, kind, reason, began_s)
    kinds = {"stopped": HaltKind.STOP.value, "paused": _paused(cause)}
    return BaseStop(number, state, kinds.get(state, ""), cause, began_s)


def _paused(cause: str) -> str:
    return HaltKind.HAND.value if cause.startswith("a hand") else ""


def _number(name: str, value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= HIGHEST:
        raise ConfigError(f"why: {name}: must be a number from 1")
    return value


def _range(number: int, numbers: Sequence[int]) -> str:
    if not numbers:
        return "there was none yet"
    if number > max(numbers):
        return f"there is none yet; the last is {numbers[-1]}"
    return f"is not remembered; {min(numbers)} to {max(numbers)} are"
