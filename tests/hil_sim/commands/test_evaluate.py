"""What `hil-sim eval --help` names is all that there is, and what takes faults names those."""

import click
import pytest

from hil_sim.commands.demo import demo_command
from hil_sim.commands.evaluate import eval_command
from hil_sim.commands.robot import robot_command
from hil_sim.ground_truth.episodes import known_suites
from hil_sim.simulation.faults import KINDS


def help_of(command: click.Command, option: str) -> str:
    [found] = [p for p in command.params if option in p.opts]
    assert isinstance(found, click.Option)
    return found.help or ""


def test_the_help_names_every_suite() -> None:
    told = help_of(eval_command, "--suite")
    assert "smoke" in known_suites()
    assert [name for name in known_suites() if name not in told] == []


@pytest.mark.parametrize("command", [eval_command, demo_command, robot_command])
def test_the_help_names_every_fault(command: click.Command) -> None:
    told = help_of(command, "--fault")
    assert [name for name in KINDS if name not in told] == []
