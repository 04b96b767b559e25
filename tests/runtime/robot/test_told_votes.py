"""Votes that come over the bus: read whole, or refused in a line; and what nobody answers."""

import threading

import pytest
from fake_node import FakeNode
from hypothesis import given
from hypothesis import strategies as st
from manual_clock import ManualClock

from runtime.core.types import Absence, Missing, Vote
from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot.told_votes import ToldVotes, read_votes

TOLD = {"expert": "r2f", "frontiers": [4, 3], "probabilities": [[4, 0.6], [3, 0.4]], "reason": "so"}
QUESTION = {"stamp_ns": 7, "goal": "bed", "experts": ["r2f", "sle"], "frontiers": []}


class Answering(FakeNode):
    """A node on which each question is answered at once, with the given messages."""

    def __init__(self, *answers: object) -> None:
        super().__init__()
        self.answers = answers

    def subscribe(self, topic, receive) -> None:
        self.receive = receive

    def publisher(self, topic, *given):
        node = self

        class Asking:
            def put(self, payload: bytes) -> None:
                node.asked = wire.decode_json(payload, topic.name)
                for answer in node.answers:
                    told = answer if isinstance(answer, bytes) else wire.encode_json(answer)
                    node.receive("rfnav/votes", told)

        return Asking()


class Patient(ManualClock):
    """Whoever waits has waited to the end."""

    def wait(self, condition: threading.Condition, until_s: float) -> None:
        self.advance(until_s - self.now_s())


def test_who_is_not_among_the_votes_abstains() -> None:
    node = Answering({"stamp_ns": 7, "votes": [TOLD]})
    said = ToldVotes(node, ManualClock(1.0)).ask(QUESTION)
    assert said == (
        Vote("r2f", (3, 4), ((3, 0.4), (4, 0.6)), "so", "told"),
        Missing("sle", Absence.NO_EVIDENCE),
    )
    assert node.asked == QUESTION


def test_evidence_may_go_along() -> None:
    (vote,) = read_votes({"votes": [TOLD | {"nats": [[4, 0.7], [3, -0.7]]}]}, ["r2f"])
    assert isinstance(vote, Vote)
    assert vote.nats == ((3, -0.7), (4, 0.7))


def test_an_answer_to_another_question_is_none() -> None:
    node = Answering(b"no message", {"stamp_ns": 6, "votes": [TOLD]})
    with pytest.raises(SensorError, match=r"^rfnav/votes: none came in 60 s; r2f, sle are told$"):
        ToldVotes(node, Patient(1.0)).ask(QUESTION)


@pytest.mark.parametrize(
    "wrong",
    [
        {"frontiers": [None]},
        {"frontiers": [1e400]},
        {"probabilities": [[4, 1.5]]},
        {"probabilities": [[4, float("nan")]]},
        {"probabilities": [4]},
        {"nats": [[4, float("inf")]]},
    ],
)
def test_what_is_no_vote_is_one_error(wrong: dict) -> None:
    with pytest.raises(SensorError, match="each vote has expert, frontiers, probabilities"):
        read_votes({"votes": [TOLD | wrong]}, ["r2f"])


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from([*TOLD]), inner),
    max_leaves=8,
)


@given(JSON)
def test_nonsense_is_one_error(told: object) -> None:
    try:
        said = read_votes({"votes": told}, ["r2f"])
    except SensorError:
        return
    assert len(said) == 1
