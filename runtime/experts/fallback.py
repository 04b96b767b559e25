"""One expert on several rungs: the best is asked first, and the next below when it cannot answer.

A rung that has nothing to go by, or sees no reason to prefer anything, has answered: none below is
asked, and the expert abstains, with what those above it said. One that is late, broken, at rest or
talks nonsense has not.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from runtime.clock import Deadline
from runtime.core.types import Absence, Brief, Missing, Vote
from runtime.core.voting.names import ANSWERED_BY
from runtime.experts.panel import Expert


@dataclass(frozen=True)
class Rung:
    """An expert on one rung. `share` of the time left may be spent on it while there are rungs
    below; `ready` says whether it is worth asking now."""

    name: str
    expert: Expert
    share: float = 1.0
    ready: Callable[[Deadline], bool] = lambda by: True


def with_fallback(name: str, rungs: Sequence[Rung]) -> Expert:
    """The expert `name` that asks one rung after the other, until one has answered."""

    def ask(brief: Brief, by: Deadline) -> Vote | Missing:
        causes: list[str] = []
        for n, rung in enumerate(rungs):
            if not rung.ready(by):
                causes.append(f"{_called(rung)}: not ready")
                continue
            lowest = n == len(rungs) - 1
            outcome = _try(rung, brief, by if lowest else by.tightened(rung.share * by.left_s()))
            if isinstance(outcome, Vote):
                return replace(outcome, expert=name, rung=rung.name)
            if outcome.why.is_answer:
                told = "; ".join([*causes, outcome.detail] if outcome.detail else causes)
                return replace(outcome, expert=name, detail=told)
            if outcome.why is Absence.NO_IMAGES:  # which is so whoever is asked
                causes.append(outcome.detail or "no view of a frontier yet")
            else:
                causes.append(f"{_called(rung)}: {outcome.cause}")
        return Missing(name, Absence.NO_MODEL, "; ".join(causes))

    return ask


def _called(rung: Rung) -> str:
    return ANSWERED_BY.get(rung.name, rung.name)


def _try(rung: Rung, brief: Brief, by: Deadline) -> Vote | Missing:
    try:
        return rung.expert(brief, by)
    except Exception as error:  # noqa: BLE001 -- whatever it is, the rung below may do better
        told = " ".join(str(error).split())[:160] or type(error).__name__
        return Missing("", Absence.CALL_FAILED, told)
