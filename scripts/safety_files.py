#!/usr/bin/env python3
"""Which files keep the robot safe, which tests are theirs, and what of them changed.

  scripts/safety_files.py         prints the tests

The list is in pyproject.toml, where coverage reads it (`tool.coverage.run`).
"""

import ast
import subprocess
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


def functions(text: str) -> dict[str, str]:
    """The code of each, whatever its comments, by `name` or `Class.name`."""
    found = dict[str, str]()
    for node in ast.parse(text).body:
        of = f"{node.name}." if isinstance(node, ast.ClassDef) else ""
        for one in node.body if isinstance(node, ast.ClassDef) else [node]:
            if isinstance(one, ast.FunctionDef | ast.AsyncFunctionDef):
                found[of + one.name] = ast.dump(one)
    return found


def changed_since(commit: str, path: str) -> set[str]:
    """Names of the functions of a file whose code was another at that commit, or not there.
    ValueError where there is no such commit."""

    def git(*words: str) -> str | None:
        done = subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, text=True)
        return done.stdout if done.returncode == 0 else None

    if git("rev-parse", "--verify", "--end-of-options", f"{commit}^{{commit}}") is None:
        raise ValueError(f"there is no commit {commit}")
    before = functions(git("show", "--end-of-options", f"{commit}:{path}") or "")
    now = functions((ROOT / path).read_text())
    return {name for name, code in now.items() if before.get(name) != code}


if __name__ == "__main__":
    sys.stdout.write("\n".join(tests_of(safety_files())) + "\n")
