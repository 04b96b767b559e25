"""The list of what keeps the robot safe, and that of its mutants that may survive."""

import importlib.util
import subprocess
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


def test_functions_are_told_apart_by_their_code():
    text = "def f(): pass\nclass A:\n  x = 1\n  def f(self): return 1\n  async def g(self): pass\n"
    found = safety_files.functions(text)
    assert list(found) == ["f", "A.f", "A.g"]
    assert found == safety_files.functions(text.replace("f(): pass", "f():  # as ever\n    pass"))
    other = safety_files.functions(text.replace("return 1", "return 2"))
    assert [name for name in found if found[name] != other[name]] == ["A.f"]


def test_what_changed_since_a_commit_is_what_was_another_then_or_not_there(tmp_path, monkeypatch):
    def git(*words: str) -> None:
        who = "-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false"
        subprocess.run(["git", "-C", str(tmp_path), *who, *words], check=True, capture_output=True)

    monkeypatch.setattr(safety_files, "ROOT", tmp_path)
    (tmp_path / "a.py").write_text("def f(): return 1\ndef g(): return 1\n")
    git("init", "-q")
    git("add", "a.py")
    git("commit", "-q", "-m", "a")
    assert safety_files.changed_since("HEAD", "a.py") == set()
    (tmp_path / "a.py").write_text("def f(): return 1\ndef g(): return 2\ndef h(): return 1\n")
    (tmp_path / "b.py").write_text("def f(): pass\n")
    assert safety_files.changed_since("HEAD", "a.py") == {"g", "h"}
    assert safety_files.changed_since("HEAD", "b.py") == {"f"}
    with pytest.raises(ValueError, match="there is no commit 0123"):
        safety_files.changed_since("0123", "a.py")


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
