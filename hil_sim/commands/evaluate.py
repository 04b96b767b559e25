"""`hil-sim eval`: drive a suite and print the table."""

import json
import sys
import time
from pathlib import Path
from typing import Any

import click

from hil_sim.driving.methods import KNOWN, method_named, needed_models
from hil_sim.evaluation.evaluate import Evaluation, claim, report, run, summaries
from hil_sim.evaluation.left_out import lines_of
from hil_sim.evaluation.report_tables import purposes
from hil_sim.evaluation.results import Results, errors, falls, sole, stages
from hil_sim.evaluation.starts import survey
from hil_sim.evaluation.summary import table
from hil_sim.evaluation.worker import Settings, protocol_for
from hil_sim.ground_truth.episodes import Episode, known_suites, load_suite
from hil_sim.simulation.faults import HELP, parse_faults
from hil_sim.simulation.protocol import EXTRAS
from runtime.errors import RfNavError
from runtime.journal import plain


@click.command(
    "eval",
    epilog="Examples:  hil-sim eval --suite smoke --method rfnav --method closest   |   "
    "hil-sim eval --episodes DIR --limit 100 --protocol robothor",
)
@click.option("--suite", default="smoke", show_default=True,
              help=f"{', '.join(known_suites())}, or a suite file.")  # fmt: skip
@click.option("--episodes", "folder", type=click.Path(path_type=Path),
              help="RoboTHOR's folder of episodes, instead of a suite.")  # fmt: skip
@click.option("--limit", default=0, help="Only so many episodes: a suite's first.")
@click.option("--method", "methods", multiple=True, default=("rfnav",), show_default=True,
              help=f"{KNOWN}; may be given more than once.")  # fmt: skip
@click.option("--workers", default=2, show_default=True, type=click.IntRange(1, 64))
@click.option("--ray", default="", metavar="ADDRESS", help="Run on a Ray cluster: auto, local, …")
@click.option("--protocol", default="hm3d", show_default=True, help="hm3d, robothor, onrobot.")
@click.option("--noise", multiple=True, metavar="NAME=SIZE",
              help="Other than the protocol's: depth=0.003, camera=kinect-v1, all, …")  # fmt: skip
@click.option("--tilt", type=click.Choice(["level", "episode"]), default="level")
@click.option("--sensor", "sensors", multiple=True, type=click.Choice(EXTRAS))
@click.option("--realtime", is_flag=True, help="In real time; results do not repeat exactly.")
@click.option("--fault", "faults", multiple=True, metavar="NAME[:KEY=VALUE,…]", help=HELP)
@click.option("--config", type=click.Path(path_type=Path), help="The runtime's TOML file.")
@click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help="Override one key of it.")
@click.option("--out", type=click.Path(path_type=Path), help="Default: out/eval-SUITE.")
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="All figures as JSON.")
@click.option("--seed", default=0, show_default=True,
              help="Of noise, faults and bootstrap intervals.")  # fmt: skip
@click.option(
    "--renderer", type=click.Choice(["auto", "egl", "tiny"]), default="auto", show_default=True
)
def eval_command(**given: Any) -> None:
    """Drive every episode of a suite with each method and print the table.

    Finished episodes are kept in OUT: after Ctrl-C, or SIGTERM, the same command goes on where it
    was.
    `hil-sim report OUT` makes tables and figures of them. Of RoboTHOR's episodes those that cannot
    be driven in the replicas are told first and left out. Exit status 1: some ended in an error.
    """
    evaluation = _evaluation(given)
    with sole(evaluation.settings.out):
        claim(evaluation)
        results = Results(evaluation.settings.out, mend=True)
        began_s = time.monotonic()
        checked = evaluation if given["folder"] is None else survey(evaluation)
        complete = checked is not None
        if checked is not None:
            evaluation = checked
            for line in lines_of(evaluation.left_out):
                click.echo(line, err=True)
            complete = run(evaluation, results)
    _print(evaluation, results, given["seed"], time.monotonic() - began_s)
    if given["json_file"] is not None:
        figures = plain(report(evaluation, results, given["seed"]))
        given["json_file"].write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    if not complete:
        click.echo("interrupted; the same command goes on where it was", err=True)
    failed = any(errors(results.of(m, evaluation.episodes)) for m in evaluation.methods)
    sys.exit(0 if complete and not failed else 1)


def _evaluation(given: dict[str, Any]) -> Evaluation:
    """What was asked for; RfNavError when something of it is unknown."""
    config, sets = given["config"], given["sets"]
    if config is not None and not config.is_file():
        raise RfNavError(f"{config}: no such configuration file")
    if given["workers"] > 1:
        sets = ("models.threads=1", *sets)
    name, episodes, limit = _episodes(given)
    parse_faults(given["faults"])
    settings = Settings(
        given["out"] or Path("out") / f"eval-{Path(name).stem}", given["protocol"], config, sets,
        given["renderer"], given["faults"], given["noise"], given["sensors"], given["tilt"],
        given["seed"], given["realtime"],
    )  # fmt: skip
    methods = tuple(dict.fromkeys(given["methods"]))
    for method in methods:
        protocol_for(settings, method_named(method))
    needed_models(methods)
    return Evaluation(name, episodes, methods, given["workers"], settings, given["ray"], limit)


def _episodes(given: dict[str, Any]) -> tuple[str, tuple[Episode, ...], int]:
    """The suite's name, its episodes and how many of them to drive (0: all)."""
    folder, limit = given["folder"], given["limit"]
    if folder is None:
        return given["suite"], load_suite(given["suite"]), limit
    from hil_sim.importers.robothor_episodes import official_episodes

    chosen = official_episodes(folder, (), limit or None, given["seed"])
    return f"robothor-{folder.name}", chosen, 0


def _print(evaluation: Evaluation, results: Results, seed: int, took_s: float) -> None:
    click.echo(f"\n{evaluation.suite}, protocol {evaluation.settings.protocol}; "
               "95 % bootstrap intervals\n")  # fmt: skip
    click.echo(table(summaries(evaluation, results, seed)))
    click.echo("")
    runs = {name: results.of(name, evaluation.episodes) for name in evaluation.methods}
    if shares := purposes(runs):
        click.echo(f"{shares}\n")
    for method in evaluation.methods:
        done = results.of(method, evaluation.episodes)
        line = f"{method}: {stages(done)}; {falls(done)} falls"
        if errors(done):
            line += f"; {errors(done)} ended in an error and count as failures"
        click.echo(line)
    for line in lines_of(evaluation.left_out):
        click.echo(line)
    click.echo(f"took {took_s:.0f} s; episodes in {evaluation.settings.out}")
