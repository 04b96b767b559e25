"""`hil-sim demo`: one episode, told as it happens."""

import json
import sys
import time
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hil_sim.commands.demo_serve import check_served, serve
from hil_sim.driving.base_wires import MavlinkWire
from hil_sim.driving.episode_result import EpisodeResult
from hil_sim.driving.episode_run import run_episode
from hil_sim.driving.link import HarnessError, Runtime, rfnav_command
from hil_sim.driving.methods import COW, SINGLE, method_named, needed_models
from hil_sim.driving.realtime import run_realtime
from hil_sim.driving.rig import home_of, open_world
from hil_sim.driving.stage import StagedHome, Step
from hil_sim.ground_truth.episodes import Episode, sample_episode
from hil_sim.ground_truth.freespace import instances
from hil_sim.ground_truth.goals import category_word
from hil_sim.ground_truth.witness import TARGET_MODES, Claim
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.faults import HELP, Fault, model_fault, parse_faults
from hil_sim.simulation.protocol import EXTRAS, Protocol, protocol_named
from hil_sim.simulation.quiet import keep_stdout_for_python
from hil_sim.simulation.rover_stand_in import RoverStandIn
from runtime.core.voting.names import introduced, listed, rule_said
from runtime.core.world import Mode
from runtime.errors import ConfigError
from runtime.journal import MAP_FILE

if TYPE_CHECKING:  # PyBullet prints when it is imported
    from hil_sim.simulation.scene_physics import ScenePhysics

SUMMARY_FILE, PICTURE_FILE = "summary.json", "map.png"
METHOD = "rfnav"


@click.command(
    "demo",
    epilog="Examples:  hil-sim demo --goal toilet   |   "
    "hil-sim demo --goal plant --scene cedar --start 3   |   "
    "hil-sim demo --goal bed --protocol onrobot --fault person:at=40   |   hil-sim demo --serve",
)
@click.option("--goal", default="", help='What to find, e.g. "toilet".')
@click.option("--serve", "serves", is_flag=True,
              help="Stay up, with `rfnav run` beside it, for `rfnav find`.")  # fmt: skip
@click.option("--listen", help="With --serve: its bus; tcp/127.0.0.1:7447 otherwise.")
@click.option("--scene", default="maple", show_default=True, help="Bundled home, or a scene file.")
@click.option("--start", default=0, show_default=True, help="Which of the random start poses.")
@click.option("--method", default=METHOD, show_default=True, help=f"{', '.join((*SINGLE, *COW))}.")
@click.option("--protocol", default="hm3d", show_default=True, help="hm3d, robothor, onrobot.")
@click.option("--noise", multiple=True, metavar="NAME=SIZE",
              help="Other than the protocol's: depth=0.003, camera=kinect-v1, all, …")  # fmt: skip
@click.option("--tilt", type=click.Choice(["level", "episode"]), default="level")
@click.option("--sensor", "sensors", multiple=True, type=click.Choice(EXTRAS))
@click.option("--whole-mm", is_flag=True, help="Depth in whole millimetres, as most cameras.")
@click.option("--realtime", is_flag=True, help="In real time; results do not repeat exactly.")
@click.option("--base", type=click.Choice(["ros2", "mavlink"]), default="ros2",
              show_default=True, help="The base's wire; mavlink: to a stand-in.")  # fmt: skip
@click.option("--dialect", type=click.Choice(["ros2dds", "rmw_zenoh"]), default="ros2dds",
              show_default=True, help="How the robot speaks ROS 2 over Zenoh.")  # fmt: skip
@click.option("--fault", "faults", multiple=True, metavar="NAME[:KEY=VALUE,…]", help=HELP)
@click.option("--seed", default=0, show_default=True, help="Of noise and faults.")
@click.option("--config", type=click.Path(path_type=Path), help="The runtime's TOML file.")
@click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help="Override one key of it.")
@click.option("--record", type=click.Path(path_type=Path), help="Where the runtime records it.")
@click.option("--out", type=click.Path(path_type=Path),
              help="Default: out/SCENE-GOAL-START, -METHOD if it is another.")  # fmt: skip
