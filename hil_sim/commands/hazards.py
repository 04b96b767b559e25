"""`hil-sim hazards`: what steps in front of a robot at speed, and whether it is touched."""

import json
import math
import statistics
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hil_sim.driving.hazards import SIZES, HazardTrial, HazardTrials, run_hazards
from hil_sim.driving.link import HarnessError, Runtime, rfnav_command
from hil_sim.driving.methods import method_named, needed_models
from hil_sim.driving.rig import home_of, open_world
from hil_sim.ground_truth.episodes import sample_episode
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.protocol import EXTRAS, DifferentialDrive, Protocol, protocol_named
from hil_sim.simulation.quiet import keep_stdout_for_python
from runtime.core.motion.courses import ControlConfig
from runtime.errors import ConfigError

if TYPE_CHECKING:  # PyBullet prints when it is imported
    from hil_sim.simulation.scene_physics import ScenePhysics

EMPTY = 3  # episodes without a trial, after which a home has no room for any
HEADER = (
    "| what | camera | speed up to | trials | in view, braking allows | of those touched | "
    "others | of those touched | zero after: median, max | after it was shown | "
    "on again: median, max |",
    "|---|---|---|---|---|---|---|---|---|---|---|",
)


@click.command(
    "hazards",
    epilog="Examples:  hil-sim hazards   |   hil-sim hazards --trials 5 --speed 0.4 --what leg   |"
    "   hil-sim hazards --tilt-deg 30 --sensor laser --sensor bumper --json hazards.json",
)
@click.option("--what", "kinds", multiple=True, type=click.Choice(list(SIZES)),
              help="Default: all.")  # fmt: skip
@click.option("--trials", default=50, show_default=True, type=click.IntRange(1),
              help="Of each, at each speed.")  # fmt: skip
@click.option("--speed", "speeds", multiple=True, type=click.FloatRange(0.05, 2.0),
              default=(0.2, 0.4), show_default=True, help="control.max_speed_mps.")  # fmt: skip
@click.option("--tilt-deg", default=0.0, show_default=True, help="How far the camera looks down.")
@click.option("--noise", multiple=True, metavar="NAME=SIZE", help="Other than onrobot's.")
@click.option("--sensor", "sensors", multiple=True, type=click.Choice(EXTRAS))
@click.option("--scene", default="maple", show_default=True, help="Bundled home, or a scene file.")
@click.option("--goal", default="toilet", show_default=True, help="What it looks for meanwhile.")
@click.option("--method", default="rfnav", show_default=True)
@click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help="Of the runtime.")
@click.option("--seed", default=0, show_default=True)
@click.option("--out", type=click.Path(path_type=Path), default=Path("out/hazards"))
@click.option("--renderer", type=click.Choice(["auto", "egl", "tiny"]), default="auto")
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="Every trial as JSON.")
def hazards_command(**given: Any) -> None:
    """Put boxes, legs and people 0.5 to 1.5 m ahead of a robot that searches in real time.

    Exit status: 0 nothing was touched that was in view and could be braked for, 1 something was,
    2 an error.
    """
    method, kinds = given["method"], given["kinds"] or tuple(SIZES)
    if method_named(method).driver != "runtime":
        raise ConfigError(f"method {method}: asks no runtime")
    needed_models((method,))
    protocol = protocol_named("onrobot", "level", given["noise"], given["sensors"])
    protocol = replace(protocol, tilt_rad=math.radians(given["tilt_deg"]))
    keep_stdout_for_python()
    brake_mps2 = ControlConfig().brake_mps2
    found = {s: HazardTrials(given["trials"], kinds, given["seed"]) for s in given["speeds"]}
    try:
        for speed, trials in found.items():
            _drive(given, protocol, speed, trials)
    finally:  # what was tried is told, whatever ended it
        done = {speed: trials.done for speed, trials in found.items()}
        _tell(done, given["tilt_deg"], brake_mps2, given["json_file"])
    hit = any(t.touched and t.avoidable(brake_mps2) for of_it in done.values() for t in of_it)
    raise click.exceptions.Exit(1 if hit else 0)


