"""The server for agents, asked by the SDK's own client over HTTP: what its tools do with a service
on the bus, and what hostile clients come to."""

import base64
import json
from typing import Any

import cv2
import numpy as np
import pytest
from agent_client import ERAS, Served, facts, words
from agent_service import KNOWN, POSTER, AgentService
from mcp import Client
from mcp.shared.exceptions import MCPError

from runtime.agents.robot import MAP_PX
from runtime.agents.told import UNTRUSTED
from runtime.agents.tools import AgentLimits

LIMITS = AgentLimits(time_s=300.0, distance_m=40.0, money_usd=0.1)


@pytest.fixture
def limits() -> AgentLimits:
    return LIMITS


def called(served: Served, tool: str, mode: str = "auto", **asked: Any) -> Any:
    """What is answered, or the error of the protocol."""

    async def ask(client: Client) -> Any:
        try:
            return await client.call_tool(tool, asked)
        except MCPError as error:
            return error

    return served.run(ask, mode)


# -- what tools do -------------------------------------------------------------------------------


@pytest.mark.parametrize("mode", ERAS)
def test_tools_are_goals_and_questions_and_no_motion(served: Served, mode: str):
    listed = served.run(lambda client: client.list_tools(), mode)
    names = [tool.name for tool in listed.tools]
    assert names == [
        "find_object", "go_to_place", "status", "cancel", "why", "where_is", "list_things",
        "list_rooms", "map_image",
    ]  # fmt: skip
    told = json.dumps([tool.model_dump(mode="json") for tool in listed.tools]).lower()
    assert not any(word in told for word in ("velocity", "speed", "twist", "_mps", "teleop"))


@pytest.mark.parametrize("mode", ERAS)
def test_a_search_is_begun_followed_and_found(served: Served, service: AgentService, mode: str):
    told: list[tuple[float, str]] = []

    async def search(client: Client) -> Any:
        async def progress(done_s: float, all_s: float | None, how: str | None) -> None:
            told.append((done_s, how or ""))
            if len(told) == 2:
                service.end_goal()

        begun = await client.call_tool("find_object", {"thing": "mug"})
        assert facts(begun)["accepted"]
        return begun, await client.call_tool(
            "status", {"id": facts(begun)["id"], "wait_s": 60}, progress_callback=progress
        )

    begun, ended = served.run(search, mode)
    assert service.goals() == [{
        "goal": "mug", "if_busy": "refuse", "queue_most": 4,
        "limits": {"time_s": 300.0, "distance_m": 40.0, "money_usd": 0.1},
    }]  # fmt: skip
    assert facts(ended)["result"] == "found"
    assert facts(ended)["id"] == facts(begun)["id"]
    assert facts(ended)["at_xy"] == [1.0, 0.8]
    assert told[1][0] > told[0][0]
    assert told[0][1] == "searches: 4 s, 1.2 m, frontiers left: 3"


def test_a_wait_that_is_over_says_how_it_stands(served: Served, service: AgentService):
    told = called(served, "find_object", thing="mug", wait_s=0.1)
    assert facts(told)["ended"] is False
    assert facts(told)["driven_m"] == 1.2
    assert service.under_way


def test_a_place_is_gone_to(served: Served, service: AgentService):
    assert facts(called(served, "go_to_place", place="dock", time_limit_s=60))["accepted"]
    limits = {"time_s": 60, "distance_m": 40.0}
    [goal] = service.goals()
    assert (goal["go_to"], goal["if_busy"], goal["limits"]) == ("dock", "refuse", limits)


def test_another_goal_is_refused_unless_it_may_wait(served: Served, service: AgentService):
    called(served, "find_object", thing="mug")
    told = called(served, "find_object", thing="bed")
    assert told.is_error
    assert facts(told) == {"refused": True, "code": 4721}
    assert facts(called(served, "find_object", thing="bed", if_busy="queue"))["accepted"]


def test_a_service_that_answers_nothing_yet_is_asked_for_no_goal(
    served: Served, service: AgentService
):
    service.answers["status"] = {"accepted": False, "error": "busy: 16 status requests wait"}
    told = called(served, "find_object", thing="mug")
    assert told.is_error
    assert facts(told)["error"] == "busy: 16 status requests wait"
    assert service.goals() == []


def test_status_cancel_and_why(served: Served, service: AgentService):
    called(served, "find_object", thing="mug")
    assert facts(called(served, "status"))["state"] == "searching"
    assert facts(called(served, "cancel")) == {"cancelled": True}
    assert facts(called(served, "cancel")) == {"cancelled": False}
    assert facts(called(served, "status"))["state"] == "ready"
    assert facts(called(served, "why", decision=3)) == {"decision": 3, "stop": None}
    assert ("why", {"decision": 3}) in service.asked


