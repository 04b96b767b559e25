"""Whether two result folders say the same: `python -m hil_sim.evaluation.compare OUT1 OUT2`.

Wall times and the order of lines are left out, everything else must be equal to the last digit:
the configuration, every episode, every step of its track. Keys that were renamed since are the same
keys. Exit status: 0 equal, 1 different, with the first difference named, 2 an error.
"""

import json
import sys
from itertools import zip_longest
from pathlib import Path
from typing import Any

from hil_sim.evaluation.results import RESULTS_FILE, RUN_FILE, run_of
from hil_sim.ground_truth.witness import TRACK_FILE
from runtime.errors import RfNavError

Rows = dict[tuple[str, str], dict[str, Any]]


def difference(one: Path, two: Path) -> str | None:
    """The first difference, in a line; None when there is none."""
    unlike = _unlike(_run(one), _run(two))
    if unlike:
        return f"{RUN_FILE}: {unlike}"
    ours, theirs = _rows(one), _rows(two)
    for key in sorted({*ours, *theirs}):
        name = " ".join(key)
        for rows, folder in ((ours, one), (theirs, two)):
            if key not in rows:
                return f"{name}: not in {folder}"
        unlike = _unlike(ours[key], theirs[key]) or _tracks(one, two, key)
        if unlike:
            return f"{name}: {unlike}"
    return None


def _unlike(ours: dict[str, Any], theirs: dict[str, Any]) -> str | None:
    for key in sorted({*ours, *theirs}):
        a, b = ours.get(key), theirs.get(key)
        if json.dumps(a, sort_keys=True) != json.dumps(b, sort_keys=True):
            return f"{key}: {a!r} and {b!r}"
    return None


def _tracks(one: Path, two: Path, key: tuple[str, str]) -> str | None:
    files = [folder / key[0] / key[1] / TRACK_FILE for folder in (one, two)]
    lines = [f.read_text(encoding="utf-8").splitlines() if f.is_file() else [] for f in files]
    for number, (a, b) in enumerate(zip_longest(*lines), 1):
        if a != b:
            return f"{TRACK_FILE}:{number}: {a or 'no such line'} and {b or 'no such line'}"
    return None


def _rows(folder: Path) -> Rows:
    path = folder / RESULTS_FILE
    if not path.is_file():
        raise RfNavError(f"{path}: no such file; name folders that `hil-sim eval` has written")
    found: Rows = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        row = json.loads(line)
        row.pop("wall", None)
        found[row["method"], row["episode"]] = row
    return found


def _run(folder: Path) -> dict[str, Any]:
    run = run_of(folder)
    if not run:
        path = folder / RUN_FILE
        raise RfNavError(f"{path}: no such file; name folders that `hil-sim eval` has written")
    return run


def main(arguments: list[str]) -> int:
    """Print the outcome; returns the exit status."""
    if len(arguments) != 2:
        print("usage: python -m hil_sim.evaluation.compare OUT1 OUT2", file=sys.stderr)
        return 2
    one, two = (Path(name) for name in arguments)
    try:
        found = difference(one, two)
    except RfNavError as error:
        print(f"compare: {error}", file=sys.stderr)
        return 2
    if found:
        print(f"different: {found}")
        return 1
    print(f"equal: {len(_rows(one))} episodes")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
