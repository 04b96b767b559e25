"""A command's own process: what it is told, and what it does not import."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from places import ROOT

from runtime.commands import own_process
from runtime.commands.own_process import become, check_packages
from runtime.errors import ConfigError


def test_what_is_missing_is_told_with_how_it_comes():
    check_packages("mcp", ("json",), "agents")
    told = r"rfnav mcp: needs no_such_one, nor_this: pip install 'rf-nav\[agents\]'"
    with pytest.raises(ConfigError, match=told):
        check_packages("mcp", ("json", "no_such_one", "nor_this"), "agents")


@pytest.mark.parametrize(("first", "safe"), [(os.getcwd(), []), ("", []), ("/opt/bin", ["-P"])])
def test_it_is_told_what_was_given(monkeypatch: pytest.MonkeyPatch, first: str, safe: list[str]):
    began: list[list[str]] = []
    monkeypatch.setattr(own_process.os, "execv", lambda _, words: began.append(words))
    monkeypatch.setattr(own_process.sys, "path", [first, *sys.path])
    become("runtime.some", {"path": Path("a"), "names": ("b",), "none": None})
    assert began[0][:-1] == [sys.executable, *safe, "-m", "runtime.some"]
    assert json.loads(began[0][-1]) == {"path": "a", "names": ["b"], "none": None}


@pytest.mark.slow
def test_what_lies_where_a_client_stands_is_not_run(tmp_path: Path):
    for name in ("anyio", "click", "cv2", "mcp", "zenoh"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('a stranger was here')")
    done = subprocess.run(
        [sys.executable, "-P", "-m", "runtime", "mcp"],
        input="", capture_output=True, text=True, cwd=tmp_path, timeout=120,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
