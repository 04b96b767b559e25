"""A panel some of whose experts are elsewhere: their votes come over the bus, in lockstep. So a
harness can have one vote by what it knows, or at random."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Protocol

from runtime.clock import Deadline
from runtime.core.types import Ballot, Brief, Frontier, Missing, Vote
from runtime.experts.panel import checked


class Asked(Protocol):
    """A panel; see `Panel`."""

    def ask(self, brief: Brief, by: Deadline) -> Ballot: ...


class TellsVotes(Protocol):
    """Whoever brings the votes; see `ToldVotes`."""

    def ask(self, question: Mapping[str, object]) -> tuple[Vote | Missing, ...]: ...


class ToldPanel:
    """`names`: the experts that are elsewhere; `frontiers`: those that the brief is of."""

    def __init__(
        self, panel: Asked, told: TellsVotes, names: Sequence[str], frontiers: Sequence[Frontier]
    ) -> None:
        self._panel, self._told, self._names, self._frontiers = panel, told, names, frontiers

    def ask(self, brief: Brief, by: Deadline) -> Ballot:
        """The panel's ballot with the votes of the others in it."""
        ballot = self._panel.ask(brief, by)
        said = [checked(outcome, brief) for outcome in self._told.ask(self._question(brief))]
        votes = (*ballot.votes, *(vote for vote in said if isinstance(vote, Vote)))
        missing = (*ballot.missing, *(one for one in said if isinstance(one, Missing)))
        return replace(
            ballot,
            votes=tuple(sorted(votes, key=lambda vote: vote.expert)),
            missing=tuple(sorted(missing, key=lambda absent: absent.expert)),
        )

    def _question(self, brief: Brief) -> dict[str, object]:
        asked = {frontier.id for frontier in brief.frontiers}
        return {
            "stamp_ns": brief.stamp_ns,
            "goal": brief.goal,
            "experts": list(self._names),
            "frontiers": [
                {
                    "id": frontier.id,
                    "goal_xy": frontier.goal_xy,
                    "cells_xy": frontier.cells_xy.round(3).tolist(),
                    "distance_m": frontier.distance_m,
                }
                for frontier in self._frontiers
                if frontier.id in asked
            ],
        }
