"""What kinds of evidence are worth, in Markdown and as figures for machines."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hil_sim.evaluation.summary import cell
from hil_sim.expert_bench.bank import Bank
from hil_sim.expert_bench.evidence import KindRow
from hil_sim.expert_bench.report import gap, head, line
from hil_sim.expert_bench.statistics import Resampling
from runtime.journal import plain

READING = (
    "By what an expert goes: `language`, likelihoods of the language model; `counts`, what was "
    "counted in homes; `guessed`, the same as if the goal had never been counted; `both`, the mean "
    "of the first two; `embedding`, the view's cosine with the goal's place; `head`, the network "
    "that was taught what lies beyond. A row of one voter takes its word, of several two must "
    "agree. Way: rank correlation of the evidence with a short way on, with the prior of unknown "
    "area; own: without it. Decides: of all questions; there, metres lost less what is fallen back "
    "on loses on the same questions; in all: the same over all questions. `paper`: the closest "
    "frontier is fallen back on; `sets`: information gain is; `prior`: evidence is weighed with "
    "unknown area and way, in one step; without any these decide. Brackets are 95 % bootstrap "
    "intervals, whole layouts resampled; bold where the interval leaves out 0."
)


def section(
    bank: Bank, rows: Mapping[str, KindRow], side: str, settings: Sequence[str], seed: int
) -> str:
    """One side's block."""
    said = f", with {' '.join(f'`{s}`' for s in settings)}" if settings else ""
    title = (
        f"## Evidence, side `{side}`: {len(bank.questions)} questions, {bank.homes} homes of "
        f"{bank.layouts} layouts{said}"
    )
    drawn = Resampling([q.layout for q in bank.questions], seed)
    parts = [title, READING, insight(rows, drawn)]
    for rule in next(iter(rows.values())).rules:
        parts += [f"### Where it decides, by the rule `{rule}`", decided(rows, rule, drawn)]
    return "\n\n".join(parts)


def insight(rows: Mapping[str, KindRow], drawn: Resampling) -> str:
    """How often each votes, and what it knows of the way."""
    lines = head("evidence", "has a set %", "way", "own", "on % of questions")
    for name, row in rows.items():
        own = drawn.mean(row.own)
        share = 100 * own.n / max(1, len(row.own))
        lines.append(line(name, f"{100 * row.voted.mean():.1f}", cell(drawn.mean(row.way)),
                          cell(own), f"{share:.1f}"))  # fmt: skip
    return "\n".join(lines)


def decided(rows: Mapping[str, KindRow], rule: str, drawn: Resampling) -> str:
    """What the votes cost that elected."""
    lines = head("evidence", "decides %", "regret there, m", "fallback's there, m",
                 "minus fallback's, m", "in all, m")  # fmt: skip
    for name, row in rows.items():
        made = row.rules[rule]
        lines.append(line(name, f"{100 * made.decided.mean():.1f}", cell(drawn.mean(made.regret_m)),
                          cell(drawn.mean(made.fallback_m)),
                          gap(drawn.mean(made.regret_m - made.fallback_m)),
                          gap(drawn.mean(made.gained_m))))  # fmt: skip
    return "\n".join(lines)


def figures(bank: Bank, rows: Mapping[str, KindRow], seed: int) -> dict[str, Any]:
    """The same, for machines."""
    drawn = Resampling([q.layout for q in bank.questions], seed)
    data: dict[str, Any] = plain(
        {
            "questions": len(bank.questions),
            "rows": {
                name: {
                    "voted": float(np.mean(row.voted)),
                    "way": drawn.mean(row.way),
                    "own": drawn.mean(row.own),
                    "rules": {
                        rule: {part: drawn.mean(values) for part, values in vars(made).items()}
                        | {"minus_fallback_m": drawn.mean(made.regret_m - made.fallback_m)}
                        for rule, made in row.rules.items()
                    },
                }
                for name, row in rows.items()
            },
        }
    )
    return data
