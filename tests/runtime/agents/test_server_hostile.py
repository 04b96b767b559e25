"""The server for agents against clients that flood, wait, give up, and are two."""

import asyncio
import time
from typing import Any

import pytest
from agent_client import ERAS, RawSession, Served, facts, until
from agent_service import AgentService
from mcp import Client

from runtime.agents.server import A_SECOND, AT_ONCE, CALLS_MOST, WAITS_MOST, Turnstile
from runtime.agents.tools import AgentLimits


def settled(served: Served, tasks: int) -> None:
    """Nothing is left of what was asked."""
    until(lambda: served.agents.turnstile.inside == 0)
    until(lambda: served.tasks() <= tasks)


@pytest.mark.parametrize("mode", ERAS)
def test_a_flood_is_refused_and_leaves_nothing(served: Served, service: AgentService, mode: str):
    async def flood(client: Client) -> list[Any]:
        return await asyncio.gather(*(client.call_tool("list_things", {}) for _ in range(24)))

    tasks, began_s = served.tasks(), time.monotonic()
    for _ in range(3):
        told = served.run(flood, mode)
    took_s = time.monotonic() - began_s
    refused = [facts(one)["error"] for one in told if one.is_error]
    assert refused
    assert all(why.startswith(("too many calls", "busy")) for why in refused)
    assert len(service.asked) <= AT_ONCE + took_s * A_SECOND
    settled(served, tasks)


def test_waits_leave_room_for_questions_and_cancel(served: Served, service: AgentService):
    tasks = served.tasks()

    async def crowd(client: Client) -> Any:
        await client.call_tool("find_object", {"thing": "mug"})
        waits = [
            asyncio.create_task(client.call_tool("status", {"wait_s": 600}))
            for _ in range(WAITS_MOST + 2)
        ]
        done, _ = await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
        assert all("busy" in facts(one.result())["error"] for one in done)
        assert facts(await client.call_tool("status", {}))["state"] == "searching"
        assert facts(await client.call_tool("cancel", {}))["cancelled"]
        return [facts(await one) for one in waits]

    told = served.run(crowd)
    assert [one.get("result") for one in told].count("cancelled") == WAITS_MOST
    settled(served, tasks)


@pytest.mark.parametrize("mode", ERAS)
def test_a_search_whose_call_is_given_up_is_cancelled(
    served: Served, service: AgentService, mode: str
):
    tasks = served.tasks()

    async def give_up(client: Client) -> None:
        call = asyncio.create_task(client.call_tool("find_object", {"thing": "mug", "wait_s": 600}))
        while "result" not in service.kinds():
            await asyncio.sleep(0.02)
        call.cancel()
        while "cancel" not in service.kinds():
            await asyncio.sleep(0.02)

    served.run(give_up, mode)
    until(lambda: not service.under_way)
    settled(served, tasks)


def test_a_search_whose_client_hangs_up_in_a_session_is_cancelled(
    served: Served, service: AgentService
):
    session = RawSession(served)
    tasks = served.tasks()
    session.say("tools/call", name="find_object", arguments={"thing": "mug", "wait_s": 600})
    until(lambda: "result" in service.kinds())
    session.wire.close()
    until(lambda: "cancel" in service.kinds())
    until(lambda: not service.under_way)
    settled(served, tasks)


def test_a_server_that_ends_has_cancelled_what_was_waited_for(service: AgentService):
    with Served(service, AgentLimits(), "").up() as served:
        session = RawSession(served)
        session.say("tools/call", name="find_object", arguments={"thing": "mug", "wait_s": 600})
        until(lambda: "result" in service.kinds())
    session.wire.close()
    assert "cancel" in service.kinds()
    assert not service.under_way


def test_a_goal_that_is_taken_after_its_call_was_given_up_is_cancelled(
    served: Served, service: AgentService
):
    service.taking.clear()

    async def give_up(client: Client) -> None:
        call = asyncio.create_task(client.call_tool("find_object", {"thing": "mug"}))
        while "goal" not in service.kinds():
            await asyncio.sleep(0.02)
        call.cancel()
        while served.agents.turnstile.inside:
            await asyncio.sleep(0.02)
        service.taking.set()

    served.run(give_up)
    until(lambda: "cancel" in service.kinds())
    until(lambda: not service.under_way)


def test_a_wait_that_is_given_up_leaves_the_search_alone(served: Served, service: AgentService):
    async def give_up(client: Client) -> None:
        await client.call_tool("find_object", {"thing": "mug"})
        call = asyncio.create_task(client.call_tool("status", {"wait_s": 600}))
        while "result" not in service.kinds():
            await asyncio.sleep(0.02)
        call.cancel()

    served.run(give_up)
    until(lambda: served.agents.turnstile.inside == 0)
    assert service.under_way
    assert "cancel" not in service.kinds()


def test_a_service_that_is_busy_is_asked_again(served: Served, service: AgentService):
    id = facts(served.run(lambda client: client.call_tool("find_object", {"thing": "mug"})))["id"]
    usual, told = service.answers["result"], []

    def busy(body: dict[str, Any]) -> Any:
        told.append(body)
        if len(told) < 3:
            return {"accepted": False, "error": "busy: 4 requests wait"}
        service.end_goal()
        service.answers["result"] = usual
        return service.ended[id]

    service.answers["result"] = busy
    wait = {"id": id, "wait_s": 60}
    ended = served.run(lambda client: client.call_tool("status", wait))
    assert facts(ended)["result"] == "found"
    service.answers["result"] = {"accepted": False, "error": "busy: 4 requests wait"}
    assert served.run(lambda client: client.call_tool("status", {"id": id})).is_error


def test_a_goal_whose_wait_fails_is_told_with_its_id(served: Served, service: AgentService):
    service.answers["result"] = {"accepted": False, "error": "busy: 4 requests wait"}
    asked = {"thing": "mug", "wait_s": 0.1}
    told = served.run(lambda client: client.call_tool("find_object", asked))
    assert told.is_error
    assert (facts(told)["id"], facts(told)["error"]) == (
        service.under_way,
        "busy: 4 requests wait",
    )


def test_two_clients_have_one_robot(served: Served, service: AgentService):
    async def both() -> list[Any]:
        async def one(thing: str) -> Any:
            async with served.client() as client:
                return await client.call_tool("find_object", {"thing": thing})

        return await asyncio.gather(one("mug"), one("bed"))

    told = asyncio.run(both())
    assert sorted(one.is_error for one in told) == [False, True]


def test_a_turnstile_counts():
    now_s = [0.0]
    turnstile = Turnstile(lambda: now_s[0])
    for _ in range(int(AT_ONCE)):
        turnstile.leave(turnstile.enter("status", waits=False))
    with pytest.raises(ValueError, match="too many calls"):
        turnstile.enter("status", waits=False)
    turnstile.leave(turnstile.enter("cancel", waits=False))
    now_s[0] = 100.0
    taken = [turnstile.enter("status", waits=False) for _ in range(CALLS_MOST)]
    with pytest.raises(ValueError, match="busy: 16 calls"):
        turnstile.enter("status", waits=False)
    for one in taken:
        turnstile.leave(one)
    assert turnstile.inside == 0
