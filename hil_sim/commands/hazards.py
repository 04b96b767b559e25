"""`hil-sim hazards`: what steps in front of a robot at speed, and whether it is touched."""

import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from hil_sim.commands.hazard_table import TrialsFile, Tried, line, table
from hil_sim.driving.hazard_trials import SIZES, SLOWEST_MPS, HazardTrials
from hil_sim.driving.hazards import run_hazards
from hil_sim.driving.link import HarnessError, Runtime, rfnav_command
from hil_sim.driving.methods import method_named, needed_models
from hil_sim.driving.other_runtime import OtherRuntime, commit
from hil_sim.driving.rig import home_of, open_world
from hil_sim.ground_truth.episodes import sample_episode
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.protocol import EXTRAS, DifferentialDrive, protocol_named
from hil_sim.simulation.quiet import keep_stdout_for_python
from runtime.core.motion.courses import ControlConfig
from runtime.errors import ConfigError

if TYPE_CHECKING:  # PyBullet prints when it is imported
    from hil_sim.ground_truth.truth import SceneTruth

EMPTY = 3  # searches without a trial, after which a home has no room for any
THIS = "this"
HOW = ("kinds", "speed", "ahead", "tilt_deg", "noise", "sensors", "scene", "goal", "method", "sets",
       "seed")  # fmt: skip


@click.command(
    "hazards",
    epilog="Examples:  hil-sim hazards   |   hil-sim hazards --trials 5 --speed 0.4 --what leg   |"
    "   hil-sim hazards --ahead 0.1 0.4 --against HEAD~3   |   "
    "hil-sim hazards --tilt-deg 30 --sensor laser --sensor bumper --json hazards.json",
)
@click.option("--what", "kinds", multiple=True, type=click.Choice(list(SIZES)),
              help="Default: all.")  # fmt: skip
@click.option("--trials", default=50, show_default=True, type=click.IntRange(1),
              help="Of each.")  # fmt: skip
@click.option("--speed", type=click.FloatRange(SLOWEST_MPS, 2.0), default=0.5, show_default=True,
              help="The fastest, m/s: each search has one of its own, from "
                   f"{SLOWEST_MPS} on, by the seed.")  # fmt: skip
@click.option("--ahead", nargs=2, type=click.FloatRange(0.02, 3.0), default=(0.5, 1.5),
              show_default=True,
              help="From the body's rim, m: the least and the most.")  # fmt: skip
@click.option("--tilt-deg", default=0.0, show_default=True, help="How far the camera looks down.")
@click.option("--noise", multiple=True, metavar="NAME=SIZE", help="Other than onrobot's.")
@click.option("--sensor", "sensors", multiple=True, type=click.Choice(EXTRAS))
@click.option("--scene", default="maple", show_default=True, help="Bundled home, or a scene file.")
@click.option("--goal", default="toilet", show_default=True, help="What it looks for meanwhile.")
@click.option("--method", default="rfnav", show_default=True)
@click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help="Of the runtime.")
@click.option("--against", metavar="REV", help="The same with the runtime of that commit, too.")
@click.option("--seed", default=0, show_default=True)
@click.option("--out", type=click.Path(path_type=Path), default=Path("out/hazards"))
@click.option("--renderer", type=click.Choice(["auto", "egl", "tiny"]), default="auto")
@click.option("--json", "json_file", type=click.Path(path_type=Path),
              help="Every trial; of a file that is there already only what it lacks is driven.",
              )  # fmt: skip
