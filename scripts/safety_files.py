#!/usr/bin/env python3
"""Which files keep the robot safe, and which tests are theirs.

  scripts/safety_files.py         prints the tests

The list is in pyproject.toml, where coverage reads it (`tool.coverage.run`).
"""

import sys
import tomllib
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def safety_files() -> list[str]:
    """Paths from the root. SystemExit for one that is not there: it would count as covered."""
    text = (ROOT / "pyproject.toml").read_text()
    files: list[str] = tomllib.loads(text)["tool"]["coverage"]["run"]["include"]
    for path in files:
        if not (ROOT / path).is_file():
            raise SystemExit(f"pyproject.toml: tool.coverage.run: there is no {path}: correct it")
    return files


def tests_of(files: Iterable[str]) -> list[str]:
    """The files of tests that are named after those modules, `test_bus_base.py` after `bus`."""
    found: set[str] = set()
    for path in map(Path, files):
        room = ROOT / "tests" / path.parent
        for pattern in (f"test_{path.stem}.py", f"test_{path.stem}_*.py"):
            found |= {str(test.relative_to(ROOT)) for test in room.glob(pattern)}
    return sorted(found)


if __name__ == "__main__":
    sys.stdout.write("\n".join(tests_of(safety_files())) + "\n")
