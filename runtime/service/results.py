"""What became of the goals that have ended, and who waits to hear of one that has not."""

from collections.abc import Mapping
from typing import Any, Final

from runtime.robot.requests import Request

KEPT: Final = 64  # that have ended
ASKERS: Final = 32  # that wait, for all goals together


class GoalResults:
    """By a goal's id."""

    def __init__(self) -> None:
        self._ended: dict[str, Mapping[str, Any]] = {}  # the oldest first
        self._askers: list[tuple[str, Request]] = []

    @property
    def last(self) -> Mapping[str, Any] | None:
        """What was told of the one that ended last."""
        return next(reversed(self._ended.values()), None)

    def of(self, id: str) -> Mapping[str, Any] | None:
        """None of one that has not ended, or long ago."""
        return self._ended.get(id)

    def file(self, told: Mapping[str, Any]) -> None:
        """One has ended: who waits for it hears of it."""
        id = str(told["id"])
        self._ended.pop(id, None)
        self._ended[id] = told
        for old in list(self._ended)[:-KEPT]:
            del self._ended[old]
        askers, self._askers = self._askers, []
        for wanted, asker in askers:
            if wanted == id:
                asker.reply(told)
            else:
                self._askers.append((wanted, asker))

    def wait(self, id: str, asker: Request) -> None:
        """Answer it when that goal ends. One too many takes the place of the one that has waited
        longest, which most likely waits no more: nobody tells of a querier that has gone."""
        self._askers.append((id, asker))
        for _, oldest in self._askers[:-ASKERS]:
            oldest.refuse(f"{ASKERS} others have asked for results since: ask again")
        self._askers = self._askers[-ASKERS:]

    def close(self, why: str) -> None:
        """Nobody hears of a goal any more."""
        askers, self._askers = self._askers, []
        for _, asker in askers:
            asker.refuse(why)
