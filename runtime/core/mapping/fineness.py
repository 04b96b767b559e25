"""How finely each place was looked at: a surface seen only from afar may hold what is small.

Beside the navigation map, in cells twice as wide: by cell the most pixels to a metre that an image
which the detector looked at had of what stands or lies there, and from which sides about so finely.
What of that is likely to have been missed follows from how large the thing is and how well the
detector finds what is so many pixels large.
"""

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from runtime.core.geometry import GridFrame, camera_at, rays
from runtime.core.mapping.grid import NavigationMap
from runtime.core.mapping.windows import Window, padded
from runtime.core.types import F32, I32, U8, Mask, Mount, Observation

WIDER: Final = 2  # cells of the map to a side of one here
STRIDE: Final = 4  # every n-th pixel of the depth image
FLOOR_BELOW_M: Final = 0.07  # as the navigation map has it
HIGHEST_M: Final = 1.6  # what is higher holds little that is looked for
LEVEL: Final = 0.25  # of the way along a column of the image that a level surface rises at most
LEVEL_M: Final = (0.2, 1.4)  # heights of surfaces that something stands on
IMAGE_PX: Final = 640  # pixels are those of an image so wide: detectors bring all to one size
FINEST, COARSEST = 12.0, 4.0  # log2 of pixels a metre: what is told apart
STEPS: Final = 254.0 / (FINEST - COARSEST)  # codes to a doubling; code 0: never seen
ABOUT: Final = 0.5  # doublings by which looks may differ that count as equally fine
FLOOR, RAISED = 0, 1  # layers: what lies on the floor, what stands on it or is borne by it

SIZE_M: Final = 0.25  # of what nobody knows the size of
OTHER_SIDES: Final = 0.3  # of a look, that one more from another side is worth: they err alike


@dataclass(frozen=True)
class Recall:
    """What share of the things of a size, the root of their box's area in px, a detector finds in
    an image IMAGE_PX wide: `top` at most, half of that at `half_px`, steeper the more `gain` (per
    doubling) is. Of the detectors that ship, as `rfnav models evaluate` prints it."""

    top: float = 0.78
    half_px: float = 22.6
    gain: float = 1.6

    def of(self, size_px: F32 | float) -> F32:
        """(...) px -> (...) share."""
        doublings = np.log2(np.maximum(np.asarray(size_px, np.float32), 1e-3) / self.half_px)
        return np.asarray(self.top / (1.0 + np.exp(-self.gain * doublings)), np.float32)


@dataclass(frozen=True)
class GoalSize:
    """What is looked for: how large it looks, the root of its box's area in m; what share of such
    things stands on the floor; how well the detector sees things of a size; how far one may reach
    from its middle, m."""

    size_m: float = SIZE_M
    on_floor: float = 0.2
    recall: Recall = field(default_factory=Recall)
    reaches_m: float = math.inf


