"""The experts' votes on a bank's questions, by the runtime's own experts, and how votes are spoilt:
an expert that answers at random, one that is absent."""

import random
from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import partial
from typing import Self

from hil_sim.driving.told_votes import drawn_vote
from hil_sim.expert_bench.bank import CLEAN, Bank, BenchQuestion
from runtime.clock import Deadline, SystemClock
from runtime.config import Config, load
from runtime.core.types import Brief, Missing, Vote
from runtime.errors import RfNavError
from runtime.experts.panel import EXPERTS, Expert
from runtime.experts.seating import COUNTS
from runtime.perception.loaded_models import LoadedModels

ALL = f"panel.experts=[{', '.join(repr(name) for name in EXPERTS)}]"


class Voters:
    """The models behind the experts, loaded once. Scores are kept in the runtime's score file: a
    bank's first judging asks the language model everything, a later one nothing."""

    def __init__(self, settings: Sequence[str] = ()) -> None:
        config = load(None, (*settings, ALL))
        self._clock = SystemClock()
        self._loaded = LoadedModels(config, self._clock)
        self._loaded.accept("toilet", config)
        self._models, self._rung = config.models, self._loaded.rung()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._loaded.close()

    def warm(self, bank: Bank, briefs: Collection[str] = (CLEAN,)) -> None:
        """Have everything scored that the questions need under these conditions: one context after
        another, each for all goals, in a fraction of the time that one goal after another takes."""
        words: dict[str, set[str]] = {}
        for question in bank.questions:
            names = words.setdefault(question.goal, set())
            for name in briefs:
                brief = question.moment.briefs[name]
                names.update(o.name for f in brief.frontiers for o in f.objects)
        for goal, names in sorted(words.items()):
            self._loaded.notice(goal, tuple(sorted(names)))
        self._loaded.settle(Deadline.never(self._clock))

    def asked(self, config: Config, questions: Sequence[BenchQuestion]) -> "Votes":
        """Their votes under a configuration; RfNavError when it needs other models."""
        if config.models != self._models:
            raise RfNavError("models: the experts were loaded with others; load them again")
        table = self._loaded.seated(replace(config, panel=replace(config.panel, experts=EXPERTS)))
        return Votes(table, questions, Deadline.never(self._clock))

    def guessing(self, config: Config, questions: Sequence[BenchQuestion]) -> "Votes":
        """The votes of O2F and R2F by counts, as if each question's goal had never been counted."""
        counted, tables = self._loaded.counted(), dict[str, dict[str, Expert]]()

        def ask(name: str, brief: Brief, by: Deadline) -> Vote | Missing:
            if brief.goal not in tables:
                tables[brief.goal] = counted.without(brief.goal).experts(config.experts)
            return tables[brief.goal][name](brief, by)

        table: dict[str, Expert] = {name: partial(ask, name) for name in ("o2f", "r2f")}
        return Votes(table, questions, Deadline.never(self._clock))

    def check(self) -> None:
        """RfNavError when a model failed meanwhile and another one answered in its place."""
        rungs = self._rung, COUNTS
        if self._loaded.health().get("errors") or self._loaded.rung() not in rungs:
            raise RfNavError(
                f"{self._rung}: failed while the bank was judged; see rfnav models verify"
            )


class Votes:
    """Each expert's vote on each question, worked out when it is first wanted."""

    def __init__(
        self, table: "dict[str, Expert]", questions: Sequence[BenchQuestion], by: Deadline
    ) -> None:
        self._table, self._questions, self._by = table, questions, by
        self._known: dict[tuple[str, int, str], Vote | Missing] = {}

    def of(self, expert: str, number: int, condition: str = CLEAN) -> Vote | Missing:
        """An expert's vote on the question of that number, on the brief of that condition."""
        key = expert, number, condition
        if key not in self._known:
            brief = self._questions[number].brief(condition)
            self._known[key] = self._table[expert](brief, self._by)
        return self._known[key]


def at_random(expert: str, question: BenchQuestion, seed: int) -> Vote:
    """A vote without any sense, on one question."""
    moment = question.moment
    place = f"{seed}/{expert}/{moment.home}/{moment.drive}/{moment.step}/{question.goal}"
    return drawn_vote(expert, list(question.costs_m), random.Random(place))
