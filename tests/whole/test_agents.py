"""`rfnav run`, and `rfnav mcp` beside it, started as a client of agents does: own processes."""

import asyncio
import base64
import os
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from agent_client import facts
from apartment import TWO_ROOMS, Apartment
from mcp import Client
from mcp.client.stdio import StdioServerParameters
from places import ROOT
from run_process import process

from hil_sim.driving.link import free_port
from runtime.core.types import Pose

CALM = (
    "control.look_radps=1.0", "safety.plan_stale_s=5.0", "safety.odom_stale_s=2.0",
    "safety.frame_stale_s=4.0", "panel.experts=[]",
)  # fmt: skip
LIMIT_S, WAIT_S = 200, 120.0


def moves(robot: Any) -> bool:
    return robot.twist.v_mps > 0.05 or abs(robot.twist.w_radps) > 0.05


async def asked(client: Client, robot: Any) -> None:
    told: list[str] = []

    async def progress(done_s: float, all_s: float | None, how: str | None) -> None:
        told.append(how or "")

    timed = await client.call_tool(
        "find_object",
        {"thing": "a red mug", "time_limit_s": 3, "wait_s": WAIT_S},
        progress_callback=progress,
    )
    assert facts(timed)["result"] == "timed_out", timed
    assert any(how.startswith("searches: ") for how in told), told

    begun = facts(await client.call_tool("find_object", {"thing": "bed"}))
    assert begun["limits"] == {"time_s": LIMIT_S, "distance_m": 200.0}
    over = await client.call_tool("find_object", {"thing": "bed", "time_limit_s": LIMIT_S + 1})
    assert over.is_error
    second = await client.call_tool("find_object", {"thing": "mug"})
    assert facts(second) == {"refused": True, "code": 4721}
    await asyncio.to_thread(robot.until, lambda: moves(robot))
    flood = [client.call_tool("list_things", {}) for _ in range(60)]
    assert any(one.is_error for one in await asyncio.gather(*flood))
    assert robot.state()["runtime"]["state"] != "fault"

    seen = await client.call_tool("look", {})
    while seen.is_error:  # the flood is over in a few seconds
        assert "too many calls" in facts(seen)["error"], seen
        await asyncio.sleep(0.5)
        seen = await client.call_tool("look", {})
    raw = np.frombuffer(base64.b64decode(seen.content[2].data), np.uint8)
    assert cv2.imdecode(raw, cv2.IMREAD_COLOR) is not None
    ended = await client.call_tool("cancel", {"id": begun["id"]})
    assert facts(ended) == {"cancelled": True}
    await asyncio.to_thread(robot.until, lambda: not moves(robot))
    assert facts(await client.call_tool("status", {"id": begun["id"]}))["result"] == "cancelled"


@pytest.mark.slow
def test_an_agent_asks_waits_floods_looks_and_cancels(tmp_path: Path):
    there = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, -0.5))
    env = os.environ | {"XDG_STATE_HOME": str(tmp_path)}
    bus = f"bus.listen=['tcp/127.0.0.1:{free_port()}']"

    async def agent(robot: Any) -> None:
        words = ["--limit-time", str(LIMIT_S), "--look", "--set", bus]
        started = StdioServerParameters(
            command=sys.executable, args=["-m", "runtime", "mcp", *words], env=env, cwd=ROOT
        )
        async with Client(started, read_timeout_seconds=WAIT_S) as client:
            await asked(client, robot)

    with process(there, 10_000, *CALM, bus, env=env, harness=False) as (_, robot):
        robot.until(lambda: robot.states and robot.state()["runtime"]["state"] == "ready", 60.0)
        asyncio.run(agent(robot))
