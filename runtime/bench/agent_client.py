"""`python -m runtime.bench.agent_client URL waits|floods`: asks `rfnav mcp` as an agent does, until
it is told to end."""

import asyncio
import sys
from typing import Any, Final

from mcp import Client

WAIT_S: Final = 30.0  # for the end of a goal, by one call
EVERY_S: Final = 0.1  # a call of a flood: as many as are taken
FLOOD: Final = ("map_image", "look", "list_things", "list_rooms")


async def wait(client: Client) -> None:
    """For the end of the goal under way, if there is one, with progress."""

    async def heard(progress: float, total: float | None, message: str | None) -> None:
        """It is for somebody to see."""

    await client.call_tool("status", {"wait_s": WAIT_S}, progress_callback=heard)
    await asyncio.sleep(EVERY_S)


async def flood(client: Client) -> None:
    """All pictures and lists that there are."""
    for tool in FLOOD:
        await client.call_tool(tool, {})
        await asyncio.sleep(EVERY_S)


async def ask(server: Any, does: str) -> None:
    """Again and again. `server`: as the SDK's client takes it."""
    async with Client(server, read_timeout_seconds=2 * WAIT_S) as client:
        while True:
            await (flood if does == "floods" else wait)(client)


if __name__ == "__main__":
    asyncio.run(ask(sys.argv[1], sys.argv[2]))
