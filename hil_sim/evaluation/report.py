"""Tables and figures of evaluations, put into a document.

What stands in the document outside of a folder's two marker comments is kept as it is:
    <!-- report val -->  ...  <!-- end of report val -->
"""

import re
from collections.abc import Sequence
from typing import Any

from hil_sim.driving.episode_result import EpisodeResult
from hil_sim.driving.methods import BOUNDS, COW, LABELS, ORACLE
from hil_sim.evaluation import report_tables as tables
from hil_sim.evaluation.failures import false_finds, split
from hil_sim.evaluation.left_out import lines_of, rows_of
from hil_sim.evaluation.result_folder import FULL, Folder
from hil_sim.evaluation.summary import summarise
from hil_sim.ground_truth.metrics import TRIVIAL_M
from runtime.errors import RfNavError
from runtime.experts.panel import SEATED
from runtime.journal import plain

NOBODY = "geometry"
"""Who asks no expert: what experts are worth is against it, in tables that other rows call for."""
GROUPS = (
    ("Against baselines", ("closest", "geometry", "geometry-ahead", *COW, "single-llm", "paper",
                           "sets", "prior", "prior-one-step", FULL)),
    ("Experts alone, in pairs, all", ("o2f", "r2f", "sle", "o2f+r2f", "o2f+sle", "r2f+sle",
                                      "paper")),
    ("Consensus against a majority", ("single-llm", "majority-k3", "majority-k5", "paper")),
    ("One expert left out, or at random", (
        *(f"{how}-{expert}" for how in ("without", "spoilt") for expert in SEATED), NOBODY, FULL)),
    ("What a vote could bring", (*BOUNDS, NOBODY, FULL)),
)  # fmt: skip
"""Tables of the paper, and what the experts are worth; each is compared with its last row."""
Group = tuple[str, str, dict[str, list[EpisodeResult]]]
ASIDES = (
    ("", ""),
    (f"{ORACLE}/", ", with true labels (oracle perception)"),
    (f"{LABELS}/", ", with true boxes and names"),
)
TOLD_ALL = (ORACLE, "oracle-goal")
INTERVALS = (
    "Brackets are 95 % bootstrap intervals over episodes; differences are paired by episode, bold "
    "where the interval leaves out 0."
)
RULE = (
    "Detection: it stopped for something else, or had the goal in view (200 pixels within 5 m) and "
    "never made for it. Planning: it made for an instance, or stopped for one, and did not end "
    "where that counts. Exploration: the goal was never in view. The rule is in "
    "`hil_sim/evaluation/failures.py`."
)


def groups(folder: Folder) -> list[Group]:
    """The paper's tables that a folder has rows for: title, the method that is compared, and
    results; each over the episodes that all its rows have. A table whose rows differ in that comes
    twice: the rows with most episodes, then all."""
    found = []
    for prefix, aside in ASIDES:
        for title, names in GROUPS:
            rows = {prefix + name: folder.runs.get(prefix + name) for name in names}
            base = prefix + names[-1]
            unnamed = prefix == ASIDES[1][0] and names[-1] == FULL and rows[base] is None
            if unnamed and any(rows.values()):
                rows.pop(base)  # the short name says the same
                base = ORACLE
                rows[base] = folder.runs.get(ORACLE)
            if first := title == GROUPS[0][0]:
                rows |= {bound: folder.runs.get(bound) for bound in TOLD_ALL if bound not in rows}
            have = {name: results for name, results in rows.items() if results}
            compared = {base} if first else {base, prefix + NOBODY}
            if base in have and set(have) - compared - set(TOLD_ALL):
                found += [(title + aside, base, runs) for runs in _tiers(have, compared)]
    return found


def _tiers(
    rows: dict[str, list[EpisodeResult]], compared: set[str]
) -> list[dict[str, list[EpisodeResult]]]:
    most = max(len(results) for results in rows.values())
    largest = {name: r for name, r in rows.items() if len(r) == most or name in compared}
    tiers = [largest] if set(largest) - compared and len(largest) < len(rows) else []
    return [_common(tier) for tier in (*tiers, rows)]


def _common(rows: dict[str, list[EpisodeResult]]) -> dict[str, list[EpisodeResult]]:
    """The same, over the episodes that every row has."""
    shared = set.intersection(*({r.episode for r in results} for results in rows.values()))
    kept = {name: [r for r in results if r.episode in shared] for name, results in rows.items()}
    return {name: results for name, results in kept.items() if results}


def section(
    folder: Folder, seed: int, pictures: Sequence[tuple[str, str]], before: Folder | None = None
) -> str:
    """One folder's block; `pictures` are (path, caption). `before`: an earlier run of it."""
    parts = [_title(folder), INTERVALS, *_compared(folder, groups(folder), seed)]
    parts += _remarks(folder)
    if before is not None:
        parts += ["### Before and after", tables.progress(folder.runs, before.runs, seed)]
    parts += ["### Why episodes failed", RULE, tables.failures(folder.runs),
              *_spent(folder.runs), "### Found, by goal", tables.categories(_main(folder)),
              "### Where the time goes", _pace(folder), tables.times(folder.runs)]  # fmt: skip
    parts += [f"![{caption}]({path})\n\n{caption}" for path, caption in pictures]
    return "\n\n".join(part for part in parts if part)


