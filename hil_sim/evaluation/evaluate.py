"""Episodes of a suite with every method, in worker processes, resumable. `command` asks."""

import hashlib
import json
import signal
import sys
import time
import tomllib
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import asdict, dataclass
from importlib.resources import files
from typing import Any

from tqdm import tqdm

from hil_sim.driving.episode_result import EpisodeResult
from hil_sim.driving.link import HarnessError
from hil_sim.driving.methods import method_named, needed_models
from hil_sim.evaluation.left_out import StartCheck, rows_of
from hil_sim.evaluation.pool import Work, local
from hil_sim.evaluation.results import RUN_FILE, SUITE_FILE, Results, errors, falls, run_of
from hil_sim.evaluation.summary import Summary, summarise
from hil_sim.evaluation.worker import (
    Drive,
    Failure,
    Job,
    Message,
    Note,
    Settings,
    Task,
    drive,
    protocol_for,
    refused,
    work,
)
from hil_sim.ground_truth.episodes import Episode, save_suite
from runtime.former_keys import modern
from runtime.journal import plain

MANIFEST = files("models") / "manifest.toml"
"""Checksums of all models' files: other weights are another configuration."""


@dataclass(frozen=True)
class Evaluation:
    """What is measured: the first `limit` episodes of a suite (0: all). `ray`: a cluster's
    address; "" for processes of this machine. `left_out`: what `starts.survey` found that cannot
    be driven."""

    suite: str
    all_episodes: tuple[Episode, ...]
    methods: tuple[str, ...]
    workers: int
    settings: Settings
    ray: str = ""
    limit: int = 0
    left_out: tuple[StartCheck, ...] = ()

    @property
    def episodes(self) -> tuple[Episode, ...]:
        """Those to drive."""
        without = {verdict.episode for verdict in self.left_out}
        return tuple(e for e in self.all_episodes[: self.limit or None] if e.id not in without)


def run(evaluation: Evaluation, results: Results, target: Work = work) -> bool:
    """Drive what is not finished; True unless interrupted. What a worker leaves undriven becomes
    results that ended in an error. HarnessError, at once, when a worker cannot go on and nothing
    has ever been finished: it would be so for all."""
    began_s = time.monotonic()
    jobs = plan(evaluation, results)
    total = len(evaluation.methods) * len(evaluation.episodes)
    todo = sum(job.size for job in jobs)
    begun = any(not r.ended.failed for r in results.by_key.values())
    failures: list[Failure] = []
    done = 0
    with (
        sigterm_as_interrupt(),
        tqdm(total=total, initial=total - todo, unit="episode", disable=None) as bar,
        workers(evaluation, jobs, target) as messages,
    ):
        try:
            for message in messages:
                done += isinstance(message, EpisodeResult)
                _take(message, results, bar)
                if isinstance(message, Failure):
                    failures.append(message)
                    if message.fatal and not (message.died or begun or done):
                        raise HarnessError(message.text)
        except KeyboardInterrupt:
            return False
        finally:
            if done:
                results.timed(done, time.monotonic() - began_s, evaluation.workers)
    _count_undriven(evaluation.settings, jobs, failures, results)
    results.settle(evaluation.all_episodes)
    return True


def _count_undriven(
    settings: Settings, jobs: Sequence[Job], failures: Sequence[Failure], results: Results
) -> None:
    """An error in the results for everything planned that no worker has sent a result of."""
    told = {failure.episode or failure.scene: failure.text for failure in failures}
    planned = [
        (task.episode, method) for job in jobs for task in job.tasks for method in task.methods
    ]
    for episode, method in planned:
        if (method, episode.id) not in results.by_key:
            why = told.get(episode.id) or told.get(episode.scene) or "its worker has ended"
            protocol = protocol_for(settings, method_named(method))
            away_m = episode.shortest_path_m  # it never moved
            results.add(refused(episode, protocol, method, why, away_m))


