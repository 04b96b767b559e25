"""What the scene-layout expert came to, in Markdown between two markers, and as figures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

import numpy as np

from hil_sim.evaluation.summary import Figure, cell
from hil_sim.expert_bench.auc import LEAST, Area
from hil_sim.expert_bench.bank import Bank
from hil_sim.expert_bench.report import gap, head, line
from hil_sim.expert_bench.scene_bank import GATE, SceneRows
from hil_sim.expert_bench.scene_speed import FRONTIERS, SceneSeconds
from hil_sim.expert_bench.scene_views import (
    GUESSING,
    HEAD,
    NEVER,
    ORACLE_FLOOR,
    ORACLE_ROOMS,
    TABLE,
    TAUGHT,
    AreaRow,
    ViewTable,
)
from hil_sim.expert_bench.scene_ways import PRIOR
from hil_sim.expert_bench.statistics import Resampling, Values
from hil_sim.expert_bench.view_questions import BEYOND_M
from runtime.journal import plain

READING = (
    "Brackets are 95 % bootstrap intervals over whole homes, or layouts; differences are paired, "
    "bold where the interval leaves out 0. Areas under the ROC curve are means over the names with "
    f"{LEAST} answers of each kind; pooled: all their questions at once. `beyond`: one within "
    f"{BEYOND_M:g} m of walking from the frontier, through what the map does not know, and not in "
    f"view; what is on the map is not asked about. `{TABLE}`: how often a train home has the thing "
    "beyond, or in view, by the room type that the detector's head sees; it has counted all names, "
    "those never taught too; guessing: it has not, and takes for them what names alike have. "
    f"`{PRIOR}`: the unknown area behind a frontier, which all experts' votes weigh in. "
    f"`{ORACLE_ROOMS}` is told by the truth which types of room lie behind each frontier, "
    f"`{ORACLE_FLOOR}` how much floor of each; both have counted in the plans of train homes what "
    "stands in them."
)
WHERE = {"beyond": "X beyond", "view": "X in view"}
AIMS = {("beyond", TAUGHT): "≥ 0.80", ("beyond", NEVER): "≥ 0.72",
        ("view", TAUGHT): "≥ 0.90", ("view", NEVER): "≥ 0.75"}  # fmt: skip


@dataclass(frozen=True)
class SideRows:
    """One side of the bank: its questions, and by kind what each came to; `prior` the rank
    correlation of the unknown area alone."""

    bank: Bank
    kinds: Mapping[str, SceneRows]
    prior: Values


@dataclass(frozen=True)
class SceneFigures:
    """All that was measured; what was not is left out."""

    views: ViewTable
    sides: Mapping[str, SideRows] = field(default_factory=dict)
    seconds: Mapping[str, SceneSeconds] = field(default_factory=dict)
    settings: Sequence[str] = ()


def section(found: SceneFigures, seed: int) -> str:
    """The block: what was aimed for first, then the details."""
    said = f", with {' '.join(f'`{s}`' for s in found.settings)}" if found.settings else ""
    parts = [
        f"### On {found.views.homes} held-out homes{said}",
        READING,
        aims(found, seed),
        questions(found.views),
        "#### Against the table",
        details(found.views),
    ]
    for name, side in found.sides.items():
        drawn = _drawn(side, seed)
        parts += [f"#### In the bank, side `{name}`: {len(side.bank.questions)} questions"]
        parts += [insight(side, drawn), SHUFFLED, *_other_rungs(side), regrets(side, drawn)]
        parts += [READING_BARS, bars(side, drawn)]
    return "\n\n".join(parts)


def _other_rungs(side: SideRows) -> list[str]:
    """Where a kind could not answer, what did in its place."""
    told = [
        f"{kind}: {count} votes by {rung}"
        for kind, rows in side.kinds.items()
        for rung, count in rows.rungs.items()
        if rung != kind
    ]
    return [f"Answered in place of what was to be judged: {'; '.join(told)}."] if told else []


def aims(found: SceneFigures, seed: int) -> str:
    """What each kind, and what it is compared with, came to beside what was aimed for."""
    table = found.views
    judges = _judges(table)
    lines = head("", "aim", *judges)

    def row(title: str, aim: str, cells: Mapping[str, str]) -> None:
        lines.append(line(title, aim, *(cells.get(j, "–") for j in judges)))

    for title, aim, told in (("rendered", "≥ 0.75", table.rooms),
                             ("photographs", "≥ 0.65", table.photographs)):  # fmt: skip
        row(f"room of a view, {title}, top-1", aim, {j: cell(a.figure) for j, a in told.items()})
    for (about, group), rows in table.areas.items():
        cells = {j: cell(r.macro.figure) for j, r in rows.items()}
        row(f"{WHERE[about]}, {group}, AUC", AIMS[about, group], cells)
    ways = {j: cell(w.voted) for j, w in table.ways.items()}
    row("evidence and a short way on, these views", "≥ 0.25", ways)
    for name, side in found.sides.items():
        drawn = _drawn(side, seed)
        for title, aim, scale, values in (
            ("votes on %", "≥ 60", 100, {k: r.votes for k, r in side.kinds.items()}),
            ("evidence and a short way on", "≥ 0.25", 1,
             {k: r.insight.voted for k, r in side.kinds.items()}),
            ("own evidence, pictures shuffled", "≤ 0.05", 1,
             {k: r.shuffled.own for k, r in side.kinds.items()}),
        ):  # fmt: skip
            digits = 2 if scale == 1 else 1
            cells = {k: cell(drawn.mean(v), scale, digits) for k, v in values.items()}
            row(f"{title}, side `{name}`", aim, cells)
    took = {kind: f"{1000 * s.new_views:.1f}" for kind, s in found.seconds.items()}
    row(f"{FRONTIERS} frontiers never looked at, 2 threads, ms", "≤ 500", took)
    took = {kind: f"{1000 * s.known_views:.1f}" for kind, s in found.seconds.items()}
    row("the same views, another goal, ms", "≤ 500", took)
    return "\n".join(lines)


def _drawn(side: SideRows, seed: int) -> Resampling:
    return Resampling([q.layout for q in side.bank.questions], seed)


def _area(area: Area | None) -> str:
    return "–" if area is None else cell(area.figure)


def _judges(table: ViewTable) -> list[str]:
    """The kinds, then what they are compared with."""
    others = (TABLE, GUESSING, PRIOR, ORACLE_ROOMS, ORACLE_FLOOR, HEAD)
    return [*(kind for kind in table.rooms if kind not in others), *others]


def details(table: ViewTable) -> str:
    """Less the table's, paired; and over all questions at once."""
    judges = [j for j in _judges(table) if j != HEAD]
    lines = head("", *judges)
    for (about, group), rows in table.areas.items():
        parts = [rows.get(j) for j in judges]
        title = f"{WHERE[about]}, {group}"
        lines.append(line(f"{title}: minus the table", *map(_gap, judges, parts)))
        lines.append(
            line(f"{title}: pooled", *(_area(None if r is None else r.micro) for r in parts))
        )
        if about == "beyond":
            lines.append(
                line(
                    f"{title}: with the prior",
                    *(_area(None if r is None else r.weighed) for r in parts),
                )
            )
            gains = (gap(r.gain.figure) if r and r.gain and j != PRIOR else "–"
                     for j, r in zip(judges, parts, strict=True))  # fmt: skip
            lines.append(line(f"{title}: with the prior, minus the prior alone", *gains))
    own = (cell(table.ways[j].own) if j in table.ways else "–" for j in judges)
    lines.append(line("own evidence and a short way on", *own))
    return "\n".join(lines)


