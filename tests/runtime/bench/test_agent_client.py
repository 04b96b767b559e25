"""What a client of the bench asks of the agents' server."""

import asyncio

import pytest
from agent_client import Served
from agent_service import AgentService
from mcp import Client

from runtime.agents.tools import AgentLimits
from runtime.bench.agent_client import FLOOD, flood, wait


@pytest.fixture
def limits() -> AgentLimits:
    """A flood asks for images, too."""
    return AgentLimits(look=True)


def test_it_waits_for_the_goal_that_is_under_way(served: Served, service: AgentService):
    async def waits(client: Client) -> None:
        await client.call_tool("find_object", {"thing": "mug"})
        waiting = asyncio.create_task(wait(client))
        while service.kinds().count("result") < 2:
            assert not waiting.done()
            await asyncio.sleep(0.01)
        service.end_goal()
        await waiting

    served.run(waits)
    asked = service.kinds()
    assert asked[asked.index("goal") :][:3] == ["goal", "status", "result"]


def test_a_flood_asks_for_all_that_there_is(served: Served, service: AgentService):
    served.run(flood)
    assert {"things", "map", "places"} <= set(service.kinds())
    assert "goal" not in service.kinds()
    listed = served.run(lambda client: client.list_tools())
    assert {*FLOOD} <= {tool.name for tool in listed.tools}
