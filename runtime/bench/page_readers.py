"""`python -m runtime.bench.page_readers ADDRESS PAGES`: reads as so many browsers do, until it is
told to end."""

import asyncio
import json
import sys

from websockets.asyncio.client import connect
from websockets.typing import Origin, Subprotocol


async def read_page(address: str) -> None:
    """One page, with the camera in view."""
    how = {"max_size": None, "compression": None, "proxy": None}
    spoken = {"origin": Origin(f"http://{address}"), "subprotocols": [Subprotocol("rfnav.1")]}
    async with connect(f"ws://{address}/ws", **spoken, **how) as page:  # type: ignore[arg-type]
        await page.send(json.dumps({"kind": "hello", "v": 1, "token": None}))
        await page.send(json.dumps({"kind": "watch", "camera": True, "hidden": False}))
        async for _ in page:
            pass


async def read_pages(address: str, pages: int) -> None:
    """All of them at once."""
    await asyncio.gather(*(read_page(address) for _ in range(pages)))


if __name__ == "__main__":
    asyncio.run(read_pages(sys.argv[1], int(sys.argv[2])))
