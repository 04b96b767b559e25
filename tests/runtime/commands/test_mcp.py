"""`rfnav mcp`: what it takes, and what it says where it cannot be."""

from typing import Any

import pytest
from click.testing import CliRunner

from runtime.__main__ import cli
from runtime.commands import mcp as module
from runtime.errors import ConfigError


def test_the_extra_is_named_where_it_is_missing(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(module, "NEEDED", ("mcp", "no_such_package"))
    done = CliRunner().invoke(cli, ["mcp"])
    assert isinstance(done.exception, ConfigError)
    told = "rfnav mcp: needs no_such_package: pip install 'rf-nav[agents]'"
    assert str(done.exception) == told


def test_its_process_takes_its_place_with_the_options(monkeypatch: pytest.MonkeyPatch):
    began: list[tuple[str, dict[str, Any]]] = []
    monkeypatch.setattr(module, "become", lambda *what: began.append(what))
    words = ["mcp", "--transport", "http", "--limit-time", "60", "--look", "--set", "a=1"]
    words += ["--limit-queue", "0"]
    assert CliRunner().invoke(cli, words).exit_code == 0
    process, told = began[0]
    assert process == "runtime.commands.mcp_process"
    assert (told["transport"], told["time_s"], told["look"]) == ("http", 60.0, True)
    assert (told["settings"], told["queue"]) == (("a=1",), 0)


@pytest.mark.parametrize(
    "words",
    [
        ["--limit-time", "0"], ["--limit-money", "-1"], ["--limit-distance", "1e9"],
        ["--limit-queue", "17"],
    ],
)  # fmt: skip
def test_limits_are_bounded(words: list[str]):
    assert CliRunner().invoke(cli, ["mcp", *words]).exit_code == 2
