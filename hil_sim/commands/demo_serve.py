"""`hil-sim demo --serve`: a robot that stays up in a furnished home, and the runtime that drives
it, for whoever wants to try the commands without a robot."""

import signal
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from threading import Event
from types import FrameType
from typing import Any, Final

import click

from hil_sim.commands.robot import living_in
from hil_sim.driving.living_robot import LivingRobot
from hil_sim.driving.served import CONFIG, LOG, STATE, Served, served_command
from hil_sim.ground_truth.goals import category_word
from hil_sim.scenes.format import Scene
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.faults import parse_faults
from hil_sim.simulation.protocol import protocol_named
from hil_sim.simulation.quiet import keep_stdout_for_python
from runtime.errors import BusError, ConfigError
from runtime.robot.session import DEFAULT_LISTEN

NOT_SERVED: Final = ("goal", "method", "protocol", "realtime", "base", "dialect")
"""Options of an episode alone."""
SIGNALS: Final = (signal.SIGTERM, signal.SIGINT)
WORTH_A_LOOK: Final = "toilet"


def check_served(context: click.Context) -> None:
    """UsageError for options that say nothing of a robot that stays up."""
    for name in NOT_SERVED:
        if context.get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE:
            raise click.UsageError(f"--{name} is of one episode: it does not go with --serve")


def serve(given: Mapping[str, Any]) -> None:
    """Until Ctrl-C or SIGTERM, which end both; HarnessError when the runtime ends before."""
    shown = given["out"] or Path("out/serve")
    folder = shown.resolve()
    endpoint = given["listen"] or DEFAULT_LISTEN[0]
    scene, faults = open_scene(given["scene"]), parse_faults(given["faults"])
    if wrong := [fault.name for fault in faults if fault.kind.model]:
        raise ConfigError(f"--fault {wrong[0]}: is a model's: it does not go with --serve")
    protocol = protocol_named("onrobot", given["tilt"], given["noise"], given["sensors"])
    protocol = replace(protocol, whole_mm=given["whole_mm"])
    config = _prepared(folder, endpoint)
    recorded = ("--record", str(given["record"])) if given["record"] is not None else ()
    settings = (*protocol.settings, *given["sets"])
    command = served_command(folder / STATE, endpoint, given["config"], settings, recorded)
    keep_stdout_for_python()
    _on_signals(_interrupt)  # also where a shell has them ignored
    click.echo(f"loading {scene.name} and the models; the runtime's log: {shown / LOG}")
    with ExitStack() as stack:
        try:
            robot = living_in(scene, protocol, given, endpoint, stack)
        except BusError as error:
            raise BusError(f"{error}; --listen tcp/127.0.0.1:PORT names another") from error
        served = Served(command, endpoint, shown / LOG)
        stack.callback(served.kill)
        ended = Event()
        _on_signals(partial(_end, ended))
        _live(robot, served, _ready_line(scene, endpoint, config), ended)
        click.echo("ending", err=True)
        served.close(robot.tick)


def _live(robot: LivingRobot, served: Served, ready_line: str, ended: Event) -> None:
    told = False
    while not ended.is_set():
        robot.tick()
        served.check()
        if served.ready.is_set() and not told:
            told = True
            click.echo(ready_line)


def _ready_line(scene: Scene, endpoint: str, config: Path) -> str:
    goals = {category_word(thing.category) for thing in scene.objects}
    goal = WORTH_A_LOOK if WORTH_A_LOOK in goals else min(goals, default=WORTH_A_LOOK)
    named = "" if endpoint == DEFAULT_LISTEN[0] else f" --config {config}"
    return (
        f"ready in {scene.name}, on {endpoint}; type in another terminal: "
        f'rfnav find "{goal}"{named}; Ctrl-C here ends both'
    )


def _prepared(folder: Path, endpoint: str) -> Path:
    """The folder, and in it a configuration by which commands find this bus."""
    path = folder / CONFIG
    try:
        (folder / STATE).mkdir(parents=True, exist_ok=True)
        path.write_text(f'[bus]\nconnect = ["{endpoint}"]\n', encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"{folder}: cannot be written ({error.strerror})") from error
    return path


def _on_signals(handler: Callable[[int, FrameType | None], None]) -> None:
    for number in SIGNALS:
        signal.signal(number, handler)


def _interrupt(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt


def _end(ended: Event, number: int, frame: FrameType | None) -> None:
    """After a tick, in the midst of which may be a message of the camera's; the second time at
    once."""
    if ended.is_set():
        raise KeyboardInterrupt
    ended.set()
