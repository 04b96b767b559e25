"""The goals of agents: what is asked of the service, and what is told of its answers."""

import asyncio
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import Any

import pytest

from runtime.agents.goals import AgentGoals, goal_body, goal_told, so_far
from runtime.agents.tools import AgentLimits
from runtime.errors import BusError

OWNER = AgentLimits(time_s=300.0, distance_m=40.0, money_usd=0.1)


def test_limits_are_the_owners_unless_the_client_wants_less():
    limits = {"time_s": 300.0, "distance_m": 40.0, "money_usd": 0.1}
    assert goal_body({"thing": "mug"}, OWNER)["limits"] == limits
    less = goal_body({"thing": "mug", "time_limit_s": 5, "money_limit_usd": 0}, OWNER)
    assert less["limits"] == {"time_s": 5, "distance_m": 40.0, "money_usd": 0}
    assert "money_usd" not in goal_body({"thing": "mug"}, AgentLimits())["limits"]
    assert "money_usd" not in goal_body({"place": "dock"}, OWNER)["limits"]


def test_an_area_is_the_owners_where_there_is_one():
    assert goal_body({"thing": "mug", "room": "hall"}, OWNER)["area"] == {"room": "hall"}
    bound = AgentLimits(area={"place": "table"})
    assert goal_body({"thing": "mug", "room": "hall"}, bound)["area"] == {"place": "table"}
    assert "area" not in goal_body({"thing": "mug"}, OWNER)


def test_nobody_is_displaced_unless_that_is_said():
    assert goal_body({"place": "dock"}, OWNER)["if_busy"] == "refuse"
    asked = {"place": "dock", "if_busy": "preempt", "then_return": True}
    assert goal_body(asked, OWNER)["if_busy"] == "preempt"
    assert goal_body(asked, OWNER)["afterwards"] == "return"


def test_how_many_may_wait_is_the_owners():
    asked = {"thing": "mug", "if_busy": "queue"}
    assert goal_body(asked, AgentLimits(queue=2))["queue_most"] == 2
    assert goal_body(asked, OWNER)["queue_most"] == AgentLimits.queue


def test_the_way_back_is_within_the_limits():
    asked = {"thing": "mug", "then_return": True, "time_limit_s": 100}
    assert goal_body(asked, OWNER)["limits"] == {
        "time_s": 50.0, "distance_m": 20.0, "money_usd": 0.1,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("answer", "line"),
    [
        ({"ahead": 2, "feedback": {}}, "waits for 2 before it"),
        ({"ahead": 0, "feedback": {}}, "begins"),
        ({"feedback": {"elapsed_s": "1", "driven_m": 2.0, "frontiers": 3}}, "begins"),
        (
            {"feedback": {"elapsed_s": 1.2, "driven_m": 2.0, "frontiers": 3, "reason": "POSTER"}},
            "searches: 1 s, 2.0 m, frontiers left: 3",
        ),
    ],
)
def test_progress_is_numbers(answer: dict, line: str):
    assert so_far(answer) == line


def test_a_result_has_its_words_apart():
    ended = {"id": "1", "result": "found", "code": 0, "sentence": "POSTER", "log_dir": "/x"}
    told = goal_told(ended)
    assert dict(told.facts) == {"ended": True, "id": "1", "result": "found", "code": 0}
    assert told.untrusted == {"sentence": "POSTER"}
    assert goal_told({"error": "no goal 2"}).error


class Link:
    """Holds what a test wants held until it goes on; `fails`: so many cancels."""

    def __init__(self, holds: str, fails: int = 0) -> None:
        self.asked, self._holds, self._fails = list[str](), holds, fails
        self.heard, self.goes_on = threading.Event(), threading.Event()

    def ask(self, kind: str, body: Any, within_s: float) -> dict[str, Any]:
        self.asked.append(kind)
        if kind == "cancel" and self.asked.count(kind) <= self._fails:
            raise BusError("nobody answers")
        if kind == self._holds:
            self.heard.set()
            assert self.goes_on.wait(20.0)
        return {"accepted": True, "id": "a1", "result": None}


def given_up(link: Link) -> list[str]:
    """What is asked when a call is given up while the link holds something."""

    async def progress(*_: object) -> None:
        raise AssertionError

    async def give_up(goals: AgentGoals) -> None:
        call = asyncio.create_task(goals.ask({"thing": "mug", "wait_s": 60}, progress))
        await asyncio.to_thread(link.heard.wait, 20.0)
        call.cancel()
        with suppress(asyncio.CancelledError):
            await call
        link.goes_on.set()

    with ThreadPoolExecutor() as usual, ThreadPoolExecutor() as hurried:
        asyncio.run(give_up(AgentGoals(link, OWNER, usual, hurried)))  # type: ignore[arg-type]
    return link.asked


def test_a_goal_whose_call_was_given_up_before_is_not_asked_for():
    assert given_up(Link("status")) == ["status"]


@pytest.mark.parametrize("holds", ["goal", "result"])
def test_one_that_is_given_up_is_cancelled_though_the_link_was_lost(
    holds: str, capsys: pytest.CaptureFixture[str]
):
    assert given_up(Link(holds, fails=1)).count("cancel") == 2
    assert capsys.readouterr().err == ""


def test_that_it_could_not_be_cancelled_is_said(capsys: pytest.CaptureFixture[str]):
    assert given_up(Link("result", fails=9)).count("cancel") == 2
    told = "rfnav: mcp: goal a1, which was given up, is not cancelled: nobody answers\n"
    assert capsys.readouterr().err == told
