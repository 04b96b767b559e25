"""Votes that the harness casts in the place of experts: by the truth, for methods whose name says
so, or at random.

The runtime asks with its frontiers while it decides (`runtime.robot.told_votes`).
"""

import math
import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from hil_sim.ground_truth.oracle_votes import AskedFrontier, Kind, OracleKnowledge
from runtime.core.types import Vote

How = Kind | Literal["random"]
Casts = tuple[tuple[str, How], ...]
"""By expert of the panel, whose vote is cast: by what it is cast."""
InScene = Callable[[float, float], tuple[float, float]]  # of the runtime's map, m
EQUAL = 0.5
"""Of the best evidence, what is as good."""
FLOOR = 0.02
"""Evidence that is left to a frontier that nothing speaks for."""
NO_MATTER = 0.05
"""Between the most and the least evidence; where all are alike nobody votes."""


@dataclass(frozen=True)
class HarnessVotes:
    """Casts the votes of one episode; the same `seed`, episode and question give the same ones."""

    casts: Casts
    known: OracleKnowledge
    episode: str
    seed: int

    def answer(self, question: Mapping[str, Any], in_scene: InScene) -> dict[str, Any]:
        """A question of the runtime's -> the message that answers it; of no frontiers, with no
        vote."""
        frontiers = [_asked(row, in_scene) for row in question["frontiers"]]
        how = dict(self.casts)
        stamp_ns = int(question["stamp_ns"])
        asked = question["experts"] if frontiers else ()
        votes = [self._vote(expert, how[expert], frontiers, stamp_ns) for expert in asked]
        return {"stamp_ns": stamp_ns, "votes": [_told(vote) for vote in votes if vote is not None]}

    def _vote(
        self, expert: str, how: How, frontiers: Sequence[AskedFrontier], stamp_ns: int
    ) -> Vote | None:
        if how == "random":
            rng = random.Random(f"{self.seed}/{expert}/{self.episode}/{stamp_ns}")
            return drawn_vote(expert, [frontier.id for frontier in frontiers], rng)
        return known_vote(expert, self.known.evidence(how, frontiers), how)


def known_vote(expert: str, evidence: Mapping[int, float], how: str) -> Vote | None:
    """A vote for all that is as good as the best, by evidence in 0..1; None where all are alike."""
    best = max(evidence.values(), default=0.0)
    if best - min(evidence.values(), default=0.0) < NO_MATTER:
        return None
    weights = {id: max(e, FLOOR) for id, e in sorted(evidence.items())}
    total = sum(weights.values())
    p = tuple((id, round(weight / total, 4)) for id, weight in weights.items())
    nats = tuple((id, round(math.log(w / total * len(p)), 3)) for id, w in weights.items())
    chosen = tuple(id for id, e in sorted(evidence.items()) if e >= EQUAL * best)
    return Vote(expert, chosen, p, f"{how} known", nats=nats)


def drawn_vote(expert: str, ids: Sequence[int], rng: random.Random) -> Vote:
    """A vote without any sense: always cast, for one frontier drawn at random, half the time for
    two."""
    chosen = sorted(rng.sample(sorted(ids), min(rng.choice((1, 2)), len(ids))))
    share = 1.0 / len(chosen)
    p = tuple((id, share if id in chosen else 0.0) for id in sorted(ids))
    return Vote(expert, tuple(chosen), p, "at random")


def _asked(row: Mapping[str, Any], in_scene: InScene) -> AskedFrontier:
    cells = np.array([in_scene(x, y) for x, y in row["cells_xy"]])
    return AskedFrontier(row["id"], cells, in_scene(*row["goal_xy"]), float(row["distance_m"]))


def _told(vote: Vote) -> dict[str, object]:
    return {
        "expert": vote.expert,
        "frontiers": list(vote.frontiers),
        "probabilities": [list(pair) for pair in vote.probabilities],
        "reason": vote.reason,
        "nats": [list(pair) for pair in vote.nats],
    }
