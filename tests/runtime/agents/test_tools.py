"""The list of tools."""

from jsonschema import Draft202012Validator

from runtime.agents.tools import AgentLimits, agent_tools


def test_schemas_are_schemas_and_bounded():
    for tool in agent_tools(AgentLimits(look=True)).values():
        schema = tool.schema()
        Draft202012Validator.check_schema(schema)
        assert schema["additionalProperties"] is False
        for part in schema["properties"].values():
            assert part["type"] == "boolean" or part.keys() & {"maxLength", "maximum", "enum"}


def test_bounds_are_the_owners():
    takes = agent_tools(AgentLimits(60.0, 5.0, 0.0))["find_object"].takes
    names = "time_limit_s", "distance_limit_m", "money_limit_usd"
    assert [takes[name]["maximum"] for name in names] == [60.0, 5.0, 0.0]


def test_the_camera_rooms_and_a_way_back_are_offered_where_they_may_be():
    assert "look" in agent_tools(AgentLimits(look=True))
    assert "look" not in agent_tools(AgentLimits())
    assert "room" in agent_tools(AgentLimits())["find_object"].takes
    bound = agent_tools(AgentLimits(area={"room": "hall"}))
    assert "room" not in bound["find_object"].takes
    assert "go_to_place" not in bound  # which may be in another
    about = agent_tools(AgentLimits(area={"place": "table"}))
    for tool in ("find_object", "go_to_place"):
        assert "then_return" not in about[tool].takes  # it may have begun elsewhere
        assert "then_return" in agent_tools(AgentLimits())[tool].takes
