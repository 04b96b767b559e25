"""`python -m models.train.fuse`: what scores of detectors are worth, alone and together, in
photographs and renderings, fitted on labelled frames of both that none of them was trained on; and
how the scene vector of our own tells the two apart. Needs no torch."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from models.checksum import sha256
from models.detection.detections import Detector, RawDetections
from models.detection.detector import PHOTOGRAPHS, OpenDetector, open_detector
from models.detection.fusion import (
    DOMAINS,
    FITTED,
    Domain,
    FusionWeights,
    Line,
    Together,
    paired,
    read_weights,
)
from models.errors import ModelFileError, told
from models.evaluation.judged import Judged, fit_calibration, fit_odds, judge, verdicts
from models.evaluation.naming import detect_all
from models.evaluation.truth import FrameTruth, read_truth
from models.store import manifest
from models.train.graph import write_metadata
from models.words.text_encoder import TextEncoder

BESIDE = "nanodet-g"
"""The detector that looks beside one of ours, trained for photographs."""
PARTS = 5
"""Of the frames, each of which is told by a fit on the others, to say how well that does."""

STRETCH = 10.0
"""Of scene vectors, so that weights are free to be as large as they have to be."""
FILE = click.Path(path_type=Path)
_NONE = np.zeros(0, np.int64), np.zeros(0, np.int64)

Doubles = NDArray[np.float64]


@dataclass(frozen=True)
class FramesSeen:
    """One directory of frames by every detector, ours first: `found` by detector and
    frame, `knows` (D, C), `scenes` (F, S)."""

    truth: FrameTruth
    found: tuple[tuple[RawDetections, ...], ...]
    knows: NDArray[np.bool_]
    scenes: Doubles


def look(detectors: Sequence[Detector], directory: Path, limit: int | None) -> FramesSeen:
    """All detectors on all frames, asked by the categories of the directory."""
    truth = read_truth(directory, limit)
    found, knows = [], []
    for detector in detectors:
        found.append(detect_all(detector, truth, [])[0])
        unseen = detector.capabilities["unseen"]
        knows.append([c not in unseen for c in truth.categories])
    scenes = next((f for f in found if f[0].scene.size), found[0])
    return FramesSeen(
        truth, tuple(found), np.array(knows, bool), np.array([f.scene for f in scenes], np.float64)
    )


def fit_alone(seen: Sequence[FramesSeen], which: int) -> Line:
    """What one detector's scores are worth."""
    parts = [judge(s.truth, s.found[which]) for s in seen]
    score, right = (np.concatenate([getattr(p, f) for p in parts]) for f in ("score", "right"))
    return Line(*fit_calibration(Judged(score, right, *_NONE)))


