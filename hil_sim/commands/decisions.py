"""`hil-sim decisions`: how long a vote takes, and that none is late whatever the experts do.

The embedded models at work on made-up maps of 8 frontiers and 20 known objects: no home is drawn.
"""

import json
import math
import os
import random
import tempfile
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import click
import numpy as np
from tqdm import tqdm

from hil_sim.ground_truth.labels import LABELLED
from runtime.clock import Deadline, SystemClock
from runtime.config import Config, load
from runtime.core.types import Absence, Brief, Decision, FrontierBrief, Missing, NearbyObject, Vote
from runtime.core.voting import consensus
from runtime.experts.panel import Expert, Panel
from runtime.perception.loaded_models import LoadedModels

FRONTIERS, OBJECTS, VIEW = 8, 20, 384
GOALS = ("mug", "television")  # the first of the robot's life, and a later one
NEW_OBJECTS = 10
READERS = ("o2f", "r2f")  # experts whose evidence the language model has to be asked for
FAULTY = 1 / 3  # of the calls
PACE = 0.5  # of the budget, from one decision to the next: as a robot's, 1 s with 2 s
WARM = 0.1  # of the decisions with faults: growth is counted from there on
MEMOISED_S, FIRST_VOTE_S, OBJECT_S, GROWTH_MB = 0.1, 2.0, 0.3, 8.0
PATIENCE_S = 300.0


@dataclass(frozen=True)
class LatencyFigure:
    """A line of the table; `most` is the goal, where there is one."""

    what: str
    value: float
    unit: str
    most: float | None = None

    @property
    def missed(self) -> bool:
        return self.most is not None and not self.value <= self.most


@dataclass(frozen=True)
class Held:
    """What a process holds on to."""

    threads: int
    files: int
    memory_mb: float

    @classmethod
    def now(cls) -> "Held":
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
        memory = pages * os.sysconf("SC_PAGE_SIZE") / 1e6
        return cls(threading.active_count(), len(os.listdir("/proc/self/fd")), memory)


class Faulty:
    """An expert that hangs, fails or talks nonsense in a third of its calls. A hang outlives its
    deadline, and ends: a thread that never came back would be called once only."""

    def __init__(self, expert: Expert, budget_s: float, seed: str) -> None:
        self._expert, self._budget_s, self._random = expert, budget_s, random.Random(seed)
        self.faults = {"hang": 0, "error": 0, "nonsense": 0}
        self.calls = 0

    def __call__(self, brief: Brief, by: Deadline) -> Vote | Missing:
        self.calls += 1
        if self._random.random() >= FAULTY:
            return self._expert(brief, by)
        fault = self._random.choice(sorted(self.faults))
        self.faults[fault] += 1
        if fault == "hang":
            time.sleep(self._random.uniform(1.0, 1.5) * self._budget_s)
        elif fault == "error":
            raise RuntimeError("injected")
        return Vote("", (10**6,), (), "nonsense")


def made_up(goal: str, objects: Sequence[str], rooms: Sequence[str], seed: str) -> Brief:
    """Eight frontiers; every object is near two of them, every frontier has room evidence and a
    view."""
    rng = random.Random(seed)
    near: dict[int, list[NearbyObject]] = {i: [] for i in range(1, FRONTIERS + 1)}
    for name in objects:
        for i in rng.sample(sorted(near), 2):
            sure, far_m = round(rng.uniform(0.6, 1.0), 3), rng.uniform(0.2, 3.5)
            near[i].append(NearbyObject(name, sure, far_m))
    told = []
    for i, things in near.items():
        shares = np.array([rng.expovariate(1.0) ** 2 for _ in rooms])
        view = np.array([rng.gauss(0.0, 1.0) for _ in range(VIEW)], np.float32)
        told.append(
            FrontierBrief(
                i,
                rng.uniform(0.5, 12.0),
                tuple(sorted(things, key=lambda o: (o.distance_m, o.name))),
                tuple(zip(rooms, (shares / shares.sum()).tolist(), strict=True)),
                view / np.float32(np.linalg.norm(view)),
            )
        )
    return Brief(goal, 0, tuple(told))


