"""Experts whose votes the harness casts, elected by a runtime that is a process of its own."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from runtime.journal import read_journal

pytestmark = pytest.mark.slow  # whole processes, and the detector


def test_who_knows_the_way_is_followed(tmp_path: Path) -> None:
    out = tmp_path / "run"
    done = subprocess.run(
        [
            sys.executable, "-m", "hil_sim", "eval", "--suite", "smoke", "--limit", "1",
            "--method", "labels/beyond-alone", "--method", "labels/all-known", "--workers", "1",
            "--out", str(out),
        ],
        capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "| labels/all-known | " in done.stdout.partition("exploring %")[2]
    rows = [json.loads(line) for line in (out / "episodes.jsonl").read_text().splitlines()]
    assert all(row["success"] for row in rows)
    for row in rows:
        lines = read_journal(out / row["method"] / row["episode"] / "decisions.jsonl")
        decisions = [line for line in lines if line["kind"] == "decision"]
        votes = [vote for decision in decisions for vote in decision["votes"]]
        assert votes
        assert {vote["rung"] for vote in votes} == {"told"}
        if row["method"] == "labels/beyond-alone":
            assert {vote["reason"] for vote in votes} == {"beyond known"}
            assert all(d["frontier"] in d["votes"][0]["frontiers"] for d in decisions if d["votes"])
