"""Finds that are none, for as many frames as were looked at."""

from dataclasses import dataclass

import pytest

from hil_sim.driving.episode_result import End, Ended
from hil_sim.evaluation.failures import Cause, cause, false_finds
from hil_sim.ground_truth.witness import Claim

STOPPED = Ended(End.STOP)


@dataclass(frozen=True)
class Log:
    claim: Claim
    success: bool = False
    ended: Ended = STOPPED
    believed_at: int | None = None
    seen_at: int | None = None


def test_false_finds_are_counted_by_the_frames_looked_at() -> None:
    logs = [Log(Claim.FALSE), Log(Claim.TRUE, True), Log(Claim.NONE), Log(Claim.FALSE)]
    assert false_finds(logs, 500) == pytest.approx(4)
    assert false_finds(logs[1:3], 500) == 0
    assert false_finds([], 0) == 0


def test_a_fall_is_a_failure_of_planning_whatever_was_seen() -> None:
    assert cause(Log(Claim.NONE, ended=Ended(End.FELL))) is Cause.PLANNING
    assert cause(Log(Claim.NONE, ended=Ended(End.FELL), seen_at=3)) is Cause.PLANNING
