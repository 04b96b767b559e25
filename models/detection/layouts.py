"""Output layouts of detectors with a fixed list of C classes, decoded to boxes and class scores.

| layout | outputs | boxes | score |
|---|---|---|---|
| v5 | (1, N, 5 + C), N = 3 per cell | cx, cy, w, h px | objectness * class |
| v8 | (1, 4 + C, N), N = 1 per cell | cx, cy, w, h px | class, or its logit |
| X | (1, N, 5 + C), N = 1 per cell | cell offsets and log sizes, undecoded | objectness * class |
| end-to-end | (1, N, 6) | x0, y0, x1, y1 px | best class's; then its number |
| detr | (1, N, C) and (1, N, 4) | cx, cy, w, h in 0..1 | class, or its logit; with C + 1, a softmax, the last is nothing |
| nanodet | (1, N, C + 4 B), or these two parts of each stride; N = 1 per cell | distances to the four sides in strides, each a distribution over B bins | class, or its logit |

Cells are those of strides 8, 16, 32, finest first; nanodet's may be of 64, too.
"""  # noqa: E501

import math
import re
from collections.abc import Collection, Mapping, Sequence
from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from models.detection.calibration import softmax
from models.errors import ModelFileError

STRIDES, MORE_STRIDES = (8, 16, 32), (8, 16, 32, 64)
ANCHORS_V5 = 3
FEW = 1000
"""A network that ends in its best boxes gives at most so many."""
MOST_CLASSES = 2000

Floats = NDArray[np.float32]
Layout = Literal["v5", "v8", "X", "end-to-end", "detr", "nanodet"]
LAYOUTS: tuple[Layout, ...] = get_args(Layout)
Outputs = Mapping[str, Floats]
"""By name, in the file's order."""
EXPECTED = (
    "expected (1, N, 5+C) as YOLOv5 or YOLOX give it, (1, 4+C, N) as YOLOv8 does, (1, N, 6) of an "
    "end-to-end one, (1, N, C) and (1, N, 4) of DETR's kind, or NanoDet's heads"
)


class Decoded(NamedTuple):
    """`boxes` (N, 4) corners in network px, `scores` (N, C)."""

    boxes: Floats
    scores: Floats


def possible(outputs: Outputs, height: int, width: int) -> dict[Layout, Collection[int]]:
    """The layouts that outputs of these shapes and names may be in for an input of that size, each
    with the numbers of classes that it then may have."""
    found: dict[Layout, Collection[int]] = {}
    shapes = [out.shape for out in outputs.values()]
    if any(len(shape) not in (3, 4) or shape[0] != 1 for shape in shapes):
        return {}
    if len(shapes) == 1 and len(shapes[0]) == 3:
        _, rows, columns = shapes[0]
        cells = _count(height, width, STRIDES)
        if columns == cells and rows > 4:
            found["v8"] = (rows - 4,)
        if rows == cells and columns > 5:
            found["X"] = (columns - 5,)
        if rows == ANCHORS_V5 * cells and columns > 5:
            found["v5"] = (columns - 5,)
        if columns == 6 and rows <= FEW:
            found["end-to-end"] = range(1, MOST_CLASSES + 1)
    elif len(shapes) == 2 and (parts := _detr(outputs)):
        classes = parts[1].shape[1]
        # RF-DETR's are sigmoids, whose last one is a class like the others
        found["detr"] = (classes,) if "dets" in outputs else (classes, classes - 1)
    heads = _nanodet(outputs, height, width)
    if heads is not None:
        found["nanodet"] = range(heads.shape[1] - 8, 0, -4)
    return found


