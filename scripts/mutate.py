#!/usr/bin/env python3
"""Mutation testing of what keeps the robot safe, with mutmut: prints, for each file, what became of
its mutants, and those that survived the tests without being in scripts/mutants.toml.

  scripts/mutate.py [--jobs N] [--since COMMIT] [FILE[:FUNCTION,...]...]

Exit status 1 when there is one, or one to take out of that list. FUNCTION is `name` or
`Class.name`; --since leaves those of which the code is another than at COMMIT.

mutmut changes a copy of the tree in mutants/, and remembers there which mutants were noticed. What
survived is tried again, for there may be a test of it by now.
"""

import argparse
import json
import os
import shutil
import sys
import tomllib
from collections import Counter
from collections.abc import Container, Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from safety_files import ROOT, changed_since, functions, safety_files, tests_of

os.chdir(ROOT)  # mutmut reads its configuration from there, and works there

from mutmut.__main__ import CatchOutput, _run, create_mutants  # noqa: E402
from mutmut.configuration import config  # noqa: E402
from mutmut.mutation.data import SourceFileMutationData  # noqa: E402
from mutmut.mutation.diff_apply import get_diff_for_mutant  # noqa: E402
from mutmut.runners.harness import PytestRunner  # noqa: E402
from mutmut.state import state  # noqa: E402
from mutmut.stats import status_by_exit_code  # noqa: E402
from mutmut.utils.file_utils import (  # noqa: E402
    copy_also_copy_files,
    copy_src_dir,
    setup_source_paths,
)
from mutmut.utils.format_utils import orig_function_and_class_names_from_key  # noqa: E402
from mutmut.workers import isolation  # noqa: E402

COPY = Path("mutants")
LIST = Path("scripts/mutants.toml")
NOTICED = ("killed", "timeout")


class Change(NamedTuple):
    """What a mutant is, however many others there are: `was` and `becomes` are lines of code."""

    path: str
    function: str
    was: str
    becomes: str

    def __str__(self) -> str:
        """As it is listed, but for the reason."""
        quoted = [json.dumps(text, ensure_ascii=False) for text in self]
        of = json.dumps(f"{self.path}: {self.function}")
        return f"[[survivor]]\nof = {of}\nwas = {quoted[2]}\nbecomes = [{quoted[3]}]"


class FastFirst(PytestRunner):
    """mutmut's own runner has the tests of a mutant in any order."""

    def run_tests(self, *, mutant_name: str | None, tests: Iterable[str]) -> int:
        took_s = state().duration_by_test
        ordered = sorted(tests, key=lambda test: took_s.get(test, 0.0))
        return super().run_tests(mutant_name=mutant_name, tests=ordered)


def main(words: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split(":")[0])
    parser.add_argument("--jobs", type=int, default=1, help="mutants that are tried at once")
    parser.add_argument("--since", metavar="COMMIT", help="what changed after it alone")
    of = "FILE[:FUNCTION,...]"
    parser.add_argument("parts", nargs="*", metavar=of, help="those alone, of the list of files")
    asked = parser.parse_args(words)
    try:
        chosen = parts(asked.parts or safety_files(), asked.since)
    except ValueError as error:
        parser.error(str(error))
    if not chosen:
        print(f"nothing of that changed since {asked.since}")
        return 0
    isolation.PytestRunner = FastFirst  # type: ignore[misc]
    prepare(safety_files(), list(chosen))
    found = [each for path, names in chosen.items() for each in mutants(path, names)]
    left = [name for name, status in found if status not in NOTICED]
    if left:
        _run(left, asked.jobs)
    return report(chosen)


def parts(words: Iterable[str], since: str | None) -> dict[str, set[str]]:
    """Names of functions by file. ValueError for what is none."""
    found = dict[str, set[str]]()
    for word in words:
        path, _, named = word.partition(":")
        if path not in safety_files():
            raise ValueError(f"{path}: is none of tool.coverage.run in pyproject.toml")
        there = set(functions((ROOT / path).read_text()))
        wanted = set(named.split(",")) if named else there
        if strangers := wanted - there:
            raise ValueError(f"{path}: has no function {min(strangers)}")
        if since is not None:
            wanted &= changed_since(since, path)
        if wanted:
            found[path] = found.get(path, set()) | wanted
    return found


def prepare(files: Sequence[str], chosen: Sequence[str]) -> None:
    """Have mutmut mutate those files in its copy, and choose among the tests of the chosen ones."""
    settings = config()
    settings.only_mutate = list(files)
    settings.pytest_add_cli_args_test_selection = tests_of(chosen)
    # mutmut copies once what it does not mutate, and asks once which tests there are.
    shutil.rmtree(COPY / "tests", ignore_errors=True)
    (COPY / "mutmut-stats.json").unlink(missing_ok=True)
    for path in files:  # of a file that was copied before it was listed there is not one mutant
        if not (COPY / f"{path}.meta").exists():
            (COPY / path).unlink(missing_ok=True)
    kept = shutil.ignore_patterns("*.py", "__pycache__")
    for path in settings.source_paths:
        shutil.copytree(path, COPY / path, ignore=kept, dirs_exist_ok=True)
    with CatchOutput():
        copy_src_dir()
        copy_also_copy_files()
        setup_source_paths()
        create_mutants(1)


def mutants(path: str, names: Container[str]) -> list[tuple[str, str]]:
    """(name, what became of it) each of those functions, by what mutmut remembers."""
    data = SourceFileMutationData(path=path)
    data.load()
    return [
        (name, status_by_exit_code[code])
        for name, code in data.exit_code_by_key.items()
        if function_of(name) in names
    ]


def function_of(name: str) -> str:
    """`name` or `Class.name`, of a mutant's own."""
    function, of = orig_function_and_class_names_from_key(name)
    return f"{of}.{function}" if of else function


def change(path: str, name: str) -> Change:
    """What a mutant is."""
    lines = get_diff_for_mutant(name, path=path).splitlines()[2:]
    was, becomes = (
        " ".join(line[1:].strip() for line in lines if line.startswith(sign)) for sign in "-+"
    )
    return Change(path, function_of(name), was, becomes)


def listed() -> set[Change]:
    """Mutants that may survive, by scripts/mutants.toml, where each has its reason."""
    found = set()
    for entry in tomllib.loads(LIST.read_text())["survivor"]:
        path, _, function = entry["of"].partition(": ")
        assert entry["why"], entry
        for becomes in entry["becomes"]:
            found.add(Change(path, function, entry["was"], becomes))
    return found


def report(chosen: Mapping[str, set[str]]) -> int:
    """Print what became of the mutants of those functions; the exit status."""
    known, wrong, total = listed(), 0, Counter[str]()
    for path, names in chosen.items():
        found = mutants(path, names)
        survived = {change(path, name) for name, status in found if status not in NOTICED}
        counts = Counter(status for _, status in found)
        total += counts
        told = ", ".join(f"{number} {status}" for status, number in sorted(counts.items()))
        print(f"{path}: {len(found)} mutants: {told}")
        for one in sorted(survived - known):
            print(f"# survived\n{one}")
        gone = sorted(one for one in known - survived if one.path == path and one.function in names)
        for one in gone:
            print(f"# does not survive: take it out of {LIST}\n{one}")
        wrong += len(survived - known) + len(gone)
    print(f"{total.total()} mutants of {len(chosen)} files: {wrong} to see to")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
