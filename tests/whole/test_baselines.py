"""The paper's baselines driven as `hil-sim eval` drives them, with networks that are imported."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from baseline_graphs import grounding_network, image_tower, text_tower
from places import TESTS

from hil_sim.ground_truth.episodes import Episode, Start, save_suite
from models.store import manifest

pytestmark = pytest.mark.slow  # whole processes

FLAT = str(TESTS / "refs/flat.json")
NEAR = Episode("flat-toilet-0", FLAT, Start(4.2, 2.4, 1.2), "toilet", 0.5)


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """What is imported goes elsewhere; furniture and models stay where they were fetched."""
    cache, models = manifest.cache_dir().parent, tmp_path / "cache" / "rf-nav" / "models"
    models.mkdir(parents=True)
    for folder in cache.iterdir():
        if folder.name != models.name:
            (models.parent / folder.name).symlink_to(folder)
    for folder in manifest.cache_dir().iterdir():
        (models / folder.name).symlink_to(folder)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    return tmp_path


def run(program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", program, *arguments]
    return subprocess.run(
        command, capture_output=True, text=True, timeout=900, check=False, env=dict(os.environ)
    )


def evaluated(home: Path, *methods: str) -> subprocess.CompletedProcess[str]:
    save_suite((NEAR,), home / "suite.json")
    asked = [word for method in methods for word in ("--method", method)]
    return run(
        "hil_sim", "eval", "--suite", str(home / "suite.json"), *asked, "--workers", "1",
        "--out", str(home / "out"), "--json", str(home / "figures.json"),
    )  # fmt: skip


def test_imported_networks_look_for_the_goal(home: Path) -> None:
    texts = str(text_tower(home / "clip"))
    image = str(image_tower(home / "image.onnx", grid=8))
    taken = run("runtime", "models", "import", image, "--as", "clip", "--texts", texts)
    assert "contract: clip with relevance" in taken.stdout, taken.stderr
    network = str(grounding_network(home / "g.onnx", [(0.5, 0.6, 0.2, 0.3)], ["toilet"]))
    tokenizer = str(home / "tokenizer.json")
    taken = run("runtime", "models", "import", network, "--as", "mdetr", "--texts", tokenizer)
    assert "contract: grounding" in taken.stdout, taken.stderr

    done = evaluated(home, "cow-clip-grad", "cow-mdetr")
    assert done.returncode == 0, done.stdout + done.stderr
    rows = json.loads((home / "figures.json").read_text())["episodes"]
    assert [row["method"] for row in rows] == ["cow-clip-grad", "cow-mdetr"]
    assert rows[0]["reason"] == "no toilet found and nothing left to explore"  # nothing is blue
    assert rows[1]["reason"].startswith("found toilet")
    logs = sorted(path.name for path in (home / "out" / "logs").iterdir())
    assert logs == ["runtime-flat-toilet-0-clip.log", "runtime-flat-toilet-0-mdetr.log"]