def choose(
    outputs: Outputs, size: tuple[int, int], classes: int, told: str, where: str
) -> tuple[Layout, int]:
    """The layout of a file with `classes` names, or 0 where they are not known, and the number of
    classes that it needs, 0 where several would do. `told`: what somebody said it is, or "". Raises
    ModelFileError where nothing fits, or several do."""
    fits = possible(outputs, *size)
    shapes = ", ".join(f"{name} {out.shape}" for name, out in outputs.items())
    place = f"{where}: outputs {shapes} for input {size[0]}x{size[1]}"
    if told:
        if told not in LAYOUTS:
            raise ModelFileError(
                f"{where}: layout {told!r} is unknown; known are {', '.join(LAYOUTS)}"
            )
        if told not in fits:
            raise ModelFileError(f"{place} cannot be of layout {told}; {EXPECTED}")
        fits = {layout: counts for layout, counts in fits.items() if layout == told}
    if not fits:
        raise ModelFileError(f"{place} are of no known layout; {EXPECTED}")
    agreeing = {layout: counts for layout, counts in fits.items() if classes in counts}
    if len(agreeing) > 1:
        raise ModelFileError(
            f"{place} may be of layout {' or '.join(agreeing)}; say which with --layout of "
            "`rfnav models import`, or in the file's metadata `layout`"
        )
    layout, counts = next(iter((agreeing or fits).items()))
    if agreeing:
        return layout, classes
    return layout, 0 if isinstance(counts, range) else next(iter(counts))


def decode(outputs: Outputs, layout: Layout, height: int, width: int, classes: int) -> Decoded:
    """Network outputs -> corners in network px and scores, or logits, per class."""
    if layout == "detr":
        parts = _detr(outputs)
        assert parts is not None
        boxes = parts[0] * np.array([width, height] * 2, np.float32)
        return Decoded(_corners(boxes), parts[1])
    if layout == "nanodet":
        heads = _nanodet(outputs, height, width)
        assert heads is not None
        return _from_distances(heads, height, width, classes)
    output = next(iter(outputs.values()))
    rows = output[0].T if layout == "v8" else output[0]
    if layout == "v8":
        return Decoded(_corners(rows[:, :4]), rows[:, 4:])
    if layout == "end-to-end":
        number = np.nan_to_num(rows[:, 5:6], nan=-1, posinf=-1, neginf=-1).round()
        return Decoded(rows[:, :4], np.where(number == np.arange(classes), rows[:, 4:5], 0))
    scores = rows[:, 4:5] * rows[:, 5:]
    if layout == "v5":
        return Decoded(_corners(rows[:, :4]), scores)
    origin, stride = _cells(height, width, STRIDES)
    middle = (rows[:, :2] + origin) * stride
    size = np.exp(np.minimum(rows[:, 2:4], 20.0)) * stride
    return Decoded(_corners(np.concatenate((middle, size), axis=1)), scores)


def are_logits(scores: Floats) -> bool:
    """Whether scores are no chances: some that are finite lie outside of 0..1, by more than
    rounding."""
    finite = scores[np.isfinite(scores)]
    return bool(((finite < -0.001) | (finite > 1.001)).any())


def _corners(cxcywh: Floats) -> Floats:
    half = cxcywh[:, 2:] / 2
    return np.concatenate((cxcywh[:, :2] - half, cxcywh[:, :2] + half), axis=1)


def _levels(height: int, width: int, strides: Sequence[int]) -> list[tuple[int, int]]:
    return [(math.ceil(height / s), math.ceil(width / s)) for s in strides]


def _count(height: int, width: int, strides: Sequence[int]) -> int:
    return sum(rows * columns for rows, columns in _levels(height, width, strides))


def _cells(height: int, width: int, strides: Sequence[int]) -> tuple[Floats, Floats]:
    """(N, 2) cell columns and rows, (N, 1) strides, finest level first."""
    origins, sizes = [], []
    for stride, (rows, columns) in zip(strides, _levels(height, width, strides), strict=True):
        y, x = np.mgrid[:rows, :columns]
        origin = np.stack((x, y), -1).reshape(-1, 2).astype(np.float32)
        origins.append(origin)
        sizes.append(np.full((len(origin), 1), stride, np.float32))
    return np.concatenate(origins), np.concatenate(sizes)