@dataclass
class Fineness:
    """Layers over `frame`, cells WIDER than the map's; owned by who owns the map.

    fine: (2, R, C) codes of pixels a metre, of FLOOR and RAISED; 0 where nothing was seen.
    sides: (2, R, C) a bit for each eighth of a turn that it was seen from about so finely.
    level: (R, C) whether a level surface was seen there, above the floor."""

    frame: GridFrame | None = None
    fine: U8 = field(default_factory=lambda: np.zeros((2, 0, 0), np.uint8), repr=False)
    sides: U8 = field(default_factory=lambda: np.zeros((2, 0, 0), np.uint8), repr=False)
    level: Mask = field(default_factory=lambda: np.zeros((0, 0), bool), repr=False)
    first: tuple[int, int] = (0, 0)  # row and column that the first frame's corner has now

    def afresh(self) -> "Fineness":
        """For another goal: what surfaces there are is known, that they were looked at is not."""
        return replace(self, fine=np.zeros_like(self.fine), sides=np.zeros_like(self.sides))

    def look(self, grid: NavigationMap, obs: Observation, mount: Mount, max_depth_m: float) -> None:
        """Book an image that the detector looked at. The map reaches as far as it shows."""
        frame = self.fit(grid.frame)
        table, half = rays(obs.intrinsics, mount, STRIDE), STRIDE // 2
        read = obs.depth_m[half::STRIDE, half::STRIDE]
        with np.errstate(invalid="ignore"):
            valid = (read > 0.0) & (read <= max_depth_m)
        depth = np.where(valid, read, np.float32(0.0))
        up = depth * table.up + np.float32(mount.z_m)
        valid &= (up > -FLOOR_BELOW_M) & (up < HIGHEST_M)
        level = _level(depth, up) & valid
        (x_m, y_m), (c, s) = camera_at(obs.pose, mount)
        ahead, left = (depth[valid] * of[valid] for of in (table.forward, table.left))
        per_m = np.float32(1.0 / frame.resolution_m)
        cols = (np.float32(x_m - frame.x0_m) + c * ahead - s * left) * per_m
        rows = (np.float32(y_m - frame.y0_m) + s * ahead + c * left) * per_m
        cells = np.stack([rows, cols], axis=1).astype(np.int32)
        window = _around(cells, frame)
        if window is None:
            return
        height, width = (part.stop - part.start for part in window)
        places = (cells[:, 0] - window[0].start) * width + cells[:, 1] - window[1].start
        seen = np.zeros(2 * height * width, np.uint8)
        raised = (up[valid] >= FLOOR_BELOW_M) * (height * width)
        one_m = np.float32(px_m_from(obs.intrinsics.fx, obs.intrinsics.width, 1.0))
        np.maximum.at(seen, places + raised, codes(np.asarray(one_m / depth[valid], np.float32)))
        borne = np.zeros(height * width, bool)
        borne[places[level[valid]]] = True
        self.level[window] |= borne.reshape(height, width)
        self._book(window, seen.reshape(2, height, width), _sides(frame, window, x_m, y_m))

    def _book(self, window: Window, seen: U8, side: U8) -> None:
        """Codes of an image (2, h, w), seen from the side whose bit (h, w) is told."""
        fine, sides = self.fine[:, *window], self.sides[:, *window]
        margin = round(ABOUT * STEPS)
        new, old = seen.astype(np.int16), fine.astype(np.int16)
        finer = new > old + margin
        alike = (new > 0) & (new >= old - margin)
        sides[:] = np.where(finer, side, np.where(alike, sides | side, sides))
        fine[:] = np.maximum(fine, seen)

    def fit(self, of: GridFrame) -> GridFrame:
        """The layers reach as far as a map's frame that may have grown since; their frame."""
        side_m = WIDER * of.resolution_m
        wanted = GridFrame(of.x0_m, of.y0_m, side_m, of.rows // WIDER, of.cols // WIDER)
        if self.frame is None:
            self.fine, self.sides = np.zeros((2, 2, *wanted.shape), np.uint8)
            self.level = np.zeros(wanted.shape, bool)
        elif self.frame != wanted:
            top = round((self.frame.y0_m - wanted.y0_m) / side_m)
            left = round((self.frame.x0_m - wanted.x0_m) / side_m)
            bottom = wanted.rows - self.frame.rows - top
            pad = top, bottom, left, wanted.cols - self.frame.cols - left
            self.fine, self.sides = padded(self.fine, pad), padded(self.sides, pad)
            self.level = padded(self.level, pad)
            self.first = self.first[0] + top, self.first[1] + left
        self.frame = wanted
        return wanted

    def missed(self, wanted: GoalSize, window: Window) -> F32:
        """(2, r, c) how likely what is looked for was missed where it is, by layer."""
        sides = _COUNT[self.sides[:, *window]]
        return _missed_table(wanted)[self.fine[:, *window], sides]


def codes(px_m: F32) -> U8:
    """(...) pixels a metre -> (...) codes, 1 at least."""
    doublings = np.log2(px_m) - np.float32(COARSEST)
    return np.asarray(np.clip(doublings * np.float32(STEPS) + 1.0, 1, 255), np.uint8)


def px_m(codes: U8) -> F32:
    """(...) codes -> (...) pixels a metre; 0 for what was never seen."""
    found = 2.0 ** ((codes.astype(np.float32) - 0.5) / np.float32(STEPS) + np.float32(COARSEST))
    return np.asarray(np.where(codes > 0, found, 0.0), np.float32)


def px_m_from(focal_px: float, width_px: int, away_m: float) -> float:
    """Pixels a metre of what is so far away, in an image IMAGE_PX wide."""
    return focal_px * IMAGE_PX / width_px / away_m


def missed_at(wanted: GoalSize, px_m: float) -> float:
    """How likely what is looked for was missed, where it was looked at once, so finely."""
    return float(1.0 - wanted.recall.of(px_m * wanted.size_m))


@lru_cache(maxsize=8)
def _missed_table(wanted: GoalSize) -> F32:
    """(256, 9) by code and number of sides."""
    every = np.arange(256).astype(np.uint8)
    once = 1.0 - wanted.recall.of(px_m(every) * np.float32(wanted.size_m))
    more = 1.0 + OTHER_SIDES * np.maximum(np.arange(9) - 1, 0)
    table = np.asarray(once[:, None] ** more, np.float32)
    table[0] = 1.0
    return table


_COUNT = np.array([n.bit_count() for n in range(256)], np.uint8)


def _level(depth: F32, up: F32) -> Mask:
    """(h, w) pixels of level surfaces above the floor: below the pixel above them they lie nearer,
    and hardly lower."""
    low, high = LEVEL_M
    rise, run = np.abs(np.diff(up, axis=0)), np.abs(np.diff(depth, axis=0))
    level = np.zeros(depth.shape, bool)
    level[1:] = (rise < LEVEL * run) & (up[1:] > low) & (up[1:] < high) & (depth[:-1] > 0)
    return level


def _around(cells: I32, frame: GridFrame) -> Window | None:
    """The window that holds some cells, all of which the frame has; None for none."""
    if not len(cells):
        return None
    (top, left), (bottom, right) = cells.min(axis=0).tolist(), cells.max(axis=0).tolist()
    if top < 0 or left < 0 or bottom >= frame.rows or right >= frame.cols:
        return None  # a pose that is off the map, as after a jump
    return slice(top, bottom + 1), slice(left, right + 1)


def _sides(frame: GridFrame, window: Window, x_m: float, y_m: float) -> U8:
    """(h, w) by cell the bit of the eighth of a turn in which the camera is."""
    r = frame.resolution_m
    x = (np.arange(window[1].start, window[1].stop) + 0.5) * r + frame.x0_m - x_m
    y = ((np.arange(window[0].start, window[0].stop) + 0.5) * r + frame.y0_m - y_m)[:, None]
    return sides_of(-x, -y)


def sides_of(x_m: NDArray[np.floating], y_m: NDArray[np.floating]) -> U8:
    """(...) m each, a camera as seen from what it looks at -> (...) the bit of its eighth of a
    turn."""
    eighth = 4 * (x_m > 0) + 2 * (y_m > 0) + (np.abs(x_m) > np.abs(y_m))
    return np.asarray(np.left_shift(1, eighth), np.uint8)