@click.option(
    "--renderer", type=click.Choice(["auto", "egl", "tiny"]), default="auto", show_default=True
)
@click.pass_context
def demo_command(context: click.Context, /, **given: Any) -> None:
    """Let the robot find something in a furnished home, and tell what it does and why.

    Writes OUT/{summary.json, decisions.jsonl, map.png}. Exit status: 0 found, 1 not found,
    2 an error. With --serve the robot stays up until Ctrl-C, and does what it is asked for; what
    is kept of it is in out/serve.
    """
    if given["serves"]:
        check_served(context)
        serve(given)
    elif given["listen"]:
        raise click.UsageError("--listen goes with --serve")
    else:
        _episode(given)


def _episode(given: dict[str, Any]) -> None:
    """One search, and the exit status."""
    began_s = time.monotonic()
    goal, method, start = " ".join(given["goal"].split()), given["method"], given["start"]
    if not goal:
        raise ConfigError("goal: is empty; say what to find, e.g. --goal toilet")
    home = open_scene(given["scene"])
    judged = category_word(goal)
    instances(home, judged)  # an error that names what there is, before anything slow
    if method_named(method).driver != "runtime":
        raise ConfigError(f"method {method}: asks no runtime; `hil-sim eval` drives it")
    needed_models((method,))
    protocol = protocol_named(given["protocol"], given["tilt"], given["noise"], given["sensors"])
    protocol = replace(protocol, whole_mm=given["whole_mm"])
    faults = parse_faults(given["faults"])
    run_dir = given["out"] or default_dir(home.name, judged, start, method)
    _clear(run_dir)
    keep_stdout_for_python()
    assets = Assets()
    with ExitStack() as stack:
        assets.catalog  # noqa: B018 -- missing furniture is an error before models are loaded
        click.echo(f"loading {home.name} and the models")
        wire = _base_wire(given, stack)
        runtime = _runtime(run_dir, faults, given, wire)
        stack.callback(runtime.close)
        world = stack.enter_context(open_world(home, assets, given["renderer"]))
        stack.enter_context(runtime)
        episode, staged = _stage(world, assets, protocol, judged, start)
        setup_s = time.monotonic() - began_s
        _announce(episode, method, protocol, setup_s)
        episode = replace(episode, goal=goal)  # in the person's own words
        drive = partial(run_realtime, renderer=given["renderer"], wire=wire)
        result = (drive if given["realtime"] else run_episode)(
            episode, staged, runtime, protocol, method, run_dir, _tell, faults, given["seed"]
        )
    result = replace(result, wall={"setup": round(setup_s, 4), **result.wall})
    _finish(run_dir, result)
    if result.ended.failed:
        raise HarnessError(result.ended.why)
    sys.exit(0 if result.success else 1)


def default_dir(scene: str, goal: str, start: int, method: str) -> Path:
    """Where one search leaves its results, so that another method's do not replace them."""
    name = f"{scene}-{goal.replace(' ', '-')}-{start}"
    return Path("out") / (name if method == METHOD else f"{name}-{method.replace('/', '-')}")


def _stage(
    world: "ScenePhysics", assets: Assets, protocol: Protocol, goal: str, start: int
) -> tuple[Episode, StagedHome]:
    """An episode in this world, and the home that it is played in."""
    from hil_sim.ground_truth.truth import SceneTruth

    truth = SceneTruth(world, assets, click.echo)
    name, success = world.scene.name, truth.success(goal)
    episode = sample_episode(truth.space, success, goal, start, truth.sees(goal), name)
    return episode, home_of(world, truth, protocol, goal)


def _base_wire(given: dict[str, Any], stack: ExitStack) -> MavlinkWire | None:
    """To a base on MAVLink, where one is asked for."""
    if given["base"] == "ros2":
        return None
    if not given["realtime"]:
        raise ConfigError("--base mavlink: a stand-in drives in real time: add --realtime")
    return stack.enter_context(MavlinkWire(RoverStandIn()))


def _runtime(
    run_dir: Path, faults: tuple[Fault, ...], given: dict[str, Any], wire: MavlinkWire | None
) -> Runtime:
    """The runtime that was asked for, as it starts."""
    mode = () if given["realtime"] else ("--lockstep",)
    mode = (*mode, "--arm") if wire else mode
    if given["record"] is not None:
        mode = (*mode, "--record", str(given["record"]))
    command, more = model_fault(faults, mode)
    return Runtime(
        run_dir / "runtime.log",
        given["config"],
        (
            *given["sets"],
            *more,
            *method_named(given["method"]).start,
            *(wire.settings if wire else ()),
        ),
        command or rfnav_command(mode),
        odometry=wire is None,
        spoken=given["dialect"],
    )