@contextmanager
def sigterm_as_interrupt() -> Iterator[None]:
    """A polite `kill` is Ctrl-C: workers and their runtimes are ended, what is finished is kept."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def plan(evaluation: Evaluation, results: Results) -> list[Job]:
    """Unfinished episodes by scene, in the suite's order; split further when workers would
    idle."""
    scenes: dict[str, list[Task]] = {}
    for episode in evaluation.episodes:
        left = tuple(m for m in evaluation.methods if not results.finished(m, episode))
        if left:
            scenes.setdefault(episode.scene, []).append(Task(episode, left))
    parts = -(-evaluation.workers // max(1, len(scenes)))
    return [
        Job(scene, tuple(tasks[part::parts]))
        for scene, tasks in scenes.items()
        for part in range(min(parts, len(tasks)))
    ]


def workers(
    evaluation: Evaluation, jobs: list[Job], target: Work, far: Drive = drive
) -> AbstractContextManager[Iterator[Message]]:
    """Messages of the jobs as they come, from processes of this machine (`target`) or of a Ray
    cluster (`far`)."""
    if evaluation.ray:
        from hil_sim.evaluation.cluster import remote  # Ray is an extra

        return remote(jobs, evaluation.settings, evaluation.ray, far)
    return local(jobs, evaluation.settings, evaluation.workers, target)


def _take(message: Message, results: Results, bar: Any) -> None:
    if isinstance(message, StartCheck):
        return
    if isinstance(message, Note | Failure):
        _say(bar, message.text)
        return
    results.add(message)
    bar.update()
    outcome = "success" if message.success else "failure"
    _say(
        bar,
        f"{message.method} {message.episode}: {outcome} ({message.ended}), {message.steps} steps, "
        f"{message.path_m:.1f} m of {message.shortest_path_m:.1f} m, "
        f"{message.wall.get('total', 0.0):.0f} s",
    )


def _say(bar: Any, text: str) -> None:
    bar.write(text, file=sys.stderr)


def report(evaluation: Evaluation, results: Results, seed: int) -> dict[str, Any]:
    """The table's figures and every episode; wall times under "wall" and nowhere else."""
    rows: list[dict[str, Any]] = []
    walls: dict[str, Any] = {}
    for method in evaluation.methods:
        for result in results.of(method, evaluation.episodes):
            row = result.to_json()
            walls.setdefault(method, {})[result.episode] = row.pop("wall")
            rows.append(row)
    methods: dict[str, dict[str, Any]] = {}
    for name, summary in summaries(evaluation, results, seed):
        done = results.of(name, evaluation.episodes)
        methods[name] = {**plain(summary), "errors": errors(done), "falls": falls(done)}
    left_out = {"left_out": rows_of(evaluation.left_out)} if evaluation.left_out else {}
    return {
        "suite": evaluation.suite,
        "protocol": evaluation.settings.protocol,
        "faults": list(evaluation.settings.faults),
        "noise": list(evaluation.settings.noise),
        "seed": seed,
        **left_out,
        "methods": methods,
        "episodes": rows,
        "wall": walls,
    }


def summaries(evaluation: Evaluation, results: Results, seed: int) -> list[tuple[str, Summary]]:
    """Each method's figures over its episodes so far."""
    return [
        (name, summarise([r.outcome for r in results.of(name, evaluation.episodes)], seed))
        for name in evaluation.methods
    ]


def claim(evaluation: Evaluation) -> None:
    """OUT belongs to one suite and one configuration; HarnessError when it holds another's."""
    settings = evaluation.settings
    config = settings.config.read_text(encoding="utf-8") if settings.config else ""
    mine = {
        "suite": evaluation.suite,
        "episodes": _digest(json.dumps([asdict(e) for e in evaluation.all_episodes])),
        "protocol": settings.protocol,
        "config": _digest(config),
        "settings": [modern(setting) for setting in settings.settings],
        "faults": list(settings.faults),
        "noise": list(settings.noise),
        "sensors": list(settings.sensors),
        "tilt": settings.tilt,
        "seed": settings.seed,
        "realtime": settings.realtime,
        "models": _digest(json.dumps(tomllib.loads(MANIFEST.read_text(encoding="utf-8")))),
    }
    imported = {f"model {m}": d for m, d in needed_models(evaluation.methods).items()}
    path = settings.out / RUN_FILE
    try:
        settings.out.mkdir(parents=True, exist_ok=True)
        other = run_of(settings.out)
        former = {key: value for key, value in other.items() if key.startswith("model ")}
        different = [key for key, value in mine.items() if other and other.get(key) != value]
        different += [key for key, value in imported.items() if former.get(key, value) != value]
        if different:
            raise HarnessError(
                f"{settings.out}: holds results of another {different[0]}; choose another --out"
            )
        whole = mine | former | imported  # methods may be added that look with other models
        path.write_text(json.dumps(whole, indent=1) + "\n", encoding="utf-8")
        save_suite(evaluation.all_episodes, settings.out / SUITE_FILE)
    except OSError as error:
        raise HarnessError(f"{settings.out}: cannot be written ({error.strerror})") from error


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]
