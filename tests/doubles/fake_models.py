"""Models that are not there: what they see is what the apartment tells, and experts are given."""

from dataclasses import replace

import numpy as np
from apartment import NO_DETECTIONS, Apartment

from runtime.clock import Deadline, SystemClock
from runtime.config import Config
from runtime.core.types import Brief, Detections, Missing, Vote
from runtime.errors import ConfigError
from runtime.experts.panel import Panel
from runtime.perception.goal_words import Goal


def broken(brief: Brief, by: Deadline) -> Vote | Missing:
    raise RuntimeError("the model fell over")


def farthest(brief: Brief, by: Deadline) -> Vote | Missing:
    far = max(brief.frontiers, key=lambda f: f.distance_m).id
    return Vote("", (far,), ((far, 1.0),), "it is far")


BEANBAG = np.array([1.0, 0.0], np.float32)
"""What a beanbag looks like, in the space of words (2,)."""


class FakeModels:
    """Sees what the apartment tells it to; its experts are given."""

    rooms = ("bathroom",)

    def __init__(self, home: Apartment, **experts) -> None:
        self.panel = Panel(experts, SystemClock())
        self.home = home
        self.finished = 0
        self.asked: list[str] = []
        self.afforded: list[float | None] = []

    def accept(self, goal: str, config: Config) -> tuple[Goal, Panel]:
        if not goal:
            raise ConfigError("goal: is empty")
        self.asked.append(goal)
        return Goal(goal, goal, ((goal,),), "as it is"), self.panel

    def hear(self, text: str, config: Config, several: bool) -> tuple[Goal, ...]:
        things = text.split(" and ") if several else [text]
        if not all(things) or (" and " in text and not several):
            raise ConfigError(f"goal: {text!r} names no thing, or several")
        return tuple(Goal(thing, thing, ((thing,),), "as it is") for thing in things)

    def afford(self, usd: float | None) -> None:
        self.afforded.append(usd)

    def detect(self, rgb: np.ndarray, window: object = None) -> Detections:
        if not self.home.things:
            return NO_DETECTIONS
        return self.home.detect(tuple(self.home.things), self.home.of_image(rgb))

    def notice(self, goal: str, names: tuple[str, ...]) -> None:
        pass

    def hold(self, frames: object) -> None:
        pass

    def settle(self, by: Deadline) -> bool:
        return True

    def likeness(self, embeddings: np.ndarray) -> np.ndarray:
        raise AssertionError("what the apartment shows has no embeddings")

    def capabilities(self) -> dict[str, object]:
        return {"contract": "fake"}

    def rung(self) -> str:
        return "none"

    def health(self) -> dict[str, object]:
        return {"rungs": {}, "errors": []}

    def bills(self) -> tuple[object, ...]:
        return ()

    def finish(self) -> None:
        self.finished += 1


class Wordy(FakeModels):
    """It knows sofas, and what it is asked for; it sees a beanbag, which it calls a sofa as long
    as it was not told better."""

    def accept(self, goal: str, config: Config) -> tuple[Goal, Panel]:
        self.names = tuple(dict.fromkeys((goal, "sofa")))
        return Goal(goal, goal, tuple((n,) for n in self.names), "as it is"), self.panel

    def likeness(self, embeddings: np.ndarray) -> np.ndarray:
        alike = {"beanbag": 0.9, "sofa": 0.6}
        return (embeddings @ BEANBAG)[:, None] * [[alike.get(n, 0.01) for n in self.names]]

    def detect(self, rgb: np.ndarray, window: object = None) -> Detections:
        seen = self.home.detect(("beanbag",), self.home.of_image(rgb))
        name = "beanbag" if "beanbag" in self.names else "sofa"
        rows = np.repeat(BEANBAG[None], len(seen.scores), axis=0)
        return replace(seen, labels=seen.labels * 0 + self.names.index(name), embeddings=rows)
