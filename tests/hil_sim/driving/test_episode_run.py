"""The lockstep with a real child process over real Zenoh; only the runtime's models are fake."""

import json
import math
import os
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from corridor import EPISODE, FAKE, SMALL, Corridor, start
from places import ROOT

from hil_sim.driving import link
from hil_sim.driving.episode_result import EpisodeResult
from hil_sim.driving.episode_run import run_episode
from hil_sim.driving.link import HarnessError, Runtime
from hil_sim.driving.methods import method_named
from hil_sim.driving.stage import Step
from hil_sim.ground_truth.episodes import Episode
from runtime.core.types import Action


@pytest.fixture(autouse=True)
def importable(monkeypatch: pytest.MonkeyPatch) -> None:
    root = str(ROOT)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([root, os.environ.get("PYTHONPATH", "")]))


@pytest.fixture
def walker(tmp_path: Path) -> Iterator[Runtime]:
    with start("walk", tmp_path / "runtime.log") as runtime:
        yield runtime


def drive(runtime: Runtime, log_dir: Path, episode: Episode = EPISODE) -> EpisodeResult:
    return run_episode(episode, Corridor().home(), runtime, SMALL, "rfnav", log_dir)


def test_an_episode_is_driven_judged_and_timed(walker: Runtime, tmp_path: Path) -> None:
    steps: list[Step] = []
    result = run_episode(
        EPISODE, Corridor().home(), walker, SMALL, "rfnav", tmp_path / "e1", steps.append
    )
    assert (str(result.ended), result.success, result.steps) == ("stop", True, 5)
    assert result.path_m == 1.0
    assert result.distance_m == 0.0
    assert result.spl == result.soft_spl == 1.0
    assert (result.decisions, result.collisions) == (1, 0)
    # At the last frame the wall is 2.6 m ahead; at the first the sensor read 3.6 m.
    assert result.reason == "red 200, nearest 2.60 m"
    assert steps[0].answer.state["reason"] == "red 200, nearest 3.60 m"
    assert [step.answer.action for step in steps] == [Action.MOVE_FORWARD] * 4 + [Action.STOP]
    assert set(result.wall) == {"render", "bus", "runtime.plan", "total"}
    assert result.wall["runtime.plan"] == 0.005
    assert json.loads((tmp_path / "e1" / "episode.json").read_text())["scene"] == "corridor"
    assert EpisodeResult.from_json(json.loads(json.dumps(result.to_json()))) == result


def test_what_the_truth_says_of_it(walker: Runtime, tmp_path: Path) -> None:
    result = drive(walker, tmp_path / "e1")
    assert (result.seen_at, result.seen_steps) == (3, 3)
    assert (result.believed_at, result.claim, result.stands) == (4, "true", ("toilet",))
    assert result.frontier_m == (0.75,)  # the frontier is at y = 3.25, success at y = 4
    assert result.actions == {"frontier": 3, "stop": 1, "target": 1}
    assert result.purposes == {"approaching": 1, "exploring": 4}
    assert (result.stopped, result.fault) == (True, "")
    track = [json.loads(line) for line in (tmp_path / "e1/track.jsonl").read_text().splitlines()]
    assert [row["y"] for row in track] == [3.25, 3.5, 3.75, 4.0, 4.0]
    assert track[0] == {
        "x": 2.0, "y": 3.25, "yaw": round(math.pi / 2, 4), "mode": "frontier",
        "action": "move_forward", "collided": False,
    }  # fmt: skip


def test_the_method_goes_along_with_the_goal(walker: Runtime, tmp_path: Path) -> None:
    result = run_episode(
        EPISODE, Corridor().home(), walker, SMALL, "oracle-perception/closest", tmp_path / "e"
    )
    assert result.method == "oracle-perception/closest"
    asked = json.loads((tmp_path / "e" / "asked.json").read_text())
    assert asked["settings"] == [*SMALL.settings, *method_named(result.method).settings]
    lines = (tmp_path / "e" / "labels.jsonl").read_text().splitlines()
    labels = [json.loads(line) for line in lines]
    assert [label["names"] for label in labels] == [[], [], ["toilet"], ["toilet"], ["toilet"]]
    assert labels[2]["boxes"] == [[20, 10, 40, 22]]
    assert {label["room"] for label in labels} == {"hallway"}


def test_of_the_truth_boxes_and_names_alone_may_go_along(walker: Runtime, tmp_path: Path) -> None:
    run_episode(EPISODE, Corridor().home(), walker, SMALL, "labels/closest", tmp_path / "e")
    lines = (tmp_path / "e" / "labels.jsonl").read_text().splitlines()
    labels = [json.loads(line) for line in lines]
    assert [label["names"] for label in labels] == [[], [], ["toilet"], ["toilet"], ["toilet"]]
    assert labels[2]["boxes"] == [[20, 10, 40, 22]]
    assert {tuple(sorted(label)) for label in labels} == {
        ("boxes", "names", "room", "scores", "stamp_ns")
    }
    assert {label["room"] for label in labels} == {None}


