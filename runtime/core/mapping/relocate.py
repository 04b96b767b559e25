"""Where a map that was remembered lies on the one that is seen now: what both show of obstacles and
of free floor is matched over all headings and places, coarse to fine.

A match is told with its rival, the best one elsewhere: rooms look alike, and half of one as much
like a half of another. Whether it is believed is `believed`'s to say.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Final, NamedTuple

import cv2
import numpy as np

from runtime.core.geometry import wrap_angle
from runtime.core.mapping.grid import RESOLUTION_M, MapCopy
from runtime.core.types import F32, F64, Mask, Pose

AROUND_M: Final = 7.0  # of the robot, what is seen is matched: odometry drifts
COARSE: Final = 2  # cells of the map to a side of one that is searched first
HEADINGS: Final = 120
BLUR_M: Final = 0.12  # between what is seen and what is remembered of one thing, searched coarsely
AWAY_M: Final = 0.35  # from all that is remembered, on floor: what is seen there is new
FREE_WEIGHT: Final = 0.5  # of the floor's agreement beside that of obstacles
PEAKS: Final = 3  # places of each heading that are looked at again,
FINE: Final = 16  # and of all of them
APART_M, APART_RAD = 0.4, math.radians(12.0)  # two matches that differ by less are one
SAMPLED: Final = 400  # points in the fine search
SAME_M: Final = 0.1  # two sightings of one surface are no farther apart
NEW_M: Final = 0.2  # an obstacle on floor that is so far from all known ones was not there before
STEPS: Final = ((0.1, math.radians(1.5)), (0.05, math.radians(0.75)), (0.025, math.radians(0.4)))


class Relocation(NamedTuple):
    """`at`: the robot in the remembered map's frame. agree: share of the obstacles in what both
    maps know that are in both. seen: share of those seen now that are remembered. metres: of those,
    how much. rival: what the best match elsewhere is worth, against this one."""

    at: Pose
    agree: float
    seen: float
    metres: float
    rival: float

    @property
    def worth(self) -> float:
        return self.agree * self.seen


class MatchLimits(NamedTuple):
    """What a match is believed from."""

    agree: float
    seen: float
    metres: float
    rival: float


ANYWHERE: Final = MatchLimits(0.92, 0.7, 8.0, 0.8)
"""Of a robot that may be anywhere: hil_sim/benchmarks/relocation.py has the trials behind it."""
SAID: Final = MatchLimits(0.9, 0.6, 8.0, 0.85)
"""Of one that was said to be at a place."""
SAID_WITHIN: Final = 1.5, math.radians(35.0)  # m and rad, of that place
KNOWABLE_M: Final = 12.0  # of obstacles: some are never seen again
REFUTED: Final = 0.6  # of `seen`, and of `agree`: with less it is not there


def believed(match: Relocation, limits: MatchLimits) -> bool:
    """Whether it is good, and nothing else is."""
    return (
        match.agree >= limits.agree
        and match.seen >= limits.seen
        and match.metres >= limits.metres
        and match.rival <= limits.rival
    )


def refuted(match: Relocation | None) -> bool:
    """Whether what is seen is not what is known around where the robot was said to be."""
    return match is None or (match.agree < REFUTED and match.seen < REFUTED)


@dataclass(frozen=True)
class Relief:
    """A map, as it is matched."""

    map: MapCopy

    @cached_property
    def surface_xy(self) -> F64:
        """(N, 2) m: obstacle cells beside free floor."""
        return self.map.frame.centres(np.argwhere(self.surface).astype(np.int32))

    @cached_property
    def free_xy(self) -> F64:
        """(N, 2) m."""
        return self.map.frame.centres(np.argwhere(self.map.free).astype(np.int32))

    @cached_property
    def surface(self) -> Mask:
        beside = cv2.dilate(self.map.free.view(np.uint8), np.ones((3, 3), np.uint8))
        return np.asarray(self.map.occupied & (beside > 0), bool)

    @cached_property
    def away_m(self) -> F32:
        """(R, C) from the nearest of them, m."""
        return _away_m(self.surface, self.map.frame.resolution_m)

    @cached_property
    def coarse(self) -> "_Coarse":
        return _Coarse.of(self)

    def near(self, xy: tuple[float, float], reach_m: float) -> tuple[F64, F64]:
        """Surface and floor, (N, 2) and (M, 2) m, within reach, seen from there."""
        surface, free = self.surface_xy - xy, self.free_xy - xy
        near, clear = np.hypot(*surface.T) <= reach_m, np.hypot(*free.T) <= reach_m
        return surface[near], free[clear]

    def compared(self, points_xy: F64) -> tuple[int, int]:
        """(N, 2) m of another map's surfaces -> how many this one has, and how many it contradicts:
        it knows floor there, and nothing close by."""
        cells = self.map.frame.cells(points_xy)
        inside = ((cells >= 0) & (cells < self.map.frame.shape)).all(axis=1)
        rows, cols = cells[inside].T
        away_m = self.away_m[rows, cols]
        other = self.map.free[rows, cols] & (away_m > NEW_M)
        return int((away_m <= SAME_M).sum()), int(other.sum())


@dataclass(frozen=True)
class _Coarse:
    """A remembered map's spectra: what it is worth that something is seen in a cell, and that floor
    is; both of size (S, S), with room for what is seen to reach beyond its edge."""

    cell_m: float
    pad: int
    size: int
    surface: F32
    floor: F32

    @classmethod
    def of(cls, relief: Relief) -> "_Coarse":
        copy, frame = relief.map, relief.map.frame
        cell_m = COARSE * frame.resolution_m
        pad = math.ceil(AROUND_M / cell_m) + 1
        rows, cols = (math.ceil(n / COARSE) for n in frame.shape)
        size = cv2.getOptimalDFTSize(max(rows, cols) + 2 * pad)
        shrunk = [_shrunk(mask) for mask in (relief.surface, copy.free)]
        surface, free = (shrunk[0] > 0), (shrunk[1] > 0.5)
        away_m = _away_m(surface, cell_m)
        worth = np.exp(-0.5 * (away_m / BLUR_M) ** 2) - 0.5 * (free & (away_m > AWAY_M))
        floor = 0.3 * free - 1.0 * (surface & ~free)
        spectra = []
        for values in (worth, floor):
            whole = np.zeros((size, size), np.float32)
            whole[pad : pad + rows, pad : pad + cols] = values
            spectra.append(np.asarray(cv2.dft(whole), np.float32))
        return cls(cell_m, pad, size, *spectra)

    def scores(self, surface_xy: F64, free_xy: F64) -> F32:
        """(S, S) what it is worth that the robot, from which the points are seen, (N, 2) and (M, 2)
        m, is in each padded cell."""
        a, b = self._spectrum(surface_xy, 1.0), self._spectrum(free_xy, FREE_WEIGHT)
        total = cv2.add(
            cv2.mulSpectrums(self.surface, a, 0, conjB=True),
            cv2.mulSpectrums(self.floor, b, 0, conjB=True),
        )
        return np.asarray(cv2.dft(total, flags=cv2.DFT_INVERSE | cv2.DFT_SCALE), np.float32)

    def _spectrum(self, points_xy: F64, weight: float) -> F32:
        cells = np.floor(points_xy[:, ::-1] / self.cell_m + 0.5).astype(np.int64) % self.size
        counts = np.bincount(cells[:, 0] * self.size + cells[:, 1], minlength=self.size**2)
        image = counts.reshape(self.size, self.size).astype(np.float32)
        return np.asarray(cv2.dft(image * (weight / max(1, len(points_xy)))), np.float32)


def knowable(known: Relief) -> bool:
    """Whether there is enough on a map for it ever to be known again."""
    return len(known.surface_xy) * RESOLUTION_M >= KNOWABLE_M


def match(
    seen: Relief, here: Pose, known: Relief, about: tuple[Pose, float, float] | None = None
) -> Relocation | None:
    """Where a robot that is `here` on what it sees is on a map it knew; None where nothing speaks
    for anywhere. `about`: it is said to be there, so many m and rad off at most."""
    surface_xy, free_xy = seen.near((here.x_m, here.y_m), AROUND_M)
    if len(surface_xy) < 2 or not len(free_xy) or not len(known.surface_xy):
        return None
    facing = -here.yaw_rad  # points as the robot sees them that faces along x
    surface_xy, free_xy = _turned(surface_xy, facing), _turned(free_xy, facing)
    thin = surface_xy[:: max(1, len(surface_xy) // SAMPLED)]
    fine = [_refined(known, thin, start) for start in _starts(known, surface_xy, free_xy, about)]
    told = sorted((_told(seen, here, known, surface_xy, at) for at in fine), key=_rank)
    if not told or told[0].worth <= 0:
        return None
    best = told[0]
    others = [m.worth for m in told if _differ(m.at, best.at)]
    ring = [_told(seen, here, known, surface_xy, at).worth for at in _ring(best.at)]
    return best._replace(rival=max([*others, *ring, 0.0]) / best.worth)


def _rank(match: Relocation) -> float:
    return -match.worth


def _starts(
    known: Relief, surface_xy: F64, free_xy: F64, about: tuple[Pose, float, float] | None
) -> list[Pose]:
    """The best places of a coarse search, no two of them alike."""
    found: list[tuple[float, Pose]] = []
    for n in range(HEADINGS):
        yaw_rad = wrap_angle(n * math.tau / HEADINGS)
        if about is None or abs(wrap_angle(yaw_rad - about[0].yaw_rad)) <= about[2]:
            found.extend(_peaks(known, surface_xy, free_xy, yaw_rad, about))
    starts: list[Pose] = []
    for _, at in sorted(found, key=lambda scored: -scored[0]):
        if not any(not _differ(at, other) for other in starts):
            starts.append(at)
        if len(starts) == FINE:
            break
    return starts


def _peaks(
    known: Relief,
    surface_xy: F64,
    free_xy: F64,
    yaw_rad: float,
    about: tuple[Pose, float, float] | None,
) -> Iterator[tuple[float, Pose]]:
    coarse, frame = known.coarse, known.map.frame
    scores = coarse.scores(_turned(surface_xy, yaw_rad), _turned(free_xy, yaw_rad))
    left_m = frame.x0_m + (frame.first_col + 0.5 * COARSE) * frame.resolution_m
    low_m = frame.y0_m + (frame.first_row + 0.5 * COARSE) * frame.resolution_m
    if about is not None:
        axis = (np.arange(coarse.size) - coarse.pad) * coarse.cell_m
        off_x, off_y = axis + left_m - about[0].x_m, axis + low_m - about[0].y_m
        scores = np.where(np.hypot(off_x[None], off_y[:, None]) <= about[1], scores, -1.0)
    near = math.ceil(APART_M / coarse.cell_m)
    for _ in range(PEAKS):
        row, col = divmod(int(scores.argmax()), coarse.size)
        score = float(scores[row, col])
        if score <= 0:
            return
        x_m = left_m + (col - coarse.pad) * coarse.cell_m
        yield score, Pose(x_m, low_m + (row - coarse.pad) * coarse.cell_m, yaw_rad)
        window = (
            slice(max(0, row - near), row + near + 1),
            slice(max(0, col - near), col + near + 1),
        )
        scores[window] = -1.0


def _refined(known: Relief, surface_xy: F64, start: Pose) -> Pose:
    """The pose near by from which the points, as the robot sees them, lie best on the surfaces."""
    best, shifts = start, np.arange(-2, 3)
    for step_m, step_rad in STEPS:
        dx, dy = (axis.ravel() * step_m for axis in np.meshgrid(shifts, shifts))
        scored = []
        for turn in shifts.tolist():
            yaw_rad = wrap_angle(best.yaw_rad + turn * step_rad)
            points = _turned(surface_xy, yaw_rad) + best.xy
            moved = points[None] + np.stack([dx, dy], axis=1)[:, None]
            worth = _lies(known, moved)
            n = int(worth.argmax())
            scored.append((float(worth[n]), n, yaw_rad))
        _, n, yaw_rad = max(scored)
        best = Pose(best.x_m + float(dx[n]), best.y_m + float(dy[n]), yaw_rad)
    return best


def _lies(known: Relief, points_xy: F64) -> F64:
    """(K, N, 2) m -> (K,) how well each lies on the surfaces that are known."""
    frame = known.map.frame
    cells = frame.cells(points_xy)
    inside = ((cells >= 0) & (cells < frame.shape)).all(axis=-1)
    cells[~inside] = 0
    near = np.clip(1.0 - known.away_m[cells[..., 0], cells[..., 1]] / (2 * SAME_M), 0.0, 1.0)
    return np.asarray((near * inside).mean(axis=-1), np.float64)


def _told(seen: Relief, here: Pose, known: Relief, surface_xy: F64, at: Pose) -> Relocation:
    same, other = known.compared(_turned(surface_xy, at.yaw_rad) + at.xy)
    theirs, _ = known.near((at.x_m, at.y_m), AROUND_M)
    back = _turned(theirs, here.yaw_rad - at.yaw_rad) + here.xy
    same_back, other_back = seen.compared(back)
    agree = (same + same_back) / max(1, same + same_back + other + other_back)
    share = same / len(surface_xy)
    return Relocation(at, agree, share, same * RESOLUTION_M, 0.0)


def _ring(at: Pose) -> Iterator[Pose]:
    """Poses beside it: along a corridor, or about the middle of a round, all are as good."""
    for n in range(8):
        aside = n * math.tau / 8
        yield Pose(
            at.x_m + APART_M * math.cos(aside), at.y_m + APART_M * math.sin(aside), at.yaw_rad
        )
    for turn in (-APART_RAD, APART_RAD):
        yield Pose(at.x_m, at.y_m, wrap_angle(at.yaw_rad + turn))


def _differ(a: Pose, b: Pose) -> bool:
    apart = math.hypot(a.x_m - b.x_m, a.y_m - b.y_m)
    return apart > APART_M or abs(wrap_angle(a.yaw_rad - b.yaw_rad)) > APART_RAD


def _turned(points_xy: F64, by_rad: float) -> F64:
    c, s = math.cos(by_rad), math.sin(by_rad)
    return np.asarray(points_xy @ np.array([[c, s], [-s, c]]), np.float64)


def _away_m(mask: Mask, cell_m: float) -> F32:
    if not mask.any():
        return np.full(mask.shape, np.inf, np.float32)
    gap = cv2.distanceTransform((~mask).view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.asarray(gap * cell_m, np.float32)


def _shrunk(mask: Mask) -> F32:
    rows, cols = (n + -n % COARSE for n in mask.shape)
    whole = np.zeros((rows, cols), np.float32)
    whole[: mask.shape[0], : mask.shape[1]] = mask
    blocks = whole.reshape(rows // COARSE, COARSE, cols // COARSE, COARSE)
    return np.asarray(blocks.mean(axis=(1, 3)), np.float32)
