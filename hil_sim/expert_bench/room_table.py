"""What the scene-layout expert is compared with: the room type of a view, and a table of how often
each thing is found from rooms of that type. No picture, and no language model."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hil_sim.expert_bench.view_questions import Floats, Indices, ViewQuestions

LAPLACE = 1.0
"""Answers of each kind that are taken to be counted already."""
LIKENESS_SCALE = 0.05
"""Cosine of two names at which one tells e times less of the other."""


@dataclass(frozen=True)
class RoomTable:
    """`share` (R, C): of questions about a category asked from a room type, how many are true."""

    share: NDArray[np.float64]

    @classmethod
    def fit(cls, questions: ViewQuestions) -> "RoomTable":
        """Counted over train homes, rooms as the detector's head has them: each question in all
        room types, by their probabilities."""
        rooms = _probabilities(questions.sights.rooms)
        found = rooms.T @ (questions.asked & questions.true).astype(np.float64)
        asked = rooms.T @ questions.asked.astype(np.float64)
        return cls((found + LAPLACE) / (asked + 2 * LAPLACE))

    def guessing(self, never: Sequence[int], name_rows: Floats) -> "RoomTable":
        """The table of one who has never counted the categories `never`, and takes for them what
        others are that are called alike; `name_rows` (C, D) unit embeddings of all names."""
        counted = np.setdiff1d(np.arange(self.share.shape[1]), never)
        likeness = name_rows[list(never)] @ name_rows[counted].T / LIKENESS_SCALE
        weights = np.exp(likeness - likeness.max(axis=1, keepdims=True))
        share = self.share.copy()
        share[:, list(never)] = self.share[:, counted] @ (weights.T / weights.sum(axis=1))
        return RoomTable(share)

    def score(self, rooms: Floats, names: Indices) -> NDArray[np.float64]:
        """(N, R) the head's rooms -> (N, K) how likely each of those categories is, nats."""
        scores: NDArray[np.float64] = np.log(_probabilities(rooms) @ self.share[:, names])
        return scores


def _probabilities(rooms: Floats) -> NDArray[np.float64]:
    rows = np.maximum(rooms.astype(np.float64), 1e-6)
    shares: NDArray[np.float64] = rows / rows.sum(axis=1, keepdims=True)
    return shares
