"""The process of `rfnav mcp`: its options, and its ends."""

import http.client
import json
import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from places import ROOT

from hil_sim.driving.link import free_port
from runtime.agents.tools import AgentLimits
from runtime.commands.mcp_process import McpOptions, agent_limits
from runtime.errors import ConfigError

START_S = 120.0  # on a busy computer


def test_limits_are_as_the_options_say():
    assert agent_limits(McpOptions()) == AgentLimits()
    options = McpOptions(time_s=60.0, distance_m=5.0, money_usd=0.0, area_room="hall")
    assert agent_limits(options) == AgentLimits(60.0, 5.0, 0.0, {"room": "hall"})
    assert agent_limits(McpOptions(look=True, queue=2)) == AgentLimits(look=True, queue=2)
    with pytest.raises(ConfigError, match="one of them"):
        agent_limits(McpOptions(area_room="hall", area_place="dock"))


@pytest.mark.slow
def test_it_says_where_it_listens_and_ends_by_a_signal(tmp_path: Path):
    port = free_port()
    token = tmp_path / "token"
    token.write_text("0123456789abcdef0123")
    token.chmod(0o600)
    listen = "--transport", "http", "--listen", f"127.0.0.1:{port}", "--token-file", str(token)
    started = [sys.executable, "-m", "runtime", "mcp", *listen]
    with subprocess.Popen(started, stdout=subprocess.PIPE, cwd=ROOT) as child:
        try:
            assert child.stdout is not None
            said = child.stdout.readline().decode()
            assert said == f"clients connect to http://127.0.0.1:{port}/mcp   (Ctrl-C ends it)\n"
            assert asked(port) == 401
            child.send_signal(signal.SIGTERM)
            assert child.wait(START_S) == 0
        finally:
            child.kill()


def asked(port: int) -> int:
    """The status, once somebody answers there."""
    by_s = time.monotonic() + START_S
    while True:
        wire = http.client.HTTPConnection("127.0.0.1", port, timeout=START_S)
        try:
            wire.request("POST", "/mcp", json.dumps({}), {"Content-Type": "application/json"})
            return wire.getresponse().status
        except ConnectionError:
            assert time.monotonic() < by_s
            time.sleep(0.05)
        finally:
            wire.close()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("--transport", "http", "--listen", "0.0.0.0:8090"), "is not this computer"),
        ((), "stdin and stdout must be pipes"),
    ],
)
def test_what_cannot_be_served_is_one_line(tmp_path: Path, words: tuple[str, ...], why: str):
    file = tmp_path / "empty"
    file.touch()
    with file.open() as nothing:
        done = subprocess.run(
            [sys.executable, "-m", "runtime", "mcp", *words],
            stdin=nothing, capture_output=True, text=True, cwd=ROOT, timeout=START_S,
        )  # fmt: skip
    assert (done.returncode, done.stdout) == (2, "")
    assert why in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.slow
def test_in_a_terminal_it_says_who_starts_it():
    here, there = pty.openpty()
    try:
        done = subprocess.run(
            [sys.executable, "-m", "runtime", "mcp"],
            stdin=there, capture_output=True, text=True, cwd=ROOT, timeout=START_S,
        )  # fmt: skip
    finally:
        os.close(here)
        os.close(there)
    assert done.returncode == 2
    assert "a client starts it" in done.stderr
