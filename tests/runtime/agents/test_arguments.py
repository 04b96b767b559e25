"""A call's arguments, whatever they are."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from runtime.agents.arguments import read_arguments
from runtime.agents.tools import AgentLimits, agent_tools

TOOLS = agent_tools(AgentLimits(look=True))
VALUES = (
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.lists(st.text())
    | st.sampled_from(["mug", "queue", 1, 0.5, True])
)  # fmt: skip
NAMES = st.sampled_from(
    sorted({name for tool in TOOLS.values() for name in tool.takes} | {"v_mps"})
)


@given(st.sampled_from(sorted(TOOLS)), st.dictionaries(NAMES, VALUES))
def test_what_is_taken_fits_the_schema_that_was_told(name: str, asked: dict[str, Any]):
    tool, wrong = TOOLS[name], ""
    try:
        assert read_arguments(tool, asked) == asked
    except ValueError as error:
        wrong = str(error)
    assert len(wrong) < 200
    assert wrong.isprintable()
    assert wrong or Draft202012Validator(tool.schema()).is_valid(asked)


@pytest.mark.parametrize(
    ("name", "asked", "why"),
    [
        ("look", {"x" * 10_000: 1}, "takes nothing"),
        ("where_is", {}, "thing is missing"),
        ("where_is", {"thing": "\n"}, "printable"),
        ("why", {"decision": 1.5}, "whole number from 1"),
        ("find_object", {"thing": "mug", "wait_s": float("nan")}, "number from 0 to 600"),
        ("find_object", {"thing": "mug", "then_return": 1}, "true or false"),
    ],
)
def test_what_is_wrong_is_one_line(name: str, asked: dict[str, Any], why: str):
    with pytest.raises(ValueError, match=why):
        read_arguments(TOOLS[name], asked)


def test_no_arguments_are_none():
    assert read_arguments(TOOLS["status"], None) == {}
