"""`hil-sim questions`: build a bank of questions with known answers; judge every method on it."""

import json
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import click

from hil_sim.evaluation.report import fill
from hil_sim.expert_bench.bank import SIDES, BankPlan, load_bank
from hil_sim.expert_bench.make import home_names, make_bank, plan_of, tell_again
from runtime.errors import RfNavError


@click.command(
    "questions",
    epilog="Examples:  hil-sim questions --bank out/questions --side fit   |   "
    "hil-sim questions --bank out/questions --side test --out docs/experts.md   |   "
    "hil-sim questions --bank out/questions --homes 0 --side fit --quick "
    "--set research.experts_bar=1.3",
)
@click.option("--bank", "folder", type=click.Path(path_type=Path), required=True,
              help="Folder of the bank; what is missing of it is made.")  # fmt: skip
@click.option("--homes", default=60, show_default=True, type=click.IntRange(0),
              help="How many it is to have; 0 takes those that are there.")  # fmt: skip
@click.option("--side", type=click.Choice([*SIDES, "all", "none"]), default="fit",
              show_default=True, help="Half that is judged; none only makes the bank.")  # fmt: skip
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="Of the runtime.")
@click.option("--quick", is_flag=True, help="Not perturbed: the main table only, in seconds.")
@click.option("--out", type=click.Path(path_type=Path), help="Put the tables into this document.")
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="All figures as JSON.")
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0),
              help="Of homes, drives, what is perturbed, intervals.")  # fmt: skip
@click.option("--workers", default=1, show_default=True, type=click.IntRange(1, 64))
@click.option("--keep-maps", is_flag=True, help="Keep the maps too (200 KB a moment).")
@click.option("--tell-again", "again", is_flag=True,
              help="Compose what experts are told anew, from maps that were kept.")  # fmt: skip
def questions_command(
    folder: Path, homes: int, side: str, settings: tuple[str, ...], quick: bool, out: Path | None,
    json_file: Path | None, seed: int, workers: int, keep_maps: bool, again: bool,
) -> None:  # fmt: skip
    """Ask the experts about frontiers in partial maps of the train homes, and say how far their
    choices, and everyone's they are compared with, are from the best.

    A bank that was interrupted goes on with the same command.
    """
    if homes:
        _make(folder, homes, BankPlan(seed), workers, keep_maps)
    if again:
        click.echo(f"{tell_again(folder, plan_of(folder))} homes told again")
    if side == "none":
        return
    from hil_sim.expert_bench import report
    from hil_sim.expert_bench.judge import BRIEFS, CONDITIONS, judge
    from hil_sim.expert_bench.voting import Voters

    bank, plan = load_bank(folder, side), plan_of(folder)
    conditions = CONDITIONS[:1] if quick else CONDITIONS
    with Voters(settings) as voters:
        voters.warm(bank, [name for name in conditions if name in BRIEFS])
        table = judge(bank, settings, voters, conditions, seed)
    text = report.section(bank, table, side, settings, vars(plan), seed)
    click.echo(text)
    if out is not None:
        document = out.read_text(encoding="utf-8") if out.is_file() else "# The experts\n"
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(fill(document, f"questions-{side}", text), encoding="utf-8")
    if json_file is not None:
        data = report.figures(bank, table, seed)
        json_file.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")


def _make(folder: Path, homes: int, plan: BankPlan, workers: int, maps: bool) -> None:
    try:
        made = make_bank(folder, home_names(homes, plan.seed), plan, workers, maps)
    except BrokenProcessPool:
        raise RfNavError("a worker died (out of memory?); run again to go on") from None
    if made:
        click.echo(f"{made} homes made in {folder}")
