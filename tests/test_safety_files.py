"""The list of what keeps the robot safe, and that of its mutants that may survive."""

import importlib.util
import tomllib
from typing import Any

import pytest
from places import ROOT


def _load() -> Any:
    spec = importlib.util.spec_from_file_location(
        "safety_files", ROOT / "scripts" / "safety_files.py"
    )
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


safety_files = _load()
SURVIVORS = tomllib.loads((ROOT / "scripts" / "mutants.toml").read_text())["survivor"]


def test_every_file_of_the_list_is_there_and_has_tests():
    files = safety_files.safety_files()
    assert len(files) == len(set(files))
    assert [path for path in files if not safety_files.tests_of([path])] == []


def test_tests_are_those_that_are_named_after_a_module():
    found = safety_files.tests_of(["runtime/guard.py", "runtime/robot/reflex.py"])
    assert "tests/runtime/test_guard_turns.py" in found
    assert "tests/runtime/robot/test_reflex.py" in found
    assert not [path for path in found if "guard" not in path and "reflex" not in path]


def test_a_file_that_is_not_there_is_not_taken_for_covered(tmp_path, monkeypatch):
    text = '[tool.coverage.run]\ninclude = ["runtime/gone.py"]\n'
    (tmp_path / "pyproject.toml").write_text(text)
    monkeypatch.setattr(safety_files, "ROOT", tmp_path)
    with pytest.raises(SystemExit, match=r"there is no runtime/gone.py: correct it"):
        safety_files.safety_files()


@pytest.mark.parametrize("entry", SURVIVORS, ids=lambda entry: entry["was"][:40])
def test_a_mutant_that_may_survive_has_a_reason_and_is_one_of_the_code_as_it_is(entry):
    path, _, function = entry["of"].partition(": ")
    assert path in safety_files.safety_files()
    assert function
    code = " ".join(line.strip() for line in (ROOT / path).read_text().splitlines())
    assert entry["was"] in code
    assert entry["becomes"]
    assert entry["was"] not in entry["becomes"]
    assert len(entry["why"]) > 10
