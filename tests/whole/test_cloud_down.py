"""An episode with a cloud that is down: it goes on with what the robot has itself."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from places import TESTS

from runtime.journal import read_journal

SCENE = TESTS / "refs/flat.json"


@pytest.mark.slow
def test_an_episode_goes_on_without_the_cloud(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "hil_sim", "demo", "--goal", "toilet", "--scene", str(SCENE)]
    command += ["--fault", "cloud-down", "--out", str(tmp_path / "run")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=1800.0, check=False)
    assert done.returncode in (0, 1), done.stdout + done.stderr  # found it or not, no error
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["steps"] > 12
    assert not summary["ended"].startswith("error")
    lines = list(read_journal(tmp_path / "run" / "decisions.jsonl"))
    calls = [line["call"] for line in lines if line["kind"] == "cloud"]
    assert calls, "no decision asked the cloud"
    down = ("late", "the connection broke")
    assert all(call["outcome"].startswith(down) for call in calls)
    votes = [v for line in lines if line["kind"] == "decision" for v in line["votes"]]
    assert votes
    assert {v["rung"] for v in votes} <= {"local", "counts", "embedding"}
