"""What a goal may bring, and what only the robot's own configuration or a harness may."""

import os
import time
from pathlib import Path
from typing import Any

import pytest

from runtime.config import known_keys
from runtime.errors import ConfigError
from runtime.loops.goal_request import (
    MAY_SET,
    STRICT,
    GoalRequest,
    Terms,
    cancel_reason,
    new_directory,
)
from runtime.service.limits import GoalLimits

HARNESS = Terms(harness=True)


def test_a_goal_as_anybody_may_ask_for_it():
    settings = ["goal.keep_map=true", "panel.decide_budget_s=1.0", 'panel.experts=["o2f"]']
    body = {"goal": "bed", "episode": "e1", "settings": settings}
    assert STRICT.read(body) == GoalRequest(("bed",), tuple(settings), None, "e1")
    assert STRICT.read({"goal": "bed"}) == GoalRequest(("bed",))


def test_several_goals_their_order_and_what_they_may_take():
    body = {
        "goal": ["a mug", "a chair"],
        "several": "in_turn",
        "if_busy": "queue",
        "limits": {"time_s": 60, "money_usd": 0},
        "afterwards": "return",
    }
    asked = STRICT.read(body)
    assert asked.texts == ("a mug", "a chair")
    assert (asked.several, asked.if_busy, asked.afterwards) == ("in_turn", "queue", "return")
    assert asked.limits == GoalLimits(time_s=60.0, money_usd=0.0)
    place = {"place": "dock"}
    assert STRICT.read({"goal": "bed", "afterwards": place}).afterwards == place


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ({}, "goal request: goal: must be text"),
        ({"goal": []}, "goal request: goal: must be text, or a list of 16 at most"),
        ({"goal": ["bed"] * 17}, "goal request: goal: must be text, or a list of 16 at most"),
        ({"goal": ["bed", 3]}, "goal request: goal: must be text, or a list of 16 at most"),
        ({"goal": "bed", "several": "both"}, "several: must be refuse or in_turn"),
        ({"goal": "bed", "if_busy": ["queue"]}, "if_busy: must be preempt or queue or refuse"),
        ({"goal": "bed", "queue_most": 17}, "queue_most: must be a whole number, 0 to 16"),
        ({"goal": "bed", "queue_most": -1}, "queue_most: must be a whole number, 0 to 16"),
        ({"goal": "bed", "queue_most": True}, "queue_most: must be a whole number, 0 to 16"),
        ({"goal": "bed", "afterwards": 1}, "afterwards: must be stay or return"),
        ({"goal": "bed", "afterwards": {"room": "x"}}, 'must be stay, return or {"place": NAME}'),
        ({"goal": "bed", "afterwards": {"place": 3}}, "afterwards: place: must be a name of at mo"),
        ({"goal": "bed", "limits": 5}, "limits: must be an object"),
        ({"goal": 5}, "goal request: goal: must be text"),
        ({"goal": "bed", "speed": 9}, "goal request: 'speed': unknown; "),
        ({"goal": "bed", "log_dri": "x"}, "goal request: 'log_dri': unknown; did you mean log_dir"),
        ({"goal": "bed", "log_dir": "/tmp/x"}, "goal request: log_dir: only under rfnav run --har"),
        ({"goal": "bed", "settings": "x"}, 'settings: must be a list of "KEY=VALUE"'),
        ({"goal": "bed", "settings": [3]}, 'settings: must be a list of "KEY=VALUE"'),
        ({"goal": "bed", "settings": ["goal.keep_map=true"] * 33}, "must be at most 32 of 200"),
        ({"goal": "bed", "settings": ["goal.keep_map=" + "x" * 200]}, "must be at most 32 of 200"),
        ({"goal": "bed", "episode": [[]]}, "goal request: episode: must be a name of at most 200"),
        ({"goal": "bed", "episode": True}, "goal request: episode: must be a name of at most 200"),
        ({"goal": "bed", "episode": "a\0b"}, "goal request: episode: must be a name"),
        ({"goal": "bed", "episode": "x" * 201}, "goal request: episode: must be a name"),
    ],
)
def test_what_is_refused_says_which_and_why(body: dict[str, Any], told: str):
    with pytest.raises(ConfigError) as caught:
        STRICT.read(body)
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "setting",
    [
        "control.max_speed_mps=50", "control={max_speed_mps=50}", '"control".max_speed_mps=50',
        "robot.radius_m=0.01", "camera.z_m=nan", "models.threads=1", "bus.connect=[]", "base={}",
        "research.score_file='/etc/passwd'", "research.cloud_spending_file='x'", "safety={}",
        "cloud.enabled=true", "goal={keep_map=true}", "", "nonsense", "battery.low_percent=0",
        "research.detector_source='topic'",
    ],
)  # fmt: skip
def test_settings_beyond_the_list_are_the_robots_own(setting: str):
    with pytest.raises(ConfigError, match=r"is the robot's, not a goal's to set; a goal sets goal"):
        STRICT.read({"goal": "bed", "settings": [setting]})
    if setting:
        assert HARNESS.read({"goal": "bed", "settings": [setting]}).settings == (setting,)


def test_the_list_is_short_and_of_keys_that_there_are():
    assert set(MAY_SET) <= set(known_keys())
    assert not any(
        name.split(".")[0] in ("robot", "camera", "control", "models") for name in MAY_SET
    )


@pytest.mark.parametrize("log_dir", ["a\0b", "", "\ud800", "x" * 5000, "a\nb", 3, None, ["x"]])
def test_a_directory_that_is_none(log_dir: object):
    with pytest.raises(ConfigError, match=r"^goal request: log_dir: must be"):
        HARNESS.read({"goal": "bed", "log_dir": log_dir})


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ({"reason": "enough"}, "enough"),
        ({}, "cancelled"),
        ({"reason": "x" * 1_000_000}, "cancelled"),
        ({"reason": "\ud800\n"}, "cancelled"),
        ({"reason": {"a": [1]}}, "cancelled"),
    ],
)
def test_a_reason_to_cancel_is_told_where_it_is_one(body: dict[str, Any], reason: str):
    assert cancel_reason(body) == reason


def test_two_searches_of_one_second_have_directories_of_their_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    monkeypatch.setattr(time, "strftime", lambda form: "20260101-120000")
    made = [new_directory() for _ in range(3)]
    assert [path.name for path in made if path] == [
        "20260101-120000", "20260101-120000-2", "20260101-120000-3"
    ]  # fmt: skip
    assert all(path and path.is_dir() for path in made)


def test_where_nothing_can_be_written_that_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    (tmp_path / "state").write_text("a file")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    assert new_directory() is None
    said = capsys.readouterr().err
    assert "searches: cannot be written (Not a directory): journal and map" in said
    assert os.linesep not in said.rstrip()
