"""The bound `oracle-goal`: the shortest way in the robot's own actions, found with the true map.

It stands where a runtime would, so that the same loop drives it and the same rules judge it.
"""

import heapq
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.driving.link import Answer, HarnessError
from hil_sim.ground_truth.freespace import FreeSpace
from hil_sim.simulation.protocol import Protocol
from runtime.core.types import Action, Pose
from runtime.core.world import Mode

TURN_COST_M = 0.01
"""Of two ways equally long, the one with fewer turns."""
HASTE = 1.05
"""The way found is at most this much longer than the best, and found ten times sooner."""
MERGE_M = 0.05
"""Poses of one heading that are this close are searched on from once."""
SAMPLE_M = 0.025
LIMIT = 300_000
"""Poses that a search may visit."""
TURNS = {Action.TURN_LEFT: 1, Action.TURN_RIGHT: -1}

Way = list[tuple[Pose, Action]]  # where the robot is, and what it does there
Key = tuple[int, int, int]


@dataclass
class ShortestPath:
    """Answers as a runtime does, from what only the harness knows.

    `success` (N, 2) cells; `where` says where the robot really is, `aim` which way to face at the
    end from there (None: any way).
    """

    space: FreeSpace
    success: NDArray[np.integer]
    protocol: Protocol
    where: Callable[[], Pose]
    aim: Callable[[Pose], float | None] = lambda pose: None
    _way: Way = field(default_factory=list)
    _field: NDArray[np.float64] | None = None

    def ask(self, query: str, body: dict[str, object], timeout_s: float = 0.0) -> Any:
        """Every goal is accepted."""
        self._way = []
        return {"accepted": True, "seconds": {}}

    def forget(self) -> None:
        """Nothing is remembered between episodes."""

    def next_action(self, pose: Pose) -> Action:
        """What it will do at a pose; HarnessError when no way leads to success."""
        if not self._way or not _same(self._way[0][0], pose):  # off the way: find another
            if self._field is None:
                inner = _inner(self.success, self.space.free.shape)
                self._field = self.space.distance_field(self.space.points(inner))
            self._way = shortest_way(self.space, self._field, pose, self.protocol)
            last, _ = self._way.pop()
            self._way += _facing(last, self.aim(last), self.protocol.turn_rad)
        return self._way[0][1]

    def exchange(self, *seen: object, **more: object) -> Answer:
        """The next action, as a runtime says it."""
        action = self.next_action(self.where())
        self._way.pop(0)
        mode = Mode.STOP if action is Action.STOP else Mode.TARGET
        return Answer(action, {"mode": mode, "reason": "the shortest path"}, ())


def shortest_way(
    space: FreeSpace, field_m: NDArray[np.float64], start: Pose, protocol: Protocol
) -> Way:
    """A* over the robot's own steps and turns to where `field_m` (H, W), geodesic metres to
    success, is 0; the last action is STOP. HarnessError when there is no such way."""
    settled: set[Key] = set()
    count = itertools.count()
    came: dict[int, tuple[int, Action, Pose]] = {}
    queue: list[tuple[float, int, float, int, Pose, int]] = []
    queue.append((0.0, next(count), 0.0, 0, start, -1))
    actions: dict[int, Action] = {0: Action.STOP}
    while queue and len(settled) < LIMIT:
        _, number, cost, turns, pose, parent = heapq.heappop(queue)
        key = (round(pose.x_m / MERGE_M), round(pose.y_m / MERGE_M), _heading(turns, protocol))
        if key in settled:
            continue
        settled.add(key)
        came[number] = (parent, actions[number], pose)
        if space.distance(field_m, pose.x_m, pose.y_m) <= 0.0:
            return _back(came, number)
        for action, turned, after, price in _moves(space, pose, turns, protocol):
            left = space.distance(field_m, after.x_m, after.y_m)
            if math.isfinite(left):
                child = next(count)
                actions[child] = action
                rank = cost + price + HASTE * left
                heapq.heappush(queue, (rank, child, cost + price, turned, after, number))
    raise HarnessError("oracle-goal: no way in the robot's own steps leads to success")


def _moves(
    space: FreeSpace, pose: Pose, turns: int, protocol: Protocol
) -> list[tuple[Action, int, Pose, float]]:
    """What can be done at a pose: action, turns to the left since the start, pose after, cost."""
    found = []
    for action, way in TURNS.items():
        yaw = _wrapped(pose.yaw_rad + way * protocol.turn_rad)
        found.append((action, turns + way, Pose(pose.x_m, pose.y_m, yaw), TURN_COST_M))
    step, c, s = protocol.step_m, math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    ahead = Pose(pose.x_m + step * c, pose.y_m + step * s, pose.yaw_rad)
    reach = np.arange(1, math.ceil(step / SAMPLE_M) + 1) * SAMPLE_M
    if all(space.is_free(pose.x_m + d * c, pose.y_m + d * s) for d in reach):
        found.append((Action.MOVE_FORWARD, turns, ahead, step))
    return found


def _back(came: dict[int, tuple[int, Action, Pose]], number: int) -> Way:
    """From the start to a node, and STOP there."""
    way: Way = [(came[number][2], Action.STOP)]
    while came[number][0] >= 0:
        parent, action, _ = came[number]
        way.append((came[parent][2], action))
        number = parent
    return way[::-1]


def _facing(pose: Pose, yaw_rad: float | None, turn_rad: float) -> Way:
    """Turns on the spot until no further one helps, then STOP."""
    way: Way = []
    while yaw_rad is not None:
        off = _wrapped(yaw_rad - pose.yaw_rad)
        if abs(off) <= turn_rad / 2 + 1e-9:
            break
        action = Action.TURN_LEFT if off > 0 else Action.TURN_RIGHT
        way.append((pose, action))
        yaw = _wrapped(pose.yaw_rad + TURNS[action] * turn_rad)
        pose = Pose(pose.x_m, pose.y_m, yaw)
    return [*way, (pose, Action.STOP)]


def _inner(cells: NDArray[np.integer], shape: tuple[int, ...]) -> NDArray[np.int64]:
    """Success cells with success all around, if there are any: not to stop on the very edge."""
    mask = np.zeros(shape, np.uint8)
    mask[tuple(cells.T)] = 1
    inner = np.argwhere(cv2.erode(mask, np.ones((3, 3), np.uint8)))
    return inner if len(inner) else np.asarray(cells, np.int64)


def _heading(turns: int, protocol: Protocol) -> int:
    return turns % max(1, round(math.tau / protocol.turn_rad))


def _same(a: Pose, b: Pose) -> bool:
    apart = math.hypot(a.x_m - b.x_m, a.y_m - b.y_m)
    return apart < 1e-6 and abs(_wrapped(a.yaw_rad - b.yaw_rad)) < 1e-6


def _wrapped(angle_rad: float) -> float:
    return math.remainder(angle_rad, math.tau)