def _detr(outputs: Outputs) -> tuple[Floats, Floats] | None:
    """Boxes (N, 4) and class scores (N, C) of two outputs; by their names where both have four
    columns."""
    if len(outputs) != 2 or any(out.ndim != 3 for out in outputs.values()):
        return None
    (first, a), (second, b) = outputs.items()
    if a.shape[1] != b.shape[1] or 4 not in (a.shape[2], b.shape[2]):
        return None
    called = [bool(re.search("box|dets", name)) for name in (first, second)]
    if a.shape[2] == b.shape[2] == 4 and called[0] == called[1]:
        return None
    swapped = called[1] if a.shape[2] == b.shape[2] else b.shape[2] == 4
    return (b[0], a[0]) if swapped else (a[0], b[0])


def _nanodet(outputs: Outputs, height: int, width: int) -> Floats | None:
    """(N, C + 4 B): NanoDet's one output, or its heads by stride put together."""
    for strides in (STRIDES, MORE_STRIDES):
        cells = [rows * columns for rows, columns in _levels(height, width, strides)]
        if len(outputs) == 1:
            (out,) = outputs.values()
            if out.ndim == 3 and out.shape[1] == sum(cells) and out.shape[2] > 8:
                return _cellwise(out)
        elif len(outputs) == 2 * len(strides) and len(set(cells)) == len(cells):
            # distances last, as their names say, else as they come
            order = sorted(outputs, key=lambda name: bool(re.search("dis|reg|box", name)))
            parts = [_cellwise(outputs[name]) for name in order]
            pairs = [[part for part in parts if len(part) == n] for n in cells]
            widths = {tuple(part.shape[1] for part in pair) for pair in pairs}
            if len(widths) == 1 and len(wide := widths.pop()) == 2 and wide[1] % 4 == 0:
                return np.concatenate([np.concatenate(pair, axis=1) for pair in pairs])
    return None


def _cellwise(out: Floats) -> Floats:
    """(1, N, K) or (1, K, h, w) -> (N, K)."""
    rows: Floats = out[0].reshape(out.shape[1], -1).T if out.ndim == 4 else out[0]
    return rows


def _from_distances(heads: Floats, height: int, width: int, classes: int) -> Decoded:
    four = len(heads) != _count(height, width, STRIDES)
    origin, stride = _cells(height, width, MORE_STRIDES if four else STRIDES)
    # NanoDet-Plus, which has a fourth stride, measures from a cell's corner, the others from its
    # middle
    middle = (origin + (0.0 if four else 0.5)) * stride
    bins = (heads.shape[1] - classes) // 4
    shares = softmax(heads[:, classes:].reshape(-1, bins)).reshape(-1, 4, bins)
    sides = shares @ np.arange(bins, dtype=np.float32) * stride
    boxes = np.concatenate((middle - sides[:, :2], middle + sides[:, 2:]), axis=1)
    return Decoded(np.asarray(boxes, np.float32), heads[:, :classes])


def decode_prompted(outputs: list[Floats], prompts: int, where: str) -> Decoded:
    """Outputs of a network that takes texts -> corners in network px and a score per prompt."""
    shapes = [out.shape for out in outputs]
    by_shape = {out.shape[2]: out for out in outputs if out.ndim == 3 and out.shape[0] == 1}
    if len(outputs) == 1 and shapes[0][:2] == (1, 4 + prompts) and len(shapes[0]) == 3:
        rows = outputs[0][0].T
        return Decoded(_corners(rows[:, :4]), rows[:, 4:])
    if len(outputs) == 2 and prompts != 4 and set(by_shape) == {4, prompts}:
        boxes, scores = by_shape[4][0], by_shape[prompts][0]
        if len(boxes) == len(scores):
            return Decoded(boxes, scores)
    if shapes[0] == shapes[-1] and prompts == 4 and len(outputs) == 2:
        return Decoded(outputs[0][0], outputs[1][0])  # as documented: boxes, then scores
    raise ModelFileError(
        f"{where}: outputs {shapes} for {prompts} texts; expected boxes (1, L, 4) and scores "
        f"(1, L, {prompts}), or (1, {4 + prompts}, L)"
    )