def brief(folder: Folder, seed: int) -> str:
    """One folder's block for a page: what is compared with the runtime as it is, and why methods
    with most episodes failed."""
    main = [group for group in groups(folder) if group[1].endswith(FULL)] or groups(folder)[:1]
    parts = [_title(folder), INTERVALS, *_compared(folder, main, seed), *_remarks(folder)]
    parts += ["### Why episodes failed", RULE, tables.failures(_main(folder))]
    parts += _spent(_main(folder))
    return "\n\n".join(part for part in parts if part)


def _compared(folder: Folder, chosen: Sequence[Group], seed: int) -> list[str]:
    """The chosen tables with their differences; where there are none, all methods in one."""
    parts = []
    for title, base, runs in chosen:
        count = len(runs[base]) if base in runs else 0
        if count:
            parts += [f"### {title}: {count} episodes", tables.outcomes(runs, seed),
                      tables.differences(runs, base, seed)]  # fmt: skip
    if parts:
        return parts
    parts.append(tables.outcomes(folder.runs, seed))
    first = next((name for name in folder.runs if name.endswith(GROUPS[0][1][0])), None)
    if first is not None and len(folder.runs) > 1:
        parts.append(tables.differences(folder.runs, first, seed))
    return parts


def _title(folder: Folder) -> str:
    run = folder.run
    more = [
        f"{key} {', '.join(run[key])}" for key in ("faults", "noise", "sensors") if run.get(key)
    ]
    rest = f"; {'; '.join(more)}" if more else ""
    seed = f"seed {run.get('seed', 0)}"
    return f"## Suite `{run['suite']}`, protocol `{run['protocol']}`, {seed}{rest}"


def _remarks(folder: Folder) -> list[str]:
    """What the figures leave out."""
    found = [f"{line}." for line in lines_of(folder.left_out)]
    trivial = sum(e.shortest_path_m < TRIVIAL_M for e in folder.episodes)
    if trivial:
        found.append(f"{trivial} of the suite's episodes have less than {TRIVIAL_M} m to go: "
                     "they are left out of SPL and SoftSPL.")  # fmt: skip
    for name, results in folder.runs.items():
        off = summarise([r.outcome for r in results]).cut_off
        if off:
            found.append(f"{name}: {off} episodes ended cut off from success; left out of DTS.")
    return found


def _spent(runs: tables.Runs) -> list[str]:
    shares = tables.purposes(runs)
    return ["### What the steps were spent on", shares] if shares else []


def _main(folder: Folder) -> dict[str, list[EpisodeResult]]:
    """The methods with most episodes."""
    most = max(len(results) for results in folder.runs.values())
    return {name: r for name, r in folder.runs.items() if len(r) == most}


def _pace(folder: Folder) -> str:
    seconds = sum(row["seconds"] for row in folder.times)
    if not seconds:
        return ""
    done = sum(row["episodes"] for row in folder.times)
    workers = sorted({row["workers"] for row in folder.times})
    cores = sorted({row["cores"] for row in folder.times})
    return (
        f"{done} episodes in {seconds / 60:.0f} minutes of wall time, setting up homes and models "
        f"included: {60 * done / seconds:.1f} a minute with {_listed(workers)} workers on "
        f"{_listed(cores)} cores. Methods of one episode share the frames of poses that they have "
        "in common; the seconds below are those that an episode itself took, so that a method that "
        "comes later in the list renders less."
    )


def _listed(numbers: Sequence[int]) -> str:
    return " or ".join(str(number) for number in numbers)


def fill(document: str, name: str, text: str) -> str:
    """The document with a folder's block replaced, or added at its end."""
    begin, end = f"<!-- report {name} -->", f"<!-- end of report {name} -->"
    block = f"{begin}\n{text}\n{end}"
    found = re.search(f"{re.escape(begin)}.*?{re.escape(end)}", document, re.DOTALL)
    if found:
        return document[: found.start()] + block + document[found.end() :]
    if begin in document:
        raise RfNavError(f"{begin}: its end is missing; write {end} after it")
    return f"{document.rstrip()}\n\n{block}\n".lstrip("\n")


def figures(folder: Folder, seed: int) -> dict[str, Any]:
    """The same as the tables, for machines."""
    left_out = {"left_out": rows_of(folder.left_out)} if folder.left_out else {}
    return {
        "run": folder.run,
        **left_out,
        "methods": {
            name: {
                **plain(summarise([r.outcome for r in results], seed)),
                "frontier_m": plain(tables.frontier_distance(results, seed)),
                "failures": split(results),
                "false_finds_in_1000_frames": false_finds(
                    results, sum(r.outcome.steps for r in results)
                ),
            }
            for name, results in folder.runs.items()
        },
        "tables": [
            {"title": title, "episodes": len(runs[base]), "rows": list(runs),
             "gains": plain(tables.gains(runs, base, seed))}
            for title, base, runs in groups(folder)
        ],
    }  # fmt: skip