def _clear(run_dir: Path) -> None:
    """Remove an earlier run's results, so that none of them is taken for this one's."""
    try:
        run_dir.mkdir(parents=True, exist_ok=True)
        for name in (SUMMARY_FILE, PICTURE_FILE, MAP_FILE, "decisions.jsonl"):
            (run_dir / name).unlink(missing_ok=True)
    except OSError as error:
        raise ConfigError(f"{run_dir}: cannot be written ({error.strerror})") from error


def _announce(episode: Episode, method: str, protocol: Protocol, setup_s: float) -> None:
    click.echo(
        f"find a {episode.goal} in {episode.scene}: {episode.shortest_path_m:.1f} m away; "
        f"method {method}, protocol {protocol.name}; ready after {setup_s:.1f} s"
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
    if state.get("mode") in (*TARGET_MODES, Mode.LOOK):
        aim = str(state["mode"])
    click.echo(f"{step.number:4}  {answer.action.value:12}  {aim:12}  {state.get('reason', '')}")


def vote_lines(decision: dict[str, Any]) -> list[str]:
    """What was decided and by which rule, what it was taken for, and who said what: a line each."""
    elected, closest = decision.get("frontier"), decision.get("closest")
    asked = decision["votes"] or decision["missing"]
    head = f"      {'vote' if asked else 'decision'} ({decision.get('why')}): "
    if elected is None:
        lines = [f"{head}no frontier can be reached"]
    else:
        rule = rule_said(str(decision.get("rule")), planned=bool(decision.get("order")))
        beside = "" if elected == closest else f"; the closest is {closest}"
        lines = [f"{head}frontier {elected}: {rule}{beside}"]
    taken = decision.get("taken")
    lines += [f"        what took it: {taken['in_words']}"] if taken else []
    said = {vote["expert"]: _voted(vote, elected) for vote in decision["votes"]}
    said |= {m["expert"]: f"does not vote: {m['cause']}" for m in decision["missing"]}
    return lines + [f"        {introduced(name)}: {what}" for name, what in sorted(said.items())]


def _voted(vote: dict[str, Any], elected: int | None) -> str:
    """Whom a vote is for, and why: for the elected frontier, else for the likeliest."""
    ids, p, reasons = vote["frontiers"], dict(vote["probabilities"]), dict(vote["reasons"])
    told = elected if elected in ids else max(ids, key=lambda id: (p.get(id, 0.0), -id))
    share = f" ({100 * p[told]:.0f} % of its belief)" if told in p else ""
    what = f"votes for {listed([str(id) for id in ids])}"
    if told != elected and elected is not None:
        what += f", not for {elected}"
    return f"{what}; for {told}{share}: {reasons.get(told, vote['reason'])}"


def _finish(run_dir: Path, result: EpisodeResult) -> None:
    text = json.dumps(result.to_json(), indent=1) + "\n"
    (run_dir / SUMMARY_FILE).write_text(text, encoding="utf-8")
    for line in final_lines(result):
        click.echo(line)
    if (run_dir / MAP_FILE).is_file():
        from hil_sim.evaluation.map_picture import draw_map

        draw_map(run_dir, run_dir / PICTURE_FILE)
    names = [SUMMARY_FILE, "decisions.jsonl", PICTURE_FILE]
    here = ", ".join(name for name in names if (run_dir / name).is_file())
    click.echo(f"{run_dir}/: {here}")


def final_lines(result: EpisodeResult) -> list[str]:
    """How it went: outcome, path, wall time by stage."""
    left = "cut off" if result.distance_m is None else f"{result.distance_m:.2f} m"
    why = f": {result.reason}{_stands(result)}" if result.reason else ""
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
        f"{result.collisions} collisions"
        + (f"; {result.fault}: ended {_standing(result)}" if result.fault else ""),
        f"wall time {total:.1f} s ({parts}) after {setup:.1f} s to set up",
    ]


def _stands(result: EpisodeResult) -> str:
    """What truly stands where it claimed a find that does not count."""
    if result.success or result.claim is Claim.NONE:
        return ""
    if not result.stands:
        return ", where nothing stands"
    things = [_with_article(name) for name in result.stands]
    return f", where {' and '.join(things)} {'stands' if len(things) == 1 else 'stand'}"


def _with_article(category: str) -> str:
    if category == "other":
        return "something without a category"
    return f"{'an' if category[0] in 'aeiou' else 'a'} {category}"


def _standing(result: EpisodeResult) -> str:
    return "standing still" if result.stopped else "on the move"