def hazards_command(**given: Any) -> None:
    """Put boxes, legs and people 0.5 to 1.5 m ahead of a robot that searches in real time.

    Exit status: 0 nothing was touched that was in view and could be braked for, 1 something was,
    2 an error.
    """
    given["kinds"] = given["kinds"] or tuple(SIZES)
    if method_named(given["method"]).driver != "runtime":
        raise ConfigError(f"method {given['method']}: asks no runtime")
    needed_models((given["method"],))
    keep_stdout_for_python()
    given["out"].mkdir(parents=True, exist_ok=True)
    how = {name: given[name] for name in HOW}
    file = TrialsFile(given["json_file"], how)
    camera = f"{given['tilt_deg']:g}° down" if given["tilt_deg"] else "level"
    camera = ", ".join([camera, *given["sensors"]])
    found = {
        runtime: HazardTrials(given["trials"], given["kinds"], given["seed"], given["ahead"],
                              ControlConfig().brake_mps2, file.of(runtime))
        for runtime in (THIS, given["against"]) if runtime
    }  # fmt: skip
    tried = {
        name: Tried(name, camera, trials.brake_mps2, trials.done) for name, trials in found.items()
    }
    try:
        for runtime, trials in found.items():
            _Trying(given, runtime, trials, file).drive()
    finally:  # what was tried is told, whatever ended it
        for row in table(tried.values()):
            click.echo(row)
    raise click.exceptions.Exit(1 if tried[THIS].hit() else 0)


class _Trying:
    """As many searches with a runtime as its trials take."""

    def __init__(
        self, given: dict[str, Any], runtime: str, trials: HazardTrials, file: TrialsFile
    ) -> None:
        self._given, self._name, self._trials, self._file = given, runtime, trials, file
        top_mps, method = given["speed"], method_named(given["method"])
        protocol = protocol_named("onrobot", "level", given["noise"], given["sensors"])
        base = DifferentialDrive(speed_mps=max(top_mps, DifferentialDrive().speed_mps))
        tilt_rad = math.radians(given["tilt_deg"])
        self._protocol = replace(protocol, tilt_rad=tilt_rad, base=base)
        told = f"control.max_speed_mps={top_mps!r}", f"camera.pitch_rad={tilt_rad!r}"
        self._settings = (*given["sets"], *method.start, *told)

    def drive(self) -> None:
        """Until all is done; HarnessError where a home has no room for it."""
        if self._trials.next_kind() is None:
            return
        given = self._given
        with ExitStack() as stack:
            runtime = stack.enter_context(self._runtime())
            world = open_world(open_scene(given["scene"]), Assets(), given["renderer"])
            stack.enter_context(world)
            from hil_sim.ground_truth.truth import SceneTruth

            truth = SceneTruth(world, Assets(), click.echo)
            home = home_of(world, truth, self._protocol, given["goal"])
            self._search(lambda speed, search: run_hazards(
                self._episode(truth, world.scene.name, search), home, runtime, self._protocol,
                given["method"], given["out"] / f"{self._name}-{search}", self._trials, speed,
                search, given["renderer"],
            ))  # fmt: skip

    def _search(self, run: Callable[[float, int], None]) -> None:
        trials, empty = self._trials, 0
        search = max((trial.search + 1 for trial in trials.done), default=0)
        while trials.next_kind() is not None:
            before = len(trials.done)
            rng = np.random.default_rng([trials.seed, search])
            speed = round(float(rng.uniform(SLOWEST_MPS, self._given["speed"])), 2)
            run(speed, search)
            self._file.keep(self._name, trials.done[before:])
            for trial in trials.done[before:]:
                click.echo(line(trial))
            empty = 0 if len(trials.done) > before else empty + 1
            if empty >= EMPTY:
                scene = self._given["scene"]
                raise HarnessError(
                    f"{scene}: {EMPTY} searches without room for a trial: another --scene"
                )
            search += 1

    def _episode(self, truth: "SceneTruth", scene: str, number: int) -> Any:
        goal = self._given["goal"]
        success = truth.success(goal)
        return sample_episode(truth.space, success, goal, number, truth.sees(goal), scene)

    @contextmanager
    def _runtime(self) -> Iterator[Runtime]:
        """Ready for goals, and ended in the end."""
        log = self._given["out"] / f"{self._name}.log"
        with ExitStack() as stack:
            if self._name == THIS:
                runtime = Runtime(log, None, self._settings, rfnav_command(()))
            else:
                root = stack.enter_context(commit(self._name))
                runtime = OtherRuntime(root, log, self._settings)
            stack.callback(runtime.close)
            yield stack.enter_context(runtime)
