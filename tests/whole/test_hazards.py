"""A robot in PyBullet, in real time, and what steps in front of it."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from places import TESTS

pytestmark = pytest.mark.slow  # whole processes


def test_what_is_in_view_and_can_be_braked_for_is_not_touched(tmp_path: Path):
    kept = tmp_path / "hazards.json"
    done = subprocess.run(
        [sys.executable, "-m", "hil_sim", "hazards", "--trials", "1", "--speed", "0.4",
         "--method", "oracle-perception/geometry", "--scene", str(TESTS / "refs/flat.json"),
         "--out", str(tmp_path), "--json", str(kept)],
        capture_output=True, text=True, timeout=600.0, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr
    trials = [kept["trial"] for kept in json.loads(kept.read_text())["trials"]]
    assert sorted(trial["kind"] for trial in trials) == ["box", "leg", "person"]
    seen = [trial for trial in trials if trial["pixels"] >= 200]
    assert seen
    assert not any(trial["touched"] for trial in seen)
