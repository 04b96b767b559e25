"""`hil-sim robot`: a simulated robot for a service that is installed."""

import math
from collections.abc import Mapping
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from hil_sim.driving.camera_process import CameraProcess
from hil_sim.driving.living_robot import NAME, LivingRobot, Mate, RobotBus
from hil_sim.driving.rig import open_world
from hil_sim.scenes.format import Scene
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.faults import HELP, parse_faults
from hil_sim.simulation.mishaps import Mishaps
from hil_sim.simulation.noise import generator
from hil_sim.simulation.protocol import EXTRAS, Protocol, protocol_named
from hil_sim.simulation.quiet import keep_stdout_for_python
from runtime.core.types import Pose

if TYPE_CHECKING:  # PyBullet prints when it is imported
    from hil_sim.simulation.scene_physics import ScenePhysics


@click.command(
    "robot",
    epilog="Example:  hil-sim robot --scene maple    and beside it:  "
    "rfnav run --set 'bus.connect=[\"tcp/127.0.0.1:7447\"]'",
)
@click.option("--scene", default="maple", show_default=True, help="Bundled home, or a scene file.")
@click.option("--start", default=0, show_default=True, help="Which of the random start poses.")
@click.option("--listen", default="tcp/127.0.0.1:7447", show_default=True, help="Its bus.")
@click.option("--sensor", "sensors", multiple=True, type=click.Choice(EXTRAS))
@click.option("--fault", "faults", multiple=True, metavar="NAME[:KEY=VALUE,…]", help=HELP)
@click.option("--seed", default=0, show_default=True, help="Of noise and faults.")
@click.option(
    "--renderer", type=click.Choice(["auto", "egl", "tiny"]), default="auto", show_default=True
)
def robot_command(**given: Any) -> None:
    """Have a robot stand in a furnished home, look and report, and obey what comes on cmd_vel,
    until Ctrl-C. Its topics are called as in the runtime's default configuration.
    """
    protocol = protocol_named("onrobot", "level", (), given["sensors"])
    scene = open_scene(given["scene"])
    keep_stdout_for_python()
    with ExitStack() as stack:
        robot = living_in(scene, protocol, given, given["listen"], stack)
        click.echo(f"a robot stands in {scene.name}; its bus is {given['listen']}; Ctrl-C ends it")
        while True:
            robot.tick()


def living_in(
    scene: Scene, protocol: Protocol, given: Mapping[str, Any], endpoint: str, stack: ExitStack
) -> LivingRobot:
    """A robot in a home, on a bus of its own. `given`: faults, seed, start and renderer, as a
    command has them."""
    faults, seed, renderer = parse_faults(given["faults"]), given["seed"], given["renderer"]
    bus = RobotBus(endpoint)
    stack.callback(bus.hang_up)
    world = stack.enter_context(open_world(scene, Assets(), renderer))
    camera = stack.enter_context(CameraProcess(scene, protocol, NAME, seed, renderer))
    mishaps = Mishaps(faults, seed, NAME, scene, world, world.populate)
    start = start_in(world, given["start"])
    return LivingRobot(start, Mate(world, camera, bus, mishaps, protocol), seed)


def start_in(world: "ScenePhysics", number: int) -> Pose:
    """A free pose of a home, scene frame."""
    from hil_sim.ground_truth.truth import SceneTruth

    space = SceneTruth(world, Assets(), click.echo).space
    rng = generator(0, NAME, number, "start")
    free = space.points(np.argwhere(space.free))
    x, y = free[int(rng.integers(len(free)))]
    return Pose(float(x), float(y), float(rng.uniform(-math.pi, math.pi)))
