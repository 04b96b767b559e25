"""When what single looks tell of where the robot is on a map that it knew is settled."""

import math
from dataclasses import dataclass
from typing import Final

from runtime.core.geometry import placed, seen_from, wrap_angle
from runtime.core.types import Pose

SETTLED_M: Final = 1.0  # between two looks that tell the same
SAME_PLACE_M, SAME_HEADING_RAD = 0.3, math.radians(6.0)


@dataclass
class Settling:
    """A match is believed when a second one, from another place, tells the same."""

    _first: tuple[Pose, Pose] | None = None  # where the robot was, here and on the known map

    def settles(self, here: Pose, at: Pose) -> bool:
        """Told of each match that is `believed`."""
        if self._first is None:
            self._first = here, at
            return False
        was, was_at = self._first
        expected = placed(was_at, seen_from(was, here))
        apart_m = math.dist((expected.x_m, expected.y_m), (at.x_m, at.y_m))
        turned = abs(wrap_angle(expected.yaw_rad - at.yaw_rad))
        if apart_m > SAME_PLACE_M or turned > SAME_HEADING_RAD:
            self._first = here, at
            return False
        return math.dist((was.x_m, was.y_m), (here.x_m, here.y_m)) >= SETTLED_M
