"""ROS 2's actions for goals: FindObject and GoToPlace, of the files that a robot's package is built
of (deploy/ros/), and Nav2's NavigateToPose. What is asked by them becomes a request on
`rfnav/goal`; what is told of a goal on `rfnav/feedback`, their feedback and result."""

import json
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, Final

from runtime.core.types import Pose
from runtime.errors import SensorError
from runtime.journal import plain
from runtime.robot import wire
from runtime.robot.action_types import ActionType

PACKAGE: Final = "rf_nav_interfaces"
NAV2: Final = "nav2_msgs/action/NavigateToPose"
# Of Nav2's action, by what a distribution has in place of the newest: `humble` says nothing in its
# result, and how far off the path a robot is, is told since `lyrical`.
NAV2_RESULT: Final = "uint16 error_code\nstring error_msg"
NAV2_FEEDBACK: Final = (
    "geometry_msgs/PoseStamped current_pose\nbuiltin_interfaces/Duration navigation_time\n"
    "builtin_interfaces/Duration estimated_time_remaining\nint16 number_of_recoveries\n"
    "float32 distance_remaining"
)
NAV2_ERRORS: Final = "\nfloat32 position_tracking_error\nfloat32 heading_tracking_error"
POINT: Final = "geometry_msgs/msg/Point"
DURATION: Final = "builtin_interfaces/msg/Duration"

Placing = Callable[[Pose, str], Pose]
"""A pose in a frame -> in odometry's; SensorError where nobody knows how that lies in it."""


@dataclass(frozen=True)
class GoalAction:
    """An action, served as `name`. `asked`: its Goal -> a request, or SensorError."""

    name: str
    kind: ActionType
    asked: Callable[[Any, Placing], dict[str, object]]

    def feedback(self, told: Mapping[str, Any], frame: str) -> Any:
        """A report on a goal -> Feedback, whose places are in odometry's `frame`, or on the map of
        a localisation that the report names."""
        places = _Places.of(told, frame)
        header = wire.header(time.time_ns(), places.frame)
        pose = wire.ros_pose(places.pose)
        made = {
            "current_pose": wire.STORE.types[wire.POSE_STAMPED](header, pose),
            "toward": places.points("toward_xy"),
            "navigation_time": _duration(told.get("elapsed_s")),
        }
        values = _values(told) | {"distance_remaining": places.left_m}
        return self.kind.filled("Feedback", values, made)

    def result(self, told: Mapping[str, Any], frame: str) -> Any:
        """The last report on a goal, or why it was refused -> Result."""
        refused = told.get("accepted") is False
        said, places = told.get("error" if refused else "sentence"), _Places.of(told, frame)
        known = {"sentence": said, "error_msg": said, "error_code": told.get("code")}
        known["frame_id"] = places.frame
        if refused:
            known["result"] = "refused"
        return self.kind.filled("Result", _values(told) | known, {"at": places.points("at_xy")})


def _ours(name: str) -> ActionType:
    """Of the file that robots build, too."""
    text = files("runtime.robot").joinpath("interfaces", f"{name}.action").read_text("utf-8")
    return ActionType.define(f"{PACKAGE}/action/{name}", *text.split("---\n"))


FIND: Final = _ours("FindObject")
GO: Final = _ours("GoToPlace")


def goal_actions(distro: str) -> tuple[GoalAction, ...]:
    """All that are served to nodes of a distribution of ROS 2."""
    return (
        GoalAction("rfnav/find_object", FIND, _find),
        GoalAction("rfnav/go_to_place", GO, _go),
        GoalAction("rfnav/navigate_to_pose", _nav2(distro), _navigate),
    )


@cache
def _nav2(distro: str) -> ActionType:
    result = "std_msgs/Empty result" if distro == "humble" else NAV2_RESULT
    feedback = NAV2_FEEDBACK + (NAV2_ERRORS if distro == "lyrical" else "")
    goal = "geometry_msgs/PoseStamped pose\nstring behavior_tree"
    return ActionType.define(NAV2, goal, result, feedback)


# -- what is asked ---------------------------------------------------------------------------------


