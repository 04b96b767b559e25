"""Recall by size, and the curve through it."""

from pathlib import Path

import numpy as np
import pytest
from labelled_frames import write_frames

from models.detection.detections import unembedded
from models.evaluation.recall import Curve, fitted, recall_by_size


def test_a_curve_is_found_again_in_what_it_tells():
    true, rng = Curve(0.8, 24.0, 2.0), np.random.default_rng(3)
    sizes = np.exp2(rng.uniform(3.0, 8.0, 6000))
    seen = (rng.random(len(sizes)) < true.of(sizes)).astype(np.float64)
    found = fitted(sizes, seen)
    np.testing.assert_allclose(found.of(sizes), true.of(sizes), atol=0.06)


def test_what_is_reported_by_its_name_near_its_place_counts(tmp_path: Path):
    """Sizes are those in an image 640 px wide; these are 96 wide."""
    sofa, toilet, hidden = (1, [10, 10, 40, 40], 0), (2, [60, 10, 20, 20], 0), (1, [0, 0, 9, 9], 1)
    truth = write_frames(tmp_path, [[sofa, toilet], [sofa, hidden]])

    def told(*rows: tuple[list[float], float, int]):
        boxes, scores, labels = zip(*rows, strict=True)
        return unembedded(
            np.array(boxes, np.float32), np.array(scores, np.float32), np.array(labels, np.int32)
        )

    found = [
        told(([12, 10, 50, 50], 0.5, 0), ([60, 10, 80, 30], 0.9, 0)),  # the toilet as a sofa
        told(([10, 10, 50, 50], 0.1, 0)),  # not surely enough
    ]
    report = recall_by_size(truth, found)
    rows = {row["to_px"]: (row["objects"], row["recall"]) for row in report["sizes"]}
    assert rows == {192: (1, 0.0), 640: (2, 0.5)}
    assert report["curve"].keys() == {"top", "half_px", "gain"}
    assert sum(row["objects"] for row in report["sizes"]) == 3
    assert report["score"] == pytest.approx(0.3)
