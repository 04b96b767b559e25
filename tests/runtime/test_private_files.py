"""What is written is its owner's alone, also what an older version left open."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from runtime.core.voting.likelihood_experts import LikelihoodQuestion
from runtime.experts.score_cache import ScoreFile
from runtime.experts.spending import Caps, Spending
from runtime.private_files import state_directory, tighten


def mode(path: Path) -> int:
    return path.stat().st_mode & 0o777


def test_whatever_umask_it_is_started_with_files_are_their_owners(tmp_path: Path) -> None:
    """In a process of its own, for a umask is the whole process's."""
    code = (
        "import os, sys, pathlib; os.umask(0)\n"
        "from runtime.private_files import keep_to_owner; keep_to_owner()\n"
        "from runtime.journal import Journal, write_map\n"
        "folder = pathlib.Path(sys.argv[1]) / 'a' / 'b'\n"
        "Journal(folder / 'decisions.jsonl').close(); write_map(folder, {}, {})\n"
    )
    subprocess.run([sys.executable, "-c", code, tmp_path], check=True)
    found = {str(p.relative_to(tmp_path)): mode(p) for p in tmp_path.rglob("*")}
    files = {"a/b/decisions.jsonl": 0o600, "a/b/map.npz": 0o600}
    assert found == {"a": 0o700, "a/b": 0o700, **files}


@pytest.mark.parametrize(("was", "is_now"), [(0o644, 0o600), (0o666, 0o600), (0o400, 0o400)])
def test_only_what_others_may_is_taken_away(tmp_path: Path, was: int, is_now: int) -> None:
    path = tmp_path / "state"
    tighten(path)
    assert not path.exists()
    path.touch()
    path.chmod(was)
    tighten(path)
    assert mode(path) == is_now


def test_files_of_a_former_version_are_closed_when_they_are_used(tmp_path: Path) -> None:
    spending, scores = tmp_path / "spending.sqlite", tmp_path / "scores.sqlite"
    before = os.umask(0o022)
    try:
        for path in (spending, scores):
            path.touch()
            assert mode(path) == 0o644
        Spending(spending, Caps(1.0, 1.0)).begin("bed")
        file = ScoreFile(scores, "model")
        assert file.load() == {}
        file.keep([(LikelihoodQuestion("a kitchen has a", " stove"), -1.0)])
        assert file.error == ""
    finally:
        os.umask(before)
    assert {p.name: mode(p) for p in tmp_path.iterdir()} == {
        "spending.sqlite": 0o600,
        "scores.sqlite": 0o600,
    }


def test_the_state_is_where_systemd_says_else_the_users_own(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("STATE_DIRECTORY", "/var/lib/rf-nav:/var/lib/other")
    monkeypatch.setenv("XDG_STATE_HOME", "/of/the/user")
    assert state_directory() == Path("/var/lib/rf-nav")
    monkeypatch.delenv("STATE_DIRECTORY")
    assert state_directory() == Path("/of/the/user/rf-nav")
    monkeypatch.delenv("XDG_STATE_HOME")
    assert state_directory() == Path.home() / ".local" / "state" / "rf-nav"
