"""The frames that poses and places are told in (REP 105). The map's is odometry's, which is
continuous and may drift; where a localisation says how that lies on a map of its own, they are told
in both. Its corrections move nothing that the robot drives by."""

import math
from collections.abc import Mapping
from typing import Final

from runtime.core.geometry import placed, seen_from, wrap_angle
from runtime.core.types import Pose
from runtime.errors import SensorError
from runtime.robot.odometry import BaseOdometry
from runtime.robot.sync import interpolate
from runtime.robot.transforms import Transforms
from runtime.robot.wire import Stamped

SMOOTH_S: Final = 2.0  # that a correction takes
SAME_M, SAME_RAD = 1e-3, 1e-3  # less is none
PLACES: Final = ("toward_xy", "at_xy")  # of a report


class ToldFrames:
    """`map_frame`: as a localisation calls it, "" for none. `update` is called by one thread,
    `told` by any."""

    def __init__(self, map_frame: str, transforms: Transforms, odometry: BaseOdometry) -> None:
        self._map, self._transforms, self._odometry = map_frame, transforms, odometry
        self._blend: tuple[Pose, Pose, float] | None = None  # from, to, and since when

    def update(self, now_s: float) -> None:
        """Take in what tf tells of odometry's frame on the map by now, monotonic s."""
        if not self._map or not self._odometry.frame:
            return
        try:
            matrix = self._transforms.placed(self._map, self._odometry.frame)
        except SensorError:
            return  # nobody has located the robot yet
        yaw_rad = math.atan2(matrix[1, 0], matrix[0, 0])
        told = Pose(float(matrix[0, 3]), float(matrix[1, 3]), yaw_rad)
        before = self._blend[1] if self._blend else None
        if before is None:
            self._blend = told, told, now_s
        elif _differ(before, told):
            self._blend = self._at(now_s), told, now_s

    @property
    def origin_xy(self) -> tuple[float, float]:
        """Where the map begins in odometry's frame, m."""
        return self._odometry.origin_xy or (0.0, 0.0)

    def told(self, report: Mapping[str, object], now_s: float) -> dict[str, object]:
        """A report whose `pose` and places are in odometry's frame from the map's origin on; with
        `origin_xy` where that is not odometry's own, and with `map`: its frame, where odometry's
        lies on it (`from_odom`: x, y, yaw), and what of pose and places there is."""
        told, origin = dict(report), self.origin_xy
        if any(origin):
            told["origin_xy"] = origin
        if self._blend is None:
            return told
        here = self._at(now_s)
        on_map: dict[str, object] = {"frame": self._map, "from_odom": _listed(here)}
        for name in ("pose", *PLACES):
            place = report.get(name)
            if isinstance(place, list | tuple):
                x_m, y_m = float(place[0]) + origin[0], float(place[1]) + origin[1]
                moved = placed(here, Pose(x_m, y_m, float(place[2]) if len(place) > 2 else 0.0))
                on_map[name] = _listed(moved)[: len(place)]
        return told | {"map": on_map}

    def taken(self, pose: Pose, frame: str, now_s: float) -> Pose:
        """The other way round: a pose in odometry's frame, also "", or on the localisation's map ->
        in odometry's frame. SensorError for another frame."""
        if frame in ("", self._odometry.frame):
            return pose
        if frame == self._map:
            if self._blend is None:
                raise SensorError(f"{frame}: nobody has told where the robot is on it")
            return seen_from(self._at(now_s), pose)
        known = " or ".join(f'"{name}"' for name in (self._odometry.frame, self._map) if name)
        remedy = "" if self._map else "; a localisation's map is named by bus.map_frame"
        raise SensorError(f'frame_id: "{frame}": must be {known or "empty"}{remedy}')

    def _at(self, now_s: float) -> Pose:
        """Where odometry's frame is told to be on the map."""
        assert self._blend is not None
        start, end, since_s = self._blend
        share = max(0.0, min(1.0, (now_s - since_s) / SMOOTH_S))
        return interpolate(Stamped(0, start), Stamped(1_000_000, end), round(share * 1_000_000))


def _listed(pose: Pose) -> list[float]:
    return [round(v, 4) for v in (pose.x_m, pose.y_m, pose.yaw_rad)]


def _differ(a: Pose, b: Pose) -> bool:
    moved = math.hypot(a.x_m - b.x_m, a.y_m - b.y_m)
    return moved > SAME_M or abs(wrap_angle(a.yaw_rad - b.yaw_rad)) > SAME_RAD
