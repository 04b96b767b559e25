"""One episode in the small, every part real: rendered frames, Zenoh, detector, language model, map,
votes, planner, robot. And what a user sees when something is wrong."""

import json
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from places import TESTS

from runtime.journal import read_journal, read_map

pytestmark = pytest.mark.slow  # whole processes


def run(*arguments: str, program: str = "hil_sim", timeout: float = 900.0):
    return subprocess.run(
        [sys.executable, "-m", program, *arguments],
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )


@pytest.mark.slow
def test_a_robot_finds_the_toilet_in_a_small_flat(tmp_path: Path):
    out = tmp_path / "run"
    scene = str(TESTS / "refs/flat.json")
    done = run("demo", "--goal", "toilet", "--scene", scene, "--out", str(out))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "SUCCESS" in done.stdout
    assert "vote (first decision)" in done.stdout
    summary = json.loads((out / "summary.json").read_text())
    assert summary["success"]
    assert 0 < summary["spl"] <= 1
    assert summary["path_m"] >= summary["shortest_path_m"] - 0.5
    lines = list(read_journal(out / "decisions.jsonl"))
    decisions = [line for line in lines if line["kind"] == "decision"]
    assert decisions
    for decision in decisions:
        heard = {v["expert"] for v in decision["votes"]} | {
            m["expert"] for m in decision["missing"]
        }
        assert heard == {"o2f", "r2f", "sle"}
        causes = {m["cause"] for m in decision["missing"]}
        assert {why.partition(":")[0] for why in causes} <= {"no evidence", "no preference"}
    arrays, meta = read_map(out)
    assert arrays["free"].sum() > 1000
    assert "toilet" in {thing["name"] for thing in meta["objects"]}
    picture = cv2.imread(str(out / "map.png"))
    assert min(picture.shape[:2]) > 400
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 50


MISTAKES = [
    (
        ("--goal", "toilet", "--scene", "mapel"),
        "scene mapel: unknown; known: cedar, dais, landing, maple",
    ),
    (("--goal", " "), "goal: is empty"),
    (("--goal", "toilet", "--method", "best"), "method best: unknown"),
    (("--goal", "toilet", "--scene", "/nowhere.json"), "/nowhere.json"),
]


@pytest.mark.parametrize(("arguments", "message"), MISTAKES)
def test_a_mistake_is_one_line_and_exit_2(arguments: tuple[str, ...], message: str, tmp_path: Path):
    done = run("demo", *arguments, "--out", str(tmp_path / "run"))
    assert done.returncode == 2
    assert message in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (("map.max_detph_m=1",), "map.max_detph_m: unknown; did you mean max_depth_m?"),
        (("models.language='/nowhere/x.gguf'",), "models.language: /nowhere/x.gguf: no such file"),
        (("models.detectors=['/nowhere/x.onnx']",), "/nowhere/x.onnx"),
    ],
)
def test_the_runtime_says_what_is_wrong_in_one_line(settings: tuple[str, ...], message: str):
    flags = [word for setting in settings for word in ("--set", setting)]
    done = run("run", "--lockstep", *flags, program="runtime")
    assert done.returncode == 2
    assert message in done.stderr
    assert done.stderr.startswith("rfnav: ")
    assert len(done.stderr.strip().splitlines()) == 1


def test_a_damaged_model_file_is_named(tmp_path: Path):
    bad = tmp_path / "bad.onnx"
    bad.write_bytes(b"\x00" * 1000)
    done = run("run", "--lockstep", "--set", f"models.detectors=['{bad}']", program="runtime")
    assert done.returncode == 2
    assert "bad.onnx" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
