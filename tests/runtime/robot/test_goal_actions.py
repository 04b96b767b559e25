"""Goals of ROS 2's actions as requests, and reports on them as feedback and results."""

import json
import math
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from places import ROOT

from runtime.core.types import Pose
from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot.dialects.type_hashes import service_hash, type_hash
from runtime.robot.goal_actions import GoalAction, goal_actions

FIND, GO, NAVIGATE = goal_actions("jazzy")
TYPES = wire.STORE.types
POINT, POSE = TYPES["geometry_msgs/msg/Point"], TYPES["geometry_msgs/msg/PoseStamped"]
TOLD = {
    "id": "0a1b",
    "goal": "a red mug",
    "state": "searching",
    "mode": "frontier",
    "reason": "frontier 3",
    "pose": [1.0, 2.0, math.pi / 2],
    "toward_xy": (3.0, -1.0),
    "elapsed_s": 61.25,
    "driven_m": 7.5,
    "decisions": 4,
}
ENDED = {
    "id": "0a1b",
    "result": "not_found",
    "code": 4701,
    "sentence": '"a red mug" was not found',
    "at_xy": [3.0, -1.0],
    "elapsed_s": 61.25,
    "driven_m": 7.5,
    "searched": {"floor_m2": 31.0},
}


def goal(action: GoalAction, **values: Any) -> Any:
    message = action.kind.blank("Goal")
    for name, value in values.items():
        setattr(message, name, value)
    return message


def pose(x: float, y: float, yaw: float, frame: str = "") -> Any:
    return POSE(wire.header(0, frame), wire.ros_pose(Pose(x, y, yaw)))


def asked(action: GoalAction, message: Any) -> dict[str, object]:
    """As it comes over the wire. The frame "far" lies 100 m off."""
    raw = wire.encode(message)
    read = wire.decode(raw, f"{action.kind.kind}_Goal", action.name)

    def placed(at: Pose, frame: str) -> Pose:
        if frame not in ("", "far"):
            raise SensorError(f"frame_id: {frame}")
        return Pose(at.x_m + 100.0, at.y_m, at.yaw_rad) if frame else at

    return json.loads(json.dumps(action.asked(read, placed)))


def test_the_files_that_robots_build_are_those_that_are_served():
    built = ROOT / "deploy/ros/rf_nav_interfaces/action"
    ours = ROOT / "runtime/robot/interfaces"
    names = sorted(path.name for path in built.iterdir())
    assert names == ["FindObject.action", "GoToPlace.action"]
    assert {name: (ours / name).read_text() for name in names} == {
        name: (built / name).read_text() for name in names
    }
    assert sorted(path.name for path in ours.iterdir()) == names
    listed = (ROOT / "deploy/ros/rf_nav_interfaces/CMakeLists.txt").read_text()
    assert all(f'"action/{name}"' in listed for name in names)


def test_a_thing_alone_is_asked_for_as_a_query_would():
    assert asked(FIND, goal(FIND, goal=["a red mug"])) == {"goal": "a red mug"}
    assert asked(FIND, goal(FIND)) == {"goal": []}  # what is wrong with it, the desk says


def test_all_that_a_goal_may_say_is_passed_on():
    message = goal(
        FIND,
        goal=["mug", "chair"],
        several="in_turn",
        if_busy="queue",
        time_limit_s=300.1,
        distance_limit_m=40.0,
        money_limit_usd=0.02,
        area=[POINT(0.0, 0.0, 0.0), POINT(4.0, 0.0, 0.0), POINT(4.0, 3.0, 0.0)],
        frame_id="far",
        afterwards="return",
        episode="e1",
        settings=["goal.keep_map=true"],
    )
    assert asked(FIND, message) == {
        "goal": ["mug", "chair"],
        "several": "in_turn",
        "if_busy": "queue",
        "limits": {"time_s": 300.1, "distance_m": 40.0, "money_usd": 0.02},
        "area": {"polygon": [[100.0, 0.0], [104.0, 0.0], [104.0, 3.0]]},
        "afterwards": "return",
        "episode": "e1",
        "settings": ["goal.keep_map=true"],
    }


def test_names_of_places_and_no_money_at_all():
    message = goal(
        FIND, goal=["mug"], area_room="kitchen", afterwards_place="dock", money_limit_usd=-1.0
    )
    assert asked(FIND, message) == {
        "goal": "mug",
        "area": {"room": "kitchen"},
        "afterwards": {"place": "dock"},
        "limits": {"money_usd": 0.0},
    }
    assert asked(FIND, goal(FIND, goal=["mug"], area_place="bay"))["area"] == {"place": "bay"}
    with pytest.raises(SensorError, match=r"^afterwards: only one"):
        asked(FIND, goal(FIND, goal=["mug"], afterwards="stay", afterwards_place="dock"))