def _find(goal: Any, placing: Placing) -> dict[str, object]:
    said = list(goal.goal)
    body: dict[str, object] = {"goal": said[0] if len(said) == 1 else said}
    body |= _limited(goal, ("time_s", "distance_m", "money_usd"))
    area = {
        "polygon": [_listed(placing(Pose(p.x, p.y, 0.0), goal.frame_id))[:2] for p in goal.area],
        "room": goal.area_room,
        "place": goal.area_place,
    }
    if told := {name: value for name, value in area.items() if value}:
        body["area"] = told
    if goal.afterwards_place:
        if goal.afterwards:
            raise SensorError("afterwards: only one, it or afterwards_place")
        body["afterwards"] = {"place": goal.afterwards_place}
    if goal.settings:
        body["settings"] = list(goal.settings)
    return body | _said(goal, ("several", "if_busy", "afterwards", "episode"))


def _go(goal: Any, placing: Placing) -> dict[str, object]:
    body = {"go_to": goal.place} if goal.place else _navigate(goal, placing)
    return body | _limited(goal, ("time_s", "distance_m")) | _said(goal, ("if_busy",))


def _navigate(goal: Any, placing: Placing) -> dict[str, object]:
    at, q = goal.pose.pose.position, goal.pose.pose.orientation
    values = at.x, at.y, q.x, q.y, q.z, q.w
    if not all(map(math.isfinite, values)):
        raise SensorError(f"pose: {values} are no finite numbers")
    yaw_rad = math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))
    there = _listed(placing(Pose(at.x, at.y, yaw_rad), goal.pose.header.frame_id))
    return {"go_to": dict(zip(("x_m", "y_m", "yaw_rad"), there, strict=True))}


def _limited(goal: Any, names: tuple[str, ...]) -> dict[str, object]:
    """Limits that are set, as decimal numbers: 1.1 m of 32 bits is 1.10000002. Below 0 nothing is
    left to spend."""
    limits = {}
    for name in names:
        what, unit = name.split("_")
        if value := float(getattr(goal, f"{what}_limit_{unit}")):
            if math.isnan(value):
                raise SensorError(f"{what}_limit_{unit}: is no number")
            limits[name] = max(0.0, float(f"{value:.6g}"))
    return {"limits": limits} if limits else {}


def _said(goal: Any, names: tuple[str, ...]) -> dict[str, object]:
    return {name: value for name in names if (value := getattr(goal, name))}


# -- what is told ----------------------------------------------------------------------------------


def _values(told: Mapping[str, Any]) -> dict[str, Any]:
    values: dict[str, Any] = plain(told)
    return values | {"details": json.dumps(values)}


@dataclass(frozen=True)
class _Places:
    """What a report tells of places, all in one `frame`: a localisation's map, where there is one;
    else odometry's, from whose origin the map's is `moved_xy`."""

    frame: str
    told: Mapping[str, Any]
    moved_xy: tuple[float, float]

    @classmethod
    def of(cls, told: Mapping[str, Any], frame: str) -> "_Places":
        on_map = told.get("map")
        if on_map is not None:
            return cls(on_map["frame"], on_map, (0.0, 0.0))
        return cls(frame, told, told.get("origin_xy", (0.0, 0.0)))

    @property
    def pose(self) -> Pose:
        x_m, y_m, yaw_rad = self.told.get("pose") or (0.0, 0.0, 0.0)
        return Pose(x_m + self.moved_xy[0], y_m + self.moved_xy[1], yaw_rad)

    @property
    def left_m(self) -> float:
        """To what it heads for, as the crow flies; 0 where that is not known."""
        pose, xy = self.told.get("pose"), self.told.get("toward_xy")
        return math.dist(pose[:2], xy) if pose and xy else 0.0

    def points(self, name: str) -> list[Any]:
        """None, or one."""
        xy = self.told.get(name)
        if xy is None:
            return []
        x_m, y_m = xy[0] + self.moved_xy[0], xy[1] + self.moved_xy[1]
        return [wire.STORE.types[POINT](float(x_m), float(y_m), 0.0)]


def _listed(pose: Pose) -> list[float]:
    return [round(v, 4) for v in (pose.x_m, pose.y_m, pose.yaw_rad)]


def _duration(seconds: Any) -> Any:
    sec, rest = divmod(float(seconds or 0.0), 1.0)
    return wire.STORE.types[DURATION](int(sec), int(rest * 1e9))
