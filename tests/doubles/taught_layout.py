"""Stand-ins for the network that was taught what lies beyond a view, and for a language model that
is shown its tokens."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np


class Outputs(NamedTuple):
    beyond: np.ndarray
    tokens: np.ndarray


class TaughtLayout:
    """Its evidence is the first feature of a view, for a goal whose row is 1; it counts looks."""

    template, text = " Further on there is a", "{}"
    detector, language, speaks = "detector", "language", True

    def __init__(self) -> None:
        self.blank = np.zeros((2, 4), np.float32)
        self.ways: list[tuple[float, ...]] = []

    def look(self, features: np.ndarray, depth: np.ndarray, way: np.ndarray) -> Outputs:
        assert (features.dtype, depth.dtype, way.dtype) == (np.float32,) * 3
        assert (features.ndim, depth.shape[1], way.shape) == (4, 2, (len(features), 2))
        self.ways += [tuple(row) for row in way.tolist()]
        first = features[:, 0, 0, :1]
        tokens = np.repeat(first[:, None], 2, axis=1) * np.ones((1, 1, 4), np.float32)
        return Outputs(np.concatenate((first, way), axis=1), tokens)

    def evidence(self, beyond: np.ndarray, goal_row: np.ndarray) -> np.ndarray:
        return beyond[:, 0] * goal_row[0]


class ShownModel:
    """Finds a toilet likelier by the first number of what it is shown, and a lamp likely always."""

    def __init__(self) -> None:
        self.shown: list[float] = []

    def score(
        self, context: str, continuations: Sequence[str], seen: np.ndarray | None = None
    ) -> list[float]:
        assert seen is not None
        assert seen.shape == (2, 4)
        self.shown.append(float(seen[0, 0]))
        liked = {" toilet": -9.0 + float(seen[0, 0]), " lamp": -1.0}
        return [liked.get(word, -5.0) for word in continuations]
