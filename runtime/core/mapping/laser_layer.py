"""What a level laser tells of the floor plan: obstacles at its height. That nothing stands in a
beam's way says only that nothing stands there at that height: it takes back what the laser said
before, and never makes floor of what nobody has seen."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from runtime.core.geometry import GridFrame
from runtime.core.mapping.windows import Window, bounds, joined, padded, polygon_patch
from runtime.core.types import I32, Mask, Pose, Scan

HIT = 4  # evidence of a scan that met something in a cell
MISS = 1  # taken back by one whose beams passed; less, for what is thin or of glass is often missed
HELD_AT = 2  # evidence from which a cell holds an obstacle: a single hit, until three pass
MOST = 20
SHORT_CELLS = 1.5  # a beam tells nothing of the last of its way, where it met something


@dataclass
class LaserLayer:
    """evidence: (R, C) int8, 0 to MOST. barred: (R, C) what the laser holds or was bumped into, as
    of when `bar` was called last. (0, 0) each of a robot without a laser."""

    evidence: NDArray[np.int8] = field(default_factory=lambda: np.zeros((0, 0), np.int8))
    barred: Mask = field(default_factory=lambda: np.zeros((0, 0), bool))

    def bar(self, window: Window, bumped: Mask) -> Mask:
        """(R, C) what else was bumped into and what the laser holds, right within a window."""
        if not self.evidence.size:
            return bumped
        self.barred[window] = bumped[window] | (self.evidence[window] >= HELD_AT)
        return self.barred

    def clear(self, window: Window, cells: Mask) -> None:
        """Nothing stands in these cells of a window: the robot does."""
        if self.evidence.size:
            self.evidence[window][cells] = 0

    def grow(self, padding: tuple[int, int, int, int]) -> None:
        if self.evidence.size:
            self.evidence = padded(self.evidence, padding)
            self.barred = padded(self.barred, padding)

    def add(
        self, frame: GridFrame, scan: Scan, pose: Pose, radius_m: float, far_m: float
    ) -> Window | None:
        """Book a scan up to `far_m`; what it met within the body, whose pose it is, is the robot
        itself. Returns the window where what it holds has changed."""
        if not self.evidence.size:
            self.evidence, self.barred = np.zeros(frame.shape, np.int8), np.zeros(frame.shape, bool)
        met = (scan.ranges_m > 0) & (scan.ranges_m <= far_m)
        aim = np.stack([np.cos(scan.headings_rad), np.sin(scan.headings_rad)], axis=1)
        ends = np.array(scan.at_xy) + scan.ranges_m[:, None] * aim
        met &= np.hypot(*(ends - pose.xy).T) > radius_m
        cells = np.unique(frame.cells(ends[met]), axis=0)
        cells = cells[((cells >= 0) & (cells < frame.shape)).all(axis=1)]
        passed_m = np.minimum(scan.ranges_m, far_m) - SHORT_CELLS * frame.resolution_m
        passed_m = np.where(scan.ranges_m > 0, np.maximum(passed_m, 0.0), 0.0)
        outline = np.array(scan.at_xy) + passed_m[:, None] * aim
        inside, window = polygon_patch(frame, outline)
        return self._book(cells, inside, window)

    def _book(self, cells: I32, inside: Mask, window: Window) -> Window | None:
        rows, cols = cells.T
        if len(cells):
            ends = (rows.min(), rows.max() + 1), (cols.min(), cols.max() + 1)
            window_of_hits = slice(*map(int, ends[0])), slice(*map(int, ends[1]))
            around = joined(window_of_hits, window)
        else:
            around = window
        before = self.evidence[around] >= HELD_AT
        hit = self.evidence[rows, cols]
        patch = self.evidence[window]
        patch[inside] = np.maximum(patch[inside] - MISS, 0)
        self.evidence[rows, cols] = np.minimum(hit + HIT, MOST)
        changed = before != (self.evidence[around] >= HELD_AT)
        return bounds(changed, around) if changed.any() else None