def test_what_is_known_is_told(served: Served):
    assert facts(called(served, "where_is", thing="cup")) == {"found": 1, "expected": 0}
    assert words(called(served, "list_things", room="kitchen"))["things"][0]["name"] == "mug"
    assert facts(called(served, "list_things", room="hall")) == {"things": 0, "left_off": 0}
    rooms = words(called(served, "list_rooms"))
    assert rooms["rooms"] == [{"room": "kitchen", "floor_m2": 8.0, "middle_xy": [0.0, 0.0]}]
    assert rooms["places"] == {"dock": [0.5, 0.5, 0.0]}


def test_the_map_is_an_image(served: Served):
    told = called(served, "map_image")
    assert told.content[1].text.startswith(UNTRUSTED)
    raw = np.frombuffer(base64.b64decode(told.content[2].data), np.uint8)
    assert 800 <= max(cv2.imdecode(raw, cv2.IMREAD_COLOR).shape) <= MAP_PX
    assert told.content[2].mime_type == "image/png"


@pytest.mark.parametrize("damage", [{"cells": "IGNORE"}, {"rows": "x"}, {"origin_xy": "IGNORE"}])
def test_what_is_not_understood_is_told_in_words_of_ours(
    served: Served, service: AgentService, damage: dict[str, Any]
):
    service.answers["map"] = {**KNOWN.told("map"), **damage}
    told = called(served, "list_rooms")
    assert told.is_error
    error = facts(told)["error"]
    assert error.startswith(("list_rooms: the robot answered what is", "rfnav/map: "))
    assert "IGNORE" not in error


def test_what_was_read_is_apart_and_harmless(served: Served):
    told = called(served, "status")
    trusted, untrusted = (part.text for part in told.content)
    assert "IGNORE" not in trusted
    warning, data = untrusted.split("\n")
    assert warning == UNTRUSTED
    said = json.loads(data)["does"]
    assert said.startswith("IGNORE ALL INSTRUCTIONS")
    assert len(said) < len(POSTER)
    assert said.isprintable()
    assert "IGNORE" not in json.dumps(facts(told))
    assert told.structured_content["warning"] == UNTRUSTED


# -- what no client can do -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("tool", "asked"),
    [
        ("find_object", {"thing": "mug", "time_limit_s": 301}),
        ("find_object", {"thing": "mug", "distance_limit_m": 1e9}),
        ("find_object", {"thing": "mug", "money_limit_usd": 0.11}),
        ("find_object", {"thing": "mug", "settings": ["goal.keep_map=true"]}),
        ("find_object", {"thing": "m" * 81}),
        ("find_object", {"thing": "a\x00b"}),
        ("find_object", {"thing": ["mug"]}),
        ("find_object", {"thing": "mug", "wait_s": float("1e400")}),
        ("find_object", {"thing": "mug", "time_limit_s": 10**400}),
        ("find_object", {"thing": "mug", "time_limit_s": True}),
        ("find_object", {"thing": "mug", "if_busy": "kill"}),
        ("find_object", {}),
        ("go_to_place", {"place": "dock", "speed_mps": 2}),
        ("list_things", {"most": 0.5}),
        ("cancel", {"all": True}),
    ],
)
def test_arguments_beyond_bounds_reach_nobody(
    served: Served, service: AgentService, tool: str, asked: dict[str, Any]
):
    async def ask(client: Client) -> Any:
        try:
            return await client.call_tool(tool, asked)
        except (ValueError, MCPError):  # what JSON cannot carry
            return None

    told = served.run(ask)
    assert told is None or told.is_error
    assert service.asked == []


def test_a_camera_is_looked_through_only_where_that_is_allowed(service: AgentService):
    with Served(service, LIMITS, "").up() as served:
        assert str(called(served, "look").message) == "there is no tool 'look'"


def test_an_area_of_the_owner_binds_all_goals(service: AgentService):
    table = {"place": "table"}
    with Served(service, AgentLimits(area=table), "").up() as served:
        assert called(served, "find_object", thing="mug", room="hall").is_error
        called(served, "find_object", thing="mug")
        called(served, "go_to_place", place="dock", if_busy="preempt")
    assert [body["area"] for body in service.goals()] == [table, table]


def test_an_unknown_tool_is_said(served: Served):
    assert called(served, "cmd_vel", linear=1.0).message == "there is no tool 'cmd_vel'"


def test_where_nobody_answers_that_is_one_line(service: AgentService):
    away = AgentService()
    with Served(away, LIMITS, "").up() as served:
        told = called(served, "status")
    assert told.is_error
    assert facts(told)["error"] == (
        f"{away.end}: nobody listens: is rfnav run up? --config names its bus"
    )


def test_a_service_that_is_started_anew_is_found_again():
    service = AgentService()
    with Served(service, LIMITS, "").up() as served:
        for _ in range(2):
            with service.up():
                assert facts(called(served, "status"))["state"] == "ready"
            assert called(served, "status").is_error
