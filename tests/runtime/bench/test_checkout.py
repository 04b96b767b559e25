import subprocess
from pathlib import Path

import pytest

from runtime.bench.checkout import checkout
from runtime.bench.measure import BenchError

SETUP = """
import pathlib, sys
pathlib.Path("compiled").write_text(" ".join(sys.argv[1:]))
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """Two commits, of which the second has something to compile."""
    root = tmp_path / "project"
    root.mkdir()
    git(root, "init", "-q")
    for name, text in (("plain.txt", ""), ("setup.py", SETUP)):
        (root / name).write_text(text)
        git(root, "add", name)
        git(root, "-c", "user.name=a", "-c", "user.email=a@b.c", "commit", "-qm", name)
    return root


def git(root: Path, *arguments: str) -> str:
    command = ["git", "-C", str(root), *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def test_a_commit_is_there_compiled_and_gone_afterwards(project: Path):
    with checkout(project, "HEAD") as root:
        assert (root / "compiled").read_text() == "-q build_ext --inplace"
    assert not root.exists()
    assert git(project, "worktree", "list").count("\n") == 1


def test_one_without_anything_to_compile_is_left_as_it_is(project: Path):
    with checkout(project, "HEAD~1") as root:
        assert sorted(path.name for path in root.iterdir()) == [".git", "plain.txt"]


def test_what_git_does_not_know_is_told(project: Path):
    with pytest.raises(BenchError, match=r"--against: .*nowhere"), checkout(project, "nowhere"):
        pass


def test_what_does_not_compile_is_told(project: Path):
    (project / "setup.py").write_text("raise SystemExit('no compiler')")
    git(project, "-c", "user.name=a", "-c", "user.email=a@b.c", "commit", "-qam", "broken")
    with pytest.raises(BenchError, match="no compiler"), checkout(project, "HEAD"):
        pass
