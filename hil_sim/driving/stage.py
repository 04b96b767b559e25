"""What an episode is played on: a home that is looked at and driven in, and whoever drives."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any
from typing import Protocol as Port

import numpy as np
from numpy.typing import NDArray

from hil_sim.driving.link import NOTHING, Answer, Votes
from hil_sim.ground_truth.witness import Footprint, Things
from hil_sim.scenes.format import Scene
from hil_sim.simulation.body import Body
from hil_sim.simulation.robot import Ground, Robot
from runtime.core.types import Intrinsics, Pose

Ranges = NDArray[np.float32]  # (N,) m around the robot, see `sensors.encode_scan`


class RenderedView(Port):
    """What a camera saw."""

    @property
    def rgb(self) -> NDArray[np.uint8]: ...  # (H, W, 3)

    @property
    def depth_m(self) -> NDArray[np.float32]: ...  # (H, W) true, 0 where nothing is

    @property
    def segmentation(self) -> NDArray[np.int32]: ...  # (H, W) index into scene.objects, or -1


class Driver(Port):
    """Whoever answers observations with actions: the runtime, or a bound that stands in for it."""

    def ask(self, query: str, body: dict[str, object]) -> Any: ...

    def forget(self) -> None: ...

    def exchange(
        self,
        stamp_ns: int,
        rgb: NDArray[np.uint8],
        depth_m: NDArray[np.float32],
        odometry: Pose,
        intrinsics: Intrinsics,
        labels: dict[str, Any] | None = None,
        beside: Mapping[str, bytes] = NOTHING,
        votes: Votes | None = None,
    ) -> Answer: ...


@dataclass(frozen=True)
class StagedHome:
    """A scene that can be looked at and driven in, and the truth about one goal in it.

    `wanted` are the indices of the goal's instances in `scene.objects` and in the segmentation,
    `goal_boxes` their footprints, `things` all that stands there.
    """

    ground: Ground
    look: Callable[[Pose], RenderedView]  # scene frame
    distance_m: Callable[[Pose], float]  # geodesic, to the goal's nearest success position
    scene: Scene
    wanted: tuple[int, ...]
    goal_boxes: tuple[Footprint, ...]
    populate: Callable[[tuple[Body, ...]], None] = lambda bodies: None  # with these, no others
    scan: Callable[[Pose], Ranges] | None = None  # a laser scanner's
    cliffs: Callable[[Pose], Mapping[str, float]] | None = None  # by topic, m down to the ground
    things: Things = ()


@dataclass(frozen=True)
class Step:
    """What happened in one step, for whoever watches."""

    number: int
    answer: Answer | None  # None: nothing was asked
    robot: Robot  # after the action
    distance_m: float
