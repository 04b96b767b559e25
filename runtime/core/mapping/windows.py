"""Windows of a grid, and shapes drawn into them: work is done where something changes."""

import math
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from runtime.core.geometry import GridFrame
from runtime.core.types import F32, F64, Mask

Window = tuple[slice, slice]  # of rows and of columns


def ends(window: Window) -> tuple[int, int, int, int]:
    """Its first row and the one after its last, and the columns: as kernels take it."""
    return window[0].start, window[0].stop, window[1].start, window[1].stop


def between(ends: tuple[int, int, int, int]) -> Window:
    """The window of what `ends` told."""
    return slice(ends[0], ends[1]), slice(ends[2], ends[3])


def fan(from_xy: tuple[float, float], azimuths_rad: F32 | F64, range_m: F32 | F64) -> F64:
    """(A,) rad in the map frame and (A,) m -> (A + 1, 2) m, the point that they are seen from
    first: the outline of what is in view."""
    outline = np.empty((len(range_m) + 1, 2))
    outline[0] = x, y = from_xy
    outline[1:, 0] = x + range_m * np.cos(azimuths_rad)
    outline[1:, 1] = y + range_m * np.sin(azimuths_rad)
    return outline


def polygon_mask(frame: GridFrame, outline: F64) -> Mask:
    """(V, 2) m in the map frame -> (R, C) cells inside the polygon."""
    mask = np.zeros(frame.shape, bool)
    patch, window = polygon_patch(frame, outline)
    mask[window] = patch
    return mask


def polygon_patch(frame: GridFrame, outline: F64) -> tuple[Mask, Window]:
    """(V, 2) m in the map frame -> the window that holds the polygon, and the cells of it that are
    inside the polygon."""
    shift = 4  # sub-cell precision of fillPoly, bits
    scaled = ((outline - (frame.x0_m, frame.y0_m)) / frame.resolution_m - 0.5) * (1 << shift)
    points = np.round(scaled).astype(np.int32)
    (x0, y0), (x1, y1) = points.min(axis=0) >> shift, points.max(axis=0) >> shift
    held = slice(max(0, int(y0) - 1), int(y1) + 3), slice(max(0, int(x0) - 1), int(x1) + 3)
    window = widened(held, 0, frame)
    corner = np.array([window[1].start, window[0].start], np.int32) << shift
    size = (window[0].stop - window[0].start, window[1].stop - window[1].start)
    patch = np.zeros(size, np.uint8)
    if patch.size:
        cv2.fillPoly(patch, [points - corner], 1, shift=shift)
    return patch.view(bool), window


def widened(window: Window, margin: int, frame: GridFrame) -> Window:
    """The window and so many cells around it, as far as the grid reaches."""

    def clipped(part: slice, size: int) -> slice:
        start = min(max(0, part.start - margin), size)
        return slice(start, max(start, min(size, part.stop + margin)))

    return clipped(window[0], frame.rows), clipped(window[1], frame.cols)


def joined(a: Window | None, b: Window) -> Window:
    """The smallest window that holds both."""
    if a is None:
        return b
    rows = slice(min(a[0].start, b[0].start), max(a[0].stop, b[0].stop))
    return rows, slice(min(a[1].start, b[1].start), max(a[1].stop, b[1].stop))


def part_frame(frame: GridFrame, window: Window) -> GridFrame:
    """The frame of an array of the window's size, in the numbers of the whole."""
    rows, cols = window
    return replace(
        frame,
        rows=rows.stop - rows.start,
        cols=cols.stop - cols.start,
        first_row=frame.first_row + rows.start,
        first_col=frame.first_col + cols.start,
    )


def inside(window: Window, outer: Window) -> Window:
    """The window as a part of another that holds it: of an array of the other's size."""
    rows, cols = (
        slice(w.start - o.start, w.stop - o.start) for w, o in zip(window, outer, strict=True)
    )
    return rows, cols


def bounds(mask: Mask, window: Window) -> Window:
    """The part of the window where the mask (of its size) holds anything."""
    rows, cols = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    r, c = window[0].start, window[1].start
    return (
        slice(r + int(rows[0]), r + int(rows[-1]) + 1),
        slice(c + int(cols[0]), c + int(cols[-1]) + 1),
    )


def disc_window(frame: GridFrame, x_m: float, y_m: float, radius_m: float) -> tuple[Mask, Window]:
    """The window of the grid around the point, and the cells of it whose centre is within the
    radius."""
    n = math.ceil(radius_m / frame.resolution_m)
    row, col = frame.cell(x_m, y_m)
    window = widened((slice(row - n, row + n + 1), slice(col - n, col + n + 1)), 0, frame)
    first_row, first_col, r = frame.first_row + 0.5, frame.first_col + 0.5, frame.resolution_m
    y = (np.arange(window[0].start, window[0].stop) + first_row) * r + frame.y0_m - y_m
    x = (np.arange(window[1].start, window[1].stop) + first_col) * r + frame.x0_m - x_m
    return np.hypot(x, y[:, None]) <= radius_m, window


def padded(array: NDArray[Any], padding: tuple[int, int, int, int]) -> NDArray[Any]:
    """(..., R, C) -> the same within zeros: so many rows above and below it, and columns to its
    left and right. Memory that is not written to costs nothing."""
    top, bottom, left, right = padding
    *rest, rows, cols = array.shape
    wider = np.zeros((*rest, top + rows + bottom, left + cols + right), array.dtype)
    wider[..., top : top + rows, left : left + cols] = array
    return wider
