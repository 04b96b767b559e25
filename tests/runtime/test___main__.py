"""The command line, of which each command is imported when it is asked for."""

import subprocess
import sys

import click
import pytest
from click.testing import CliRunner
from places import ROOT

from runtime.__main__ import MODULES, cli


@pytest.mark.parametrize("name", sorted(MODULES))
def test_each_command_is_where_it_is_said_to_be(name: str):
    command = cli.get_command(click.Context(cli), name)
    assert command is not None
    assert command.name == name
    assert command.help or command.short_help


def test_one_that_is_none_is_told():
    result = CliRunner().invoke(cli, ["fnd"])
    assert result.exit_code == 2
    assert "No such command 'fnd'" in result.output


@pytest.mark.parametrize("name", ["find", "status", "mqtt", "where", "map"])
def test_who_asks_a_service_has_no_models_and_no_loop(name: str):
    code = f"""
import sys
from runtime.__main__ import cli
try:
    cli(["{name}", "--help"])
except SystemExit:
    print(*sys.modules)
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True
    )
    loaded = set(done.stdout.split())
    assert "runtime.commands.running" in loaded
    heavy = {"onnxruntime", "runtime.run", "runtime.loops.realtime", "runtime.perception.detection"}
    assert not heavy & loaded
