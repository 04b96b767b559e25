"""`rfnav bench`: how late the loop is, measured against its budgets."""

import itertools
import sys
from collections.abc import Callable
from pathlib import Path

import click

from runtime import config as configuration
from runtime.bench import measure, recorded, synthetic, verdict
from runtime.bench.checkout import checkout
from runtime.bench.measure import BenchError, Measured, Subject
from runtime.tracing.budgets import read_budgets

SECONDS = 60.0  # of a drive that nobody recorded
PAIRS = 6  # with fewer the interval is that of what the machine did meanwhile
GOALS = (
    "toilet", "sofa", "bed", "plant", "television", "chair", "lamp", "fridge", "bathtub", "laptop",
    "mug", "vase", "towel", "pillow", "microwave", "bookshelf", "clock", "sink", "oven", "mirror",
    "carpet", "piano", "guitar", "basketball", "backpack", "kettle", "toaster", "candle", "bowl",
    "newspaper", "remote control", "trash can", "washing machine", "dining table", "teddy bear",
)  # fmt: skip


@click.command(
    "bench",
    epilog="Examples:  rfnav bench   |   rfnav bench --against HEAD~3 --seconds 30",
)
@click.argument("file", required=False, type=click.Path(path_type=Path, dir_okay=False))
@click.option(
    "--seconds",
    type=click.FloatRange(5.0),
    default=SECONDS,
    show_default=True,
    help="How much of the drive is played.",
)
@click.option("--goal", help="What is looked for; as it was recorded, else one after the other.")
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
    type=click.IntRange(3),
    default=PAIRS,
    show_default=True,
    help="Runs of each, with --against.",
)
def bench_command(
    file: Path | None,
    seconds: float,
    goal: str | None,
    budgets_path: Path | None,
    path: Path | None,
    settings: tuple[str, ...],
    against: str | None,
    pairs: int,
) -> None:
    """Play a recorded drive, FILE, or one through a made-up room, in real time to a runtime with
    all models, and print how long its stages took, against deploy/budgets.toml. Exit status 1 when
    a budget is broken."""
    budgets, config = read_budgets(budgets_path), configuration.load(path, settings)
    arguments = [*(("--config", str(path.resolve())) if path else ())]
    arguments += itertools.chain.from_iterable(("--set", setting) for setting in settings)
    topics, hz = config.bus.topics, config.realtime.control_hz
    if file is not None:
        goal = goal or recorded.goal_of(file)
        arguments += itertools.chain.from_iterable(("--set", s) for s in recorded.camera_of(topics))

    goals = (goal,) if goal else GOALS
    if against is not None:
        goals = goals[:1]  # with several, both would not do the same
    if len(goals) > 1:
        arguments += ["--set", "research.keep_stages=true", "--set", "research.keep_scores=false"]

    def run(root: Path | None) -> Measured:
        subject = Subject(arguments, root)
        if file is not None:
            drive = recorded.drive(file, topics, seconds)
        else:
            drive = synthetic.drive(seconds, topics, config.camera)
        return measure.measured(subject, goals, drive, topics, hz)

    if against is None:
        found = run(None)
        rows = verdict.rows(found, budgets)
        click.echo(verdict.table(rows))
        click.echo(_said(found))
        sys.exit(int(any(row.broken for row in rows)))
    _compare(run, against, pairs)


def _compare(run: Callable[[Path | None], Measured], against: str, pairs: int) -> None:
    """This code and another commit's in turns, and what the medians are of each other."""
    ours: list[Measured] = []
    theirs: list[Measured] = []
    with checkout(Path(__file__).resolve().parents[2], against) as root:
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
