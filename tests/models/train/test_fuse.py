"""What was fitted is what is read, and what is told apart is told."""

from pathlib import Path

import numpy as np
import onnx
import pytest
from labelled_frames import SOFA, sofa_graph, write_frames

pytest.importorskip("pycocotools")

from models.detection.detector import OpenDetector, open_detector
from models.detection.fusion import DOMAINS, FusionWeights, Line, Together, read_weights
from models.train import fuse
from models.words.text_encoder import TextEncoder


def test_what_is_written_is_read(tmp_path: Path) -> None:
    names = "ours", "list"
    whole = Together((Line(0.5, 1.0), Line(1.0, 2.0)), -3.0)
    weights = FusionWeights(
        {"ours": "renderings", "list": "photographs"},
        {(n, d): Line(1.5, -0.25) for n in names for d in DOMAINS},
        {(names, d): whole for d in DOMAINS},
    )
    path = tmp_path / "fusion.toml"
    path.write_text(fuse.written(weights))
    assert read_weights(path) == weights


def test_agreement_is_worth_more_than_one_voice(
    tmp_path: Path, constant_graph, encoder: TextEncoder
) -> None:
    """Two that see a sofa everywhere, where in half of the frames there is one; one stays silent in
    the others."""
    truth = [[tuple(SOFA)] if k % 2 else [] for k in range(40)]
    write_frames(tmp_path / "frames", truth)
    both = [open_detector(sofa_graph(constant_graph, encoder), "auto", encoder) for _ in range(2)]
    seen = fuse.look(both, tmp_path / "frames", None)
    quiet = tuple(
        f
        if k % 2
        else f._replace(boxes_px=f.boxes_px[:0], scores=f.scores[:0], labels=f.labels[:0])
        for k, f in enumerate(seen.found[1])
    )
    seen = fuse.FramesSeen(seen.truth, (seen.found[0], quiet), seen.knows, seen.scenes)
    whole = fuse.fit_together([seen])
    p = float(seen.found[0][0].scores[0])
    odds = np.log(p / (1 - p))
    one = whole.lines[0].gain * odds + whole.lines[0].shift + whole.constant
    two = one + whole.lines[1].gain * odds + whole.lines[1].shift
    assert one < -1
    assert two > 1


def test_the_direction_tells_photographs_and_is_kept_in_the_file(
    tmp_path: Path, constant_graph, encoder: TextEncoder
) -> None:
    rng = np.random.default_rng(0)
    rows = rng.normal(size=(120, 384))
    rows[:60, 0] += 5.0
    rows /= np.linalg.norm(rows, axis=1, keepdims=True)
    row, share = fuse.fit_direction(rows[:60], rows[60:])
    assert share > 0.7
    path = sofa_graph(constant_graph, encoder)
    fuse.write_direction(path, row)
    assert onnx.load(str(path)).metadata_props
    detector = open_detector(path, "auto", encoder)
    assert isinstance(detector, OpenDetector)
    odds = [detector.photograph_odds(r.astype(np.float32)) for r in (rows[0], rows[-1])]
    assert odds[0] is not None
    assert odds[1] is not None
    assert odds[0] > 0 > odds[1]
    assert odds[0] == pytest.approx(float(row[:-1] @ rows[0] + row[-1]), abs=1e-2)
