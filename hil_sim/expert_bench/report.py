"""What a judged bank says, in Markdown between two markers, and as figures for machines."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hil_sim.evaluation.summary import Figure, cell
from hil_sim.expert_bench.bank import CLEAN, Bank
from hil_sim.expert_bench.judge import CONDITIONS, CONSENSUS, NEAR, RIGHT_M, SPOILT, Row, Table
from hil_sim.expert_bench.statistics import Resampling
from runtime.journal import plain

CLOSEST = "closest"
READING = (
    "Brackets are 95 % bootstrap intervals, whole layouts resampled; differences are paired by "
    "question, bold where the interval leaves out 0. A choice is right when it costs less than "
    f"{RIGHT_M} m more than the best one, and the worst when no other costs more. `{CONSENSUS}` "
    f"is the paper's rule, `{NEAR}` the same where no vote wins what is more than a metre farther "
    f"than the closest (`research.consensus_detour_m`), `{CONSENSUS}+geometry` the same where "
    "information gain is fallen back on; `random` a frontier drawn blindly, as its expectation; "
    "voted: the experts chose, and not what is fallen back on."
)
SPOILING = (
    "Wrong labels: each object goes by another's name with probability {wrong}. Missing objects: "
    "each was never seen with probability {missing}. One at random: each of the method's experts "
    "in its turn votes for one or two frontiers drawn at random, and never abstains. One absent: "
    "each in its turn. The last two are means over these turns."
)


def section(
    bank: Bank, table: Table, side: str, settings: Sequence[str], plan: Mapping[str, Any], seed: int
) -> str:
    """One side's block."""
    drawn = Resampling(table.layouts, seed)
    left_out = ", ".join(f"{why} {count}" for why, count in sorted(bank.left_out.items()))
    said = f", with {' '.join(f'`{s}`' for s in settings)}" if settings else ""
    parts = [
        f"## Side `{side}`: {len(bank.questions)} questions, {bank.homes} homes of "
        f"{bank.layouts} layouts{said}",
        f"Left out (no question): {left_out or 'none'}.",
        READING,
        clean(table, drawn),
    ]
    if len(table.rows[CONSENSUS]) > 1:
        parts += ["### Perturbed: mean regret, m", SPOILING.format(**plan),
                  perturbed(table, drawn), "### One expert spoilt: the consensus",
                  spoilt(table, drawn)]  # fmt: skip
    parts += ["### The experts", experts(table, drawn), "### Do they say the same?",
              likeness(table, drawn)]  # fmt: skip
    return "\n\n".join(parts)


def clean(table: Table, drawn: Resampling) -> str:
    """The main table."""
    lines = head("method", "regret m", f"minus {CONSENSUS}, m", "right %", "worst %", "voted %")
    base = table.rows[CONSENSUS][CLEAN]
    for name, rows in table.rows.items():
        row = rows[CLEAN]
        behind = "–" if name == CONSENSUS else gap(drawn.mean(row.regret_m - base.regret_m))
        cells = (cell(drawn.mean(row.regret_m)), behind, cell(drawn.mean(row.right), 100, 1),
                 cell(drawn.mean(row.worst), 100, 1), _percent(row.voted))  # fmt: skip
        lines.append(line(name, *cells))
    return "\n".join(lines)


def perturbed(table: Table, drawn: Resampling) -> str:
    """Mean regrets by condition."""
    names = [name for name in CONDITIONS if name in table.rows[CONSENSUS]]
    lines = head("method", *names)
    for name, rows in table.rows.items():
        lines.append(line(name, *(cell(drawn.mean(rows[c].regret_m)) for c in names)))
    return "\n".join(lines)


def spoilt(table: Table, drawn: Resampling) -> str:
    """The consensus with each expert at random or absent: what that costs, and whether it still
    beats the closest frontier."""
    lines = head("expert", "how", "regret m", "minus clean, m", f"minus {CLOSEST}, m", "worst %")
    whole, closest = table.rows[CONSENSUS][CLEAN], table.rows[CLOSEST][CLEAN]
    for kind in SPOILT:
        turns = dict(table.spoilt.get(kind, {}))
        if turns:
            turns["each in turn"] = table.rows[CONSENSUS][kind]
        for expert, row in turns.items():
            cells = (cell(drawn.mean(row.regret_m)),
                     gap(drawn.mean(row.regret_m - whole.regret_m)),
                     gap(drawn.mean(row.regret_m - closest.regret_m)),
                     cell(drawn.mean(row.worst), 100, 1))  # fmt: skip
            lines.append(line(expert, kind.removeprefix("one "), *cells))
    return "\n".join(lines)


def experts(table: Table, drawn: Resampling) -> str:
    """How often each votes, why not, and whether its evidence knows the way."""
    told = "evidence and a short way on, rank correlation"
    lines = head("expert", "voted %", "abstained %", told, "on % of questions")
    for name, outcomes in table.votes.items():
        why = ", ".join(f"{c} {100 * s:.1f}" for c, s in outcomes.items() if c != "voted")
        insight = drawn.mean(table.insight[name])
        share = insight.n / max(1, len(table.layouts))
        lines.append(line(name, f"{100 * outcomes.get('voted', 0.0):.1f}", why or "–",
                           cell(insight), f"{100 * share:.1f}"))  # fmt: skip
    return "\n".join(lines)


def likeness(table: Table, drawn: Resampling) -> str:
    """How far two experts repeat each other."""
    lines = head("experts", "both vote %", "sets share a frontier %", "by chance %",
                  "evidence, rank correlation")  # fmt: skip
    for (one, other), like in table.likeness.items():
        lines.append(line(f"{one}, {other}", cell(drawn.mean(like.both_vote), 100, 1),
                           cell(drawn.mean(like.overlap), 100, 1), _percent(like.by_chance),
                           cell(drawn.mean(like.correlation))))  # fmt: skip
    return "\n".join(lines)


def figures(bank: Bank, table: Table, seed: int) -> dict[str, Any]:
    """The same as the tables, for machines."""
    drawn = Resampling(table.layouts, seed)
    base = table.rows[CONSENSUS]

    def row(values: Row, against: Row) -> dict[str, Figure]:
        found = {name: drawn.mean(column) for name, column in vars(values).items()}
        return {**found, "minus_consensus_m": drawn.mean(values.regret_m - against.regret_m)}

    data: dict[str, Any] = plain(
        {
            "questions": len(bank.questions),
            "homes": bank.homes,
            "layouts": bank.layouts,
            "left_out": bank.left_out,
            "methods": {
                name: {c: row(values, base[c]) for c, values in rows.items()}
                for name, rows in table.rows.items()
            },
            "spoilt": {
                kind: {expert: row(values, base[CLEAN]) for expert, values in turns.items()}
                for kind, turns in table.spoilt.items()
            },
            "votes": table.votes,
            "insight": {name: drawn.mean(values) for name, values in table.insight.items()},
            "likeness": {
                f"{one}, {other}": {k: drawn.mean(v) for k, v in vars(like).items()}
                for (one, other), like in table.likeness.items()
            },
        }
    )
    return data


def gap(figure: Figure) -> str:
    apart = math.isfinite(figure.low) and (figure.low > 0 or figure.high < 0)
    return f"**{cell(figure)}**" if apart else cell(figure)


def _percent(values: "np.ndarray[Any, np.dtype[np.float64]]") -> str:
    known = values[np.isfinite(values)]
    return f"{100 * known.mean():.1f}" if known.size else "–"


def head(*names: str) -> list[str]:
    return [line(*names), f"|{'---|' * len(names)}"]


def line(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"