def _gap(judge: str, row: AreaRow | None) -> str:
    return "–" if row is None or judge == TABLE else gap(row.gap.figure)


def questions(table: ViewTable) -> str:
    """How many there are."""
    told = [
        f"{WHERE[about]}, {group}: {names} names, {count} questions"
        for (about, group), (names, count) in table.asked.items()
    ]
    if PRIOR in table.ways:
        prior = table.ways[PRIOR].voted
        told.append(
            f"a short way on: {prior.n} moments and things where three frontiers have a view and a "
            f"way, of which the prior of unknown area alone has {cell(prior)}"
        )
    return f"{'; '.join(told)}."


ABSENT = "sle absent"
SHUFFLED = (
    "Way: rank correlation of evidence with a short way on; own: without the prior of unknown area "
    "that all experts' evidence has, which is a row of its own. Shuffled: each frontier is shown "
    "another one's picture, and keeps its own place in it, where all can be given another; in "
    "brackets behind it what the same questions have unshuffled. Sle absent: the same rule where "
    "it never votes; who votes seldom comes near to that, and need not vote well."
)


def insight(side: SideRows, drawn: Resampling) -> str:
    """How often each kind votes, and what its evidence knows."""
    lines = head("expert", "votes on %", "way", "minus the prior", "minus r2f", "way, own",
                 "own minus r2f's", "own, shuffled (unshuffled)", "on % of questions")  # fmt: skip
    count = len(side.bank.questions)
    for kind, rows in side.kinds.items():
        mine, theirs, mixed = rows.insight, rows.rival, drawn.mean(rows.shuffled.own)
        share = drawn.mean(mine.voted).n / count
        lines.append(line(
            f"sle, {kind}", cell(drawn.mean(rows.votes), 100, 1), cell(drawn.mean(mine.voted)),
            gap(drawn.mean(mine.voted - side.prior)), gap(drawn.mean(mine.voted - theirs.voted)),
            cell(drawn.mean(mine.own)), gap(drawn.mean(mine.own - theirs.own)),
            f"{cell(mixed)} ({cell(drawn.mean(rows.kept.own))})", f"{100 * share:.1f}",
        ))  # fmt: skip
    for rows in list(side.kinds.values())[:1]:
        told = rows.rival
        share = drawn.mean(told.voted).n / count
        lines.append(line("r2f", "–", cell(drawn.mean(told.voted)),
                          gap(drawn.mean(told.voted - side.prior)), "–",
                          cell(drawn.mean(told.own)), "–", "–", f"{100 * share:.1f}"))  # fmt: skip
    prior = drawn.mean(side.prior)
    lines.append(line("the prior alone", "–", cell(prior), "–", "–", "–", "–", "–",
                      f"{100 * prior.n / count:.1f}"))  # fmt: skip
    return "\n".join(lines)


