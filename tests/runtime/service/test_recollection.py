"""Why it went there, and why it stood: what is remembered, and how it is asked for."""

from typing import Any

import numpy as np
import pytest

from runtime.core.types import Ballot, Brief, Frontier, FrontierBrief
from runtime.core.voting.consensus import ConsensusConfig, elect
from runtime.errors import ConfigError
from runtime.loops.standing import RunState
from runtime.service.recollection import DECISIONS_KEPT, STANDS, STOPS_KEPT, Recollection

FRONTIER = Frontier(7, np.array([[1.0, 2.0]]), (1.0, 2.0), 1.5)
SEEN = FrontierBrief(7, 1.5, (), ())


def decided(recollection: Recollection, number: int, goal: str = "mug") -> None:
    decision = elect(Ballot(), [SEEN], ConsensusConfig(mode="strict"), 0, "first decision")
    told = decision, Brief(goal, 0, (SEEN,)), (FRONTIER,), 7, 3.0
    recollection.decided(number, goal, *told, id="a1")


def in_words(answer: dict[str, Any], kind: str) -> str:
    return "\n".join(answer[kind]["in_words"])


def test_before_anything_there_is_nothing_to_tell():
    assert Recollection().why({}, 0.0) == {"decision": None, "stop": None}
    with pytest.raises(ConfigError, match="decision 1: there was none yet"):
        Recollection().why({"decision": 1}, 0.0)
    with pytest.raises(ConfigError, match="stop 2: there was none yet"):
        Recollection().why({"stop": 2}, 0.0)


def test_the_last_decision_and_the_last_stop_and_those_before_by_number():
    recollection = Recollection()
    for number in (1, 2):
        decided(recollection, number)
    recollection.stood(1.0, "held", "odometry: no odometry for 0.4 s")
    recollection.stood(2.5, "searching", "")
    recollection.stood(4.0, "stopped", "stopped by rfnav/stop: ask rfnav/release to go on")
    answer = recollection.why({}, 5.0)
    assert [answer["decision"][name] for name in ("number", "id", "goal")] == [2, "a1", "mug"]
    assert "frontier 7, at (1.0, 2.0) m, 1.5 m on foot" in in_words(answer, "decision")
    assert (answer["stop"]["number"], answer["stop"]["kind"]) == (2, "stop")
    assert "it goes on, 1.0 s by now" in in_words(answer, "stop")
    first = recollection.why({"stop": 1}, 5.0)
    assert set(first) == {"stop"}
    assert (first["stop"]["kind"], first["stop"]["reason"]) == ("odometry", "no odometry for 0.4 s")
    assert "It began 4.0 s ago; it lasted 1.5 s, then: searching." in in_words(first, "stop")
    assert recollection.why({"decision": 1}, 5.0)["decision"]["number"] == 1


def test_one_stop_follows_another_and_each_has_its_time():
    recollection = Recollection()
    recollection.stood(1.0, "held", "frame: none")
    recollection.stood(2.0, "held", "plan: old")
    recollection.stood(3.0, "degraded", "rung: none")
    assert "it lasted 1.0 s, then: held: plan: old." in in_words(
        recollection.why({"stop": 1}, 9.0), "stop"
    )
    assert "it lasted 1.0 s, then: degraded: rung: none." in in_words(
        recollection.why({"stop": 2}, 9.0), "stop"
    )
    with pytest.raises(ConfigError, match="stop 3: there is none yet; the last is 2"):
        recollection.why({"stop": 3}, 9.0)


@pytest.mark.parametrize(
    ("state", "cause", "kind"),
    [
        ("paused", "a hand has the sticks: teleop", "hand"),
        ("paused", "paused by rfnav/pause", ""),
        ("fault", "internal error: KeyError('x')", ""),
        ("held", "something new: x", ""),
        ("stopped", "stopped by a button: ask rfnav/release to go on", "stop"),
    ],
)
def test_the_kind_of_a_stop_is_told_by_how_the_runtime_stands(state: str, cause: str, kind: str):
    recollection = Recollection()
    recollection.stood(1.0, state, cause)
    told = recollection.why({"stop": 1}, 2.0)["stop"]
    assert (told["kind"], told["reason"]) == (kind, cause)


def test_that_a_cancel_was_waited_for_is_no_stop_and_ends_one():
    recollection = Recollection()
    recollection.stood(1.0, "held", "frame: none")
    recollection.stood(2.0, "held", "cancel: a cancel waits to be answered")
    stop = recollection.why({}, 3.0)["stop"]
    assert (stop["number"], stop["ended_s"]) == (1, 2.0)


def test_of_several_searches_the_newest_decision_of_a_number_is_told():
    recollection = Recollection()
    decided(recollection, 1, "mug")
    decided(recollection, 1, "sofa")
    assert recollection.why({"decision": 1}, 0.0)["decision"]["goal"] == "sofa"


def test_memory_is_bounded():
    recollection = Recollection()
    for number in range(1, DECISIONS_KEPT + 3):
        decided(recollection, number)
        recollection.stood(2.0 * number, "held", "frame: none")
        recollection.stood(2.0 * number + 1, "searching", "")
    with pytest.raises(ConfigError, match=f"decision 2: is not remembered; 3 to {number} are"):
        recollection.why({"decision": 2}, 0.0)
    with pytest.raises(ConfigError, match=f"{number - STOPS_KEPT + 1} to {number} are"):
        recollection.why({"stop": 1}, 0.0)


@pytest.mark.parametrize(
    "body",
    [{"decision": 0}, {"decision": True}, {"stop": "1"}, {"stop": 1e3}, {"stop": 10**12}, {"x": 1}],
)
def test_what_is_no_question_is_refused_in_a_line(body: dict[str, Any]):
    with pytest.raises(ConfigError, match="why: ") as refused:
        Recollection().why(body, 0.0)
    assert "\n" not in str(refused.value)


def test_it_stands_in_states_that_there_are():
    assert set(STANDS) <= {state.value for state in RunState}
