"""`hil-sim questions`: build a bank of questions with known answers; judge every method on it, or
one expert by itself."""

import json
from pathlib import Path
from typing import Any

import click

from hil_sim.evaluation.report import fill
from hil_sim.expert_bench.bank import SIDES, BankPlan, load_bank
from hil_sim.expert_bench.learned_homes import check_unknown
from hil_sim.expert_bench.make import home_names, make_bank, plan_of, tell_again
from hil_sim.expert_bench.scene_plan import KINDS, ScenePlan


@click.command(
    "questions",
    epilog="Examples:  hil-sim questions --bank out/questions --side fit   |   "
    "hil-sim questions --bank out/questions --side test --out docs/lab/experts-tables.md   |   "
    "hil-sim questions --bank out/questions --homes 0 --side fit --quick "
    "--set research.experts_bar=1.3   |   hil-sim questions --expert sle --views out/beyond/dev "
    "--counted out/beyond/train --bank out/questions --homes 0 --side all",
)
@click.option("--bank", "folder", type=click.Path(path_type=Path),
              help="Folder of the bank; what is missing of it is made.")  # fmt: skip
@click.option("--homes", default=60, show_default=True, type=click.IntRange(0),
              help="How many it is to have; 0 takes those that are there.")  # fmt: skip
@click.option("--side", type=click.Choice([*SIDES, "all", "none"]), default="fit",
              show_default=True, help="Half that is judged; none only makes the bank.")  # fmt: skip
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="Of the runtime.")
@click.option("--quick", is_flag=True, help="Not perturbed: the main table only, in seconds.")
@click.option("--evidence", is_flag=True,
              help="Judge kinds of evidence, and pairs of them, in place of methods.")  # fmt: skip
@click.option("--out", type=click.Path(path_type=Path), help="Put the tables into this document.")
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="All figures as JSON.")
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0),
              help="Of homes, drives, what is perturbed, intervals.")  # fmt: skip
@click.option("--workers", default=1, show_default=True, type=click.IntRange(1, 64))
@click.option("--expert", type=click.Choice(["sle"]),
              help="Judge this one by itself: the scene-layout expert, on views too.")  # fmt: skip
@click.option("--views", type=click.Path(path_type=Path),
              help="For --expert: held-out homes' views, by hil-sim beyond.")  # fmt: skip
@click.option("--counted", type=click.Path(path_type=Path),
              help="For --expert: train homes' views, that the table is counted of; without, it "
              "is counted of --plans.")  # fmt: skip
@click.option("--plans", default=200, show_default=True, type=click.IntRange(1),
              help="For --expert: train homes whose plans are counted; nothing is drawn of "
              "them.")  # fmt: skip
@click.option("--photographs", type=click.Path(path_type=Path),
              help="For --expert: a folder of photographs with their rooms.")  # fmt: skip
@click.option("--rows", default=16, show_default=True, type=click.IntRange(0),
              help="For --expert: views of each home that are asked about; 0: all.")  # fmt: skip
@click.option("--kind", "kinds", multiple=True, type=click.Choice(KINDS), default=KINDS,
              help="For --expert: kinds of it; all, if none is given.")  # fmt: skip
@click.option("--keep-maps", is_flag=True, help="Keep the maps too (200 KB a moment).")
@click.option("--tell-again", "again", is_flag=True,
              help="Compose what experts are told anew, from maps that were kept.")  # fmt: skip
def questions_command(
    folder: Path | None, homes: int, side: str, settings: tuple[str, ...], quick: bool,
    evidence: bool, out: Path | None, json_file: Path | None, seed: int, workers: int,
    expert: str | None, views: Path | None, counted: Path | None, plans: int,
    photographs: Path | None, rows: int, kinds: tuple[str, ...], keep_maps: bool, again: bool,
) -> None:  # fmt: skip
    """Ask the experts about frontiers in partial maps of the train homes, and say how far their
    choices, and everyone's they are compared with, are from the best.

    A bank that was interrupted goes on with the same command.
    """
    if folder is not None and homes:
        _make(folder, homes, BankPlan(seed), workers, keep_maps)
    if folder is not None and again:
        click.echo(f"{tell_again(folder, plan_of(folder))} homes told again")
    if expert is not None:
        if views is None:
            raise click.UsageError("--expert needs --views: see hil-sim beyond")
        sides = {"all": SIDES, "none": ()}.get(side, (side,))
        plan = ScenePlan(
            views, counted, rows, plans, photographs, folder, sides, kinds, settings, seed
        )
        _tell(*_expert(plan), "questions-sle", out, json_file)
    elif folder is None:
        raise click.UsageError("--bank is needed")
    elif evidence and side != "none":
        _tell(
            *_evidence(folder, side, settings, seed), f"questions-evidence-{side}", out, json_file
        )
    elif side != "none":
        text, data = _methods(folder, side, settings, quick, seed)
        _tell(text, data, f"questions-{side}", out, json_file)


def _expert(plan: ScenePlan) -> tuple[str, dict[str, Any]]:
    """The scene-layout expert's block and figures."""
    from hil_sim.expert_bench import scene_report
    from hil_sim.expert_bench.never_taught import never_taught
    from hil_sim.expert_bench.scene import measure
    from hil_sim.expert_bench.voting import Voters
    from runtime.config import load
    from runtime.perception.beholders import open_beholders

    opened = open_beholders(plan.kinds, load(None, plan.settings).models)
    found = measure(plan, *opened, never_taught(), Voters)
    return scene_report.section(found, plan.seed), scene_report.figures(found, plan.seed)


def _methods(
    folder: Path, side: str, settings: tuple[str, ...], quick: bool, seed: int
) -> tuple[str, dict[str, Any]]:
    """One side's block and figures."""
    from hil_sim.expert_bench import report
    from hil_sim.expert_bench.judge import BRIEFS, CONDITIONS, judge
    from hil_sim.expert_bench.voting import Voters

    bank, plan = load_bank(folder, side), plan_of(folder)
    conditions = CONDITIONS[:1] if quick else CONDITIONS
    with Voters(settings) as voters:
        voters.warm(bank, [name for name in conditions if name in BRIEFS])
        table = judge(bank, settings, voters, conditions, seed)
    text = report.section(bank, table, side, settings, vars(plan), seed)
    return text, report.figures(bank, table, seed)


def _evidence(
    folder: Path, side: str, settings: tuple[str, ...], seed: int
) -> tuple[str, dict[str, Any]]:
    """One side's block and figures of kinds of evidence."""
    from hil_sim.expert_bench import evidence_report
    from hil_sim.expert_bench.evidence import weigh
    from hil_sim.expert_bench.voting import Voters

    bank = load_bank(folder, side)
    with Voters(settings) as voters:
        voters.warm(bank)
        rows = weigh(bank, settings, voters)
    return (evidence_report.section(bank, rows, side, settings, seed),
            evidence_report.figures(bank, rows, seed))  # fmt: skip


def _tell(
    text: str, data: dict[str, Any], block: str, out: Path | None, json_file: Path | None
) -> None:
    click.echo(text)
    if out is not None:
        document = out.read_text(encoding="utf-8") if out.is_file() else "# The experts\n"
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(fill(document, block, text), encoding="utf-8")
    if json_file is not None:
        json_file.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")


def _make(folder: Path, homes: int, plan: BankPlan, workers: int, maps: bool) -> None:
    names = home_names(homes, plan.seed)
    check_unknown(names)
    made = make_bank(folder, names, plan, workers, maps)
    if made:
        click.echo(f"{made} homes made in {folder}")
