"""`hil-sim soak`: goals and troubles without end for a robot beside a service."""

import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import click

from hil_sim.commands.robot import start_in
from hil_sim.driving.camera_process import CameraProcess
from hil_sim.driving.installed_service import Child, Service, Unit, check_small, put_aside
from hil_sim.driving.link import free_port
from hil_sim.driving.living_robot import NAME, LivingRobot, Mate, RobotBus
from hil_sim.driving.rig import open_world
from hil_sim.driving.soak import soak, told, wrong
from hil_sim.driving.soak_goals import Asking
from hil_sim.driving.soak_plan import PROCESS, troubles
from hil_sim.ground_truth.goals import category_word
from hil_sim.scenes.format import Scene
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.mishaps import Mishaps
from hil_sim.simulation.protocol import protocol_named
from hil_sim.simulation.quiet import keep_stdout_for_python
from runtime.errors import ConfigError


@click.command(
    "soak",
    epilog="Examples:  hil-sim soak --minutes 3   |   "
    "hil-sim soak --minutes 30 --unit rf-nav.service --within 'nsenter -t 4711 -a' "
    "--listen tcp/127.0.0.1:7447",
)
@click.option("--minutes", default=3.0, show_default=True)
@click.option("--every", default=20.0, show_default=True, help="Seconds from trouble to trouble.")
@click.option("--scene", default="maple", show_default=True, help="Bundled home, or a scene file.")
@click.option("--seed", default=0, show_default=True, help="Of troubles, goals and noise.")
@click.option("--unit", help="A unit of systemd that is up; else a child is kept running.")
@click.option("--within", default="", help="What goes before systemctl, to be in a container.")
@click.option("--state", type=click.Path(path_type=Path, exists=True),
              help="Where the unit's state is, as seen from here.")  # fmt: skip
@click.option("--full-disk", type=click.Path(path_type=Path, exists=True),
              help="A folder of it on a tmpfs, which may be filled.")  # fmt: skip
@click.option("--listen", help="The robot's bus; a free port of the loopback otherwise.")
@click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help="Of the child's.")
@click.option("--out", type=click.Path(path_type=Path), default=Path("out/soak"))
@click.option(
    "--renderer", type=click.Choice(["auto", "egl", "tiny"]), default="auto", show_default=True
)
def soak_command(**given: Any) -> None:
    """Have a robot search while its camera, odometry, link, base and service fail in turn.

    Exit status: 0 when every goal had a result, every stop came in time, memory stayed bounded and
    what was saved could be read after each start; 1 otherwise; 2 an error.
    """
    seconds = 60.0 * given["minutes"]
    if given["full_disk"] is not None:
        check_small(given["full_disk"])
    if given["unit"] and not (given["listen"] and given["state"]):
        raise ConfigError("--unit: needs --listen, where it connects to, and --state")
    state = given["state"] or given["out"].resolve() / "state"
    lacks = () if given["unit"] and given["full_disk"] is not None else ("disk-full",)
    plan = troubles(seconds, given["every"], given["seed"], lacks)
    scene, protocol = open_scene(given["scene"]), protocol_named("onrobot")
    endpoint = given["listen"] or f"tcp/127.0.0.1:{free_port()}"
    keep_stdout_for_python()
    with ExitStack() as stack:
        bus = RobotBus(endpoint)
        stack.callback(bus.hang_up)
        world = stack.enter_context(open_world(scene, Assets(), given["renderer"]))
        camera = CameraProcess(scene, protocol, NAME, given["seed"], given["renderer"])
        stack.enter_context(camera)
        faults = tuple(one.fault() for one in plan if one.name not in PROCESS)
        mishaps = Mishaps(faults, given["seed"], NAME, scene, world, world.populate)
        start = start_in(world, given["seed"])
        service = _service(given, endpoint, state, stack)
        asking = Asking(endpoint, _goals(scene), given["seed"])
        asking.start()
        robot = LivingRobot(start, Mate(world, camera, bus, mishaps, protocol), given["seed"])
        try:
            watch, memory = soak(robot, service, plan, seconds, click.echo)
        finally:
            _outlive(robot, asking)
        broken = put_aside(state)
        for why, times in asking.refused.most_common():
            click.echo(f"refused {times} times: {why}")
        lost = len(asking.lost)
        for row in told(watch, memory, asking.results, lost, broken):
            click.echo(row)
        sys.exit(1 if wrong(watch, memory, lost, broken) else 0)


def _service(given: dict[str, Any], endpoint: str, state: Path, stack: ExitStack) -> Service:
    if given["unit"]:
        return Unit(given["unit"], given["within"].split(), given["full_disk"])
    state.mkdir(parents=True, exist_ok=True)
    command = ["/usr/bin/env", f"XDG_STATE_HOME={state}", sys.executable, "-m", "runtime", "run"]
    command += ["--set", f'bus.connect=["{endpoint}"]']
    for setting in given["sets"]:
        command += ["--set", setting]
    child = Child(command, given["out"] / "rfnav.log")
    stack.callback(child.close)
    return child


def _goals(scene: Scene) -> list[str]:
    """What there is in a home, in a person's words; and one thing that there is not."""
    return [*sorted({category_word(thing.category) for thing in scene.objects}), "surfboard"]


def _outlive(robot: LivingRobot, asking: Asking) -> None:
    """Live on until the last goal has its result."""
    asking.leave()
    while asking.is_alive():
        robot.tick()
