"""Votes that come over the bus, from a harness that stands in for experts: a question goes out with
the frontiers that there are, and waits for its answer.

{"stamp_ns": 5, "goal": "bed", "experts": ["r2f"], "frontiers": [{"id", "goal_xy", "cells_xy",
"distance_m"}, ...]} is answered with {"stamp_ns": 5, "votes": [{"expert": "r2f", "frontiers": [3],
"probabilities": [[3, 0.8], [4, 0.2]], "reason": "...", "nats": [[3, 1.0], [4, -0.4]]}]}; who is not
among the votes abstains, and whose evidence is not told in `nats` gives some to what it names.
"""

import math
import threading
from collections.abc import Collection, Mapping, Sequence
from typing import Any, Final

from runtime.clock import Clock, Deadline
from runtime.core.types import Absence, Missing, Vote
from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot.dialects.dialect import RosTopic
from runtime.robot.ros_node import RosNode, Sending
from runtime.robot.session import QUESTION, VOTES

WAIT_S: Final = 60.0  # for an answer, in lockstep
REASON: Final = 200  # characters that are kept of one
MOST_NATS: Final = 100.0
TOLD: Final = "told"  # the rung of such a vote


class ToldVotes:
    """One question at a time, by the thread that decides."""

    def __init__(self, node: RosNode, clock: Clock) -> None:
        self._clock, self._changed = clock, threading.Condition()
        self._newest: Mapping[str, Any] = {}
        self._question = node.publisher(RosTopic(QUESTION, wire.STRING), Sending(blocks=True))
        node.subscribe(RosTopic(VOTES, wire.STRING), self._file)

    def ask(self, question: Mapping[str, object]) -> tuple[Vote | Missing, ...]:
        """How each of the question's `experts` votes, in their order. SensorError when nobody
        answers, or not with votes."""
        stamp_ns, experts = question["stamp_ns"], question["experts"]
        assert isinstance(experts, Sequence)
        by = Deadline.after(WAIT_S, self._clock)
        self._question.put(wire.encode_json(question))
        with self._changed:
            while self._newest.get("stamp_ns") != stamp_ns and not by.passed():
                self._clock.wait(self._changed, by.at_s)
            answer = self._newest
        if answer.get("stamp_ns") != stamp_ns:
            raise SensorError(f"{VOTES}: none came in {WAIT_S:g} s; {', '.join(experts)} are told")
        return read_votes(answer, experts)

    def _file(self, topic: str, payload: bytes) -> None:
        try:
            told = wire.decode_json(payload, topic)
        except SensorError:
            return  # whoever waits says that none came
        with self._changed:
            self._newest = told
            self._changed.notify_all()


def read_votes(message: Mapping[str, Any], experts: Collection[str]) -> tuple[Vote | Missing, ...]:
    """What each expert says, in their order; SensorError when the message is not of that form."""
    try:
        found = {vote.expert: vote for vote in map(_vote, message["votes"])}
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        what = "each vote has expert, frontiers, probabilities and reason"
        raise SensorError(f"{VOTES}: {error!r}: {what}") from error
    return tuple(found.get(name) or Missing(name, Absence.NO_EVIDENCE) for name in experts)


def _vote(told: Mapping[str, Any]) -> Vote:
    pairs = tuple(sorted((int(id), float(p)) for id, p in told["probabilities"]))
    if not all(math.isfinite(p) and 0.0 <= p <= 1.0 for _, p in pairs):
        raise ValueError("a probability is none")
    nats = tuple(sorted((int(id), float(x)) for id, x in told.get("nats", ())))
    if not all(abs(x) <= MOST_NATS for _, x in nats):
        raise ValueError("evidence is none")
    ids = tuple(sorted({int(id) for id in told["frontiers"]}))
    return Vote(str(told["expert"]), ids, pairs, str(told["reason"])[:REASON], TOLD, nats=nats)
