"""Two lives of `rfnav run` in one home, and a third in another: what the first saw the second goes
to, once it knows where it is, though its odometry began elsewhere; the third uses nothing of it."""

import math
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from apartment import TWO_ROOMS, Apartment
from places import DOUBLES, ROOT
from robot_double import RobotDouble

from hil_sim.driving.link import free_port
from runtime.core.geometry import seen_from
from runtime.core.types import Observation, Pose
from runtime.journal import read_journal
from runtime.loops.remembering import MEMORY_FILE
from runtime.robot.session import BusConfig

pytestmark = pytest.mark.slow  # whole processes

TOILET = (7.4, 2.2, 0.3)
SETTINGS = (
    "goal.keep_map=true", "control.look_radps=1.0", "safety.plan_stale_s=5.0",
    "safety.odom_stale_s=2.0", "safety.frame_stale_s=4.0",
)  # fmt: skip
PROCESS = """
import sys
sys.path[:0] = {paths!r}
import numpy as np
from apartment import TWO_ROOMS, Apartment
from fake_models import FakeModels
from runtime import __main__, run
from runtime.core.types import Pose

class Seeing(FakeModels):
    def __init__(self, config, clock, book):
        super().__init__(Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, -0.5)))
        self.home.things = {things!r}

    def detect(self, rgb, window=None):
        self.home.pose = Pose(*np.frombuffer(rgb.tobytes()[:24]).tolist())
        return super().detect(rgb)

    def likeness(self, embeddings):
        return np.ones((len(embeddings), 1))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.panel.close()

run.LoadedModels = Seeing
__main__.main()
"""
OTHER = """
############################
#            #             #
#  ooo       #       oooo  #
#  ooo       #       oooo  #
#                          #
#                          #
#        #########         #
#        #                 #
#  o     #     oo          #
#  o     #     oo          #
#        #                 #
#        #          b      #
#   ooo  ######   ##########
#   ooo                    #
#                     ooo  #
#             oo      ooo  #
#             oo           #
#                          #
############################
"""


class Telling(Apartment):
    """Its images say where they were taken, to models that stand in for real ones."""

    def observe(self) -> Observation:
        obs = super().observe()
        told = np.array([self.pose.x_m, self.pose.y_m, self.pose.yaw_rad])
        obs.rgb.reshape(-1)[:24] = np.frombuffer(told.tobytes(), np.uint8)
        return obs


@contextmanager
def life(
    plan: str, start: Pose, state: Path, things: Mapping[str, tuple[float, float, float]]
) -> Iterator[tuple[subprocess.Popen[str], RobotDouble]]:
    """`rfnav run`, whose odometry begins where the robot stands."""
    home = Telling.of(plan, start)
    assert home.fits(start.x_m, start.y_m)
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    robot = RobotDouble(home, BusConfig(listen=(endpoint,)))
    robot.bend = lambda pose: seen_from(start, pose)
    settings = [*SETTINGS, f"bus.connect=['{endpoint}']", *robot.wire.settings]
    code = PROCESS.format(paths=[str(DOUBLES)], things=dict(things))
    child = subprocess.Popen(
        [sys.executable, "-c", code, "run", "--harness",
         *(part for setting in settings for part in ("--set", setting))],
        stderr=subprocess.PIPE, text=True, cwd=ROOT,
        env=os.environ | {"XDG_STATE_HOME": str(state), "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    robot.start()
    try:
        yield child, robot
    finally:
        child.kill()
        child.communicate()
        robot.close()


def ended(child: subprocess.Popen[str]) -> str:
    child.send_signal(signal.SIGTERM)
    _, said = child.communicate(timeout=60)
    assert child.returncode == 0, said
    return said


def memory(robot: RobotDouble) -> str:
    return str(robot.state().get("memory", ""))


def over(robot: RobotDouble) -> bool:
    return robot.state().get("state") in ("found", "not_found", "unreachable")


def test_what_one_life_saw_the_next_goes_to_and_another_home_is_none_of_it(tmp_path: Path):
    state = tmp_path / "state"
    with life(TWO_ROOMS, Pose(4.0, 3.0, -0.5), state, {"toilet": TOILET}) as (child, robot):
        robot.ask("status")
        assert robot.ask("goal", {"goal": "toilet", "log_dir": str(tmp_path / "a")})["accepted"]
        robot.until(lambda: over(robot) or child.poll() is not None, 240.0)
        assert robot.state()["state"] == "found"
        assert robot.ask("status")["memory"] == "none: it begins here"
        assert robot.ask("places", {"name": "the toilet"})["accepted"]
        ended(child)
    assert (state / "rf-nav" / MEMORY_FILE).is_file()

    start = Pose(2.0, 3.9, 2.0)
    with life(TWO_ROOMS, start, state, {}) as (child, robot):  # its models see nothing
        robot.ask("status")
        assert robot.ask("places", {"list": True})["places"] == {"the toilet": None}
        assert robot.ask("goal", {"goal": "toilet", "log_dir": str(tmp_path / "b")})["accepted"]
        robot.until(lambda: memory(robot).startswith("bound") or over(robot), 240.0)
        assert memory(robot) == "bound by the map, which is seen again"
        true = seen_from(start, Pose(*TOILET[:2], 0.0))
        robot.until(lambda: robot.state().get("mode") == "target" or over(robot), 120.0)
        going = [state for state in robot.states if state.get("mode") == "target"]
        assert going, robot.state()
        assert math.dist(going[0]["toward_xy"], (true.x_m, true.y_m)) < 1.5  # stood before
        x_m, y_m, _ = robot.ask("places", {"list": True})["places"]["the toilet"]
        assert math.dist((x_m, y_m), (true.x_m, true.y_m)) < 2.0
        ended(child)
    told = list(read_journal(tmp_path / "b" / "decisions.jsonl"))
    (taken,) = [line for line in told if line["kind"] == "memory"]
    (thing,) = taken["goal"]
    assert math.dist(thing["xy"], (true.x_m, true.y_m)) < 0.5

    before = (state / "rf-nav" / MEMORY_FILE).read_bytes()
    with life(OTHER, Pose(1.5, 3.2, 0.5), state, {}) as (child, robot):
        robot.ask("status")
        assert robot.ask("goal", {"goal": "toilet", "log_dir": str(tmp_path / "c")})["accepted"]
        robot.hears(lambda: over(robot), 40.0)
        assert memory(robot).startswith("unbound: ")
        ended(child)
    told = list(read_journal(tmp_path / "c" / "decisions.jsonl"))
    assert any(line["kind"] == "located" for line in told)
    assert not any(line["kind"] == "memory" for line in told)
    assert (state / "rf-nav" / MEMORY_FILE).read_bytes() == before
