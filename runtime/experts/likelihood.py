"""O2F and R2F by a model that scores: what it is asked, and what is remembered of its answers."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from runtime.clock import Deadline
from runtime.core.types import Absence, Brief, Missing, Vote
from runtime.core.voting import likelihood_experts
from runtime.core.voting.likelihood_experts import (
    OBJECTS,
    ROOMS,
    Doors,
    Evidence,
    ExpertConfig,
    Topic,
    averaged,
    object_evidence,
    room_evidence,
)
from runtime.experts.counts import CountExperts
from runtime.experts.panel import Expert
from runtime.experts.scorer import Scorer

GOALS_KEPT = 1000  # whose affinities are remembered
ENOUGH = 0.5  # of what is asked about; with less, the expert is late
DOORS_SHARE = 0.5  # of the time left, that a vote waits for what doors lead to

Ask = Callable[["_Affinities", Brief, Deadline], Vote | Missing]


@dataclass
class LikelihoodExperts:
    """A scorer of one model, all room types as it is told of them, and what it has computed."""

    scorer: Scorer
    rooms: tuple[str, ...]
    used: bool = False  # whether it was ever asked
    _doors: Doors = field(default_factory=dict)
    _known: dict[tuple[Topic, str], dict[str, float]] = field(default_factory=dict)

    def begin(self, goal: str) -> None:
        """Score what every search for this goal needs, in the background."""
        if len(self._known) > GOALS_KEPT:
            self._known = {}
        self.scorer.warm(likelihood_experts.questions(ROOMS, goal, self.rooms))
        self.scorer.warm(likelihood_experts.questions(OBJECTS, goal, ()))
        self.scorer.warm(
            likelihood_experts.door_questions(self.rooms)
        )  # hundreds, and the least of it

    def forget(self) -> None:
        """Score all that is asked from here on anew."""
        self._doors, self._known = {}, {}
        self.scorer.forget()

    def notice(self, goal: str, names: Sequence[str]) -> None:
        """Score objects that are on the map by now, in the background."""
        self.scorer.warm(likelihood_experts.questions(OBJECTS, goal, names))

    def experts(self, cfg: ExpertConfig, counts: CountExperts | None = None) -> dict[str, Expert]:
        """The experts that it can answer for, by name; together with `counts`, where there are."""

        def beside(brief: Brief) -> tuple[Evidence, Evidence]:
            found = counts.evidence(brief) if counts is not None else None
            return found or ({}, {})

        def objects(told: _Affinities, brief: Brief, by: Deadline) -> Vote | Missing:
            return likelihood_experts.vote_objects(brief, told.near(), cfg, beside(brief)[0])

        def rooms(told: _Affinities, brief: Brief, by: Deadline) -> Vote | Missing:
            around, doors = told.around(), self.doors(by)
            return likelihood_experts.vote_rooms(brief, around, cfg, doors, beside(brief)[1])

        def both(told: _Affinities, brief: Brief, by: Deadline) -> Vote | Missing:
            near, around = told.near(), told.around()
            counted = beside(brief)
            return likelihood_experts.vote_both(
                brief,
                averaged(object_evidence(brief, near), counted[0]),
                averaged(room_evidence(brief, around, self.doors(by)), counted[1]),
                cfg,
            )

        return {name: self._expert(f) for name, f in
                (("o2f", objects), ("r2f", rooms), ("both", both))}  # fmt: skip

    def _expert(self, vote: Ask) -> Expert:
        def ask(brief: Brief, by: Deadline) -> Vote | Missing:
            self.used = True
            told = _Affinities(self, brief, by)
            outcome = vote(told, brief, by)
            if by.passed() and told.answered < ENOUGH * told.asked:
                return Missing("", Absence.LATE, f"{told.answered} of {told.asked} answered")
            return outcome

        return ask

    def doors(self, by: Deadline) -> Doors:
        """What doors lead to, as the model has it; nothing while it has not said."""
        if not self._doors:
            soon = by.tightened(DOORS_SHARE * by.left_s())
            answers = self.scorer.answer(likelihood_experts.door_questions(self.rooms), soon)
            self._doors = likelihood_experts.behind(self.rooms, answers)
        return self._doors

    def affinities(
        self, topic: Topic, goal: str, things: Sequence[str], by: Deadline
    ) -> dict[str, float]:
        """By thing, of those that the model reached by the deadline, now or earlier."""
        known = self._known.setdefault((topic, goal), {})
        asked = [thing for thing in things if thing not in known]
        if asked:
            answers = self.scorer.answer(likelihood_experts.questions(topic, goal, asked), by)
            known.update(likelihood_experts.affinities(topic, goal, asked, answers))
        return {thing: known[thing] for thing in things if thing in known}


@dataclass
class _Affinities:
    """Those of one decision, and how much of what was asked was answered."""

    scored: LikelihoodExperts
    brief: Brief
    by: Deadline
    asked: int = 0
    answered: int = 0

    def near(self) -> dict[str, float]:
        return self._ask(OBJECTS, likelihood_experts.things_near(self.brief))

    def around(self) -> dict[str, float]:
        rooms = self.scored.rooms if any(f.rooms for f in self.brief.frontiers) else ()
        return self._ask(ROOMS, rooms)

    def _ask(self, topic: Topic, things: Sequence[str]) -> dict[str, float]:
        if not things or len(self.brief.frontiers) < 2:
            return {}  # one frontier is no choice: nothing to ask
        found = self.scored.affinities(topic, self.brief.goal, things, self.by)
        self.asked += len(things)
        self.answered += len(found)
        return found
