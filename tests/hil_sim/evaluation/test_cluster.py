"""The same jobs on a local Ray: the same results, and their files come home."""

import importlib
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from places import DOUBLES, ROOT

from hil_sim.driving.episode_result import EpisodeResult
from hil_sim.evaluation.cluster import remote
from hil_sim.evaluation.pool import local
from hil_sim.evaluation.worker import Failure, Job, Settings, Task
from hil_sim.ground_truth.episodes import Episode, Start

HERE = str(DOUBLES)
JOBS = [
    Job(
        scene,
        tuple(
            Task(Episode(f"e{i}", scene, Start(0, 0, 0), "bed", 4.0), ("closest", "rfnav"))
            for i in range(first, first + 3)
        ),
    )
    for scene, first in (("maple", 0), ("cedar", 3))
]


@pytest.fixture
def worker(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(HERE)
    root = str(ROOT)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([root, HERE]))
    return importlib.import_module("fake_worker")


def results(messages: Any) -> list[EpisodeResult]:
    found = [replace(m, wall={}) for m in messages if isinstance(m, EpisodeResult)]
    return sorted(found, key=lambda r: (r.episode, r.method))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_local_ray_gives_what_local_workers_give(worker: Any, tmp_path: Path) -> None:
    with remote(JOBS, Settings(tmp_path / "ray"), "local", worker.drive_with_files) as messages:
        far = results(messages)
    with local(JOBS, Settings(tmp_path / "here"), 2, worker.work) as messages:
        near = results(messages)
    assert far == near
    assert len(far) == 12
    tracks = sorted((tmp_path / "ray").rglob("track.jsonl"))
    assert len(tracks) == 12
    assert tracks[0].read_text() == "closest e0\n"


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_what_fails_on_a_node_is_told(worker: Any, tmp_path: Path) -> None:
    settings = Settings(tmp_path, settings=("crash late",))
    with remote(JOBS[:1], settings, "local", worker.drive) as messages:
        said = list(messages)
    (failure,) = (m for m in said if isinstance(m, Failure))
    assert failure.text.startswith("the task for maple failed: ")
    assert {m.episode for m in said if isinstance(m, EpisodeResult)} == {"e0"}
