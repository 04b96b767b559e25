"""Kernels of the semantic map: what the boxes of an image show, cells under things, and where
instances are. Tuples of numbers are what `objects_*.c` has as structures, in that order."""

from runtime.core.kernels import _compiled
from runtime.core.types import F32, F64, U8, Mask

Frame = tuple[float, float, float]
"""A grid's corner and its cells' length, m."""
Place = tuple[float, float, float, float, float, float, float]
"""A camera's x, y, z in the base frame, m, the base's x, y in the map frame, m, the cosine and sine
of its yaw."""
Told = tuple[float, float, float, float, float, float, bytes]
"""Of a thing: how far away it is; the medians x, y, z of its points in the map frame; from which
height to which they reach, strays left out; and `packed` cells. m"""


def things(
    depth_m: F32,
    rays: tuple[F32, F32, F32],
    stride: int,
    boxes: F64,
    place: Place,
    frame: Frame,
    rules: tuple[float, ...],
) -> list[Told | None]:
    """The thing in each box; None where there are too few points of one, or they are more than
    100 m apart along an axis, or nowhere: a sensor's fault. `depth_m` (H, W) m along the axis, what
    is not finite or not above 0 is unknown; of its every `stride`-th pixel, from half of that on,
    `rays` (h, w) go so far forward, left and up in the base frame per metre. `boxes` (N, 6): the
    pixels of those from top, left (0 or more) to bottom, right (not included), the thing's distance
    if it is known, else NaN, and the box's width per metre of distance. `rules`: as `SegmentRules`.
    ValueError for shapes that do not fit, and numbers that cannot be."""
    return _compiled.things(depth_m, *rays, stride, boxes, place, frame, rules)


def joined_cells(
    cells: F64, others: F64, frame: Frame, strays: tuple[float, float], settled: bool
) -> tuple[bytes, bool, float, float] | None:
    """The cells of a grid under both (N, 2), (M, 2) m, each once, in scan order, without strays,
    packed; whether there was none; and the medians of x and y. None where `settled`, the first
    having no strays, and no cell is new. `strays` are farther from the middle than so many times
    the median, and than so far, m. ValueError for points that are nowhere on a map, and numbers
    that cannot be."""
    return _compiled.joined_cells(cells, others, frame, strays, settled)


def cells_gap(
    cells: F64, xy: tuple[float, float], other_cells: F64, other_xy: tuple[float, float]
) -> float:
    """(N, 2), (2,), (M, 2), (2,) m -> from either's point to the nearest of the other's cells."""
    return _compiled.cells_gap(cells, xy, other_cells, other_xy)


def cells_extent(cells: F64) -> tuple[float, float]:
    """(N, 2) m -> how far they reach along x and along y, m."""
    return _compiled.cells_extent(cells)


def put_place(places: F64, column: int, xy: tuple[float, float], z_m: float, cells: F64) -> None:
    """Write a column of `places` (7, N): x, y, z of a middle, and the left, lower, right and upper
    end of cells (M, 2), m. IndexError for one that is not there."""
    _compiled.put_place(places, column, xy, z_m, cells)


def near_places(
    places: F64, names: list[int], xy: tuple[float, float], cells: F64, within_m: float
) -> list[tuple[float, int]]:
    """Which of the first columns of `places`, that have a name, may be so near to a thing with its
    middle at `xy` and cells (M, 2), and how near at least, m, the nearest first: its middle to
    their box or middle, or its box to their middle."""
    return _compiled.near_places(places, names, xy, cells, within_m)


def in_plain_view(
    places: F64, names: list[int], depth_m: F32, lens: tuple[float, ...]
) -> list[int]:
    """Which of the first columns of `places`, that have a name, have their middle well inside the
    image (H, W) m, in range, and nothing before it: the median of what is known in the 9 x 9 pixels
    round it is as far. `lens`: as `Lens`."""
    return _compiled.in_plain_view(places, names, depth_m, lens)


def cosine(one: F32, other: F32) -> float:
    """Of (D,) and (D,); NaN where one is of length 0, or they are of different sizes."""
    return _compiled.cosine(one, other)


def add_where(into: F32, mask: Mask, value: float) -> None:
    """Add a number to (h, w) where the mask (h, w) says, in place."""
    _compiled.add_where(into, mask, value)


def shortened(outline: F64, reach_m: float) -> tuple[bytes, float, float, float, float]:
    """(V, 2) m -> the same, packed, no point farther from the first than that; and how far it
    reaches: left, below, right and above."""
    return _compiled.shortened(outline, reach_m)


def sharpness(rgb: U8, rows: int, cols: int) -> float:
    """The mean absolute Laplacian of an image (H, W * 3) made as small as (rows, cols), and grey:
    what OpenCV's area interpolation, conversion and Laplacian give. ValueError unless it is a
    whole number of times as large."""
    return _compiled.sharpness(rgb, rows, cols)
