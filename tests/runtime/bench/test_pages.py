"""What is told of runs with pages and without, and what readers say to the page's server."""

import asyncio
import json

from websockets.asyncio.server import ServerConnection, serve

from runtime.bench.measure import Measured
from runtime.bench.page_readers import read_pages
from runtime.bench.pages import STAGES, _told, scene_ms


def test_a_run_is_told_by_stage_with_what_held_the_base():
    row = {"p50_ms": 0.1, "p99_ms": 1.25, "max_ms": 20.0}
    run = Measured({"late": row, "tick": row}, row, 30.0, 1.0, None, 0.0, 0.0, {"plan": 2}, 1)
    lines = _told(run, 4).splitlines()
    assert [line.split()[:2] for line in lines] == [["4", s] for s in ("sleeper", *STAGES)]
    assert lines[1].split()[2:] == ["0.10", "1.25", "20.00", "plan", "2"]
    assert lines[3].split()[2:] == ["0.00", "0.00", "0.00"]  # no frame came


def test_a_scene_takes_the_thread_that_draws_some_time():
    assert scene_ms() > 0.0


def test_readers_say_who_they_are_and_that_they_watch_the_camera():
    said: list[list[dict[str, object]]] = []

    async def page(connection: ServerConnection) -> None:
        assert connection.request is not None
        assert connection.request.headers["Origin"] == f"http://{address}"
        said.append([json.loads(await connection.recv()) for _ in range(2)])

    async def both() -> None:
        nonlocal address
        async with serve(page, "127.0.0.1", 0, subprotocols=["rfnav.1"]) as server:  # type: ignore[list-item]
            address = "{}:{}".format(*next(iter(server.sockets)).getsockname())
            await read_pages(address, 2)  # until the server hangs up

    address = ""
    asyncio.run(both())
    hello, watch = {"kind": "hello", "v": 1, "token": None}, {"kind": "watch", "camera": True}
    assert said == [[hello, {**watch, "hidden": False}]] * 2
