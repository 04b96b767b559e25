"""`hil-sim demo`: one episode, told as it happens."""

import json
import sys
import time
from contextlib import ExitStack
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import click

from hil_sim.assets import Assets
from hil_sim.episode_run import EpisodeResult, Step, run_episode
from hil_sim.episodes import Episode, sample_episode
from hil_sim.freespace import instances
from hil_sim.homes import open_scene
from hil_sim.link import HarnessError, Runtime
from hil_sim.methods import SINGLE, method_named
from hil_sim.protocol import HM3D
from hil_sim.quiet import keep_stdout_for_python
from hil_sim.rig import home_of, open_world
from runtime.edge.journal import MAP_FILE
from runtime.errors import ConfigError

SUMMARY_FILE, PICTURE_FILE = "summary.json", "map.png"


@click.command(
    "demo",
    epilog="Examples:  hil-sim demo --goal toilet   |   "
    "hil-sim demo --goal plant --scene cedar --start 3",
)
@click.option("--goal", required=True, help='What to find, e.g. "toilet".')
@click.option("--scene", default="maple", show_default=True, help="Bundled home, or a scene file.")
@click.option("--start", default=0, show_default=True, help="Which of the random start poses.")
@click.option("--method", default="rfnav", show_default=True, help=f"{', '.join(SINGLE)}.")
@click.option("--config", type=click.Path(path_type=Path), help="The runtime's TOML file.")
@click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help="Override one key of it.")
@click.option("--out", type=click.Path(path_type=Path), help="Default: out/SCENE-GOAL-START.")
@click.option(
    "--renderer", type=click.Choice(["auto", "egl", "tiny"]), default="auto", show_default=True
)
def demo_command(
    goal: str,
    scene: str,
    start: int,
    method: str,
    config: Path | None,
    sets: tuple[str, ...],
    out: Path | None,
    renderer: str,
) -> None:
    """Let the robot find something in a furnished home, and tell what it does and why.

    Writes OUT/{summary.json, decisions.jsonl, map.png}. Exit status: 0 found, 1 not found,
    2 an error.
    """
    began_s = time.monotonic()
    goal = " ".join(goal.split())
    if not goal:
        raise ConfigError("goal: is empty; say what to find, e.g. --goal toilet")
    home = open_scene(scene)
    instances(home, goal)  # an error that names what there is, before anything slow
    method_named(method)
    run_dir = out or Path("out") / f"{home.name}-{goal.replace(' ', '-')}-{start}"
    _clear(run_dir)
    keep_stdout_for_python()
    assets = Assets()
    with ExitStack() as stack:
        assets.catalog  # noqa: B018 -- missing furniture is an error before models are loaded
        click.echo(f"loading {home.name} and the models")
        runtime = Runtime(run_dir / "runtime.log", config, sets)
        stack.callback(runtime.close)
        world = stack.enter_context(open_world(home, assets, renderer))
        stack.enter_context(runtime)
        from hil_sim.truth import Truth

        truth = Truth(world, assets, click.echo)
        found = sample_episode(
            truth.space, truth.success(goal), goal, start, truth.sees(goal), home.name
        )
        setup_s = time.monotonic() - began_s
        _announce(found, method, setup_s)
        result = run_episode(
            found, home_of(world, truth, HM3D, goal), runtime, HM3D, method, run_dir, _tell
        )
    result = replace(result, wall={"setup": round(setup_s, 4), **result.wall})
    _finish(run_dir, result)
    if result.ended.startswith("error"):
        raise HarnessError(result.ended.removeprefix("error: "))
    sys.exit(0 if result.success else 1)


def _clear(run_dir: Path) -> None:
    """Remove an earlier run's results, so that none of them is taken for this one's."""
    try:
        run_dir.mkdir(parents=True, exist_ok=True)
        for name in (SUMMARY_FILE, PICTURE_FILE, MAP_FILE, "decisions.jsonl"):
            (run_dir / name).unlink(missing_ok=True)
    except OSError as error:
        raise ConfigError(f"{run_dir}: cannot be written ({error.strerror})") from error


def _announce(episode: Episode, method: str, setup_s: float) -> None:
    click.echo(
        f"find a {episode.goal} in {episode.scene}: {episode.shortest_path_m:.1f} m away; "
        f"method {method}; ready after {setup_s:.1f} s"
    )


def _tell(step: Step) -> None:
    """A line a step, and a few more when there was a decision."""
    answer = step.answer
    if answer is None:
        click.echo(f"{step.number:4}  nothing was asked")
        return
    for decision in answer.decisions:
        for line in vote_lines(decision):
            click.echo(line)
    state = answer.state
    frontier = state.get("frontier")
    aim = f"frontier {frontier}" if frontier is not None else "no frontier"
    if state.get("mode") in ("target", "face", "stop", "look"):
        aim = str(state["mode"])
    click.echo(f"{step.number:4}  {answer.action.value:12}  {aim:12}  {state.get('reason', '')}")


def vote_lines(decision: dict[str, Any]) -> list[str]:
    """Who voted for what, and why: one line for the decision, one for each expert."""
    elected, closest = decision.get("frontier"), decision.get("closest")
    what = f"frontier {elected}" if elected is not None else "no frontier"
    beside = "" if elected == closest else f", where the closest is {closest}"
    lines = [f"      vote ({decision.get('why')}): {what} by {decision.get('rule')}{beside}"]
    said = {vote["expert"]: (_set(vote["frontiers"]), vote["reason"]) for vote in decision["votes"]}
    said |= {absent["expert"]: ("abstains", absent["cause"]) for absent in decision["missing"]}
    return lines + [f"        {name}: {who}: {why}" for name, (who, why) in sorted(said.items())]


def _set(ids: list[int]) -> str:
    return "{" + ", ".join(str(number) for number in ids) + "}"


def _finish(run_dir: Path, result: EpisodeResult) -> None:
    text = json.dumps(asdict(result), indent=1) + "\n"
    (run_dir / SUMMARY_FILE).write_text(text, encoding="utf-8")
    for line in final_lines(result):
        click.echo(line)
    if (run_dir / MAP_FILE).is_file():
        from hil_sim.draw import draw_map  # matplotlib takes a second to import

        draw_map(run_dir, run_dir / PICTURE_FILE)
    names = [SUMMARY_FILE, "decisions.jsonl", PICTURE_FILE]
    here = ", ".join(name for name in names if (run_dir / name).is_file())
    click.echo(f"{run_dir}/: {here}")


def final_lines(result: EpisodeResult) -> list[str]:
    """How it went: outcome, path, wall time by stage."""
    left = "cut off" if result.distance_m is None else f"{result.distance_m:.2f} m"
    why = f": {result.reason}" if result.reason else ""
    outcome = "SUCCESS" if result.success else "FAILURE"
    spl = "–" if result.spl is None else f"{result.spl:.2f}"
    stages = dict(result.wall)
    total = stages.pop("total", 0.0)
    setup = stages.pop("setup", 0.0)
    parts = ", ".join(f"{name.removeprefix('runtime.')} {s:.1f}" for name, s in stages.items())
    return [
        f"{outcome}: {result.ended}{why}; {left} from where it counts",
        f"path {result.path_m:.2f} m in {result.steps} steps, shortest "
        f"{result.shortest_path_m:.2f} m, SPL {spl}; {result.decisions} decisions, "
        f"{result.collisions} collisions",
        f"wall time {total:.1f} s ({parts}) after {setup:.1f} s to set up",
    ]