def decide(
    panel: Panel, brief: Brief, config: Config, clock: SystemClock
) -> tuple[Decision, float]:
    """A decision as the runtime makes it, and how long it took, s."""
    began_s = perf_counter()
    ballot = panel.ask(brief, Deadline.after(config.panel.votes_s, clock))
    decision = consensus.elect(ballot, brief.frontiers, config.navigate.consensus)
    return decision, perf_counter() - began_s


def first_votes(
    models: LoadedModels, goal: str, objects: Sequence[str], config: Config, clock: SystemClock
) -> dict[str, float]:
    """Seconds from a goal to the first vote of each expert that reads, deciding again and again;
    an abstention for want of a preference is as informed as a vote."""
    began_s = perf_counter()
    _, panel = models.accept(goal, config)
    brief = made_up(goal, objects, models.rooms, goal)
    took: dict[str, float] = {}
    while len(took) < len(READERS) and perf_counter() - began_s < PATIENCE_S:
        asked_s = perf_counter() - began_s
        ballot = decide(panel, brief, config, clock)[0].ballot
        informed = [vote.expert for vote in ballot.votes]
        informed += [m.expert for m in ballot.missing if m.why is Absence.NO_PREFERENCE]
        for expert in (e for e in informed if e in READERS):
            took.setdefault(expert, asked_s + ballot.latency_s[expert])
    return took


def new_objects(
    models: LoadedModels, goal: str, names: Sequence[str], objects: Sequence[str],
    clock: SystemClock, config: Config,
) -> list[float]:  # fmt: skip
    """Seconds from the mapping of each new object until its evidence counts in O2F's vote."""
    took = []
    o2f = models.seated(config)["o2f"]
    for n, name in enumerate(names):
        known = (*objects, *names[: n + 1])
        brief = made_up(goal, known, models.rooms, name)
        models.settle(Deadline.never(clock))
        began_s = perf_counter()
        models.notice(goal, tuple(sorted(known)))
        o2f(brief, Deadline.never(clock))
        took.append(perf_counter() - began_s)
    return took


def speed(config: Config, count: int, seed: int) -> tuple[list[LatencyFigure], dict[str, object]]:
    """Cold, warm, and with faults; the table's lines, and what else was counted."""
    clock, rng = SystemClock(), random.Random(seed)
    names = rng.sample(sorted(n for n in LABELLED if n not in GOALS), OBJECTS + NEW_OBJECTS)
    objects, new = names[:OBJECTS], names[OBJECTS:]
    figures: list[LatencyFigure] = []
    with LoadedModels(config, clock) as models:
        for goal, when in zip(GOALS, ("nothing known yet", "others asked before"), strict=True):
            took = first_votes(models, goal, objects, config, clock)
            first = min(took.values(), default=math.inf)
            figures.append(
                LatencyFigure(f"new goal to first vote, {when}", first, "s", FIRST_VOTE_S)
            )
            figures += [
                LatencyFigure(f"  to the first of {n}", took.get(n, math.inf), "s") for n in READERS
            ]
            models.settle(Deadline.never(clock))
        goal = GOALS[-1]
        models.notice(goal, tuple(objects))
        took_s = new_objects(models, goal, new, objects, clock, config)
        figures.append(
            LatencyFigure("new object to its evidence, p50", _at(took_s, 50), "s", OBJECT_S)
        )
        figures.append(LatencyFigure("  the slowest of them", max(took_s), "s"))
        models.settle(Deadline.never(clock))
        _, panel = models.accept(goal, config)
        models.settle(Deadline.never(clock))
        briefs = [made_up(goal, objects, models.rooms, f"{seed}/{n}") for n in range(200)]
        quick = [decide(panel, brief, config, clock)[1] for brief in briefs]
        figures.append(LatencyFigure("memoised decision, p50", _at(quick, 50), "s", MEMOISED_S))
        figures.append(LatencyFigure("  p95", _at(quick, 95), "s"))
        figures.append(LatencyFigure("  max", max(quick), "s"))
        spoilt, told = _with_faults(models, briefs, config, count, seed)
    return figures + spoilt, told


