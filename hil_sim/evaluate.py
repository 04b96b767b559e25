"""`hil-sim eval`: episodes of a suite, in worker processes, resumable, as one table."""

import hashlib
import json
import multiprocessing
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from multiprocessing import connection
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import Any

import click
from tqdm import tqdm

from hil_sim.episodes import Episode, load_suite
from hil_sim.link import METHODS, HarnessError, method_settings
from hil_sim.metrics import Summary, summarise, table
from hil_sim.protocol import protocol_named
from hil_sim.results import Results, errors, stages
from hil_sim.worker import Failure, Job, Message, Note, Settings, work
from runtime.edge.journal import plain
from runtime.errors import RfNavError

RUN_FILE = "run.json"
Work = Callable[[Job, Settings, connection.Connection], None]


@dataclass(frozen=True)
class Evaluation:
    """What is measured."""

    suite: str
    episodes: tuple[Episode, ...]
    methods: tuple[str, ...]
    workers: int
    settings: Settings


def run(evaluation: Evaluation, results: Results, target: Work = work) -> bool:
    """Drive what is not finished; True unless interrupted. A worker's failure is raised after
    the others' finished episodes have been kept."""
    jobs = plan(evaluation, results)
    total = len(evaluation.methods) * len(evaluation.episodes)
    todo = sum(len(job.episodes) for job in jobs)
    with (
        tqdm(total=total, initial=total - todo, unit="episode", disable=None) as bar,
        _pool(evaluation, jobs, target) as messages,
    ):
        try:
            for message in messages:
                _take(message, results, bar)
        except KeyboardInterrupt:
            return False
    return True


