"""A worker in a real home, driven by the shortest path: no models, real frames."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from hil_sim.driving.episode_result import EpisodeResult
from hil_sim.driving.link import HarnessError
from hil_sim.driving.methods import method_named
from hil_sim.evaluation import worker
from hil_sim.evaluation.worker import Failure, Job, Message, Settings, Task, drive, protocol_for
from hil_sim.ground_truth.episodes import Episode, load_suite

MAPLE = tuple(e for e in load_suite("smoke") if e.scene == "maple")


def driven(episodes: tuple[Episode, ...], out: Path, protocol: str = "hm3d") -> list[Message]:
    said: list[Message] = []
    tasks = tuple(Task(episode, ("oracle-goal",)) for episode in episodes)
    drive(Job("maple", tasks), Settings(out, protocol, renderer="auto"), said.append)
    return said


@pytest.mark.slow
@pytest.mark.parametrize("protocol", ["hm3d", "robothor"])
def test_the_shortest_path_always_succeeds(protocol: str, tmp_path: Path) -> None:
    results = [m for m in driven(MAPLE, tmp_path, protocol) if isinstance(m, EpisodeResult)]
    assert len(results) == len(MAPLE)
    assert [r.episode for r in results if not r.success] == []
    if protocol == "hm3d":  # without noise
        assert all(r.collisions == 0 for r in results)
        spls = [r.spl for r in results if r.spl is not None]  # None: too short a way
        assert spls
        assert min(spls) > 0.8
    assert all(r.wall["rendered"] + r.wall["recalled"] == 1 for r in results)
    track = tmp_path / "oracle-goal" / MAPLE[0].id / "track.jsonl"
    assert len(track.read_text().splitlines()) == results[0].steps


@pytest.mark.slow
def test_an_episode_that_cannot_begin_is_told_and_the_others_go_on(tmp_path: Path) -> None:
    wall = replace(MAPLE[0], id="wall", start=replace(MAPLE[0].start, x_m=0.0, y_m=0.0))
    missing = replace(MAPLE[1], id="missing", goal="bathtub mat")
    said = driven((wall, missing, MAPLE[2]), tmp_path)
    failures = [m for m in said if isinstance(m, Failure)]
    assert [(f.fatal, f.episode) for f in failures] == [(False, "wall"), (False, "missing")]
    assert failures[0].text.startswith("wall: start (0, 0): inside furniture, a wall or outside")
    assert "goal 'bathtub mat': no such object here" in failures[1].text
    assert [m.episode for m in said if isinstance(m, EpisodeResult)] == [MAPLE[2].id]


@pytest.mark.slow
def test_an_episode_that_raises_costs_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    whole = worker.run_episode

    def run_episode(episode: Episode, *given: Any, **more: Any) -> EpisodeResult:
        if episode.id == MAPLE[0].id:
            raise ValueError("a shape\nof another size")
        return whole(episode, *given, **more)

    monkeypatch.setattr(worker, "run_episode", run_episode)
    said = driven(MAPLE[:2], tmp_path)
    (failure,) = (m for m in said if isinstance(m, Failure))
    wanted = f"{MAPLE[0].id}: ValueError: a shape of another size"
    assert (failure.text, failure.episode, failure.fatal) == (wanted, MAPLE[0].id, False)
    assert "Traceback" in capfd.readouterr().err
    assert [m.episode for m in said if isinstance(m, EpisodeResult)] == [MAPLE[1].id]


def test_methods_with_true_labels_get_small_frames(tmp_path: Path) -> None:
    settings = Settings(tmp_path)
    small = protocol_for(settings, method_named("oracle-perception/o2f"))
    full = protocol_for(settings, method_named("o2f"))
    assert (small.width, full.width) == (320, 640)
    assert protocol_for(settings, method_named("labels/o2f")) == full  # its views are looked at
    assert small.intrinsics.fx == pytest.approx(full.intrinsics.fx / 2)
    with pytest.raises(HarnessError, match="votes of the harness's are for lockstep"):
        protocol_for(replace(settings, realtime=True), method_named("labels/all-known"))
    with pytest.raises(HarnessError, match="oracle-goal: takes steps and turns; choose hm3d"):
        protocol_for(replace(settings, protocol="onrobot"), method_named("oracle-goal"))
