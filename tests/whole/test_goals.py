"""`rfnav run` and the commands that people type beside it, each a process of its own."""

import os
import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from apartment import TWO_ROOMS, Apartment
from places import ROOT
from run_process import process

from hil_sim.driving.link import free_port
from runtime.commands.running import running
from runtime.core.types import Pose
from runtime.robot.session import BusConfig

CALM = (
    "control.look_radps=1.0", "safety.plan_stale_s=5.0", "safety.odom_stale_s=2.0",
    "safety.frame_stale_s=4.0", "panel.experts=[]",
)  # fmt: skip
BEGUN = re.compile(r"^([0-9a-f]{8}): ", re.MULTILINE)


class Person:
    """Types commands for the runtime on that port."""

    def __init__(self, port: int) -> None:
        self.end = f"tcp/127.0.0.1:{port}"
        self.bus = f"bus.listen=['{self.end}']"

    def begin(self, *words: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "runtime", *words, "--set", self.bus]
        pipe = subprocess.PIPE
        return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, cwd=ROOT)

    def types(self, *words: str, status: int = 0) -> str:
        with self.begin(*words) as child:
            out, error = child.communicate(timeout=60)
        assert child.returncode == status, (words, out, error)
        return out

    def status(self) -> dict[str, Any]:
        with running(BusConfig(listen=(self.end,))) as runtime:
            return runtime.ask("status", {})


def moves(robot: Any) -> bool:
    return robot.twist.v_mps > 0.05 or abs(robot.twist.w_radps) > 0.05


def stands(robot: Any) -> bool:
    return robot.twist.v_mps == robot.twist.w_radps == 0.0


@pytest.mark.slow
def test_a_person_asks_pauses_goes_on_cancels_and_a_goal_outlives_the_service(tmp_path: Path):
    there = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, -0.5))
    env = os.environ | {"XDG_STATE_HOME": str(tmp_path)}
    port = free_port()
    person = Person(port)
    given: Sequence[str] = (*CALM, person.bus, "goal.after_restart=resume")
    with process(there, 10_000, *given, env=env, harness=False) as (child, robot):
        robot.until(lambda: robot.states and robot.state()["runtime"]["state"] == "ready", 60.0)

        timed = person.begin("find", "a red mug", "--limit-time", "3")
        out, progress = timed.communicate(timeout=60)
        assert timed.returncode == 1
        assert re.search(r'^"a red mug" ran out of time; [\d.]+ m2 of floor', out, re.M), out
        assert "s, " in progress
        robot.until(lambda: stands(robot))

        [first] = BEGUN.findall(person.types("find", "bed", "--no-wait"))
        robot.until(lambda: moves(robot))
        assert person.types("pause") == f"{first}: paused\n"
        robot.until(lambda: stands(robot) and robot.state()["runtime"]["state"] == "paused")
        second, third = BEGUN.findall(
            person.types("find", "a sofa, then a vase", "--queue", "--no-wait")
        )
        assert person.types("resume") == f"{first}: goes on\n"
        robot.until(lambda: moves(robot))
        assert [goal["id"] for goal in person.status()["queue"]] == [second, third]
        assert person.types("cancel", third) == f"cancelled: {third}\n"
        child.kill()
    with process(there, 10_000, *given, env=env, harness=False) as (child, robot):
        robot.until(lambda: moves(robot), 60.0)
        assert person.status()["id"] == first
        waiting = person.begin("find", "a lamp", "--queue")
        assert '"bed" was cancelled' in person.types("cancel", first)
        robot.until(lambda: robot.feedback and robot.feedback[-1]["id"] == second)
        robot.until(lambda: len(person.status()["queue"]) == 1)
        assert "cancelled" in person.types("cancel")
        out, _ = waiting.communicate(timeout=60)
        assert waiting.returncode == 1
        assert '"a lamp" was cancelled: rfnav cancel' in out
        assert person.types("pause", status=1) == ""
        robot.until(lambda: stands(robot))
        child.terminate()
        assert child.wait(timeout=60) == 0
