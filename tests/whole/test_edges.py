"""Searches that begin beside a stairwell and on a platform, as processes: nobody falls. All twenty
starts: `hil-sim eval --suite edges --method oracle-perception`, with `--protocol robothor --tilt
episode` for a camera that looks down, and with `--realtime`."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from hil_sim.ground_truth.episodes import load_suite, save_suite

pytestmark = pytest.mark.slow  # whole processes
LEVEL = ("--protocol", "hm3d")
TILTED = ("--protocol", "robothor", "--tilt", "episode")
VELOCITIES = ("--protocol", "onrobot")


def evaluated(out: Path, ids: tuple[str, ...], *arguments: str) -> dict:
    """The figures of these episodes of the suite."""
    chosen = tuple(episode for episode in load_suite("edges") if episode.id in ids)
    assert len(chosen) == len(ids)
    save_suite(chosen, out / "some.json")
    done = subprocess.run(
        [
            sys.executable, "-m", "hil_sim", "eval", "--suite", str(out / "some.json"),
            "--method", "oracle-perception", "--workers", "1", "--out", str(out / "run"),
            "--json", str(out / "figures.json"), *arguments,
        ],
        capture_output=True, text=True, timeout=900, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "; 0 falls" in done.stdout
    figures: dict = json.loads((out / "figures.json").read_text())
    return figures


@pytest.mark.parametrize(
    ("protocol", "ids", "found"),
    [
        (LEVEL, ("landing-plant-1", "landing-chair-4", "dais-plant-0", "dais-chair-2"), 3),
        (TILTED, ("landing-plant-1", "landing-chair-4", "dais-plant-0", "dais-chair-2"), 3),
        (VELOCITIES, ("landing-plant-1", "dais-chair-2"), 1),
    ],
    ids=("hm3d", "robothor", "onrobot"),
)
def test_from_beside_an_edge_nobody_falls(
    protocol: tuple[str, ...], ids: tuple[str, ...], found: int, tmp_path: Path
):
    figures = evaluated(tmp_path, ids, *protocol)
    assert figures["methods"]["oracle-perception"]["falls"] == 0
    ended = [episode["ended"] for episode in figures["episodes"]]
    assert ended == ["stop"] * len(ids)
    assert sum(episode["success"] for episode in figures["episodes"]) >= found


def test_in_real_time_nobody_falls_either(tmp_path: Path):
    figures = evaluated(tmp_path, ("dais-chair-2",), *LEVEL, "--realtime")
    assert figures["methods"]["oracle-perception"]["falls"] == 0
    assert [episode["collisions"] for episode in figures["episodes"]] == [0]


def test_where_a_level_camera_sees_an_edge_too_late_cliff_sensors_decide(tmp_path: Path):
    """Without them the robot stays where it began: what is open may begin at its feet."""
    figures = evaluated(tmp_path, ("landing-plant-2",), *LEVEL, "--realtime", "--sensor", "cliffs")
    assert figures["methods"]["oracle-perception"]["falls"] == 0
    assert all(episode["path_m"] > 0.5 for episode in figures["episodes"])
