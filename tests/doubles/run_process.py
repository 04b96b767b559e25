"""`rfnav run` as a process, with models that need no files, beside a robot in the flat-land
apartment."""

import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from apartment import Apartment
from places import DOUBLES, ROOT
from robot_double import RobotDouble

from hil_sim.driving.link import free_port
from hil_sim.driving.robot_wire import Spoken
from runtime.robot.session import BusConfig

PROCESS = """
import sys
sys.path[:0] = {paths!r}
import pytest
from apartment import TWO_ROOMS, Apartment
from fake_models import FakeModels
from runtime import __main__, run
from runtime.core import world
from runtime.core.types import Pose

world.FIRST_LOOKS = 1

class FailingModels(FakeModels):
    def __init__(self, config, clock, book):
        super().__init__(Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, -0.5)))
        self.left = {frames}

    def detect(self, rgb, window=None):
        self.left -= 1
        if self.left < 0:
            raise KeyError("what the camera saw")
        return super().detect(rgb)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.panel.close()

run.LoadedModels = FailingModels
__main__.main()
"""


@contextmanager
def process(
    home: Apartment,
    frames: int,
    *settings: str,
    env: Mapping[str, str] = os.environ,
    spoken: Spoken = "ros2dds",
    odom_hz: float = 20.0,
    harness: bool = True,
) -> Iterator[tuple[subprocess.Popen[str], RobotDouble]]:
    """`rfnav run` with models that fail after so many frames; without `harness` as on a robot."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    robot = RobotDouble(home, BusConfig(listen=(endpoint,)), odom_hz, spoken=spoken)
    code = PROCESS.format(paths=[str(DOUBLES)], frames=frames)
    given = [*settings, f"bus.connect=['{endpoint}']", *robot.wire.settings]
    arguments = [part for setting in given for part in ("--set", setting)]
    child = subprocess.Popen(
        [sys.executable, "-c", code, "run", *(["--harness"] if harness else []), *arguments],
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env=dict(env),
    )
    robot.start()
    try:
        yield child, robot
    finally:
        child.kill()
        child.communicate()
        robot.close()
