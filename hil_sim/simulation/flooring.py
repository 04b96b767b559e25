"""The floor of a scene, which may have holes: what is seen of it, where a robot falls, and what
sensors under the robot's rim tell."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from hil_sim.scenes.format import Hole, Scene
from hil_sim.scenes.holes import depth_at
from hil_sim.simulation.body import Body
from hil_sim.simulation.shell import floor, pits
from runtime.core.types import Pose

FOOT_M = 0.09
"""Around the body's middle wheels and casters stand: it falls when one of them has no floor."""
FALL_M = 0.04
"""A step down that no wheel gets over unharmed."""
CLIFFS: dict[str, float] = {
    "cliff/front_left": math.radians(20.0),
    "cliff/front_right": math.radians(-20.0),
    "cliff/left": math.radians(65.0),
    "cliff/right": math.radians(-65.0),
}
"""Topics of the sensors that look down, and where at the rim each is, from ahead."""
CLIFF_RIM_M, CLIFF_Z_M = 0.16, 0.03
CLIFF_FAR_M = 0.2
"""They see no farther."""


class Flooring:
    """`draw` puts an OBJ into the picture and returns its number, by which `hide` takes it out."""

    def __init__(
        self,
        scene: Scene,
        scratch: Path,
        draw: Callable[[Path], int],
        hide: Callable[[int], None],
    ) -> None:
        self._scene, self._scratch = scene, scratch
        self._draw, self._hide = draw, hide
        self._drawn: list[int] = []
        self._laid = 0
        self._openings: tuple[Hole, ...] = ()
        self._lay()

    def open(self, bodies: tuple[Body, ...]) -> None:
        """Have the openings that are among these, and no others beside the scene's holes."""
        openings = tuple(hole_of(body) for body in bodies if body.kind == "opening")
        if openings != self._openings:
            self._openings = openings
            self._lay()

    def depth_at(self, x_m: float, y_m: float) -> float:
        """How far below the floor the ground is, m."""
        return depth_at((*self._scene.holes, *self._openings), x_m, y_m)

    def falls(self, x_m: float, y_m: float) -> bool:
        """Whether a robot that stands there falls."""
        if not self._scene.holes and not self._openings:
            return False
        feet = [(x_m, y_m)] + [
            (x_m + FOOT_M * math.cos(turn), y_m + FOOT_M * math.sin(turn))
            for turn in (n * math.tau / 8 for n in range(8))
        ]
        return any(self.depth_at(x, y) > FALL_M for x, y in feet)

    def cliffs(self, pose: Pose) -> dict[str, float]:
        """By topic, m from a sensor down to the ground; inf where that is out of its sight."""
        found = {}
        for topic, aside in CLIFFS.items():
            x = pose.x_m + CLIFF_RIM_M * math.cos(pose.yaw_rad + aside)
            y = pose.y_m + CLIFF_RIM_M * math.sin(pose.yaw_rad + aside)
            range_m = CLIFF_Z_M + self.depth_at(x, y)
            found[topic] = range_m if range_m <= CLIFF_FAR_M else math.inf
        return found

    def _lay(self) -> None:
        """Draw the floor as it is now, in place of the one before."""
        for number in self._drawn:
            self._hide(number)
        scene = replace(self._scene, holes=(*self._scene.holes, *self._openings))
        surfaces = [floor(scene, self._scratch)]
        if scene.holes:
            surfaces.append(pits(scene.holes, self._scratch))
        self._drawn = []
        for n, (surface, texture) in enumerate(surfaces):
            path = self._scratch / f"floor{self._laid}-{n}.obj"
            surface.write(path, texture)
            self._drawn.append(self._draw(path))
        self._laid += 1


def hole_of(body: Body) -> Hole:
    """An opening as a hole."""
    c, s = math.cos(body.yaw_rad), math.sin(body.yaw_rad)
    half_w, half_d = body.size_m[0] / 2, body.size_m[1] / 2
    corners = ((-half_w, -half_d), (half_w, -half_d), (half_w, half_d), (-half_w, half_d))
    polygon = tuple((body.x_m + c * x - s * y, body.y_m + s * x + c * y) for x, y in corners)
    return Hole(polygon, body.size_m[2])
