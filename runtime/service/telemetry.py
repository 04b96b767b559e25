"""What the service tells those who watch over it: how it stands, what it counted since its start.
The thread that owns the world writes; the newest `Watched` may be read by any."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from runtime.clock import Clock
from runtime.core.types import Brief, Decision, Frontier
from runtime.core.voting.explain import in_words
from runtime.errors import ConfigError
from runtime.log import DEBUG, ERROR, INFO, NOTICE, WARNING, say
from runtime.robot.requests import Request
from runtime.service.recollection import Recollection

EVERY_S: Final = 1.0  # between two of what is watched
KINDS_KEPT: Final = 64  # of pairs that are counted: names of experts, rungs and causes are few
PRIORITIES: Final = {
    "fault": ERROR, "stopped": WARNING, "held": WARNING, "degraded": WARNING, "paused": NOTICE,
}  # fmt: skip
Tell = Callable[..., None]
"""See `log.say`."""


@dataclass(frozen=True)
class Watched:
    """At one moment: the answer to a query on `rfnav/status`, and counts since the start. Nobody
    changes it."""

    at_s: float
    status: Mapping[str, Any] = field(default_factory=dict)
    votes: Mapping[tuple[str, str], int] = field(default_factory=dict)
    """By expert and rung."""
    absences: Mapping[tuple[str, str], int] = field(default_factory=dict)
    """By expert and why it did not vote."""
    decisions: int = 0
    results: Mapping[str, int] = field(default_factory=dict)


class Telemetry:
    """Times are monotonic seconds. `watched`: whether anybody wants `newest`; `tell`: where lines
    go."""

    def __init__(self, clock: Clock, watched: bool = False, tell: Tell = say) -> None:
        self._clock, self._began_s = clock, clock.now_s()
        self._watched, self._tell = watched, tell
        self._recollection = Recollection()
        self._votes, self._absences = Counter[tuple[str, str]](), Counter[tuple[str, str]]()
        self._decisions, self._results = 0, Counter[str]()
        self._goal_id = self._does = ""
        self.newest = Watched(self._began_s)

    # -- what happens --------------------------------------------------------------------------

    def began(self, goal: str, how: str, id: str = "") -> None:
        """A search for a goal begins."""
        self._goal_id = id
        self._tell(f'goal "{goal}": {how}', INFO, **self._fields("goal"))

    def decided(
        self,
        number: int,
        goal: str,
        decision: Decision,
        brief: Brief,
        frontiers: Sequence[Frontier],
        heads_for: int | None,
        elapsed_s: float,
    ) -> None:
        """A decision was adopted; see `Recollection.decided`."""
        told = decision, brief, frontiers, heads_for, elapsed_s, self._goal_id
        self._recollection.decided(number, goal, *told)
        self._decisions += 1
        for vote in decision.ballot.votes:
            _count(self._votes, (vote.expert, vote.rung))
        for missing in decision.ballot.missing:
            _count(self._absences, (missing.expert, missing.why.value))
        said = f"decision {number}: {in_words(decision)}"
        self._tell(said, DEBUG, **self._fields("decision"), DECISION=str(number))

    def stood(self, now_s: float, was: str, state: str, cause: str) -> None:
        """How the runtime stands from now on, `loops.standing.RunStanding`; `was`: before, in
        words."""
        self._recollection.stood(now_s, state, cause)
        now = f"{state}: {cause}" if cause else state
        fields = self._fields("standing")
        if state == "held":
            fields = self._fields("halt") | {"HALT": cause.partition(": ")[0]}
        priority = PRIORITIES.get(state, INFO)
        self._tell(f"{was} -> {now}", priority, **fields, STATE=state, CAUSE=cause)

    def does(self, reason: str) -> None:
        """What the robot does now for its search, and why."""
        self._does = reason

    def ended(self, result: str, sentence: str, id: str = "") -> None:
        """A goal ended so, whether or not it was searched for."""
        self._results[result] += 1
        fields = self._fields("result") | ({"GOAL_ID": id} if id else {})
        self._tell(f"{result}: {sentence}", NOTICE, **fields, RESULT=result)
        if id in ("", self._goal_id):
            self._goal_id = self._does = ""

    # -- what is told --------------------------------------------------------------------------

    def due(self) -> bool:
        """Whether it is time for `note`."""
        return self._watched and self._clock.now_s() - self.newest.at_s >= EVERY_S

    def note(self, status: Mapping[str, Any]) -> None:
        """How all stands now: what a query on `rfnav/status` is answered."""
        counts = dict(self._votes), dict(self._absences), self._decisions, dict(self._results)
        self.newest = Watched(self._clock.now_s(), status, *counts)

    def told(self) -> dict[str, object]:
        """What `rfnav/status` has of it."""
        now_s = self._clock.now_s()
        return {
            "now_s": round(now_s, 3),  # by the clock that streams' arrivals are told by
            "up_s": round(now_s - self._began_s, 1),
            "does": self._does,
            "memory_mb": round(memory_bytes() / 1e6, 1),
            "votes": _nested(self._votes),
            "absences": _nested(self._absences),
            "results": dict(self._results),
        }

    def why(self, request: Request) -> dict[str, object]:
        """The answer to a query on `rfnav/why`; see `Recollection.why`. Where no number is asked
        for, also what it does now."""
        now: dict[str, object] = {} if request.body else {"now": self._does or "no search"}
        try:
            return now | self._recollection.why(request.body, self._clock.now_s())
        except ConfigError as error:
            return {"accepted": False, "error": str(error)}

    def _fields(self, event: str) -> dict[str, str]:
        return {"EVENT": event} | ({"GOAL_ID": self._goal_id} if self._goal_id else {})


def untold(line: str, priority: int = INFO, **fields: str) -> None:
    """No line goes anywhere."""


def memory_bytes() -> int:
    """What of this process is in memory; 0 where nobody tells."""
    try:
        words = Path("/proc/self/status").read_text(encoding="ascii", errors="replace").split()
        return int(words[words.index("VmRSS:") + 1]) * 1024
    except (OSError, ValueError, IndexError):
        return 0


def _count(counter: Counter[tuple[str, str]], pair: tuple[str, str]) -> None:
    """Models' names are the owner's, and a few; were they not, memory is bounded all the same."""
    if pair in counter or len(counter) < KINDS_KEPT:
        counter[pair] += 1


def _nested(counter: Mapping[tuple[str, str], int]) -> dict[str, dict[str, int]]:
    told: dict[str, dict[str, int]] = {}
    for (first, second), n in sorted(counter.items()):
        told.setdefault(first, {})[second] = n
    return told
