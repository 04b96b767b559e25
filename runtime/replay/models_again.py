"""The models run again beside a replay, which goes on with what they said then.

Compared with a tolerance, as a recording has colour as JPEG, and sums may come out otherwise on
another processor: a detection has a counterpart where one of the same class covers it by SAME_IOU
with a score within SAME_SCORE; a vote where the same expert names the same frontiers. Not compared:
detections weaker than WEAK, embeddings, the room and scene of a view, probabilities and reasons of
votes, how long an answer took, and experts that were late, busy or cut short then.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from runtime.clock import Deadline, SystemClock
from runtime.config import Config
from runtime.core.objects.surfaces import Window
from runtime.core.types import Absence, Ballot, Brief, Detections
from runtime.experts.panel import Panel
from runtime.loops.order import SearchModels

SAME_IOU: Final = 0.5
SAME_SCORE: Final = 0.2
WEAK: Final = 0.3
ENOUGH: Final = 0.8  # of what is compared must have a counterpart
RACES: Final = (Absence.LATE, Absence.BUSY, Absence.SETTLED, Absence.NO_TIME, Absence.AT_REST)


@dataclass
class Agreement:
    """Of how many what was said then is said again, and the first that was not."""

    same: int = 0
    of: int = 0
    first: str = ""

    def note(self, same: int, of: int, what: str) -> None:
        self.same, self.of = self.same + same, self.of + of
        if same < of and not self.first:
            self.first = what

    @property
    def enough(self) -> bool:
        return self.same >= ENOUGH * self.of

    def in_words(self, what: str) -> str:
        if not self.of:
            return f"models: no {what} were compared"
        told = f"models: {self.same} of {self.of} {what} come out alike"
        return f"{told}; first not so: {self.first}" if self.first else told


@dataclass
class ModelsAgain:
    """What the models say now, beside what they said then."""

    models: SearchModels
    detections: Agreement = field(default_factory=Agreement)
    votes: Agreement = field(default_factory=Agreement)
    _panel: Panel | None = None

    @property
    def alike(self) -> bool:
        """False, too, when nothing was compared."""
        compared = self.detections.of + self.votes.of
        return compared > 0 and self.detections.enough and self.votes.enough

    def accept(self, goal: str, config: Config) -> None:
        """A goal was accepted then."""
        _, self._panel = self.models.accept(goal, config)

    def look(
        self, turn: int, rgb: np.ndarray, window: Callable[[], Window | None], then: Detections
    ) -> None:
        """An image that was looked at then."""
        now = self.models.detect(rgb, window)
        pairs = _counterparts(then, now), _counterparts(now, then)
        for of, same in pairs:
            self.detections.note(same, of, f"turn {turn}")

    def ask(self, turn: int, brief: Brief, then: Ballot) -> None:
        """A brief that was voted on then."""
        if self._panel is None:
            return
        now = self._panel.ask(brief, Deadline.never(SystemClock()))
        raced = {m.expert for m in then.missing if m.why in RACES}
        mine, theirs = ({v.expert: v.frontiers for v in ballot.votes} for ballot in (now, then))
        asked = {v.expert for v in (*now.votes, *then.votes)}
        asked |= {m.expert for m in (*now.missing, *then.missing)}
        for expert in sorted(asked - raced):
            same = mine.get(expert) == theirs.get(expert)
            self.votes.note(int(same), 1, f"{expert} in turn {turn}")


def _counterparts(these: Detections, others: Detections) -> tuple[int, int]:
    """How many are compared, and how many of them have a counterpart."""
    strong = np.flatnonzero(these.scores >= WEAK)
    found = 0
    for n in strong:
        alike = others.labels == these.labels[n]
        alike &= np.abs(others.scores - these.scores[n]) <= SAME_SCORE
        alike &= _iou(these.boxes_px[n], others.boxes_px) >= SAME_IOU
        found += bool(alike.any())
    return len(strong), found


def _iou(box: np.ndarray, boxes: np.ndarray) -> np.ndarray:
    """(4,) and (N, 4) px -> (N,)."""
    low, high = np.maximum(box[:2], boxes[:, :2]), np.minimum(box[2:], boxes[:, 2:])
    shared = np.prod(np.maximum(high - low, 0.0), axis=1)
    sizes = np.prod(boxes[:, 2:] - boxes[:, :2], axis=1) + np.prod(box[2:] - box[:2])
    share: np.ndarray = shared / np.maximum(sizes - shared, 1e-9)
    return share
