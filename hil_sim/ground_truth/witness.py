"""What the truth says of an episode, step by step: the facts that reports are made from."""

import json
import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hil_sim.ground_truth.labels import FULL_PX
from hil_sim.ground_truth.true_labels import pixels
from hil_sim.simulation.protocol import GoalSighting
from hil_sim.simulation.robot import Robot
from runtime.core.purpose import Purpose
from runtime.core.types import Pose
from runtime.core.world import Mode

LEAST_PIXELS, SEEN_M = 200, 5.0
"""The goal counts as seen with this many pixels of one instance, no further than this."""
BELIEVED_M = 0.5
"""How far from an instance's box a point may lie that the runtime takes for the goal."""
TARGET_MODES = (Mode.TARGET, Mode.FACE, Mode.STOP)
TRACK_FILE = "track.jsonl"

Footprint = NDArray[np.float64]  # (4, 2) m, scene frame, counter-clockwise
Things = Sequence[tuple[str, Footprint]]  # category and where it stands


class Claim(StrEnum):
    """Whether the place that the runtime stopped for is an instance of the goal."""

    NONE = ""  # it claimed no find
    TRUE = "true"
    FALSE = "false"


@dataclass(frozen=True)
class Facts:
    """Of one episode; see `EpisodeResult`."""

    seen_at: int | None
    seen_steps: int
    believed_at: int | None
    claim: Claim
    stands: tuple[str, ...]
    frontier_m: tuple[float, ...]
    actions: dict[str, int]
    purposes: dict[str, int]


class Witness:
    """Watches one episode and writes its track. `wanted` are the instances' indices in the
    segmentation, `boxes` their footprints; `distance_m` is the way to success; `things`: all that
    stands in the home."""

    def __init__(
        self,
        wanted: tuple[int, ...],
        boxes: tuple[Footprint, ...],
        distance_m: Callable[[Pose], float],
        track: Path,
        things: Things = (),
    ) -> None:
        self._wanted, self._boxes, self._distance_m = wanted, boxes, distance_m
        self._things = things
        self._seen_at: int | None = None
        self._believed_at: int | None = None
        self._seen_steps = 0
        self._claim, self._stands = Claim.NONE, tuple[str, ...]()
        self._frontier_m: list[float] = []
        self._actions: Counter[str] = Counter()
        self._purposes: Counter[str] = Counter()
        self.sightings: tuple[GoalSighting, ...] = ()  # of the newest frame
        self._track = track.open("w", encoding="utf-8")

    def close(self) -> None:
        self._track.close()

    def look(
        self,
        step: int,
        pose: Pose,
        depth_m: NDArray[np.float32],
        segmentation: NDArray[np.int32],
    ) -> None:
        """A frame, as it truly is, before anything is done about it."""
        found = []
        scale = FULL_PX / segmentation.size
        counts = pixels(segmentation, max(self._wanted, default=0) + 1)
        for index, box in zip(self._wanted, self._boxes, strict=True):
            seen = round(scale * int(counts[index]))
            depth = float(np.median(depth_m[segmentation == index])) if seen else math.inf
            found.append(GoalSighting(seen, depth, box_distance_m(box, pose.x_m, pose.y_m)))
        self.sightings = tuple(found)
        if any(s.pixels >= LEAST_PIXELS and s.depth_m <= SEEN_M for s in found):
            self._seen_steps += 1
            self._seen_at = step if self._seen_at is None else self._seen_at

    def hear(
        self,
        step: int,
        state: Mapping[str, Any],
        decisions: tuple[Mapping[str, Any], ...],
        in_scene: Callable[[float, float], tuple[float, float]],
    ) -> None:
        """What the runtime said to it; `in_scene` takes a point of its map to the scene frame."""
        mode = str(state.get("mode", ""))
        self._actions[mode] += 1
        self._purposes[str(state.get("purpose", Purpose.OTHER))] += 1
        aim = state.get("toward_xy")
        if aim and mode in TARGET_MODES:
            there = in_scene(*aim)
            at_goal = self._is_goal(*there)
            if at_goal and self._believed_at is None:
                self._believed_at = step
            if mode == Mode.STOP:
                self._claim = Claim.TRUE if at_goal else Claim.FALSE
                self._stands = standing_at(self._things, *there)
        for decision in decisions:
            point = _elected(decision)
            if point is not None:
                left_m = self._distance_m(Pose(*in_scene(*point), 0.0))
                if math.isfinite(left_m):
                    self._frontier_m.append(round(left_m, 3))

    def moved(self, robot: Robot, mode: str, action: str, collided: bool) -> None:
        """Where the step ended."""
        x, y, yaw = robot.pose.x_m, robot.pose.y_m, robot.pose.yaw_rad
        row = {"x": round(x, 4), "y": round(y, 4), "yaw": round(yaw, 4)}
        line = json.dumps({**row, "mode": mode, "action": action, "collided": collided})
        self._track.write(line + "\n")

    def facts(self) -> Facts:
        return Facts(
            self._seen_at,
            self._seen_steps,
            self._believed_at,
            self._claim,
            self._stands,
            tuple(self._frontier_m),
            dict(sorted(self._actions.items())),
            dict(sorted(self._purposes.items())),
        )

    def _is_goal(self, x_m: float, y_m: float) -> bool:
        return any(box_distance_m(box, x_m, y_m) <= BELIEVED_M for box in self._boxes)


def box_distance_m(box: Footprint, x_m: float, y_m: float) -> float:
    """From a point to a convex footprint (n, 2), counter-clockwise; 0 inside."""
    sides = np.roll(box, -1, axis=0) - box
    to_point = np.array([x_m, y_m]) - box
    if (sides[:, 0] * to_point[:, 1] - sides[:, 1] * to_point[:, 0] >= 0).all():
        return 0.0
    along = np.clip((to_point * sides).sum(axis=1) / (sides**2).sum(axis=1), 0.0, 1.0)
    return float(np.hypot(*(to_point - along[:, None] * sides).T).min())


def standing_at(things: Things, x_m: float, y_m: float) -> tuple[str, ...]:
    """What stands at a point: the categories of all whose footprint it lies in, else of the
    nearest, if that is no further than counts as the same place; "other" where nothing else is."""
    gaps_m = [box_distance_m(box, x_m, y_m) for _, box in things]
    least_m = min(gaps_m, default=math.inf)
    if least_m > BELIEVED_M:
        return ()
    found = {name for (name, _), gap_m in zip(things, gaps_m, strict=True) if gap_m == least_m}
    return tuple(sorted(found - {"other"})) or ("other",)


def to_scene(truth: Pose, reported: Pose) -> Callable[[float, float], tuple[float, float]]:
    """Takes points of the runtime's map to the scene frame: the robot truly stands at `truth`
    where its odometry says `reported`."""
    turn = truth.yaw_rad - reported.yaw_rad
    c, s = math.cos(turn), math.sin(turn)

    def moved(x_m: float, y_m: float) -> tuple[float, float]:
        dx, dy = x_m - reported.x_m, y_m - reported.y_m
        return truth.x_m + c * dx - s * dy, truth.y_m + s * dx + c * dy

    return moved


def _elected(decision: Mapping[str, Any]) -> tuple[float, float] | None:
    """Goal point (map frame) of the frontier that a decision elected."""
    for frontier in decision.get("frontiers", ()):
        if frontier["id"] == decision.get("frontier"):
            x, y = frontier["goal_xy"]
            return float(x), float(y)
    return None
