"""The protocol on standard input and output: lines of bounded length, so many a second, and an end
where the client is gone or takes nothing any more."""

import asyncio
import os
import signal
import sys
from collections.abc import AsyncIterator
from typing import Any, Final, cast

import anyio
from mcp.server.lowlevel import Server
from mcp.server.stdio import stdio_server

from runtime.errors import ConfigError
from runtime.log import say

LINE_BYTES: Final = 64 << 10
LINES_A_SECOND, LINES_AT_ONCE = 50.0, 200.0
TAKEN_S: Final = 30.0  # in which a client must read a line
TOO_LONG: Final = "too long\n"  # is no JSON: refused as that


async def serve_stdio(server: Server[Any]) -> None:
    """Until the client hangs up, SIGTERM or SIGINT. ConfigError where nobody can speak."""
    wire_in, wire_out = _claimed(0, "rb"), _claimed(1, "wb")
    _divert()
    loop = asyncio.get_running_loop()
    reader = asyncio.StreamReader(limit=LINE_BYTES)
    try:
        await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), wire_in)
        transport, flow = await loop.connect_write_pipe(asyncio.streams.FlowControlMixin, wire_out)
    except ValueError as error:
        raise ConfigError("rfnav mcp: stdin and stdout must be pipes, of a client") from error
    lines = cast("anyio.AsyncFile[str]", InputLines(reader))
    out = cast("anyio.AsyncFile[str]", OutputLines(asyncio.StreamWriter(
        transport, cast(Any, flow), None, loop)))  # fmt: skip
    ending = anyio.CancelScope()
    for number in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, ending.cancel)
    try:
        with ending:
            async with stdio_server(lines, out) as (heard, said):
                await server.run(heard, said, server.create_initialization_options())
    except* (TimeoutError, ConnectionError):
        say("mcp: the client takes nothing any more")


class InputLines:
    """What a client sends. A line that is too long comes as one that is no message."""

    def __init__(self, reader: asyncio.StreamReader) -> None:
        self._reader = reader
        self._left, self._seen_s = LINES_AT_ONCE, 0.0

    def __aiter__(self) -> AsyncIterator[str]:
        return self._lines()

    async def _lines(self) -> AsyncIterator[str]:
        loop = asyncio.get_running_loop()
        self._seen_s = loop.time()
        while True:
            try:
                raw = await self._reader.readline()
            except ValueError:  # the limit; what is left of the line comes as others
                raw = TOO_LONG.encode()
            if not raw:
                return
            yield raw.decode("utf-8", "replace")
            await self._paced(loop)

    async def _paced(self, loop: asyncio.AbstractEventLoop) -> None:
        now_s = loop.time()
        passed = (now_s - self._seen_s) * LINES_A_SECOND
        self._left, self._seen_s = min(LINES_AT_ONCE, self._left + passed) - 1.0, now_s
        if self._left < 0:
            await asyncio.sleep(-self._left / LINES_A_SECOND)


class OutputLines:
    """What is said to a client: TimeoutError for one that does not take it."""

    def __init__(self, writer: asyncio.StreamWriter) -> None:
        self._writer = writer

    async def write(self, text: str) -> None:
        self._writer.write(text.encode())

    async def flush(self) -> None:
        with anyio.fail_after(TAKEN_S):
            await self._writer.drain()


def _claimed(number: int, mode: str) -> Any:
    """The wire, at a descriptor that nothing else knows."""
    return os.fdopen(os.dup(number), mode, buffering=0)


def _divert() -> None:
    """What else is printed, or read, in this process does not meet the wire."""
    nowhere = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nowhere, 0)
    os.close(nowhere)
    os.dup2(sys.stderr.fileno(), 1)
