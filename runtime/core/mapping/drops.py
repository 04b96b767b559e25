"""Where the floor ends: what tells a drop from noise, and what else is in doubt beside one."""

import math
from dataclasses import dataclass, field
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from runtime.core.geometry import GridFrame
from runtime.core.mapping.windows import Window, fan, polygon_patch, widened
from runtime.core.types import F32, F64, U8, Mask

SLACK: Final = 0.03  # m a metre away: a tilt that is off by 1.7 degrees makes no drop of the floor
LIP_M: Final = 0.03  # of the far side of a hole no more passes for floor
DROP_WITHIN_M: Final = 3.0  # of the camera cells are told to drop; farther ones are gone to first
DROP_AT: Final = 2  # frames that show a cell to drop, after which it does
DROP_MOST: Final = 6  # frames; so many less one that show floor in it undo a drop
OPEN_AZIMUTHS: Final = 3  # of a frame that drop without floor before; fewer may be a reflection
SECTORS: Final = 120
DOUBT_RAD: Final = math.radians(125.0)  # to either side of an opening, at most
DOUBT_M: Final = 2.5  # farther it does not reach
LEAVE_RAD: Final = math.radians(30.0)  # so wide a sector is left to a robot, if there is one,
LEAVE_M: Final = 0.4  # which begins so long with so much
FEET_M: Final = 0.1  # to either side
SAME_M: Final = 0.2  # a robot that has moved by less looks from the same place


@dataclass
class Openings:
    """Openings of which the camera sees only the far part, as it may see nothing near the body:
    they can begin anywhere before that, and reach sideways to where the view from above ends. What
    was seen of them from one place, all around."""

    from_xy: tuple[float, float] | None = None
    edges_felt: bool = False  # sensors under the body tell where the floor ends: doubt bars nothing
    _frame: GridFrame | None = None
    _open: Mask = field(default_factory=lambda: np.zeros(SECTORS, bool))  # by azimuth in the map
    _reach_m: float = 0.0
    _before: Mask = field(default_factory=lambda: np.zeros((0, 0), bool))  # doubt, from elsewhere
    _window: Window = (slice(0, 0), slice(0, 0))

    def doubt(
        self,
        doubtful: Mask,
        frame: GridFrame,
        camera_xy: tuple[float, float],
        azimuths_rad: F32,
        open_m: F32,
    ) -> Window | None:
        """Mark in `doubtful` (R, C), in place, where unseen floor is not believed in.
        `azimuths_rad` (A,) in the map frame, `open_m` (A,) how near each drops without floor before
        it, 0 for nowhere. The window of what changed, None for nothing."""
        at = np.flatnonzero(open_m > 0)
        if len(at) < OPEN_AZIMUTHS:
            return None
        moved = self.from_xy is None or math.dist(self.from_xy, camera_xy) > SAME_M
        if moved or frame != self._frame:
            self._begin(doubtful, frame, camera_xy)
        assert self.from_xy is not None
        sectors = (np.remainder(azimuths_rad[at], math.tau) * SECTORS / math.tau).astype(np.int32)
        reach_m = min(DOUBT_M, float(open_m[at].min()) + frame.resolution_m)
        if self._open[sectors % SECTORS].all() and reach_m <= self._reach_m:
            return None
        self._open[sectors % SECTORS] = True
        self._reach_m = max(self._reach_m, reach_m)
        near, away_rad, widest_rad = _near(self._open)
        middles = (np.arange(SECTORS) + 0.5) * math.tau / SECTORS
        range_m = np.where(near, self._reach_m, 0.0)
        around = fan(self.from_xy, middles, range_m)[1:]  # a whole turn: it has no corner
        patch, window = polygon_patch(frame, around)
        doubtful[self._window] = self._before
        doubtful[window] |= patch
        if widest_rad >= LEAVE_RAD:
            way, window = polygon_patch(frame, _strip(self.from_xy, away_rad))
            doubtful[window] &= ~way
        return self._window

    def barred(self, doubtful: Mask) -> Mask:
        """What of the doubtful cells (R, C) is no way."""
        if not self.edges_felt:
            return doubtful
        return np.broadcast_to(np.zeros(doubtful.shape[1], bool), doubtful.shape)

    def _begin(self, doubtful: Mask, frame: GridFrame, camera_xy: tuple[float, float]) -> None:
        row, col = frame.cell(*camera_xy)
        cells = math.ceil(DOUBT_M / frame.resolution_m) + 2
        here = slice(row, row + 1), slice(col, col + 1)
        self._window = widened(here, cells, frame)
        self._before = doubtful[self._window].copy()
        self.from_xy, self._frame, self._reach_m = camera_xy, frame, 0.0
        self._open[:] = False


def _near(opened: Mask) -> tuple[Mask, float, float]:
    """(SECTORS,) -> (SECTORS,) what is in doubt for being beside something open; and the middle of
    the widest part where nothing is open, by which the robot leaves, and how wide that is."""
    at = np.flatnonzero(opened)
    gaps = np.diff(np.r_[at, at[0] + SECTORS])
    widest_rad = float(gaps.max()) * math.tau / SECTORS
    beside_rad = min(DOUBT_RAD, max(0.0, (widest_rad - LEAVE_RAD) / 2))
    apart = np.abs(np.arange(SECTORS)[:, None] - at)
    apart = np.minimum(apart, SECTORS - apart).min(axis=1)
    after = int(gaps.argmax())
    away_rad = (float(at[after]) + 0.5 + float(gaps[after]) / 2) * math.tau / SECTORS
    return np.asarray(apart * math.tau / SECTORS <= beside_rad, bool), away_rad, widest_rad


def _strip(from_xy: tuple[float, float], along_rad: float) -> F64:
    """(4, 2) m: as wide as the feet of a body, from it to where a sector is wider."""
    c, s = math.cos(along_rad), math.sin(along_rad)
    corners = np.array(
        [[-FEET_M, -FEET_M], [LEAVE_M, -FEET_M], [LEAVE_M, FEET_M], [-FEET_M, FEET_M]]
    )
    return np.asarray(corners @ np.array([[c, s], [-s, c]]) + from_xy, np.float64)


def lose_way(driven: U8, dropped: U8, cells: int) -> bool:
    """A way that was driven (r, c) is none any more, in place, where a cell that drops, by the
    evidence (r, c), is no farther than that; whether there is any."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * cells + 1, 2 * cells + 1))
    gone = (cv2.dilate((dropped >= DROP_AT).view(np.uint8), disc) > 0) & (driven > 0)
    driven[gone] = 0
    return bool(gone.any())


def disbelieve(evidence: NDArray[np.int16], doubtful: Mask, driven: U8, least: int) -> None:
    """That the body reached over a doubtful cell, which counts `least`, does not tell that floor is
    there. All (r, c); the evidence changes in place."""
    reached = (evidence >= -least) & (evidence < 0) & (driven == 0)
    evidence[reached & doubtful] = 0
