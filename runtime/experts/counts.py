"""O2F and R2F by what was counted in homes: no model is asked, and none is waited for."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from runtime.clock import Deadline
from runtime.core.types import Absence, Brief, Missing, Vote
from runtime.core.voting import likelihood_experts
from runtime.core.voting.counts import CountTable, object_nats, room_nats
from runtime.core.voting.likelihood_experts import Evidence, ExpertConfig
from runtime.experts.panel import Expert

LEARNT = 300  # names beside those that were counted, after which it is begun anew


@dataclass(frozen=True)
class _Learnt:
    """A table with names that others stand in for, the goal first, and those for which none does:
    so what it says of that goal does not depend on what was asked before."""

    goal: str
    table: CountTable
    strange: frozenset[str] = frozenset()


@dataclass
class CountExperts:
    """A table, and how alike a name is to each that it has (cosines). Any thread may ask: what two
    learn at once, one of them learns again."""

    table: CountTable
    likeness: Callable[[str], Mapping[str, float]]
    _learnt: _Learnt | None = None

    def experts(self, cfg: ExpertConfig) -> dict[str, Expert]:
        """The experts that it can answer for, by name."""

        def ask(cast: Callable[[Brief, Evidence, Evidence], Vote | Missing]) -> Expert:
            def expert(brief: Brief, by: Deadline) -> Vote | Missing:
                found = self.evidence(brief)
                if found is None:
                    return Missing("", Absence.NO_MODEL, f"never counted: {brief.goal}")
                return cast(brief, *found)

            return expert

        def objects(brief: Brief, near: Evidence, around: Evidence) -> Vote | Missing:
            return likelihood_experts.vote_where_known("o2f", brief, near, cfg)

        def rooms(brief: Brief, near: Evidence, around: Evidence) -> Vote | Missing:
            return likelihood_experts.vote_where_known("r2f", brief, around, cfg)

        def both(brief: Brief, near: Evidence, around: Evidence) -> Vote | Missing:
            return likelihood_experts.vote_both(brief, near, around, cfg)

        return {"o2f": ask(objects), "r2f": ask(rooms), "both": ask(both)}

    def begin(self, goal: str) -> None:
        """Have others stand in for a goal that was never counted before it is asked about."""
        self._learn(goal)

    def without(self, goal: str) -> "CountExperts":
        """As if a goal had never been counted."""
        return CountExperts(self.table.without(goal), self.likeness)

    def evidence(self, brief: Brief) -> tuple[Evidence, Evidence] | None:
        """By objects and by rooms; None where nothing like the goal was counted."""
        table = self._learn(brief.goal, likelihood_experts.things_near(brief))
        if brief.goal not in table.rates:
            return None
        near = object_nats(brief, table.near(brief.goal))
        return near, room_nats(brief, table.beyond(brief.goal))

    def _learn(self, goal: str, things: Sequence[str] = ()) -> CountTable:
        """The table with others standing in for names that were never counted."""
        known, counted = self._learnt, goal in self.table.rates
        if known is None or self._full(known) or not (counted or goal == known.goal):
            known = self._with(_Learnt(goal, self.table), goal)
        for name in things:
            known = self._with(known, name)
        self._learnt = known
        return known.table

    def _full(self, known: _Learnt) -> bool:
        return len(known.table.rates) - len(self.table.rates) + len(known.strange) > LEARNT

    def _with(self, known: _Learnt, name: str) -> _Learnt:
        if name in known.table.rates or name in known.strange:
            return known
        grown = known.table.standing_in(name, self.likeness(name))
        if grown is known.table:
            return replace(known, strange=known.strange | {name})
        return replace(known, table=grown)
