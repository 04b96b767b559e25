"""A camera without a process: what is looked at is seen at the next tick."""

from corridor import Corridor

from hil_sim.driving.camera_process import Glance, Shot
from runtime.core.types import Pose


class Blink:
    def __init__(self) -> None:
        self.busy = False
        self.glances: list[Glance] = []

    def look(self, glance: Glance) -> None:
        self.busy = True
        self.glances.append(glance)

    def seen(self) -> Shot:
        self.busy = False
        view = Corridor().look(Pose(2.0, self.glances[-1].pose.y_m, 0.0))
        return Shot(view.rgb, view.depth_m, view.depth_m, view.segmentation)
