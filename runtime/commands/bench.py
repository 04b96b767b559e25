"""`rfnav bench`: how late the loop is, measured against its budgets."""

import itertools
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click

from runtime import config as configuration
from runtime.bench import measure, synthetic, verdict
from runtime.bench.measure import BenchError, Measured, Subject
from runtime.tracing.budgets import read_budgets

SECONDS = 60.0  # of a drive that nobody recorded
PAIRS = 3


@click.command(
    "bench",
    epilog="Examples:  rfnav bench   |   rfnav bench --against HEAD~3 --seconds 30",
)
@click.option(
    "--seconds",
    type=click.FloatRange(5.0),
    default=SECONDS,
    show_default=True,
    help="How much of the drive is played.",
)
@click.option("--goal", default="toilet", show_default=True, help="What is looked for.")
@click.option(
    "--budgets",
    "budgets_path",
    type=click.Path(path_type=Path),
    help="TOML file; deploy/budgets.toml otherwise.",
)
@click.option("--config", "path", type=click.Path(path_type=Path), help="As of rfnav run.")
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="As of rfnav run.")
@click.option(
    "--against",
    metavar="REV",
    help="Measure a commit of this checkout too, in turns, and print ratios of the medians.",
)
@click.option(
    "--pairs",
    type=click.IntRange(1),
    default=PAIRS,
    show_default=True,
    help="Runs of each, with --against.",
)
def bench_command(
    seconds: float,
    goal: str,
    budgets_path: Path | None,
    path: Path | None,
    settings: tuple[str, ...],
    against: str | None,
    pairs: int,
) -> None:
    """Play a drive in real time to a runtime with all models, and print how long its stages took,
    against deploy/budgets.toml. Exit status 1 when a budget is broken."""
    budgets, config = read_budgets(budgets_path), configuration.load(path, settings)
    arguments = [*(("--config", str(path.resolve())) if path else ())]
    arguments += itertools.chain.from_iterable(("--set", setting) for setting in settings)
    topics, hz = config.bus.topics, config.realtime.control_hz

    def run(root: Path | None) -> Measured:
        drive = synthetic.drive(seconds, topics, config.camera)
        return measure.measured(Subject(arguments, root), goal, drive, topics, hz)

    if against is None:
        found = run(None)
        rows = verdict.rows(found, budgets)
        click.echo(verdict.table(rows))
        click.echo(_said(found))
        sys.exit(int(any(row.broken for row in rows)))
    ours: list[Measured] = []
    theirs: list[Measured] = []
    with _checkout(against) as root:
        for n in range(pairs):
            for other in (n % 2 == 0, n % 2 == 1):
                (theirs if other else ours).append(run(root if other else None))
    ratios = verdict.ratios(ours, theirs)
    if not ratios:
        raise BenchError(f"{against}: traces no stages, there is nothing to compare")
    for ratio in ratios:
        click.echo(f"{ratio.stage:10}{ratio.ratio:8.3f}   {ratio.low:.3f} .. {ratio.high:.3f}")


def _said(found: Measured) -> str:
    halts = ", ".join(f"{kind} {n}" for kind, n in found.halts.items()) or "none"
    return (
        f"{found.seconds:.0f} s; decisions {found.decisions}; halts: {halts}; memory grew by "
        f"{found.grown_mb:.1f} MB in the second half"
    )


@contextmanager
def _checkout(rev: str) -> Iterator[Path]:
    """A commit of this checkout in a folder of its own."""
    here = Path(__file__).resolve().parents[2]
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder) / "against"
        _git(here, "worktree", "add", "--detach", str(root), rev)
        try:
            yield root
        finally:
            _git(here, "worktree", "remove", "--force", str(root))


def _git(root: Path, *arguments: str) -> None:
    done = subprocess.run(["git", "-C", str(root), *arguments], capture_output=True, text=True)
    if done.returncode:
        said = (done.stderr.strip().splitlines() or ["git failed"])[-1]
        raise BenchError(f"--against: {said}")
