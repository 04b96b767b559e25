"""What an evaluation left in a folder, read whole."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hil_sim.driving.episode_result import EpisodeResult
from hil_sim.driving.methods import METHODS
from hil_sim.evaluation.left_out import StartCheck, Survey, read_survey
from hil_sim.evaluation.results import RUN_FILE, SUITE_FILE, TIMES_FILE, Results
from hil_sim.ground_truth.episodes import Episode, load_suite
from runtime.errors import RfNavError

FULL = "rfnav"
"""The method that is ours with everything."""


@dataclass(frozen=True)
class Folder:
    """What `hil-sim eval` left in one folder. `runs`: methods' results in the suite's order.
    `left_out`: what could not be driven; neither `episodes` nor `runs` have it."""

    path: Path
    run: dict[str, Any]
    episodes: tuple[Episode, ...]
    runs: dict[str, list[EpisodeResult]]
    times: list[dict[str, Any]]
    left_out: tuple[StartCheck, ...] = ()

    @property
    def name(self) -> str:
        return self.path.resolve().name


def read_folder(path: Path) -> Folder:
    """RfNavError when it is none that `hil-sim eval` has written."""
    if not (path / RUN_FILE).is_file() or not (path / SUITE_FILE).is_file():
        raise RfNavError(f"{path}: holds no results; name a folder that `hil-sim eval` has written")
    run = json.loads((path / RUN_FILE).read_text(encoding="utf-8"))
    left_out = (read_survey(path) or Survey()).left_out
    without = {verdict.episode for verdict in left_out}
    episodes = tuple(e for e in load_suite(path / SUITE_FILE) if e.id not in without)
    results = Results(path)
    found = {name: results.of(name, episodes) for name in METHODS}
    times = path / TIMES_FILE
    lines = times.read_text(encoding="utf-8").splitlines() if times.is_file() else []
    runs = {name: rows for name, rows in found.items() if rows}
    if not runs:
        raise RfNavError(f"{path}: no episode is finished; run `hil-sim eval` again to go on")
    return Folder(path, run, episodes, runs, [json.loads(line) for line in lines], left_out)