def fit_together(seen: Sequence[FramesSeen]) -> Together:
    """What the reports of all are worth, of classes that all know: a logistic fit of "right" on who
    reports, and how surely."""
    evidence, right, none = [], [], np.zeros(0, np.float32)
    for s in seen:
        for marks, found in zip(s.truth.marks, zip(*s.found, strict=True), strict=True):
            places = paired(found)
            surest = np.nanmax(places.odds, axis=1, initial=-np.inf)
            one = RawDetections(places.boxes_px, surest, places.labels, none, none, none)
            for k, verdict in enumerate(verdicts(one, marks)):
                if verdict is not None and s.knows[:, places.labels[k]].all():
                    said = np.isfinite(places.odds[k])
                    odds = np.where(said, places.odds[k], 0.0)
                    evidence.append(np.stack((odds, said), axis=1).reshape(-1))
                    right.append(verdict)
    start = np.array([1.0, 0.0] * len(seen[0].found) + [-1.0])
    *w, constant = fit_odds(np.array(evidence), np.array(right, bool), start).tolist()
    lines = tuple(Line(w[2 * d], w[2 * d + 1]) for d in range(len(w) // 2))
    return Together(lines, constant)


def fit_direction(photographs: Doubles, renderings: Doubles) -> tuple[Doubles, float]:
    """(P, S), (R, S) scene vectors -> (S + 1,) weights and a constant for the log odds of a
    photograph, and the share of single frames that fits on the others tell rightly. Each domain
    counts as much as the other."""
    count = min(len(photographs), len(renderings))
    rng = np.random.default_rng(0)
    rows = np.concatenate([rng.permutation(x)[:count] for x in (photographs, renderings)])
    is_photograph = np.arange(2 * count) < count
    part = np.arange(2 * count) % PARTS
    right = []
    for k in range(PARTS):
        w = _direction(rows[part != k], is_photograph[part != k])
        right.append((rows[part == k] @ w[:-1] + w[-1] > 0) == is_photograph[part == k])
    return _direction(rows, is_photograph), float(np.concatenate(right).mean())


def _direction(rows: Doubles, is_photograph: NDArray[np.bool_]) -> Doubles:
    w = fit_odds(STRETCH * rows, is_photograph, np.zeros(rows.shape[1] + 1))
    return np.append(STRETCH * w[:-1], w[-1])


def write_direction(path: Path, row: Doubles) -> None:
    """Put the direction into the metadata of our detector's file."""
    write_metadata(path, {PHOTOGRAPHS: json.dumps([round(float(v), 4) for v in row])})


def written(weights: FusionWeights) -> str:
    """The TOML that models.detection.fusion reads."""
    lines = [
        "# What detectors' scores are worth (log odds), alone and together, by domain: made by"
    ]
    lines += ["# `python -m models.train.fuse`."]
    for name, home in weights.home.items():
        lines += [f"[detectors.{name}]", f'home = "{home}"']
        lines += [f"{d} = {_inline(weights.alone[name, d])}" for d in DOMAINS] + [""]
    for names in dict.fromkeys(names for names, _ in weights.together):
        lines += ["[[together]]", f"of = {json.dumps(list(names))}"]
        for domain in DOMAINS:
            whole = weights.together[names, domain]
            parts = [f"{n} = {_inline(line)}" for n, line in zip(names, whole.lines, strict=True)]
            lines.append(f"{domain} = {{ constant = {whole.constant:.3f}, {', '.join(parts)} }}")
    return "\n".join(lines) + "\n"


def _inline(line: Line) -> str:
    return f"{{ gain = {line.gain:.3f}, shift = {line.shift:.3f} }}"


@click.command(
    epilog="Example:  python -m models.train.fuse --photographs coco --photographs rooms "
    "--renderings frames/dev"
)
@click.option("--photographs", type=FILE, multiple=True, required=True, help="Labelled frames; of "
              "those without any box the domain alone is learned.")  # fmt: skip
@click.option("--renderings", type=FILE, multiple=True, required=True)
@click.option(
    "--ours", type=FILE, help="Our detector's file; it is written to. Default: the project's."
)
@click.option("--name", default="rfnav-det", show_default=True, help="Of ours.")
@click.option("--home", type=click.Choice(DOMAINS), default="renderings", show_default=True,
              help="What ours was trained for first.")  # fmt: skip
@click.option("--out", type=FILE, default=FITTED, show_default=True)
@click.option("--limit", type=click.IntRange(1), help="Only as many frames of each directory.")
def main(
    photographs: tuple[Path, ...], renderings: tuple[Path, ...], ours: Path | None, name: str,
    home: Domain, out: Path, limit: int | None,
) -> None:  # fmt: skip
    """Fit what the scores of ours and of nanodet-g are worth, and the direction that tells domains;
    what OUT has of other detectors stays."""
    path, encoder = ours or manifest.locate(name), TextEncoder(manifest.fetch("minilm"))
    names = name, BESIDE
    files = (path, manifest.locate(BESIDE))
    detectors = [open_detector(file, "auto", encoder) for file in files]
    if not isinstance(detectors[0], OpenDetector):
        raise ModelFileError(f"{path}: not a detector of ours; its scenes tell the domain")
    seen: dict[Domain, list[FramesSeen]] = {
        "photographs": [look(detectors, d, limit) for d in photographs],
        "renderings": [look(detectors, d, limit) for d in renderings],
    }
    boxed = {d: [s for s in seen[d] if s.truth.categories] for d in DOMAINS}
    alone = {(n, d): fit_alone(boxed[d], k) for k, n in enumerate(names) for d in DOMAINS}
    before = read_weights(out) if out.exists() else FusionWeights()
    weights = FusionWeights(
        {**before.home, name: home, BESIDE: "photographs"},
        {**before.alone, **alone},
        {**before.together, **{(names, d): fit_together(boxed[d]) for d in DOMAINS}},
    )
    out.write_text(written(weights), encoding="utf-8")
    scenes = [np.concatenate([s.scenes for s in seen[d]]) for d in DOMAINS]
    row, share = fit_direction(*scenes)
    write_direction(path, row)
    click.echo(f"{out}: written\n{path}: of single frames {share:.3f} are told rightly")
    click.echo(f"{path.stat().st_size} bytes, sha256 {sha256(path)}")


if __name__ == "__main__":
    told(main)
