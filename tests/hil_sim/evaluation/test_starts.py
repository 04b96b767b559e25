"""Starts that cannot be driven: told before, left out of the tables, kept."""

import importlib
import json
import os
import signal
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from places import DOUBLES, TESTS

from hil_sim.__main__ import cli
from hil_sim.driving.link import HarnessError
from hil_sim.evaluation.evaluate import Evaluation, claim, report, run
from hil_sim.evaluation.left_out import StartCheck, Undrivable, lines_of, read_survey
from hil_sim.evaluation.report import figures, section
from hil_sim.evaluation.result_folder import read_folder
from hil_sim.evaluation.results import Results
from hil_sim.evaluation.starts import survey
from hil_sim.evaluation.worker import Settings
from hil_sim.ground_truth.episodes import Episode, Start

FLAT = str(TESTS / "refs/flat.json")
EPISODES = tuple(
    Episode(f"e{i}", "maple" if i < 4 else "cedar", Start(0, 0, 0), "bed", 4.0) for i in range(8)
)
ODD = tuple(StartCheck(f"e{i}", Undrivable.INSIDE) for i in (1, 3, 5, 7))


@pytest.fixture
def worker(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A module that worker processes can import, too."""
    monkeypatch.syspath_prepend(str(DOUBLES))
    return importlib.import_module("fake_worker")


def evaluation(out: Path, *settings: str) -> Evaluation:
    return Evaluation("robothor-val", EPISODES, ("rfnav",), 2, Settings(out, settings=settings))


def test_what_cannot_be_driven_is_in_no_table_and_in_the_report(
    worker: Any, tmp_path: Path
) -> None:
    asked = evaluation(tmp_path)
    claim(asked)
    checked = survey(asked, worker.look)
    assert checked is not None
    assert checked.left_out == ODD
    results = Results(tmp_path)
    assert run(checked, results, worker.work)
    assert {episode for _, episode in results.by_key} == {"e0", "e2", "e4", "e6"}
    rows = report(checked, results, 0)
    assert rows["methods"]["rfnav"]["episodes"] == 4
    assert rows["left_out"][0] == {
        "episode": "e1", "cause": "INSIDE", "why": "start inside furniture or a wall",
    }  # fmt: skip
    folder = read_folder(tmp_path)
    assert [episode.id for episode in folder.episodes] == ["e0", "e2", "e4", "e6"]
    line = "4 episodes left out, start inside furniture or a wall: e1, e3, e5, e7"
    assert line in section(folder, 0, [])
    assert figures(folder, 0)["left_out"] == rows["left_out"]


def test_starts_are_looked_at_once_and_again_where_a_process_died(
    worker: Any, tmp_path: Path
) -> None:
    first = survey(evaluation(tmp_path, "crash"), worker.look)
    assert first is not None
    assert first.left_out == ODD[:2]
    kept = read_survey(tmp_path)
    assert kept is not None
    assert kept.unchecked == ("e5", "e6", "e7")
    second = survey(evaluation(tmp_path), worker.look)
    assert second is not None
    assert second.left_out == ODD
    # Nobody looks any more: this worker could not.
    assert survey(evaluation(tmp_path, "fail"), worker.look) == replace(
        evaluation(tmp_path, "fail"), left_out=ODD
    )


def test_homes_that_cannot_be_looked_at_are_a_line(worker: Any, tmp_path: Path) -> None:
    with pytest.raises(HarnessError, match=r"^furniture: none here; run `hil-sim assets pull`$"):
        survey(evaluation(tmp_path, "fail"), worker.look)
    assert read_survey(tmp_path) is None


def test_a_long_list_is_counted() -> None:
    left = [StartCheck(f"e{i}", Undrivable.OFF_FLOOR) for i in range(7)]
    left.append(StartCheck("lost", Undrivable.CUT_OFF))
    assert lines_of(left) == [
        "7 episodes left out, start off the free floor: too near an obstacle, or outside the home: "
        "e0, e1, e2, e3, e4 and 2 more",
        "1 episode left out, goal that no way leads to from the start: lost",
    ]
    assert lines_of([]) == []


@pytest.mark.slow
def test_official_episodes_are_driven_but_for_those_that_cannot_be(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    good = Episode("good", FLAT, Start(1.0, 0.8, 0.0), "toilet", 4.0)
    episodes = (
        good,
        replace(good, id="in-bed", start=Start(1.0, 2.85, 0.0)),
        replace(good, id="outdoors", start=Start(-3.0, 0.0, 0.0)),
        replace(good, id="no-sofa", goal="sofa"),
    )
    monkeypatch.setattr(
        "hil_sim.importers.robothor_episodes.official_episodes", lambda *given: episodes
    )
    out = tmp_path / "out"
    command = ["eval", "--episodes", "val", "--method", "oracle-goal", "--out", str(out)]
    told = [
        "1 episode left out, start inside furniture or a wall: in-bed",
        "1 episode left out, start off the free floor: too near an obstacle, or outside the home: "
        "outdoors",
        "1 episode left out, goal that is not in the home: no-sofa",
    ]
    for _ in range(2):  # the second time from what is kept
        done = CliRunner().invoke(cli, command)
        assert done.exit_code == 0, done.output
        assert "| oracle-goal | 1 | 100.0 [" in done.stdout
        assert all(line in done.stderr.splitlines() for line in told)
        assert all(line in done.stdout.splitlines() for line in told)
    causes = [row["cause"] for row in json.loads((out / "left_out.json").read_text())["left_out"]]
    assert causes == ["INSIDE", "OFF_FLOOR", "NO_GOAL"]
    assert len((out / "episodes.jsonl").read_text().splitlines()) == 1


def test_an_interrupted_look_leaves_nothing_half_known(worker: Any, tmp_path: Path) -> None:
    before = signal.getsignal(signal.SIGTERM)

    def end_politely() -> None:
        until_s = time.monotonic() + 60
        while signal.getsignal(signal.SIGTERM) is before and time.monotonic() < until_s:
            time.sleep(0.02)
        os.kill(os.getpid(), signal.SIGTERM)

    thread = threading.Thread(target=end_politely)
    thread.start()
    assert survey(evaluation(tmp_path, "hang"), worker.look) is None
    thread.join()
    assert signal.getsignal(signal.SIGTERM) is before
    assert read_survey(tmp_path) is None
