"""What the detector has looked at, and which of the images that wait shows most that is new.

A detector may be slower than the camera: of the images that came meanwhile, the newest is not
always the one that shows what nobody has looked at yet.
"""

import math
from dataclasses import dataclass, field
from typing import Generic, TypeVar

import numpy as np

from runtime.core.types import F64, Pose

RANGE_M = 4.0  # what is farther away is hardly recognised: it has not been looked at
BEYOND_M = 0.3  # the free range ends where the furniture begins that is to be looked at
PATCH_M = 0.25  # side of the squares that are counted
RAY_STRIDE = 4  # every n-th azimuth of an outline
SIDES = 8  # headings from which a patch may be looked at
OTHER_SIDE = 0.25  # what a patch is worth that was looked at, but not from this side
WORTH = 6.0  # patches that are new, for which an image is looked at that is not the newest
KEPT = 5  # images that wait
_WIDE = 1 << 32  # patches of a row

Item = TypeVar("Item")


@dataclass(frozen=True)
class View:
    """The patches of the floor that an image shows from near, by number, and from which side."""

    patches: frozenset[int]
    side: int


def view_of(outline: F64, pose: Pose) -> View:
    """What is seen from `pose`: `outline` (V, 2) m, map frame, begins with the camera."""
    apex, offset = outline[0], outline[1::RAY_STRIDE] - outline[0]
    reach = np.maximum(np.hypot(*offset.T), 1e-6)
    along = np.arange(PATCH_M / 2, RANGE_M, PATCH_M)
    points = apex + (offset / reach[:, None])[:, None] * along[:, None]  # (V', A, 2)
    seen = along[None] <= (reach + BEYOND_M)[:, None]
    cells = np.floor(points[seen] / PATCH_M).astype(np.int64)
    numbers = np.unique(cells[:, 0] * _WIDE + cells[:, 1])
    side = int((pose.yaw_rad % math.tau) / math.tau * SIDES) % SIDES
    return View(frozenset(numbers.tolist()), side)


@dataclass
class Waiting(Generic[Item]):
    """An image that nobody has looked at, `item` being whatever it is to its owner."""

    item: Item
    view: View


@dataclass
class Attention(Generic[Item]):
    """The images that wait, the newest last, KEPT at most, and what was looked at so far: by patch
    the sides, one bit each. `newest_only`: the others are of no use."""

    newest_only: bool = False
    waiting: list[Waiting[Item]] = field(default_factory=list)
    _looked: dict[int, int] = field(default_factory=dict)
    _took_older: bool = False

    def offer(self, item: Item, view: View) -> None:
        """One more image. When there are too many, the one goes that adds least to the others; the
        newest stays."""
        if self.newest_only:
            self.waiting.clear()
        self.waiting.append(Waiting(item, view))
        if len(self.waiting) > KEPT:
            self.waiting.remove(self._least())

    def take(self, newest: bool = False) -> Item | None:
        """The image to look at now, which counts as looked at: the one that shows most that is new,
        when that is worth it, else the newest. Every other one is the newest, whatever waits."""
        if not self.waiting:
            return None
        chosen = self.waiting[-1]
        if not (newest or self._took_older):
            best = max(self.waiting, key=lambda w: self.novelty(w.view))
            chosen = best if self.novelty(best.view) >= WORTH else chosen
        self._took_older = chosen is not self.waiting[-1]
        self.waiting.remove(chosen)
        _book(self._looked, chosen.view)
        if not self._took_older:  # older ones wait only for what is new in them
            self.waiting = [w for w in self.waiting if self.novelty(w.view) >= WORTH]
        return chosen.item

    def news(self) -> bool:
        """Whether an image waits that shows something new."""
        return any(self.novelty(w.view) >= WORTH for w in self.waiting)

    def novelty(self, view: View) -> float:
        """How many patches of a view nobody has looked at; those seen from other sides count
        OTHER_SIDE."""
        return _novelty(self._looked, view)

    def _least(self) -> Waiting[Item]:
        """Of all but the newest the one that adds least: chosen last when the best of what the
        better ones leave is chosen again and again."""
        *older, newest = self.waiting
        looked = self._looked | {}
        _book(looked, newest.view)
        while len(older) > 1:
            best = max(older, key=lambda w: _novelty(looked, w.view))
            _book(looked, best.view)
            older.remove(best)
        return older[0]


def _novelty(looked: dict[int, int], view: View) -> float:
    bit, new, other = 1 << view.side, 0, 0
    for patch in view.patches:
        sides = looked.get(patch, 0)
        if not sides:
            new += 1
        elif not sides & bit:
            other += 1
    return new + OTHER_SIDE * other


def _book(looked: dict[int, int], view: View) -> None:
    bit = 1 << view.side
    for patch in view.patches:
        looked[patch] = looked.get(patch, 0) | bit
