"""Evaluations: nothing finished is lost, and the figures repeat byte for byte."""

import importlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from places import DOUBLES, ROOT, TESTS

from hil_sim.__main__ import cli, main
from hil_sim.driving.link import HarnessError
from hil_sim.evaluation.evaluate import Evaluation, claim, plan, report, run, summaries
from hil_sim.evaluation.results import Results, sole, stages
from hil_sim.evaluation.summary import table
from hil_sim.evaluation.worker import Settings
from hil_sim.ground_truth.episodes import Episode, Start, load_suite

FLAT = TESTS / "refs/flat.json"

EPISODES = tuple(
    Episode(f"e{i}", "maple" if i < 4 else "cedar", Start(0, 0, 0), "bed", 4.0) for i in range(8)
)


@pytest.fixture
def worker(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A module that worker processes can import, too."""
    monkeypatch.syspath_prepend(str(DOUBLES))
    return importlib.import_module("fake_worker")


def evaluation(out: Path, *settings: str, methods: tuple[str, ...] = ("rfnav",)) -> Evaluation:
    return Evaluation("smoke", EPISODES, methods, 2, Settings(out, settings=settings))


def filled(worker: Any, out: Path, ended: str = "stop") -> Results:
    """Results without processes."""
    results = Results(out)
    for episode in EPISODES:
        results.add(worker.result_of("rfnav", episode, ended))
    return results


def test_every_episode_is_driven_once_and_kept(worker: Any, tmp_path: Path) -> None:
    asked = evaluation(tmp_path, methods=("rfnav", "closest"))
    results = Results(tmp_path)
    assert run(asked, results, worker.work)
    kept = Results(tmp_path)
    assert kept.by_key == results.by_key
    assert len(kept.by_key) == 16
    assert [r.episode for r in kept.of("closest", EPISODES)] == [e.id for e in EPISODES]
    assert plan(asked, kept) == []


def test_figures_repeat_byte_for_byte_and_wall_times_stay_apart(
    worker: Any, tmp_path: Path
) -> None:
    texts = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        asked, results = evaluation(tmp_path / name), filled(worker, tmp_path / name)
        figures = report(asked, results, seed=1)
        walls = figures.pop("wall")
        assert walls["rfnav"]["e0"]["render"] == 1.0
        texts.append(json.dumps(figures))
    assert texts[0] == texts[1]
    assert json.loads(texts[0])["methods"]["rfnav"]["success"]["mean"] == 0.5
    assert "| rfnav | 8 | 50.0 [" in table(summaries(asked, results, 1))
    assert "render 1.0, map 0.5" in stages(results.of("rfnav", EPISODES))


def test_a_crashed_worker_is_an_error_and_what_was_finished_is_kept(
    worker: Any, tmp_path: Path
) -> None:
    asked, results = evaluation(tmp_path, "crash"), Results(tmp_path)
    assert run(asked, results, worker.work)
    kept = Results(tmp_path)
    ends = {episode: str(result.ended) for (_, episode), result in kept.by_key.items()}
    assert {id for id, end in ends.items() if end == "stop"} == {"e0", "e4"}
    assert ends["e1"] == "error: the worker for maple ended with status 3; run again to go on"
    assert ends["e7"] == "error: the worker for cedar ended with status 3; run again to go on"
    assert report(asked, results, 0)["methods"]["rfnav"]["errors"] == 6
    assert "| rfnav | 8 | 25.0 [" in table(summaries(asked, results, 1))
    assert sum(job.size for job in plan(evaluation(tmp_path), kept)) == 6
    assert run(evaluation(tmp_path), results, worker.work)
    assert report(asked, results, 0)["methods"]["rfnav"]["errors"] == 0


def test_a_workers_own_failure_is_what_its_episodes_ended_in(worker: Any, tmp_path: Path) -> None:
    assert run(evaluation(tmp_path, "fail"), Results(tmp_path), worker.work)
    ends = [str(r.ended) for r in Results(tmp_path).of("rfnav", EPISODES)]
    assert ends.count("stop") == 2
    assert ends.count("error: furniture: none here; run `hil-sim assets pull`") == 6


def test_a_failure_before_anything_is_finished_is_a_line(worker: Any, tmp_path: Path) -> None:
    with pytest.raises(HarnessError, match=r"^furniture: none here; run `hil-sim assets pull`$"):
        run(evaluation(tmp_path, "fail at once"), Results(tmp_path), worker.work)
    assert Results(tmp_path).by_key == {}


@pytest.fixture
def interruptible() -> Iterator[None]:
    """A shell that starts tests in the background has Ctrl-C ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_and_kill_leave_finished_work(worker: Any, tmp_path: Path, how: int) -> None:
    def interrupt() -> None:
        until_s = time.monotonic() + 90
        while time.monotonic() < until_s:
            if (tmp_path / "episodes.jsonl").is_file() and len(Results(tmp_path).by_key) >= 2:
                break
            time.sleep(0.02)
        os.kill(os.getpid(), how)

    thread = threading.Thread(target=interrupt)
    thread.start()
    complete = run(evaluation(tmp_path, "hang"), Results(tmp_path), worker.work)
    thread.join()
    assert not complete
    assert set(Results(tmp_path).by_key) == {("rfnav", "e0"), ("rfnav", "e4")}


def test_episodes_that_ended_in_an_error_are_tried_again(worker: Any, tmp_path: Path) -> None:
    results = filled(worker, tmp_path, "error: late")
    assert report(evaluation(tmp_path), results, 0)["methods"]["rfnav"]["errors"] == 8
    assert sum(job.size for job in plan(evaluation(tmp_path), results)) == 8
    results = filled(worker, tmp_path)
    assert report(evaluation(tmp_path), results, 0)["methods"]["rfnav"]["errors"] == 0
    assert plan(evaluation(tmp_path), Results(tmp_path)) == []


def test_a_torn_last_line_is_cut_off(worker: Any, tmp_path: Path) -> None:
    results = filled(worker, tmp_path)
    path = tmp_path / "episodes.jsonl"
    whole = path.read_text()
    path.write_text(whole + '{"episode": "e9", "me')
    assert Results(tmp_path).by_key == results.by_key
    assert path.read_text() != whole  # a reader leaves what another may be writing
    assert Results(tmp_path, mend=True).by_key == results.by_key
    assert path.read_text() == whole


def test_an_output_folder_has_one_writer(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with sole(out), pytest.raises(HarnessError, match="out: in use by another"), sole(out):
        pass
    with sole(out):
        pass
    (tmp_path / "file").touch()
    with pytest.raises(HarnessError, match="cannot be written"), sole(tmp_path / "file" / "x"):
        pass


WORKER = """
import multiprocessing, os, sys, time
from hil_sim.driving.child import end_with_parent

def work():
    end_with_parent()
    print(os.getpid(), flush=True)
    time.sleep(60)

if __name__ == "__main__":
    multiprocessing.get_context("spawn").Process(target=work).start()
    time.sleep(60)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux")
def test_a_worker_does_not_outlive_its_parent(tmp_path: Path) -> None:
    (tmp_path / "parent.py").write_text(WORKER)
    with subprocess.Popen(
        [sys.executable, str(tmp_path / "parent.py")], stdout=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    ) as parent:  # fmt: skip
        assert parent.stdout is not None
        child = int(parent.stdout.readline())
        parent.kill()
    until_s = time.monotonic() + 30
    while Path(f"/proc/{child}/cmdline").is_file() and time.monotonic() < until_s:
        if not Path(f"/proc/{child}/cmdline").read_text():  # ended, and not yet reaped
            break
        time.sleep(0.05)
    assert time.monotonic() < until_s


def test_jobs_are_of_one_scene_and_fill_the_workers(worker: Any, tmp_path: Path) -> None:
    asked = evaluation(tmp_path, methods=("rfnav", "closest"))
    results = Results(tmp_path)
    jobs = plan(asked, results)
    assert [(job.scene, len(job.tasks), job.size) for job in jobs] == [
        ("maple", 4, 8),
        ("cedar", 4, 8),
    ]
    assert jobs[0].tasks[0].methods == ("rfnav", "closest")
    alone = replace(asked, limit=3)
    assert [[t.episode.id for t in job.tasks] for job in plan(alone, results)] == [
        ["e0", "e2"],
        ["e1"],
    ]
    results.add(worker.result_of("rfnav", EPISODES[1]))
    assert plan(alone, results)[1].tasks[0].methods == ("closest",)


@pytest.mark.slow
def test_two_runs_leave_the_same_file_whoever_was_first(worker: Any, tmp_path: Path) -> None:
    texts = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        asked = evaluation(tmp_path / name, "shuffle", methods=("closest", "rfnav"))
        assert run(asked, Results(tmp_path / name), worker.work)
        lines = (tmp_path / name / "episodes.jsonl").read_text().splitlines()
        rows = [json.loads(line) for line in lines]
        texts.append(json.dumps([row | {"wall": {}} for row in rows]))
    assert texts[0] == texts[1]
    assert [row["method"] for row in json.loads(texts[0])[:2]] == ["rfnav", "closest"]


def test_an_output_folder_belongs_to_one_configuration(tmp_path: Path) -> None:
    claim(evaluation(tmp_path / "out"))
    claim(evaluation(tmp_path / "out", methods=("closest",)))
    with pytest.raises(HarnessError, match="holds results of another settings; choose another"):
        claim(evaluation(tmp_path / "out", "models.threads=4"))
    (tmp_path / "file").touch()
    with pytest.raises(HarnessError, match="cannot be written"):
        claim(evaluation(tmp_path / "file" / "x"))


def test_an_output_folder_belongs_to_one_file_of_a_model(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    listed = tmp_path / "rf-nav" / "models.toml"
    listed.parent.mkdir()

    def here(digest: str) -> None:
        listed.write_text(f"[clip]\ncontract = 'clip'\n[[clip.files]]\nsha256 = '{digest}'\n")

    here("abc")
    for methods in (("rfnav",), ("rfnav", "cow-clip-patch"), ("closest",)):  # in the same folder
        claim(evaluation(tmp_path / "out", methods=methods))
    here("def")
    claim(evaluation(tmp_path / "out"))
    with pytest.raises(HarnessError, match="holds results of another model clip; choose another"):
        claim(evaluation(tmp_path / "out", methods=("cow-clip-ref",)))


@pytest.mark.parametrize("command", [[], ["eval"], ["demo"], ["report"], ["episodes"], ["show"]])
def test_help_has_an_example(command: list[str]) -> None:
    done = CliRunner().invoke(cli, [*command, "--help"])
    assert done.exit_code == 0
    assert "Example" in done.output


@pytest.mark.parametrize(
    ("arguments", "wanted"),
    [
        (["demo", "--goal", "  "], "hil-sim: goal: is empty; say what to find"),
        (["demo", "--goal", "bed", "--scene", "igloo"], "hil-sim: scene igloo: unknown; known:"),
        (["demo", "--goal", "zebra"], "hil-sim: maple: goal 'zebra': no such object here"),
        (["demo", "--goal", "bed", "--method", "luck"], "hil-sim: method luck: unknown; known:"),
        (["eval", "--method", "luck"], "hil-sim: method luck: unknown; known: rfnav, sets"),
        (
            ["eval", "--method", "cow-mdetr"],
            "hil-sim: method cow-mdetr: model mdetr is not here; `rf",
        ),
        (
            ["demo", "--goal", "bed", "--method", "cow-clip-ref"],
            "hil-sim: method cow-clip-ref: model clip is not here; `rfnav models import image.onnx",
        ),
        (["eval", "--suite", "huge"], "hil-sim: suite huge: unknown; known:"),
        (["eval", "--protocol", "hm4d"], "hil-sim: protocol hm4d: unknown; known: hm3d"),
        (["eval", "--fault", "earthquake"], "hil-sim: fault earthquake: unknown; known:"),
        (["eval", "--noise", "hum=3"], "hil-sim: noise hum"),
        (["eval", "--tilt", "episode"], "hil-sim: tilt episode: protocol hm3d's camera is level"),
        (["eval", "--episodes", "nowhere"], "hil-sim: nowhere: no such folder of official"),
        (["eval", "--method", "oracle-goal", "--realtime"], "hil-sim: oracle-goal: takes steps"),
        (["report", "nowhere", "--out", "r.md"], "hil-sim: nowhere: holds no results; name a"),
        (["show", "igloo", "--out", "x"], "hil-sim: scene igloo: unknown; known:"),
        (["episodes", "--make", "huge", "--out", "x.json"], "hil-sim: suite huge: no recipe;"),
        (["eval", "--config", "no.toml"], "hil-sim: no.toml: no such configuration file"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(
    arguments: list[str],
    wanted: str,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    monkeypatch.setattr("sys.argv", ["hil-sim", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    said = capfd.readouterr().err.strip()
    assert ended.value.code == 2
    assert said.startswith(wanted)
    assert "\n" not in said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_goals_that_a_scene_lacks_are_passed_over_where_asked(tmp_path: Path) -> None:
    out = tmp_path / "suite.json"
    command = ["episodes", str(FLAT), "--goal", "sofa", "--goal", "toilet", "--starts", "1"]
    refused = CliRunner().invoke(cli, [*command, "--out", str(out)])
    assert "goal 'sofa': no such object here" in str(refused.exception)
    assert not out.exists()
    done = CliRunner().invoke(cli, [*command, "--skip-missing", "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert [episode.goal for episode in load_suite(out)] == ["toilet"]
    only = ["episodes", str(FLAT), "--goal", "sofa", "--skip-missing", "--out", str(out)]
    assert "none of these goals can be met" in str(CliRunner().invoke(cli, only).exception)


def test_missing_furniture_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr("hil_sim.commands.demo.keep_stdout_for_python", lambda: None)
    monkeypatch.setattr(
        "sys.argv", ["hil-sim", "demo", "--goal", "bed", "--out", str(tmp_path / "o")]
    )
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    assert "no furniture here; run `hil-sim assets pull`" in capfd.readouterr().err