def _with_faults(
    models: LoadedModels, briefs: Sequence[Brief], config: Config, count: int, seed: int
) -> tuple[list[LatencyFigure], dict[str, object]]:
    clock, budget_s = SystemClock(), config.panel.decide_budget_s
    seats = {
        name: Faulty(expert, budget_s, f"{seed}/{name}")
        for name, expert in models.seated(config).items()
    }
    rule = config.navigate.consensus
    took: list[float] = []
    voters: dict[int, int] = {}
    held = Held.now()
    with Panel(
        dict(seats), clock, settled=lambda v, out, b: consensus.settled(v, out, b.frontiers, rule)
    ) as panel:
        for n in tqdm(range(count), unit="decision", disable=None):
            if n == round(count * WARM):
                held = Held.now()
            decision, seconds = decide(panel, briefs[n % len(briefs)], config, clock)
            took.append(seconds)
            time.sleep(max(0.0, PACE * budget_s - seconds))  # else all are asked while some hang
            votes = len(decision.ballot.votes)
            voters[votes] = voters.get(votes, 0) + 1
            if decision.frontier is None:
                raise AssertionError("a map with frontiers was left undecided")
        after = Held.now()
    calls = {name: {"calls": s.calls, **s.faults} for name, s in seats.items()}
    told = {"calls": calls, "voters": {str(k): v for k, v in sorted(voters.items())}}
    return _held_up(took, budget_s, held, after, list(seats.values())), told


def _held_up(
    took: Sequence[float], budget_s: float, held: Held, after: Held, seats: Sequence[Faulty]
) -> list[LatencyFigure]:
    late = sum(seconds > budget_s for seconds in took)
    return [
        LatencyFigure(f"decision with faults, p50 (of {len(took)})", _at(took, 50), "s"),
        LatencyFigure("  p95", _at(took, 95), "s"),
        LatencyFigure("  max", max(took), "s", budget_s),
        LatencyFigure("  later than the budget", late, "", 0),
        LatencyFigure("  threads more at the end", after.threads - held.threads, "", 0),
        LatencyFigure("  open files more at the end", after.files - held.files, "", 0),
        LatencyFigure(
            "  memory more at the end", after.memory_mb - held.memory_mb, "MB", GROWTH_MB
        ),
        LatencyFigure("  calls", sum(seat.calls for seat in seats), ""),
        LatencyFigure("  of them at fault", sum(sum(seat.faults.values()) for seat in seats), ""),
    ]


def _at(seconds: Sequence[float], percent: float) -> float:
    return float(np.percentile(seconds, percent))


def lines(figures: Sequence[LatencyFigure]) -> list[str]:
    """The table, ready to print."""
    rows = []
    for f in figures:
        value = f"{f.value:.4f} {f.unit}" if f.unit == "s" else f"{f.value:.0f} {f.unit}".rstrip()
        goal = "" if f.most is None else f"<= {f.most:g} {f.unit}".rstrip()
        rows.append(f"{f.what:44} {value:>10}  {goal:10} {'MISSED' if f.missed else ''}".rstrip())
    return [f"{'':44} {'measured':>10}  goal", *rows]


@click.command(
    "decisions",
    epilog="Examples:  hil-sim decisions   |   hil-sim decisions --count 1000 --budget 0.2 "
    "--json speed.json",
)
@click.option("--count", default=1000, show_default=True, type=click.IntRange(10),
              help="Decisions with faults in a third of the calls.")  # fmt: skip
@click.option("--budget", default=2.0, show_default=True, type=click.FloatRange(0.1),
              help="Of a decision, s. With faults, half of them take all of it.")  # fmt: skip
@click.option("--seed", default=0, show_default=True)
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="All figures as JSON.")
def decisions_command(count: int, budget: float, seed: int, json_file: Path | None) -> None:
    """How long a vote takes: cold, memoised, and while experts hang and fail.

    Exit status 1 when a goal is missed.
    """
    with tempfile.TemporaryDirectory() as folder:
        settings = [
            f"panel.decide_budget_s={budget}",
            f"research.score_file='{folder}/scores.sqlite'",
            "research.word_evidence=language",  # counts take a thousandth of its time
        ]
        config = load(None, settings)
        figures, told = speed(config, count, seed)
    for line in lines(figures):
        click.echo(line)
    if json_file is not None:
        wall = [{**vars(f), "missed": f.missed} for f in figures]
        kept = {"count": count, "budget_s": budget, "seed": seed, **told, "wall": wall}
        json_file.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    if any(f.missed for f in figures):
        raise click.exceptions.Exit(1)
