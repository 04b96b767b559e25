"""A goal that was said to be near something: what is mapped of that is looked at first."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from places import TESTS

from runtime.journal import read_journal

pytestmark = pytest.mark.slow  # whole processes


def flat(folder: Path) -> str:
    """The small flat; from where the search begins the bed is far and the toilet out of sight."""
    scene = json.loads((TESTS / "refs/flat.json").read_text())
    places = {"bed": [1.9, 3.0, 0], "toilet": [3.75, 3.5, 0]}
    for thing in scene["objects"]:
        thing["position_m"] = places.get(thing["id"], thing["position_m"])
    scene["spawn"] = [[[0.3, 0.3], [0.8, 0.3], [0.8, 0.8], [0.3, 0.8]]]
    path = folder / "flat.json"
    path.write_text(json.dumps(scene))
    return str(path)


def reasons(goal: str, folder: Path) -> list[str]:
    """What the robot was told, step by step, until it had found the goal."""
    done = subprocess.run(
        [
            sys.executable, "-m", "hil_sim", "demo", "--goal", goal, "--scene", flat(folder),
            "--method", "oracle-perception", "--out", str(folder / "run"),
        ],
        capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert json.loads((folder / "run/summary.json").read_text())["success"]
    lines = read_journal(folder / "run/decisions.jsonl")
    return [str(line["reason"]) for line in lines if line["kind"] == "step"]


def test_the_bed_is_looked_at_first_and_the_toilet_found_where_it_is(tmp_path: Path):
    told = reasons("the toilet near the bed", tmp_path)
    visit = [n for n, reason in enumerate(told) if reason.endswith(", as was said")]
    assert visit
    assert visit[0] == 12  # as soon as the first look around is over
    assert visit[-1] - visit[0] == len(visit) - 1  # and once
    assert told[-1].startswith("found toilet")
