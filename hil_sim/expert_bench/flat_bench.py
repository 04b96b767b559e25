"""How much a search gains by what is spent how: every way to elect, on the same searches."""

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from hil_sim.evaluation.summary import Figure, bootstrap
from hil_sim.expert_bench.flat_home import FlatHome, flat_home
from hil_sim.expert_bench.flat_search import Decide, FlatResult, FlatSearch, drive, task_in
from hil_sim.expert_bench.flat_voices import FlatVoices, recognised
from hil_sim.scenes.format import SceneError
from hil_sim.scenes.open import open_scene
from runtime.core.types import Ballot, Decision, Frontier, Missing, Vote
from runtime.core.voting import consensus, search_order
from runtime.core.voting.consensus import ConsensusConfig
from runtime.core.voting.counts import CountTable
from runtime.perception.counted import counted_in_homes

GOALS: Final = (
    "chair", "sofa", "plant", "bed", "toilet", "tv monitor", "refrigerator", "laptop", "bathtub",
    "stove", "mug", "apple", "bowl", "alarm clock", "microwave", "washing machine",
)  # fmt: skip
METHODS: Final = {
    "closest": ConsensusConfig(mode="strict", fallback="closest"),
    "geometry": ConsensusConfig(mode="strict", fallback="geometry"),
    "ahead": ConsensusConfig(mode="strict", fallback="ahead"),
    "paper": ConsensusConfig(mode="strict", fallback="closest"),
    "consensus": ConsensusConfig(mode="strict", fallback="geometry"),
    "consensus, gain": ConsensusConfig(mode="strict", rank="gain", fallback="ahead"),
    "prior": ConsensusConfig(mode="prior", fallback="ahead"),
    "prior, one step": ConsensusConfig(mode="prior", fallback="geometry"),
}
"""How each elects; SILENT ones ask nobody."""
SILENT: Final = ("closest", "geometry", "ahead")
ORACLE: Final = "what lies behind"
BASE: Final = "geometry"
CLEAN: Final = "clean"
FAIR: Final = 0.7
"""SPL of one who knows the ways: with less a task says little of searching, as the goal is in view
from hardly anywhere."""


@dataclass(frozen=True)
class FlatPlan:
    """`homes` are searched from the seed `first` on, for `goals` things each;
    `rooms`, `beyond`: how many rooms are taken for what they are, by who stands in them and by who
    looks ahead."""

    homes: int = 40
    first: int = 400_000
    goals: int = 3
    rooms: float = 0.72
    beyond: float = 0.5


Rows = dict[tuple[str, str], list[FlatResult]]
"""By method and condition."""


def run(plan: FlatPlan, methods: Sequence[str]) -> Iterator[tuple[str, Rows]]:
    """The name of each home, and what its searches came to: a list for each method and condition,
    one a task."""
    counts = counted_in_homes()
    for n in range(plan.homes):
        home = _home(plan.first + n)
        if home is not None:
            yield home.name, _searched(home, plan, counts, methods)


def _home(seed: int) -> FlatHome | None:
    """None where no home could be drawn."""
    try:
        return flat_home(open_scene(f"train-{seed}"))
    except SceneError:
        return None


def _searched(home: FlatHome, plan: FlatPlan, counts: CountTable, methods: Sequence[str]) -> Rows:
    rows: Rows = {}
    goals = [goal for goal in GOALS if home.wanted(goal)]
    random.Random(f"flat/goals/{home.name}").shuffle(goals)
    rooms = recognised(home, plan.rooms, "rooms")
    beyond = recognised(home, plan.beyond, "beyond")
    left = plan.goals
    for goal in goals:
        task = task_in(home, goal, 0)
        if task is None or not left:
            continue
        oracle = drive(home, task, _knowing)
        if oracle.spl < FAIR:
            continue
        left -= 1
        rows.setdefault((ORACLE, CLEAN), []).append(oracle)
        for method in methods:
            cfg = METHODS[method]
            for spoilt in ("",) if method in SILENT else ("", "o2f", "r2f", "sle"):
                voices = FlatVoices(counts, rooms, beyond, spoilt)
                decide = _electing(cfg, None if method in SILENT else voices)
                key = method, f"{spoilt} at random" if spoilt else CLEAN
                rows.setdefault(key, []).append(drive(home, task, decide))
    return rows


def _electing(cfg: ConsensusConfig, voices: FlatVoices | None) -> Decide:
    """As the runtime elects."""

    def decide(
        search: FlatSearch, frontiers: tuple[Frontier, ...], unknown_m2: dict[int, float]
    ) -> Decision:
        ahead = search_order.looked_ahead(
            frontiers, unknown_m2, search.terrain, search.pose, search.decision, cfg.plans
        )
        assert ahead is not None  # there are frontiers
        order = search_order.ordered(ahead, {})
        said = voices.ask(search, frontiers, unknown_m2) if voices and len(frontiers) > 1 else []
        votes = tuple(each for each in said if isinstance(each, Vote))
        missing = tuple(each for each in said if isinstance(each, Missing))
        ballot = Ballot(votes, missing)
        if cfg.fallback == "closest":
            return consensus.elect(ballot, frontiers, cfg)
        return consensus.elect(ballot, frontiers, cfg, order=order, ahead=ahead)

    return decide


def _knowing(
    search: FlatSearch, frontiers: tuple[Frontier, ...], unknown_m2: dict[int, float]
) -> Decision:
    """Of one who knows the way on from each."""
    way = search.home.way_m(search.task.goal)

    def cost_m(frontier: Frontier) -> float:
        row, col = search.frame.cell(*frontier.goal_xy)
        onward = way[max(0, row - 2) : row + 3, max(0, col - 2) : col + 3]
        return frontier.distance_m + float(onward.min())

    best = min(frontiers, key=cost_m)
    return Decision(best.id, ORACLE, (), None, Ballot(), 0, "")


def tables(rows: Rows) -> str:
    """Markdown: each method with its difference to BASE, clean and with one expert at random."""
    base = _spl(rows, BASE, CLEAN)
    lines = [
        f"| method | SPL % | minus {BASE}, points | one at random, points | way m |",
        "|---|---|---|---|---|",
    ]
    for method in dict.fromkeys(name for name, _ in rows):
        clean = _spl(rows, method, CLEAN)
        spoilt = [_spl(rows, m, c) for m, c in rows if m == method and c != CLEAN]
        less = _told(bootstrap((clean - base).tolist())) if method != BASE else "–"
        wild = "–"
        if spoilt:
            wild = _told(bootstrap((np.mean(spoilt, axis=0) - base).tolist()))
        way_m = np.mean([result.path_m for result in rows[method, CLEAN]])
        lines.append(
            f"| {method} | {_told(bootstrap(clean.tolist()))} | {less} | {wild} | {way_m:.1f} |"
        )
    return "\n".join(lines)


def _spl(rows: Rows, method: str, condition: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """(N,) percent, one a task."""
    return np.array([100.0 * result.spl for result in rows[method, condition]])


def _told(value: Figure) -> str:
    return f"{value.mean:.1f} [{value.low:.1f}, {value.high:.1f}]"
