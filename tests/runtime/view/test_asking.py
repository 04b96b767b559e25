"""What a page may ask, and what it may not."""

from typing import Any

import pytest

from runtime.robot.requests import QUERIES
from runtime.view.asking import ASKED, asked


@pytest.mark.parametrize(
    ("what", "body"),
    [
        ("goal", {"goal": "mug", "area": {"polygon": [[0, 0], [1, 0], [1, 1]]}}),
        ("goal", {"go_to": {"x_m": 1.0, "y_m": 2.0}}),
        ("cancel", {}),
        ("zones", {"add": "stairs", "polygon": [[0, 0], [1, 0], [1, 1]]}),
        ("places", {"name": "table"}),
        ("stop", {}),
        ("why", {"decision": 3}),
    ],
)
def test_what_a_page_is_for_is_passed_on_as_it_is(what: str, body: dict[str, Any]):
    assert asked(what, body) == body


@pytest.mark.parametrize(
    ("what", "body", "why"),
    [
        ("status", {}, "a page asks"),
        ("forget", {}, "a page asks"),
        ("", {}, "a page asks"),
        ("x" * 500, {}, "a page asks"),
        ("goal", {"goal": "mug", "settings": {"goal.keep_map": True}}, "settings"),
        ("goal", {"goal": "mug", "log_dir": "/tmp"}, "log_dir"),
        ("goal", {"goal": "mug", "episode": "x"}, "episode"),
        ("zones", {"clear": True}, "clear"),
        ("zones", {}, "must have one of"),
        ("places", {"forget": True}, "forget"),
        ("pause", {"x": 1}, "may have nothing"),
        ("goal", ["mug"], "must be a JSON object"),
        ("goal", "mug", "must be a JSON object"),
    ],
)
def test_what_it_is_not_for_is_refused_in_a_line(what: str, body: Any, why: str):
    with pytest.raises(ValueError, match=why) as told:
        asked(what, body)
    assert len(str(told.value)) < 200
    assert "\n" not in str(told.value)


def test_nothing_that_steers_a_robot_is_left_out():
    """Whoever adds a query thinks of the page."""
    steering = {kind for kind, query in QUERIES.items() if query.steers}
    assert steering <= set(ASKED)
