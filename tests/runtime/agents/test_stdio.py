"""The protocol on stdin and stdout, of the command itself: the SDK's own client, and hostile
ones."""

import asyncio
import json
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from typing import Any

import pytest
from agent_client import facts, until
from agent_service import AgentService
from mcp import Client
from mcp.client.stdio import StdioServerParameters
from places import ROOT

from runtime.agents.stdio import LINE_BYTES, InputLines

START = {
    "jsonrpc": "2.0", "id": 0, "method": "initialize",
    "params": {"protocolVersion": "2025-06-18", "capabilities": {},
               "clientInfo": {"name": "test", "version": "1"}},
}  # fmt: skip


def command(service: AgentService) -> list[str]:
    return ["-m", "runtime", "mcp", "--set", f"bus.listen=['{service.end}']"]


class Wire:
    """The command, spoken to by hand. `said`: what it said, by id."""

    def __init__(self, service: AgentService) -> None:
        self.process = subprocess.Popen(
            [sys.executable, *command(service)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            cwd=ROOT,
        )
        self.said: dict[Any, dict[str, Any]] = {}
        self.stray = list[bytes]()
        self.deaf = threading.Event()
        self.reading = threading.Thread(target=self._read, daemon=True)
        self.reading.start()

    def say(self, message: dict[str, Any]) -> None:
        self.raw(json.dumps(message).encode() + b"\n")

    def raw(self, line: bytes) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(line)
        self.process.stdin.flush()

    def call(self, id: int, tool: str, **asked: Any) -> None:
        params = {"name": tool, "arguments": asked}
        self.say({"jsonrpc": "2.0", "id": id, "method": "tools/call", "params": params})

    def end(self) -> int:
        assert self.process.stdin is not None
        self.process.stdin.close()
        return self.process.wait(20.0)

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            if self.deaf.is_set():
                self.process.stdout.close()
                return
            try:
                told = json.loads(line)
                self.said[told.get("id")] = told
            except ValueError:
                self.stray.append(line)


@pytest.fixture
def wire(service: AgentService) -> Iterator[Wire]:
    wire = Wire(service)
    wire.say(START)
    until_patiently(lambda: 0 in wire.said)
    wire.say({"jsonrpc": "2.0", "method": "notifications/initialized"})
    with wire.process:  # closes its pipes
        yield wire
        wire.process.kill()
        wire.reading.join(20.0)


def until_patiently(what: Any) -> None:
    """A process that is started on a busy computer takes its time."""
    for _ in range(3):
        try:
            return until(what)
        except AssertionError:
            continue
    return until(what)


@pytest.mark.slow
def test_the_clients_own_command_finds_something(service: AgentService):
    async def search() -> Any:
        started = StdioServerParameters(
            command=sys.executable, args=command(service), env=dict(os.environ), cwd=ROOT
        )
        async with Client(started, read_timeout_seconds=60.0) as client:
            begun = await client.call_tool("find_object", {"thing": "mug"})
            service.end_goal()
            return await client.call_tool("status", {"id": facts(begun)["id"]})

    assert facts(asyncio.run(search()))["result"] == "found"


@pytest.mark.slow
def test_a_hostile_client_is_kept_in_bounds(wire: Wire, service: AgentService):
    wire.raw(b"x" * (40 * LINE_BYTES) + b"\n")
    wire.raw(b"\xff\x00{]\n" + b"[" * 20_000 + b"\n\n")
    for id in range(1, 120):
        wire.call(id, "status")
    wire.call(900, "cancel")
    until_patiently(lambda: {900, *range(1, 120)} <= wire.said.keys())
    answers = [wire.said[id]["result"] for id in range(1, 120)]
    assert sum(one["isError"] for one in answers) >= 20
    assert len(service.asked) < 100
    assert wire.said[900]["result"]["structuredContent"]["facts"] == {"cancelled": False}
    assert not wire.stray
    assert wire.end() == 0


@pytest.mark.slow
def test_a_client_that_goes_away_half_way_has_its_search_cancelled(
    wire: Wire, service: AgentService
):
    wire.call(1, "find_object", thing="mug", wait_s=600)
    until_patiently(lambda: "result" in service.kinds())
    assert wire.end() == 0
    until(lambda: "cancel" in service.kinds())
    assert not service.under_way


@pytest.mark.slow
def test_who_ends_it_by_a_signal_has_its_search_cancelled(wire: Wire, service: AgentService):
    wire.call(1, "find_object", thing="mug", wait_s=600)
    until_patiently(lambda: "result" in service.kinds())
    wire.process.terminate()
    assert wire.process.wait(60.0) == 0
    until(lambda: "cancel" in service.kinds())
    assert not service.under_way


@pytest.mark.slow
def test_a_client_that_closes_its_ears_is_left(wire: Wire, service: AgentService):
    assert wire.process.stdin is not None
    wire.call(1, "find_object", thing="mug", wait_s=600)
    until_patiently(lambda: "result" in service.kinds())
    wire.deaf.set()
    wire.call(2, "status")
    wire.reading.join(20.0)
    wire.call(3, "status")
    assert wire.process.wait(60.0) == 0
    until(lambda: not service.under_way)


def test_lines_are_bounded_and_paced():
    async def read() -> tuple[list[str], float]:
        reader = asyncio.StreamReader(limit=100)
        reader.feed_data(b"y" * 1000 + b"\n" + b"a\n" * 220)
        reader.feed_eof()
        loop = asyncio.get_running_loop()
        began_s = loop.time()
        return [line async for line in InputLines(reader)], loop.time() - began_s

    lines, took_s = asyncio.run(read())
    assert all(len(line) <= 101 for line in lines)
    assert lines.count("a\n") == 220
    assert took_s > 0.2  # beyond 200 at once they come at 50 a second