def regrets(side: SideRows, drawn: Resampling) -> str:
    """The gate: what each method loses with each kind, and where SLE does not vote at all; and the
    differences."""
    judged = [*side.kinds, ABSENT]
    pairs = list(combinations(judged, 2))
    lines = head("regret, m", *judged, *(f"{a} minus {b}" for a, b in pairs))
    for method in GATE:
        lost = {kind: rows.regret_m[method] for kind, rows in side.kinds.items()}
        for rows in list(side.kinds.values())[:1]:  # the same beside each kind
            lost |= {ABSENT: rows.absent_m[method]} if method in rows.absent_m else {}
        told = (cell(drawn.mean(lost[j])) if j in lost else "–" for j in judged)
        apart = (gap(drawn.mean(lost[a] - lost[b])) if b in lost else "–" for a, b in pairs)
        lines.append(line(method, *told, *apart))
    return "\n".join(lines)


READING_BARS = (
    "The same votes by other bars: a frontier of n is recommended from a probability of bar / n "
    "on. Regret in m, and in brackets less that by the bar as it is, paired."
)


def bars(side: SideRows, drawn: Resampling) -> str:
    """What it would cost to vote more often, or less."""
    lines = head("kind", "bar", "votes on %", *GATE)
    for kind, rows in side.kinds.items():
        for bar, row in rows.bars.items():
            lost = (
                f"{drawn.mean(regret).mean:.2f} ({gap(drawn.mean(regret - rows.regret_m[method]))})"
                for method, regret in row.regret_m.items()
            )
            voted = f"{100 * drawn.mean(row.votes).mean:.1f}"
            lines.append(line(f"sle, {kind}", f"{bar:g}", voted, *lost))
    return "\n".join(lines)


def figures(found: SceneFigures, seed: int) -> dict[str, Any]:
    """The same as the tables, for machines."""
    told = found.views
    data: dict[str, Any] = plain(
        {
            "homes": told.homes,
            "areas": {
                f"{about}, {group}": {judge: _plain(row) for judge, row in rows.items()}
                for (about, group), rows in told.areas.items()
            },
            "rooms": {judge: area.figure for judge, area in told.rooms.items()},
            "photographs": {judge: area.figure for judge, area in told.photographs.items()},
            "ways": told.ways,
            "sides": {name: _side(side, seed) for name, side in found.sides.items()},
            "seconds": found.seconds,
        }
    )
    return data


def _plain(row: AreaRow) -> dict[str, Figure]:
    return {name: area.figure for name, area in vars(row).items() if area is not None}


def _side(side: SideRows, seed: int) -> dict[str, Any]:
    drawn = _drawn(side, seed)

    def both(values: Any) -> dict[str, Figure]:
        return {name: drawn.mean(each) for name, each in vars(values).items()}

    return {
        "questions": len(side.bank.questions),
        "prior": drawn.mean(side.prior),
        "kinds": {
            kind: {
                "votes": drawn.mean(rows.votes),
                "insight": both(rows.insight),
                "r2f": both(rows.rival),
                "minus_prior": drawn.mean(rows.insight.voted - side.prior),
                "minus_r2f": drawn.mean(rows.insight.voted - rows.rival.voted),
                "shuffled": both(rows.shuffled),
                "unshuffled": both(rows.kept),
                "regret_m": {m: drawn.mean(np.asarray(v)) for m, v in rows.regret_m.items()},
                "absent_m": {m: drawn.mean(np.asarray(v)) for m, v in rows.absent_m.items()},
                "rungs": rows.rungs,
                "bars": {
                    f"{bar:g}": {
                        "votes": drawn.mean(row.votes),
                        "regret_m": {m: drawn.mean(v) for m, v in row.regret_m.items()},
                    }
                    for bar, row in rows.bars.items()
                },
            }
            for kind, rows in side.kinds.items()
        },
    }