def test_a_place_or_a_pose_is_gone_to():
    assert asked(GO, goal(GO, place="dock", if_busy="refuse", time_limit_s=60.0)) == {
        "go_to": "dock",
        "if_busy": "refuse",
        "limits": {"time_s": 60.0},
    }
    there = goal(GO, pose=pose(1.0, -2.0, 2.5, "far"))
    to = {"x_m": 101.0, "y_m": -2.0, "yaw_rad": 2.5}
    assert asked(GO, there) == {"go_to": to}
    assert asked(NAVIGATE, goal(NAVIGATE, pose=pose(1.0, -2.0, 2.5, "far"))) == {"go_to": to}


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_pose_is_finite_and_in_a_frame_that_is_known(bad: float):
    with pytest.raises(SensorError, match="are no finite numbers"):
        asked(GO, goal(GO, pose=pose(bad, 0.0, 0.0)))
    with pytest.raises(SensorError, match="frame_id: elsewhere"):
        asked(GO, goal(GO, pose=pose(0.0, 0.0, 0.0, "elsewhere")))


def test_a_report_is_feedback_with_the_same_values():
    told = through(FIND, "Feedback", FIND.feedback(TOLD, "odom"))
    assert (told.state, told.mode, told.reason) == ("searching", "frontier", "frontier 3")
    assert (told.elapsed_s, told.driven_m, told.decisions) == (61.25, 7.5, 4)
    assert [(p.x, p.y) for p in told.toward] == [(3.0, -1.0)]
    assert told.current_pose.header.frame_id == "odom"
    assert told.current_pose.header.stamp.sec > 0
    at = told.current_pose.pose
    assert (at.position.x, at.position.y) == (1.0, 2.0)
    assert at.orientation.z == pytest.approx(math.sqrt(0.5))
    assert json.loads(told.details) == json.loads(json.dumps(TOLD))
    nowhere = through(FIND, "Feedback", FIND.feedback({"state": "searching"}, "odom"))
    assert nowhere.toward == []


def test_places_are_told_in_odometrys_own_frame_or_on_the_localisations_map():
    far = FIND.feedback({**TOLD, "origin_xy": (1000.0, 0.0)}, "odom")
    assert far.current_pose.pose.position.x == 1001.0
    assert far.toward[0].x == 1003.0
    on_map = {"frame": "map", "pose": [8.0, 0.0, 0.0], "toward_xy": [10.0, 2.0]}
    mapped = FIND.feedback({**TOLD, "origin_xy": (1000.0, 0.0), "map": on_map}, "odom")
    assert mapped.current_pose.header.frame_id == "map"
    assert mapped.current_pose.pose.position.x == 8.0
    assert (mapped.toward[0].x, mapped.toward[0].y) == (10.0, 2.0)
    ended = FIND.result({**ENDED, "map": {"frame": "map", "at_xy": [7.0, 1.0]}}, "odom")
    assert (ended.frame_id, ended.at[0].x, ended.at[0].y) == ("map", 7.0, 1.0)


def test_how_a_goal_ended_is_its_result():
    told = through(FIND, "Result", FIND.result(ENDED, "odom"))
    assert (told.result, told.code, told.cause) == ("not_found", 4701, "")
    assert told.sentence == '"a red mug" was not found'
    assert (told.frame_id, told.at[0].x) == ("odom", 3.0)
    assert json.loads(told.details)["searched"] == {"floor_m2": 31.0}
    went = through(GO, "Result", GO.result({**ENDED, "result": "unreachable", "code": 4702}, ""))
    assert (went.result, went.error_code, went.error_msg) == (
        "unreachable",
        4702,
        '"a red mug" was not found',
    )
    nav2 = through(NAVIGATE, "Result", NAVIGATE.result(ENDED, ""))
    assert (nav2.error_code, nav2.error_msg) == (4701, '"a red mug" was not found')


def test_why_a_goal_was_refused_is_its_result():
    answer = {"accepted": False, "code": 4720, "error": "goal: is empty"}
    told = through(FIND, "Result", FIND.result(answer, "odom"))
    assert (told.result, told.code, told.sentence) == ("refused", 4720, "goal: is empty")


def test_a_way_is_told_as_nav2_does():
    for action in (GO, NAVIGATE):
        told = through(action, "Feedback", action.feedback(TOLD, "odom"))
        assert told.distance_remaining == pytest.approx(math.hypot(2.0, 3.0))
        assert (told.navigation_time.sec, told.navigation_time.nanosec) == (61, 250_000_000)
        assert told.current_pose.pose.position.y == 2.0
        assert action.feedback({"state": "queued"}, "odom").distance_remaining == 0.0