def test_a_method_whose_votes_nobody_casts_is_refused(walker: Runtime, tmp_path: Path) -> None:
    with pytest.raises(HarnessError, match="spoilt-sle: votes are cast by `hil-sim eval` alone"):
        run_episode(EPISODE, Corridor().home(), walker, SMALL, "spoilt-sle", tmp_path / "e")


def test_one_child_serves_many_episodes(walker: Runtime, tmp_path: Path) -> None:
    results = [drive(walker, tmp_path / str(i)) for i in range(3)]
    assert [replace(result, wall={}) for result in results] == [replace(results[0], wall={})] * 3


def test_running_out_of_steps_is_a_failure_with_progress(tmp_path: Path) -> None:
    with start("turn", tmp_path / "log") as runtime:
        result = drive(runtime, tmp_path / "e")
    assert (str(result.ended), result.success, result.steps) == ("steps", False, SMALL.max_steps)
    assert (result.spl, result.soft_spl) == (0.0, 0.0)


def test_a_refused_goal_is_an_error_with_the_runtimes_own_words(
    walker: Runtime, tmp_path: Path
) -> None:
    with pytest.raises(HarnessError, match=r"^goal: nothing: unknown$"):
        drive(walker, tmp_path / "e", replace(EPISODE, goal="nothing"))


@pytest.mark.slow
def test_a_runtime_that_does_not_answer_fails_the_episode(tmp_path: Path) -> None:
    with start("mute", tmp_path / "log", answer_s=0.6) as runtime:
        result = drive(runtime, tmp_path / "e")
    assert str(result.ended) == "error: no answer to an observation in 0.6 s"
    assert not result.success
    assert result.steps == 0


def test_a_runtime_that_dies_fails_the_episode_with_its_last_words(tmp_path: Path) -> None:
    with start("die", tmp_path / "log") as runtime:
        result = drive(runtime, tmp_path / "e")
        assert str(result.ended) == "error: rfnav: camera: fell off"
        assert result.steps == 1
        with pytest.raises(HarnessError):
            runtime.check_alive()


def test_a_runtime_that_cannot_start_is_reported_at_once(tmp_path: Path) -> None:
    began_s = time.monotonic()
    with (
        pytest.raises(HarnessError, match=r"^rfnav: models.language: nosuch: unknown$"),
        start("broken", tmp_path / "log"),
    ):
        pass
    assert time.monotonic() - began_s < 20


def test_closing_ends_the_child(tmp_path: Path) -> None:
    runtime = start("walk", tmp_path / "log")
    child = runtime._child
    assert child is not None
    runtime.close()
    runtime.close()
    assert child.poll() is not None
    with pytest.raises(HarnessError, match="has been closed"):
        runtime.check_alive()


@pytest.mark.skipif(sys.platform != "linux", reason="prctl")
def test_a_harness_that_is_killed_takes_its_child_along(tmp_path: Path) -> None:
    import subprocess

    code = (
        "import sys, time; from pathlib import Path; from hil_sim.driving.link import Runtime\n"
        f"r = Runtime(Path({str(tmp_path / 'log')!r}), command=[sys.executable, {str(FAKE)!r}, 'walk']).__enter__()\n"  # noqa: E501
        "print(r._child.pid, flush=True); time.sleep(60)"
    )
    harness = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert harness.stdout is not None
    child = int(harness.stdout.readline())
    harness.kill()
    harness.wait()
    harness.stdout.close()
    until_s = time.monotonic() + 10
    while _alive(child):
        assert time.monotonic() < until_s, "the child outlives the harness"
        time.sleep(0.02)


def _alive(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except OSError:
        return False
    return state != "Z"


def test_the_bus_is_the_harnesss_to_place() -> None:
    settings = link._bus_settings("tcp/127.0.0.1:5")
    assert 'bus.connect=["tcp/127.0.0.1:5"]' in settings
    assert 'bus.topics.color="camera/color/image_raw"' in settings


@pytest.mark.slow
def test_an_observation_that_got_lost_is_sent_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(link, "RESEND_S", 0.3)
    with start("walk", tmp_path / "log") as runtime:
        lossy = _Lossy(runtime._publish["depth"])
        runtime._publish["depth"] = lossy
        result = drive(runtime, tmp_path / "e")
    assert (str(result.ended), result.steps) == ("stop", 5)
    assert lossy.lost == 2


class _Lossy:
    """A publisher that loses the first and the fourth message."""

    def __init__(self, publisher: Any) -> None:
        self._publisher = publisher
        self.sent = self.lost = 0

    def put(self, payload: bytes, attachment: bytes | None) -> None:
        self.sent += 1
        if self.sent in (1, 4):
            self.lost += 1
        else:
            self._publisher.put(payload, attachment=attachment)
