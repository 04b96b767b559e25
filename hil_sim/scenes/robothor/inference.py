"""The walls of a layout from its evidence.

Candidates are axis-aligned runs that no path comes near and where no furniture stands. First the
runs behind paintings; then, one by one, the run that bars most of the straight ways that nothing
else bars (`evidence.Evidence.chords`). A run ends at the outer walls, at another wall, or where
paths go round its tip.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hil_sim.scenes.robothor.evidence import CELL_M, OUTER, Bools, Floats, WallEvidence
from hil_sim.scenes.robothor.regions import Segment

ALONG_M = 0.13
"""No path comes nearer to a wall than this."""
TIP_M = 0.16
"""Paths go round a wall's tip at this distance."""
SAME_M = 0.02
"""Planes nearer than this are one wall's; it is looked for as far beside them."""
SLACK_M = 0.15
"""A painting's own plane is kept unless a wall beside it would be longer by this."""
REACH_M = 0.4
"""A run that ends this near another wall, or beyond it, ends at it."""
LEAST_M = 0.35
"""Shorter pieces are no walls."""
ENOUGH = 0.006
"""Share of the barred ways that a wall without paintings must bar."""
FEWEST = 6
MOST = 12


@dataclass(frozen=True)
class WallRun:
    """A straight piece of wall. `axis` 0: along x at y = `at`, from `low` to `high`; 1: along y.
    `hung`: paintings hang on it."""

    axis: int
    at: float
    low: float
    high: float
    hung: bool = False

    @property
    def length(self) -> float:
        return self.high - self.low

    @property
    def segment(self) -> Segment:
        """Its ends, m, scene frame."""
        if self.axis == 0:
            return (self.low, self.at), (self.high, self.at)
        return (self.at, self.low), (self.at, self.high)


def infer(evidence: WallEvidence) -> tuple[WallRun, ...]:
    """The walls of a layout."""
    walls = _behind_paintings(evidence)
    left = _unexplained(evidence.chords, walls)
    for _ in range(MOST):
        best, gain = _most_barring(evidence, walls, left)
        if best is None or gain < max(FEWEST, ENOUGH * len(evidence.chords)):
            break
        walls.append(best)
        left = _unexplained(left, [best])
    return _joined(evidence, walls)


# -- runs ------------------------------------------------------------------------------------------


def _possible(evidence: WallEvidence, axis: int, at: float) -> Bools:
    """(cells,) where along a line a wall could be."""
    line = round((at - OUTER[1 - axis]) / CELL_M - 0.5)
    clear = evidence.clear_m[line] if axis == 0 else evidence.clear_m[:, line]
    solid = evidence.solid[line] if axis == 0 else evidence.solid[:, line]
    possible: Bools = (clear > ALONG_M) & ~solid
    return possible


def _run_at(evidence: WallEvidence, axis: int, at: float, along: float) -> WallRun | None:
    """The longest run on the line that holds a place along it, its tips clear of paths."""
    possible = _possible(evidence, axis, at)
    first = last = int((along - OUTER[axis]) / CELL_M)
    if not 0 <= first < len(possible) or not possible[first]:
        return None
    while first > 0 and possible[first - 1]:
        first -= 1
    while last < len(possible) - 1 and possible[last + 1]:
        last += 1
    return _trimmed(evidence, WallRun(axis, at, *_ends(axis, first, last)))


def _ends(axis: int, first: int, last: int) -> tuple[float, float]:
    return OUTER[axis] + first * CELL_M, OUTER[axis] + (last + 1) * CELL_M


def _trimmed(evidence: WallEvidence, run: WallRun) -> WallRun | None:
    """Tips back to where paths keep the distance at which they go round one."""
    good = np.flatnonzero(_beside(evidence.clear_m, run) >= TIP_M)
    if len(good) == 0:
        return None
    low, high = run.low + good[0] * CELL_M, run.low + (good[-1] + 1) * CELL_M
    return replace(run, low=low, high=high) if high - low >= LEAST_M else None


def _behind_paintings(evidence: WallEvidence) -> list[WallRun]:
    """A run for each painting, moved sideways by up to 2 cm if it is longer there."""
    found: list[WallRun] = []
    for plane in evidence.planes:
        along = (plane.low + plane.high) / 2
        if any(_holds(run, plane.axis, plane.at, along) for run in found):
            continue
        shifts = np.arange(-SAME_M, SAME_M + 1e-6, CELL_M)
        runs = [_run_at(evidence, plane.axis, plane.at + s, along) for s in shifts]
        if good := [run for run in runs if run is not None]:
            whole = max(run.length for run in good) - SLACK_M
            long = [run for run in good if run.length >= whole]
            best = min(long, key=lambda run: abs(run.at - plane.at))
            found.append(replace(best, hung=True))
    return found


def _holds(run: WallRun, axis: int, at: float, along: float) -> bool:
    beside = abs(run.at - at) < 2 * SAME_M
    return run.axis == axis and beside and run.low <= along <= run.high


def _beside(grid: Floats, run: WallRun) -> Floats:
    line = round((run.at - OUTER[1 - run.axis]) / CELL_M - 0.5)
    whole = grid[line] if run.axis == 0 else grid[:, line]
    first, last = (round((v - OUTER[run.axis]) / CELL_M) for v in (run.low, run.high))
    part: Floats = whole[max(first, 0) : max(last, first + 1)]
    return part


