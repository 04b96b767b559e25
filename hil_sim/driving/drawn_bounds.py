"""What people draw for a robot, told to the runtime for one episode: keep-out zones, and the area
that a goal is bound to."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from hil_sim.driving.link import HarnessError
from hil_sim.driving.stage import Driver
from hil_sim.ground_truth.witness import to_scene
from runtime.core.types import Pose

Corners = Sequence[tuple[float, float]]
ORIGIN: Final = Pose(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class DrawnBounds:
    """Polygons in the scene's frame: zones by name, and an area; without corners there is none."""

    zones: Mapping[str, Corners] = field(default_factory=dict)
    area: Corners = ()

    def draw(self, driver: Driver, start: Pose) -> dict[str, object]:
        """Have the zones drawn for a robot whose map begins at `start`; what the goal's request
        says of the area. HarnessError when the runtime takes one for none."""
        in_map = to_scene(ORIGIN, start)
        for name, corners in self.zones.items():
            polygon = [in_map(*xy) for xy in corners]
            reply = driver.ask("zones", {"add": name, "polygon": polygon})
            if not reply.get("accepted"):
                raise HarnessError(str(reply.get("error") or "the runtime refused a zone"))
        return {"area": {"polygon": [in_map(*xy) for xy in self.area]}} if self.area else {}

    def wipe(self, driver: Driver) -> None:
        """Have no zones any more."""
        if self.zones:
            driver.ask("zones", {"clear": True})


UNBOUND: Final = DrawnBounds()
