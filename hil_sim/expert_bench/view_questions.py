"""Questions about single views, with the truth beside them: is there a thing beyond this frontier,
out of view; is there one in view; what room is this. From the files of `hil-sim beyond`."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hil_sim.expert_bench.bank import HOMES, layout_of
from hil_sim.expert_bench.views import HomeViews, read_views
from runtime.core.types import Mask
from runtime.errors import RfNavError

BEYOND_M = 5.0
"""Of walking from a frontier: what lies within is beyond it."""
ANOTHER = "seen by another detector than the other homes; remove it, and run hil-sim beyond again"
AHEAD = 0.5, 2.0
"""Column (0..1) and metres of a view that is of no frontier."""
Floats = NDArray[np.floating[Any]]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class SightRows:
    """What is seen, one view a row: keyframes' `features` (N, D, h, w), `depth` (N, 2, h, w),
    `scene` (N, 384) and the detector's `rooms` (N, R); of the frontier its `column`, 0..1, and
    `range_m`, (N,); and the layout of the `home` that each is of."""

    features: Floats
    depth: Floats
    scene: Floats
    rooms: Floats
    column: Floats
    range_m: Floats
    home: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.home)


@dataclass(frozen=True)
class ViewQuestions:
    """One question for each row of `sights` and category of LABELLED where `asked` (N, C); `true`
    (N, C) are the answers."""

    sights: SightRows
    asked: Mask
    true: Mask


@dataclass(frozen=True)
class WaysOn:
    """From each row's frontier: metres of walking to the nearest of each category that nobody has
    seen, by any way, `onward_m` (N, C), inf where there is none; `unknown_m2` (N,) of the brief;
    floor that truly lies behind it within BEYOND_M, by room type, `room_m2` (N, R).
    `moment` (N,) is a number of its own for each moment of each home."""

    moment: Indices
    onward_m: Floats
    unknown_m2: Floats
    room_m2: Floats


@dataclass(frozen=True)
class ViewBank:
    """The questions of a folder. `beyond`: one row a moment and frontier, its keyframe as the
    runtime chose it, with the `ways` on from there; what is on the map or in view is not asked
    about. `in_view`: one row a keyframe; `room` (N,) is the true room type in it, index of
    ROOM_TYPES, -1 where there is no one type. `detector`: SHA-256 of the file that saw them."""

    beyond: ViewQuestions
    ways: WaysOn
    in_view: ViewQuestions
    room: NDArray[np.int8]
    homes: int
    detector: str


def load_views(folder: Path, most: int = 0, seed: int = 0, sighted: bool = True) -> ViewBank:
    """About `most` rows a home for each kind of question, drawn by the seed, whole moments; 0 takes
    all. Without `sighted` all but features and depth, which are large. Homes without a view are
    passed over. RfNavError when a file is none, or seen by another detector than the first, or no
    home has a view."""
    read = list[ViewBank]()
    for path in sorted((folder / HOMES).glob("*.npz")):
        views = read_views(path)
        if len(views.frame):
            read.append(_home(views, layout_of(path.stem), most, seed, sighted))
            if read[-1].detector != read[0].detector:
                raise RfNavError(f"{path}: {ANOTHER}")
    if not read:
        raise RfNavError(f"{folder}: no views; make them: hil-sim beyond --out {folder}")
    return ViewBank(
        _joined([r.beyond for r in read]),
        _ways([r.ways for r in read]),
        _joined([r.in_view for r in read]),
        np.concatenate([r.room for r in read]),
        len(read),
        read[0].detector,
    )


def _home(views: HomeViews, layout: str, most: int, seed: int, sighted: bool) -> ViewBank:
    rows = _whole_moments(np.flatnonzero(views.best), views.moment, most, seed)
    frames = _drawn(np.arange(len(views.room)), most, seed)
    column, range_m = (np.full(len(frames), value) for value in AHEAD)

    def shown(at: Indices, column: Floats, range_m: Floats) -> SightRows:
        large = at if sighted else at[:0]
        return SightRows(views.features[large], views.depth[large], views.scene[at],
                         views.rooms[at], column, range_m, (layout,) * len(at))  # fmt: skip

    at = views.frame[rows].astype(np.intp)
    asked = (views.asked[rows] | views.absent[rows]) & ~views.in_view[at]
    return ViewBank(
        ViewQuestions(shown(at, views.column[rows], views.range_m[rows]), asked,
                      views.beyond_m[rows] <= BEYOND_M),
        WaysOn(views.moment[rows].astype(np.intp), views.onward_m[rows], views.unknown_m2[rows],
               views.room_m2[rows]),
        ViewQuestions(shown(frames, column, range_m),
                      np.ones_like(views.in_view[frames]), views.in_view[frames]),
        views.room[frames].astype(np.int8),
        1,
        views.detector,
    )  # fmt: skip


def _drawn(rows: Indices, most: int, seed: int) -> Indices:
    """Some of the rows, in order."""
    if not most or len(rows) <= most:
        return rows
    drawn: Indices = np.sort(np.random.default_rng(seed).permutation(rows)[:most])
    return drawn


def _whole_moments(rows: Indices, moment: NDArray[np.int32], most: int, seed: int) -> Indices:
    """The rows of some moments, until there are so many."""
    if not most or len(rows) <= most:
        return rows
    kept = np.zeros(len(rows), bool)
    for one in np.random.default_rng(seed).permutation(np.unique(moment[rows])):
        if kept.sum() >= most:
            break
        kept |= moment[rows] == one
    return rows[kept]


def _ways(parts: Sequence[WaysOn]) -> WaysOn:
    """Moments are counted on from home to home."""
    moments, first = [], 0
    for part in parts:
        moments.append(part.moment + first)
        first += int(part.moment.max(initial=-1)) + 1
    return WaysOn(
        np.concatenate(moments),
        np.concatenate([p.onward_m for p in parts]),
        np.concatenate([p.unknown_m2 for p in parts]),
        np.concatenate([p.room_m2 for p in parts]),
    )


def _joined(parts: Sequence[ViewQuestions]) -> ViewQuestions:
    sights = [p.sights for p in parts]
    arrays = {
        name: np.concatenate([getattr(s, name) for s in sights])
        for name in ("features", "depth", "scene", "rooms", "column", "range_m")
    }
    return ViewQuestions(
        SightRows(**arrays, home=tuple(h for s in sights for h in s.home)),
        np.concatenate([p.asked for p in parts]),
        np.concatenate([p.true for p in parts]),
    )
