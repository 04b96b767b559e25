"""What the scene-layout expert is taught from: what keyframes of rendered homes show toward
frontiers, and what is true beyond them. `hil-sim beyond` writes a file a home."""

import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.errors import ModelFileError

BEYOND_M = 5.0
"""Of walking: what is nearer to a frontier, through what is not known yet, lies beyond it."""
OF_FRAMES = ("features", "depth", "rooms", "room", "in_view")
OF_ROWS = (
    "frame", "column", "range_m", "moment", "frontier", "best", "unknown_m2", "told_rooms",
    "asked", "absent", "beyond_m", "onward_m", "area_m2", "room_m2",
)  # fmt: skip
OF_ALL = ("categories", "room_names")
SEEN_BY = "detector"
READ_ONLY_ONCE = 4000
"""Frames that a compaction is fitted on, at most."""

Array = NDArray[Any]
Floats = NDArray[np.float32]
Bools = NDArray[np.bool_]
Change = Callable[[Floats], Floats]


@dataclass(frozen=True)
class Homes:
    """Frames (F) and rows (N) of homes, one behind the other; K categories, R room types.

    A row is one keyframe toward one frontier at one moment of a search. `features` (F, C, h, w),
    `depth` (F, 2, h, w) as runtime.core.mapping.sights has it, `rooms` (F, R) the detector's,
    `room` (F,) true or -1, `in_view` (F, K). Of rows: `frame`, `column` 0..1, `range_m`,
    `moment` (numbered through all homes), `frontier`, `best` (the runtime would choose this
    keyframe), `unknown_m2`, `told_rooms` (N, R); `asked` (N, K) it is in the home and not on the
    map, `absent` (N, K); `beyond_m` (N, K) walking from the frontier through what is not known,
    `onward_m` (N, K) by any way; `area_m2` beyond, `room_m2` (N, R). `home` (N,) and
    `frame_home` (F,) number the homes.
    """

    features: Array
    depth: Array
    rooms: Array
    room: Array
    in_view: Array
    frame: Array
    column: Array
    range_m: Array
    moment: Array
    frontier: Array
    best: Array
    unknown_m2: Array
    told_rooms: Array
    asked: Array
    absent: Array
    beyond_m: Array
    onward_m: Array
    area_m2: Array
    room_m2: Array
    home: Array
    frame_home: Array
    categories: tuple[str, ...]
    room_names: tuple[str, ...]

    def known(self) -> Bools:
        """(N, K) whether "is there one beyond, out of view" has an answer."""
        return (self.asked | self.absent) & ~self.in_view[self.frame]

    def there(self) -> Bools:
        """(N, K) whether there is one beyond."""
        return self.beyond_m <= BEYOND_M

    def way(self) -> Floats:
        """(N, 2) column and range, m."""
        return np.stack((self.column, self.range_m), axis=1).astype(np.float32)


def read_homes(folder: Path, change: Change | None = None, detector: str = "") -> Homes:
    """All homes of a folder that have a view toward a frontier; `change` is applied to each one's
    features. `detector`: SHA-256 of the file that must have seen them; "": of any one file. Raises
    ModelFileError."""
    parts: list[dict[str, Array]] = []
    names: tuple[tuple[str, ...], ...] = ()
    frames = moments = 0
    for path in home_files(folder):
        part = _read(path)
        by = str(part.pop(SEEN_BY))
        detector = detector or by
        if by != detector:
            raise ModelFileError(
                f"{path}: seen by detector {by[:12]}…, not by {detector[:12]}…; make it anew with "
                "`hil-sim beyond`"
            )
        own = tuple(tuple(map(str, part.pop(name))) for name in OF_ALL)
        if names and own != names:
            raise ModelFileError(f"{path}: other categories or rooms than the first; make it anew")
        names = own
        if not len(part["frame"]):
            continue
        if change is not None:
            part["features"] = change(part["features"].astype(np.float32)).astype(np.float16)
        count = len(part["features"])
        part["home"] = np.full(len(part["frame"]), len(parts))
        part["frame_home"] = np.full(count, len(parts))
        part["frame"] = part["frame"].astype(np.int64) + frames
        _, order = np.unique(part["moment"], return_inverse=True)
        part["moment"] = order + moments
        frames, moments = frames + count, moments + int(order.max(initial=-1)) + 1
        parts.append(part)
    if not parts:
        raise ModelFileError(f"{folder}: no home has a view; make more with `hil-sim beyond`")
    table = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return Homes(**table, categories=names[0], room_names=names[1])


def home_files(folder: Path) -> list[Path]:
    """The homes of a folder that `hil-sim beyond` wrote, in order."""
    found = sorted((folder / "homes").glob("*.npz"))
    if not found:
        raise ModelFileError(f"{folder}: holds no homes/*.npz; make some with `hil-sim beyond`")
    return found


def feature_sample(folder: Path, rng: np.random.Generator) -> Floats:
    """(F, C, h, w) features of frames drawn from all homes, as many from each."""
    files = home_files(folder)
    each = max(1, READ_ONLY_ONCE // len(files))
    drawn = []
    for path in files:
        seen = _read(path, ("features",))["features"]
        if len(seen):
            drawn.append(seen[rng.permutation(len(seen))[:each]])
    if not drawn:
        raise ModelFileError(f"{folder}: no home has a view; make more with `hil-sim beyond`")
    return np.concatenate(drawn).astype(np.float32)


def _read(
    path: Path, names: Sequence[str] = (*OF_FRAMES, *OF_ROWS, *OF_ALL, SEEN_BY)
) -> dict[str, Array]:
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            return {name: file[name] for name in names}
    except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
        told = " ".join(str(error).split())[:120]
        raise ModelFileError(f"{path}: cannot be read ({told}); delete it, make it anew") from error


@dataclass(frozen=True)
class Moments:
    """Which rows belong to a moment's frontiers: (M, G, V) rows, -1 where there is none; M moments
    of at least one frontier, V views of each."""

    rows: NDArray[np.int64]

    @classmethod
    def of(cls, homes: Homes, views: int = 3) -> "Moments":
        """Those of all homes."""
        order = np.lexsort((~homes.best, homes.frontier, homes.moment))
        moment, frontier = homes.moment[order], homes.frontier[order]
        new_moment = np.diff(moment, prepend=-1) != 0
        new = new_moment | (np.diff(frontier, prepend=frontier[:1] - 1) != 0)
        number = np.cumsum(new) - 1
        view = np.arange(len(order)) - np.flatnonzero(new)[number]
        group = number - (number[np.flatnonzero(new_moment)])[np.cumsum(new_moment) - 1]
        rows = np.full((int(new_moment.sum()), int(group.max()) + 1, views), -1, np.int64)
        kept = view < views
        rows[(np.cumsum(new_moment) - 1)[kept], group[kept], view[kept]] = order[kept]
        return cls(rows)

    def best(self) -> NDArray[np.int64]:
        """(M, G) the view of each frontier that the runtime would choose."""
        return self.rows[:, :, 0]

    def draw(self, count: int, rng: np.random.Generator) -> Iterator[NDArray[np.int64]]:
        """(count, G) rows of moments drawn without end, one view of each frontier at random."""
        while True:
            order = rng.permutation(len(self.rows))
            for start in range(0, len(order), count):
                rows = self.rows[order[start : start + count]]
                views = np.maximum((rows >= 0).sum(axis=2), 1)
                drawn = (rng.random(views.shape) * views).astype(np.int64)
                yield np.take_along_axis(rows, drawn[..., None], axis=2)[..., 0]
