"""What several detectors say of one frame, as one voice: one thing that two see is one detection,
and its score is what their saying so, or the silence of one that knows such things, is worth in
photographs or in renderings. How much that is was fitted (models/detection/fusion.toml, made by
models.train.fuse); of detectors that nothing was fitted for the surest counts."""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.detection.boxes import iou
from models.detection.calibration import log_odds, sigmoid
from models.detection.detections import Floats, RawDetections, select, unembedded
from models.errors import ModelFileError

Domain = Literal["photographs", "renderings"]
DOMAINS: tuple[Domain, ...] = ("photographs", "renderings")
FITTED = Path(__file__).with_name("fusion.toml")
ONE_THING_IOU = 0.5
"""Boxes of one name by two detectors that overlap so far are of one thing."""

Doubles = NDArray[np.float64]
Flags = NDArray[np.bool_]


class Line(NamedTuple):
    """Log odds: `gain` times those of a score, and `shift`."""

    gain: float = 1.0
    shift: float = 0.0


@dataclass(frozen=True)
class Together:
    """What reports are worth where all of these detectors have looked and know such a thing: each
    one's `lines`, in their order, where it reports, and a `constant`."""

    lines: tuple[Line, ...]
    constant: float


@dataclass(frozen=True)
class FusionWeights:
    """Of detectors by name: the domain that each was trained for (`home`), what its scores are
    worth alone in each domain, and what those of a set of them are worth together."""

    home: Mapping[str, Domain] = field(default_factory=dict)
    alone: Mapping[tuple[str, Domain], Line] = field(default_factory=dict)
    together: Mapping[tuple[tuple[str, ...], Domain], Together] = field(default_factory=dict)


def read_weights(path: Path = FITTED) -> FusionWeights:
    """Raises ModelFileError naming what is wrong."""
    try:
        table: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
        home = {name: body["home"] for name, body in table["detectors"].items()}
        if not set(home.values()) <= set(DOMAINS):
            raise ValueError(f"home is one of {', '.join(DOMAINS)}")
        alone = {
            (name, d): Line(**body[d]) for name, body in table["detectors"].items() for d in DOMAINS
        }
        together = {
            (tuple(body["of"]), d): Together(
                tuple(Line(**body[d][name]) for name in body["of"]), float(body[d]["constant"])
            )
            for body in table.get("together", [])
            for d in DOMAINS
        }
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ModelFileError(
            f"{path}: not weights of detectors ({error!r}); make them with models.train.fuse"
        ) from error
    return FusionWeights(home, alone, together)


class FusedPlaces(NamedTuple):
    """Things of one frame by D detectors: `boxes_px` (P, 4) of the surest, `labels` (P,), `odds`
    (P, D) the log odds of each one's score, NaN where it is silent, `which` (P, D) its detection,
    -1 where it is silent."""

    boxes_px: Floats
    labels: NDArray[np.int32]
    odds: Doubles
    which: NDArray[np.int64]


def paired(found: Sequence[RawDetections]) -> FusedPlaces:
    """Detections of one name that overlap are one thing, the surest first."""
    scores = np.concatenate([f.scores for f in found])
    boxes = np.concatenate([f.boxes_px for f in found])
    labels = np.concatenate([f.labels for f in found]).astype(np.int32)
    owner = np.repeat(np.arange(len(found)), [len(f.scores) for f in found])
    own = np.concatenate([np.arange(len(f.scores)) for f in found])
    near = _neighbours(boxes, labels, owner)
    free = [True] * len(scores)
    firsts, which = [], []
    for k in np.argsort(-scores, kind="stable").tolist():
        if not free[k]:
            continue
        row = [-1] * len(found)
        for j in (k, *near[k]):
            if free[j] and row[owner[j]] < 0:
                row[owner[j]], free[j] = int(own[j]), False
        firsts.append(k)
        which.append(row)
    at = np.array(which, np.int64).reshape(-1, len(found))
    odds = np.full(at.shape, np.nan)
    for d, f in enumerate(found):
        said = at[:, d] >= 0
        odds[said, d] = log_odds(f.scores[at[said, d]])
    return FusedPlaces(boxes[firsts], labels[firsts], odds, at)


def _neighbours(
    boxes: Floats, labels: NDArray[np.int32], owner: NDArray[np.int64]
) -> list[list[int]]:
    """Of each detection those of other detectors that are of one thing with it, the nearest
    first."""
    a, b = np.nonzero((labels[:, None] == labels) & (owner[:, None] != owner))
    share = iou(boxes[a], boxes[b])
    near: list[list[int]] = [[] for _ in labels]
    for k in np.argsort(-share, kind="stable").tolist():
        if share[k] >= ONE_THING_IOU:
            near[a[k]].append(int(b[k]))
    return near


def worth(
    places: FusedPlaces, names: Sequence[str], knows: Flags, domain: Domain, weights: FusionWeights
) -> Doubles:
    """(P,) log odds of each place, of detectors by name that all have looked; `knows` (D, C) which
    has a word for which class."""
    gains, shifts = np.array([weights.alone.get((n, domain), Line()) for n in names]).T
    odds = np.nanmax(places.odds * gains + shifts, axis=1, initial=-np.inf)
    said = np.isfinite(places.odds)
    for (those, where), whole in weights.together.items():
        if where != domain or not set(those) <= set(names) or not len(odds):
            continue
        mine = [names.index(n) for n in those]
        theirs = [d for d in range(len(names)) if d not in mine]
        apt = knows[mine][:, places.labels].all(axis=0) & ~said[:, theirs].any(axis=1)
        gains, shifts = np.array(whole.lines).T
        parts = np.where(said[:, mine], places.odds[:, mine] * gains + shifts, 0.0)
        odds = np.where(apt, parts.sum(axis=1) + whole.constant, odds)
    return np.asarray(odds, np.float64)


def fused(
    found: Sequence[RawDetections], names: Sequence[str], knows: Flags, domain: Domain,
    weights: FusionWeights,
) -> tuple[RawDetections, FusedPlaces]:  # fmt: skip
    """One frame's detections as one, best first, without embeddings, rooms or scene; and the places
    that they are, in the same order. Arguments as of `worth`."""
    places = paired(found)
    odds = worth(places, names, knows, domain, weights)
    scores = sigmoid(odds).astype(np.float32)
    kept = select(places.boxes_px, scores, places.labels, across=1.0)
    boxes, labels, each, which = places
    places = FusedPlaces(boxes[kept], labels[kept], each[kept], which[kept])
    return unembedded(places.boxes_px, scores[kept], places.labels), places