def plan(evaluation: Evaluation, results: Results) -> list[Job]:
    """Unfinished episodes by method and scene; split further when workers would idle."""
    groups: dict[tuple[str, str], list[Episode]] = {}
    for method in evaluation.methods:
        for episode in evaluation.episodes:
            if not results.finished(method, episode):
                groups.setdefault((method, episode.scene), []).append(episode)
    parts = -(-evaluation.workers // max(1, len(groups)))
    return [
        Job(method, scene, tuple(episodes[part::parts]))
        for (method, scene), episodes in groups.items()
        for part in range(min(parts, len(episodes)))
    ]


@contextmanager
def _pool(evaluation: Evaluation, jobs: list[Job], target: Work) -> Iterator[Iterator[Message]]:
    """Messages of at most `workers` processes; all have ended when the block is left."""
    spawn = multiprocessing.get_context("spawn")
    running: dict[connection.Connection, tuple[SpawnProcess, Job]] = {}
    waiting = list(jobs)

    def start(job: Job) -> None:
        ours, theirs = spawn.Pipe(duplex=False)
        process = spawn.Process(target=target, args=(job, evaluation.settings, theirs))
        # Ctrl-C reaches every process of the terminal; children inherit the block, so that only
        # the parent acts on it.
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            process.start()
        finally:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        theirs.close()
        running[ours] = (process, job)

    def messages() -> Iterator[Message]:
        while waiting or running:
            while waiting and len(running) < evaluation.workers:
                start(waiting.pop(0))
            for ready in connection.wait(list(running)):
                assert isinstance(ready, connection.Connection)
                try:
                    yield ready.recv()
                except EOFError:
                    process, job = running.pop(ready)
                    process.join()
                    if process.exitcode:
                        yield Failure(
                            f"the worker for {job.scene} ({job.method}) ended with status "
                            f"{process.exitcode}; run again to go on"
                        )

    try:
        yield messages()
    finally:
        for process, _ in running.values():
            process.terminate()
        for process, _ in running.values():
            process.join(5.0)
            if process.is_alive():
                process.kill()
                process.join()


def _take(message: Message, results: Results, bar: Any) -> None:
    if isinstance(message, Failure):
        raise HarnessError(message.text)
    if isinstance(message, Note):
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
            row = asdict(result)
            walls.setdefault(method, {})[result.episode] = row.pop("wall")
            rows.append(row)
    methods = {
        name: {**plain(summary), "errors": errors(results.of(name, evaluation.episodes))}
        for name, summary in summaries(evaluation, results, seed)
    }
    return {
        "suite": evaluation.suite,
        "protocol": evaluation.settings.protocol,
        "seed": seed,
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
        "episodes": _digest(json.dumps([asdict(e) for e in evaluation.episodes])),
        "protocol": settings.protocol,
        "config": _digest(config),
        "settings": list(settings.settings),
    }
    path = settings.out / RUN_FILE
    try:
        settings.out.mkdir(parents=True, exist_ok=True)
        if path.is_file():
            other = json.loads(path.read_text(encoding="utf-8"))
            different = [key for key, value in mine.items() if other.get(key) != value]
            if different:
                raise HarnessError(
                    f"{settings.out}: holds results of another {different[0]}; choose another --out"
                )
        path.write_text(json.dumps(mine, indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        raise HarnessError(f"{settings.out}: cannot be written ({error.strerror})") from error


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]


@click.command(
    "eval",
    epilog="Example:  hil-sim eval --suite smoke --method rfnav --method closest --json eval.json",
)
@click.option("--suite", default="smoke", show_default=True, help="Bundled name, or a suite file.")
@click.option(
    "--method",
    "methods",
    multiple=True,
    default=("rfnav",),
    show_default=True,
    help=f"{', '.join(METHODS)}; may be given more than once.",
)
@click.option("--workers", default=2, show_default=True, type=click.IntRange(1, 64))
@click.option("--protocol", default="hm3d", show_default=True)
@click.option("--config", type=click.Path(path_type=Path), help="The runtime's TOML file.")
@click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help="Override one key of it.")
@click.option("--out", type=click.Path(path_type=Path), help="Default: out/eval-SUITE.")
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="All figures as JSON.")
@click.option("--seed", default=0, show_default=True, help="Of the bootstrap intervals.")
@click.option(
    "--renderer", type=click.Choice(["auto", "egl", "tiny"]), default="auto", show_default=True
)
def eval_command(
    suite: str,
    methods: tuple[str, ...],
    workers: int,
    protocol: str,
    config: Path | None,
    sets: tuple[str, ...],
    out: Path | None,
    json_file: Path | None,
    seed: int,
    renderer: str,
) -> None:
    """Drive every episode of a suite with each method and print the table.

    Finished episodes are kept in OUT: after Ctrl-C the same command goes on where it was.
    """
    for method in methods:
        method_settings(method)
    protocol_named(protocol)
    if config is not None and not config.is_file():
        raise RfNavError(f"{config}: no such configuration file")
    if workers > 1:
        sets = ("models.threads=1", *sets)
    settings = Settings(
        out or Path("out") / f"eval-{Path(suite).stem}", protocol, config, sets, renderer
    )
    evaluation = Evaluation(
        suite, load_suite(suite), tuple(dict.fromkeys(methods)), workers, settings
    )
    claim(evaluation)
    results = Results(settings.out)
    began_s = time.monotonic()
    complete = run(evaluation, results)
    _print(evaluation, results, seed, time.monotonic() - began_s)
    if json_file is not None:
        figures = report(evaluation, results, seed)
        json_file.write_text(json.dumps(plain(figures), indent=1) + "\n", encoding="utf-8")
    if not complete:
        click.echo("interrupted; the same command goes on where it was", err=True)
    failed = any(errors(results.of(m, evaluation.episodes)) for m in evaluation.methods)
    sys.exit(0 if complete and not failed else 1)


def _print(evaluation: Evaluation, results: Results, seed: int, took_s: float) -> None:
    click.echo(f"\n{evaluation.suite}, protocol {evaluation.settings.protocol}; "
               "95 % bootstrap intervals\n")  # fmt: skip
    click.echo(table(summaries(evaluation, results, seed)))
    click.echo("")
    for method in evaluation.methods:
        done = results.of(method, evaluation.episodes)
        line = f"{method}: {stages(done)}"
        if errors(done):
            line += f"; {errors(done)} ended in an error and count as failures"
        click.echo(line)
    click.echo(f"took {took_s:.0f} s; episodes in {evaluation.settings.out}")
