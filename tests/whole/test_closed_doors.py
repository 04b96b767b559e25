"""A doorway is closed, or somebody stands in it, while the robot searches: it looks again."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from places import TESTS

from runtime.journal import read_journal

pytestmark = pytest.mark.slow  # whole processes


@pytest.mark.parametrize(
    ("fault", "more"),
    [
        ("door-closes:at=14,for=60", ()),
        ("person-stands:at=14,for=70", ()),
        ("door-closes:at=50,for=150", ("--realtime",)),
    ],
)
def test_what_is_beyond_is_found_when_it_is_open_again(
    fault: str, more: tuple[str, ...], tmp_path: Path
):
    out, scene = tmp_path / "run", str(TESTS / "refs/flat.json")
    done = subprocess.run(
        [
            sys.executable, "-m", "hil_sim", "demo", "--goal", "toilet", "--scene", scene,
            "--method", "oracle-perception", "--fault", fault, *more, "--out", str(out),
        ],
        capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert json.loads((out / "summary.json").read_text())["success"]
    if not more:  # in real time the door may be seen open again by chance
        lines = read_journal(out / "decisions.jsonl")
        assert any("is open again" in str(line.get("reason")) for line in lines)
