"""How long the scene-layout expert takes for a vote on eight frontiers that all have a view."""

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np

from hil_sim.expert_bench.bank import CLEAN, BenchQuestion, Moment
from hil_sim.expert_bench.judge import CONSENSUS, METHODS, Electorate
from hil_sim.expert_bench.scene_bank import EXPERT
from hil_sim.expert_bench.view_questions import SightRows
from runtime.clock import Clock
from runtime.config import load
from runtime.core.types import Brief, FrontierBrief, Sight, Vote
from runtime.errors import RfNavError

FRONTIERS, VOTES = 8, 9
THREADS = 2
GOALS = ("toilet", "washing machine")
"""One is asked about views that nobody has looked at before, the other about the same again."""


@dataclass(frozen=True)
class SceneSeconds:
    """Medians: a vote on eight views never seen before, and on them again for another goal."""

    new_views: float
    known_views: float


def time_votes(
    sights: SightRows, kind: str, settings: Sequence[str], voters: Electorate, clock: Clock
) -> SceneSeconds:
    """VOTES votes on eight views each, under settings that ask for that kind; RfNavError when there
    are fewer views, or another kind answered."""
    rows = _different(sights)
    if len(rows) < FRONTIERS * VOTES:
        raise RfNavError(f"{len(rows)} views; {FRONTIERS * VOTES} are needed to time votes")
    config = load(None, (*settings, *METHODS[CONSENSUS], "research.experts_bar=0.0"))
    took = []
    for n in range(VOTES):
        moment = _moment(sights, rows[n * FRONTIERS : (n + 1) * FRONTIERS])
        votes = voters.asked(config, [BenchQuestion(moment, goal, {}) for goal in GOALS])
        for number in range(len(GOALS)):
            began_s = clock.now_s()
            vote = votes.of(EXPERT, number)
            took.append(clock.now_s() - began_s)
            said = f"voted by {vote.rung}" if isinstance(vote, Vote) else vote.cause
            if not isinstance(vote, Vote) or vote.rung != kind:
                raise RfNavError(f"{EXPERT}, {kind}: {said}; see rfnav models verify")
    return SceneSeconds(median(took[::2]), median(took[1::2]))


def _different(sights: SightRows) -> list[int]:
    """The first row of each picture: the expert looks once at what it is shown again."""
    first = dict[bytes, int]()
    for row, features in enumerate(sights.features):
        first.setdefault(features.tobytes(), row)
    return list(first.values())


def _moment(sights: SightRows, rows: Sequence[int]) -> Moment:
    frontiers = tuple(
        FrontierBrief(n, 1.0 + n, (), (), sights.scene[r].astype(np.float32), unknown_m2=1.0,
                      sight=Sight(sights.features[r].astype(np.float16),
                                  sights.depth[r].astype(np.float16),
                                  float(sights.column[r]), float(sights.range_m[r])))
        for n, r in enumerate(rows)
    )  # fmt: skip
    brief = Brief("", rows[0], frontiers)
    places = tuple((1.0 + n, 0.0) for n in range(len(frontiers)))
    return Moment("", 0, rows[0], "timed", {CLEAN: brief}, (), tuple(range(len(rows))), places, {})
