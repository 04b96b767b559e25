"""What people read of an expert that did not vote."""

import pytest

from runtime.core.types import Absence, Missing


@pytest.mark.parametrize(
    ("why", "detail", "cause"),
    [
        (Absence.LATE, "", "late"),
        (Absence.LATE, "3 of 9 answered", "late: 3 of 9 answered"),
        (Absence.NO_TIME, "", "no time"),
        (Absence.AT_REST, "rate limited (429)", "left alone after: rate limited (429)"),
        (Absence.NOT_AFFORDED, "cap per day: 0.1 USD left", "cap per day: 0.1 USD left"),
        (Absence.CALL_FAILED, "cannot be reached", "cannot be reached"),
        (Absence.HAS_VOTED, "", "the cloud has voted"),
        (Absence.NO_MODEL, "", "no model"),
        (Absence.NO_MODEL, "local: late; cloud: not ready", "local: late; cloud: not ready"),
    ],
)  # fmt: skip
def test_a_cause_is_one_line_for_people(why: Absence, detail: str, cause: str) -> None:
    assert Missing("o2f", why, detail).cause == cause
    assert not why.is_answer
