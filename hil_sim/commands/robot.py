"""`hil-sim robot`: a simulated robot for a service that is installed."""

import math
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from hil_sim.driving.camera_process import CameraProcess
from hil_sim.driving.living_robot import NAME, LivingRobot, Mate, RobotBus
from hil_sim.driving.rig import open_world
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.faults import parse_faults
from hil_sim.simulation.mishaps import Mishaps
from hil_sim.simulation.noise import generator
from hil_sim.simulation.protocol import EXTRAS, protocol_named
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
@click.option("--fault", "faults", multiple=True, metavar="NAME[:KEY=VALUE,…]")
@click.option("--seed", default=0, show_default=True, help="Of noise and faults.")
@click.option(
    "--renderer", type=click.Choice(["auto", "egl", "tiny"]), default="auto", show_default=True
)
def robot_command(**given: Any) -> None:
    """Have a robot stand in a furnished home, look and report, and obey what comes on cmd_vel,
    until Ctrl-C. Its topics are called as in the runtime's default configuration.
    """
    protocol = protocol_named("onrobot", "level", (), given["sensors"])
    scene, faults = open_scene(given["scene"]), parse_faults(given["faults"])
    keep_stdout_for_python()
    with ExitStack() as stack:
        bus = RobotBus(given["listen"])
        stack.callback(bus.hang_up)
        world = stack.enter_context(open_world(scene, Assets(), given["renderer"]))
        camera = CameraProcess(scene, protocol, NAME, given["seed"], given["renderer"])
        stack.enter_context(camera)
        mishaps = Mishaps(faults, given["seed"], NAME, scene, world, world.populate)
        start = start_in(world, given["start"])
        robot = LivingRobot(start, Mate(world, camera, bus, mishaps, protocol), given["seed"])
        click.echo(f"a robot stands in {scene.name}; its bus is {given['listen']}; Ctrl-C ends it")
        while True:
            robot.tick()


def start_in(world: "ScenePhysics", number: int) -> Pose:
    """A free pose of a home, scene frame."""
    from hil_sim.ground_truth.truth import SceneTruth

    space = SceneTruth(world, Assets(), click.echo).space
    rng = generator(0, NAME, number, "start")
    free = space.points(np.argwhere(space.free))
    x, y = free[int(rng.integers(len(free)))]
    return Pose(float(x), float(y), float(rng.uniform(-math.pi, math.pi)))