def test_what_a_field_cannot_hold_is_left_out_or_cut():
    odd = {"state": 7, "reason": None, "decisions": -3, "driven_m": 1e300, "elapsed_s": "soon"}
    told = through(FIND, "Feedback", FIND.feedback({**odd, "elapsed_s": None}, "odom"))
    assert (told.state, told.reason, told.decisions, told.elapsed_s) == ("", "", 0, 0.0)
    assert told.driven_m == pytest.approx(3.4e38, rel=0.01)
    assert FIND.result({"code": 70_000}, "").code == 0xFFFF
    assert FIND.result({"code": True}, "").code == 0


def through(action: GoalAction, part: str, message: Any) -> Any:
    """Over the wire."""
    return wire.decode(wire.encode(message), f"{action.kind.kind}_{part}", "test")


DISTRO = """
from runtime.robot import wire
from runtime.robot.dialects.type_hashes import type_hash
from runtime.robot.goal_actions import goal_actions
kind = goal_actions("{0}")[2].kind
for part in ("Result", "Feedback"):
    print(*[name for name, _ in wire.STORE.fielddefs[kind.kind + "_" + part][1]])
print(type_hash(kind.kind + "_FeedbackMessage", "{0}"))
"""
FED = "current_pose navigation_time estimated_time_remaining number_of_recoveries"


@pytest.mark.parametrize(
    ("distro", "result", "feedback"),
    [
        ("humble", "result", f"{FED} distance_remaining"),
        (
            "lyrical",
            "error_code error_msg",
            f"{FED} distance_remaining position_tracking_error heading_tracking_error",
        ),
    ],
)
def test_nav2s_action_is_the_distributions(distro: str, result: str, feedback: str):
    done = subprocess.run(
        [sys.executable, "-c", DISTRO.format(distro)], capture_output=True, text=True, cwd=ROOT,
        timeout=60.0, check=True,
    )  # fmt: skip
    fields = done.stdout.splitlines()
    assert fields[:2] == [result, feedback]
    hashed = type_hash(f"{NAVIGATE.kind.kind}_FeedbackMessage", "jazzy")
    assert (fields[2] == "TypeHashNotSupported") == (distro == "humble")
    assert fields[2] != hashed


def test_the_types_have_hashes_and_nav2s_is_what_others_know():
    kinds = [action.kind.kind for action in (FIND, GO, NAVIGATE)]
    parts = "SendGoal", "GetResult"
    hashes = {service_hash(f"{kind}_{part}", "jazzy") for kind in kinds for part in parts}
    assert len(hashes) == 6
    assert all(hashed.startswith("RIHS01_") for hashed in hashes)
    known = "RIHS01_9d1f6fa2eb975ce733b419ac2e97b134d8ff92b6478b6559feed9a50bdfd82b3"
    assert type_hash(f"{kinds[2]}_FeedbackMessage", "jazzy") == known


BY_ROS = """
import sys
from pathlib import Path
from rosidl_adapter.action import convert_action_to_idl
from rosidl_parser.definition import Action, IdlLocator
from rosidl_parser.parser import parse_idl_file

package, out, name = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3]
path = convert_action_to_idl(package, package.name, Path("action", name + ".action"), out)
(action,) = parse_idl_file(IdlLocator("/", path)).content.get_elements_of_type(Action)
for part in (action.goal, action.result, action.feedback):
    print("fields", *(member.name for member in part.structure.members))
"""
DEBIANS = shutil.which("python3", path="/usr/bin") or ""


def has_rosidl() -> bool:
    asked = [DEBIANS, "-c", "import em, rosidl_adapter, rosidl_parser"]
    return bool(DEBIANS) and subprocess.run(asked, capture_output=True, check=False).returncode == 0


@pytest.mark.skipif(
    not has_rosidl(), reason="NOT PROVEN: apt-get install python3-rosidl python3-empy"
)
@pytest.mark.parametrize("name", ["FindObject", "GoToPlace"])
def test_ros_2s_own_tools_read_the_files(name: str, tmp_path: Path):
    package = ROOT / "deploy/ros/rf_nav_interfaces"
    done = subprocess.run(
        [DEBIANS, "-c", BY_ROS, str(package), str(tmp_path), name],
        capture_output=True, text=True, timeout=60.0, check=True,
    )  # fmt: skip
    read = [line.split()[1:] for line in done.stdout.splitlines() if line.startswith("fields")]
    kind = f"rf_nav_interfaces/action/{name}"
    ours = [
        [field for field, _ in wire.STORE.fielddefs[f"{kind}_{part}"][1]]
        for part in ("Goal", "Result", "Feedback")
    ]
    assert read == ours
