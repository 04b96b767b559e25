"""A mind without models: it sees what the apartment tells it to, and its experts are given."""

import numpy as np
from apartment import NO_DETECTIONS, Apartment

from runtime.config import Config
from runtime.core.types import Brief, Detections, Missing, Vote
from runtime.edge.clock import Deadline, SystemClock
from runtime.edge.panel import Panel
from runtime.errors import ConfigError
from runtime.goal import Goal


def broken(brief: Brief, by: Deadline) -> Vote | Missing:
    raise RuntimeError("the model fell over")


def farthest(brief: Brief, by: Deadline) -> Vote | Missing:
    far = max(brief.frontiers, key=lambda f: f.distance_m).id
    return Vote("", (far,), ((far, 1.0),), "it is far")


class FakeMind:
    """Sees what the apartment tells it to; its experts are given."""

    rooms = ("bathroom",)

    def __init__(self, home: Apartment, **experts) -> None:
        self.panel = Panel(experts, SystemClock())
        self.home = home
        self.finished = 0

    def accept(self, goal: str, config: Config) -> tuple[Goal, Panel]:
        if not goal:
            raise ConfigError("goal: is empty")
        return Goal(goal, goal, ((goal,),), "as it is"), self.panel

    def detect(self, rgb: np.ndarray) -> Detections:
        if not self.home.things:
            return NO_DETECTIONS
        return self.home.detect(tuple(self.home.things), self.home.observe())

    def notice(self, goal: str, names: tuple[str, ...]) -> None:
        pass

    def rung(self) -> str:
        return "none"

    def health(self) -> dict[str, object]:
        return {"rungs": {}, "errors": []}

    def bills(self) -> tuple[object, ...]:
        return ()

    def finish(self) -> None:
        self.finished += 1