def _tell(
    found: dict[float, list[HazardTrial]], tilt_deg: float, brake_mps2: float, file: Path | None
) -> None:
    for line in table(found, tilt_deg, brake_mps2):
        click.echo(line)
    if file is not None:
        told = [{"speed_mps": s, **asdict(t)} for s, done in found.items() for t in done]
        file.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")


def table(
    found: dict[float, list[HazardTrial]], tilt_deg: float, brake_mps2: float
) -> Iterable[str]:
    """By speed, the trials of it -> the table's lines."""
    yield from HEADER
    camera = f"{tilt_deg:g}° down" if tilt_deg else "level"
    for speed, done in found.items():
        for kind in dict.fromkeys(trial.kind for trial in done):
            of_it = [trial for trial in done if trial.kind == kind]
            sure = [trial for trial in of_it if trial.avoidable(brake_mps2)]
            others = [trial for trial in of_it if not trial.avoidable(brake_mps2)]
            figures = [
                kind, camera, f"{speed:g} m/s", len(of_it), len(sure), _touched(sure), len(others),
                _touched(others), _spread([t.zero_s for t in sure]),
                _spread([t.shown_zero_s for t in sure]), _spread([t.resumed_s for t in of_it]),
            ]  # fmt: skip
            yield f"| {' | '.join(map(str, figures))} |"


def _touched(trials: Sequence[HazardTrial]) -> int:
    return sum(trial.touched for trial in trials)


def _spread(times: Iterable[float | None]) -> str:
    known = [time for time in times if time is not None]
    return f"{statistics.median(known):.2f}, {max(known):.2f} s" if known else "-"


def _drive(given: dict[str, Any], protocol: Protocol, speed: float, trials: HazardTrials) -> None:
    """As many episodes as the trials take."""
    home, assets, out = open_scene(given["scene"]), Assets(), given["out"]
    base = DifferentialDrive(speed_mps=max(speed, DifferentialDrive().speed_mps))
    started = method_named(given["method"]).start
    settings = (*given["sets"], *started, f"control.max_speed_mps={speed!r}",
                f"camera.pitch_rad={protocol.tilt_rad!r}")  # fmt: skip
    protocol = replace(protocol, base=base)
    with ExitStack() as stack:
        runtime = Runtime(out / "runtime.log", None, settings, rfnav_command(()))
        stack.callback(runtime.close)
        world = stack.enter_context(open_world(home, assets, given["renderer"]))
        stack.enter_context(runtime)
        _episodes(given, protocol, speed, trials, runtime, world, assets)


def _episodes(
    given: dict[str, Any],
    protocol: Protocol,
    speed: float,
    trials: HazardTrials,
    runtime: Runtime,
    world: "ScenePhysics",
    assets: Assets,
) -> None:
    from hil_sim.ground_truth.truth import SceneTruth

    truth = SceneTruth(world, assets, click.echo)
    goal, name, start, empty = given["goal"], world.scene.name, 0, 0
    while trials.next_kind() is not None:
        before = len(trials.done)
        success = truth.success(goal)
        episode = sample_episode(truth.space, success, goal, start, truth.sees(goal), name)
        run_hazards(
            episode, home_of(world, truth, protocol, goal), runtime, protocol, given["method"],
            given["out"] / f"{speed:g}-{start}", trials, speed, given["renderer"],
        )  # fmt: skip
        for trial in trials.done[before:]:
            click.echo(_line(trial))
        empty = 0 if len(trials.done) > before else empty + 1
        if empty >= EMPTY:
            raise HarnessError(
                f"{name}: {EMPTY} searches without room for a trial: another --scene"
            )
        start += 1


def _line(trial: HazardTrial) -> str:
    zero = f"zero after {trial.zero_s:.2f} s" if trial.zero_s is not None else "no zero"
    end = "touched" if trial.touched else "not touched"
    return (
        f"{trial.kind} {trial.high_m:g} m high, {trial.ahead_m:.2f} m ahead at {trial.v_mps:.2f} "
        f"m/s, {trial.pixels} px: {zero}, {end}, {trial.gap_m:.2f} m apart"
    )