def _most_barring(
    evidence: WallEvidence, walls: list[WallRun], chords: Floats
) -> tuple[WallRun | None, int]:
    """The run, attached to a wall, that bars most of the chords, and how many."""
    best: tuple[int, WallRun | None] = (0, None)
    if len(chords) == 0:
        return None, 0
    for axis in (0, 1):
        for at in np.arange(OUTER[1 - axis] + 0.3, OUTER[3 - axis] - 0.3, 2 * CELL_M):
            for run in _free_runs(evidence, axis, float(at)):
                count = int(_bars(run, chords).sum())
                if count > best[0] and _attached(run, walls):
                    best = (count, run)
    return best[1], best[0]


def _free_runs(evidence: WallEvidence, axis: int, at: float) -> list[WallRun]:
    edges = np.diff(np.r_[False, _possible(evidence, axis, at), False].astype(int))
    spans = zip(np.flatnonzero(edges > 0), np.flatnonzero(edges < 0), strict=True)
    runs = [WallRun(axis, at, *_ends(axis, int(a), int(b) - 1)) for a, b in spans]
    return [r for run in runs if (r := _trimmed(evidence, run)) is not None]


def _attached(run: WallRun, walls: Sequence[WallRun]) -> bool:
    """Whether a run ends at the outer walls or at another wall."""
    outer = run.low - OUTER[run.axis] < REACH_M or OUTER[run.axis + 2] - run.high < REACH_M
    return outer or any(_meets(run, wall) is not None for wall in walls)


def _meets(run: WallRun, wall: WallRun) -> float | None:
    """Where along the run a wall across it is met, or nearly."""
    if wall.axis == run.axis or not run.low - REACH_M <= wall.at <= run.high + REACH_M:
        return None
    return wall.at if wall.low - REACH_M <= run.at <= wall.high + REACH_M else None


def _bars(run: WallRun, chords: Floats) -> Bools:
    """(N,) which chords cross a wall, or pass its tip nearer than the body can."""
    a, b = 1 - run.axis, 3 - run.axis  # across the wall
    start, end = chords[:, a] - run.at, chords[:, b] - run.at
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.where(start == end, 0.0, start / (start - end))
    along = chords[:, run.axis] + t * (chords[:, run.axis + 2] - chords[:, run.axis])
    near = (along > run.low - TIP_M) & (along < run.high + TIP_M)
    crossing: Bools = (start * end < 0) & near
    return crossing


def _unexplained(chords: Floats, walls: Sequence[WallRun]) -> Floats:
    left = np.ones(len(chords), bool)
    for wall in walls:
        left &= ~_bars(wall, chords)
    kept: Floats = chords[left]
    return kept


# -- junctions -------------------------------------------------------------------------------------


def _joined(evidence: WallEvidence, walls: Sequence[WallRun]) -> tuple[WallRun, ...]:
    """Runs cut back or lengthened to the walls they meet; what hangs over is dropped unless it
    bars chords that nothing else does or carries a painting."""
    done = _merged(walls)
    for i, run in enumerate(done):
        others = [other for j, other in enumerate(done) if j != i]
        done[i] = _at_junctions(evidence, run, others)
    return tuple(sorted((at_edges(run) for run in done), key=lambda r: (r.axis, r.at, r.low)))


def _merged(walls: Sequence[WallRun]) -> list[WallRun]:
    """Runs on one line that overlap are one wall."""
    done: list[WallRun] = []
    for run in sorted(walls, key=lambda r: (not r.hung, -r.length)):
        for i, other in enumerate(done):
            beside = other.axis == run.axis and abs(other.at - run.at) < 3 * SAME_M
            if beside and other.low <= run.high and run.low <= other.high:
                low, high = min(run.low, other.low), max(run.high, other.high)
                done[i] = replace(other, low=low, high=high)
                break
        else:
            done.append(run)
    return done


def at_edges(run: WallRun) -> WallRun:
    """A run that ends near an outer wall ends at it."""
    low, high = OUTER[run.axis], OUTER[run.axis + 2]
    return replace(
        run,
        low=low if run.low - low < REACH_M else run.low,
        high=high if high - run.high < REACH_M else run.high,
    )


def _at_junctions(evidence: WallEvidence, run: WallRun, others: Sequence[WallRun]) -> WallRun:
    left = _unexplained(evidence.chords, others)
    for at in sorted(at for other in others if (at := _meets(run, other)) is not None):
        below, above = replace(run, high=at), replace(run, low=at)
        corner = any(_corner(other, run.at, run.low) for other in others)
        if at - run.low < REACH_M or not (corner or _supported(evidence, below, left, above)):
            run = above
        corner = any(_corner(other, run.at, run.high) for other in others)
        if run.high - at < REACH_M or not (corner or _supported(evidence, above, left, below)):
            run = replace(run, high=at)
    return run


def _corner(other: WallRun, at: float, end: float) -> bool:
    """Whether a wall across ends where a run at `at` ends."""
    nearest = min(abs(other.low - at), abs(other.high - at))
    return nearest < REACH_M and abs(other.at - end) < REACH_M


def _supported(evidence: WallEvidence, piece: WallRun, chords: Floats, rest: WallRun) -> bool:
    """Whether a piece beyond a junction carries a painting or bars what the rest does not."""
    for plane in evidence.planes:
        middle = (plane.low + plane.high) / 2
        if _holds(piece, plane.axis, plane.at, middle):
            return True
    alone = _bars(piece, chords) & ~_bars(rest, chords)
    return int(alone.sum()) >= max(FEWEST, ENOUGH * len(evidence.chords))
