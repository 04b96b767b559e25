"""The tables of docs/goals.md are those of the runtime."""

import re

import pytest
from places import ROOT

from runtime.core.types import SearchState
from runtime.loops.goal_request import ASKED, TEXTS
from runtime.service.goal_queue import WAITING
from runtime.service.outcomes import REFUSALS, RESULTS, FailCause
from runtime.service.results import KEPT

PAGE = (ROOT / "docs" / "goals.md").read_text(encoding="utf-8")


def test_every_result_is_in_the_table_as_it_is():
    rows = re.findall(r"^\| `(\w+)` \| (?:`(\w+)`)? ?\| (\d+) \| (.*) \|$", PAGE, re.MULTILINE)
    told = {(result, cause): (int(code), meaning) for result, cause, code, meaning in rows}
    expected = {
        ("failed", key.value) if isinstance(key, FailCause) else (key.value, ""): (
            listed.code,
            listed.meaning,
        )
        for key, listed in RESULTS.items()
    }
    assert told == expected
    assert {SearchState(result) for result, _ in told} >= {SearchState.FAILED}


def test_every_refusal_is_in_the_table_as_it_is():
    rows = re.findall(r"^\| `(\w+)` \| (47\d\d) \| (.*) \|$", PAGE, re.MULTILINE)
    assert {name: (int(code), meaning) for name, code, meaning in rows} == {
        refusal.value: (listed.code, listed.meaning) for refusal, listed in REFUSALS.items()
    }


@pytest.mark.parametrize("name", [name for name in ASKED if name != "log_dir"])
def test_all_that_a_goal_may_bring_is_told(name: str):
    (table,) = re.findall(r"^\| on `rfnav/goal` .*?\n\n", PAGE, re.MULTILINE | re.DOTALL)
    assert f"`{name}`" in table


def test_how_many_there_may_be_is_told():
    assert f"a list of up to {TEXTS}," in PAGE
    assert f"with up to {WAITING - 1} others" in PAGE
    assert f"the last {KEPT} results are kept" in PAGE
