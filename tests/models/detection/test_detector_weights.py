"""The committed detector is what the manifest says, and answers sensibly to odd frames."""

from pathlib import Path

import numpy as np
import pytest

from models.detection.detector import Detector, open_detector
from models.store import manifest
from models.words.text_encoder import TextEncoder
from models.words.vocabulary import load_vocabulary


@pytest.fixture(scope="module")
def detector(encoder: TextEncoder) -> Detector:
    found = open_detector(manifest.locate("rfnav-det"), "rfnav", encoder)
    words = load_vocabulary()
    found.set_vocabulary(words.objects, words.rooms)
    return found


def test_it_is_small_and_attributed() -> None:
    assert manifest.locate("rfnav-det").stat().st_size < 12e6
    assert (Path(manifest.PACKAGE) / "weights" / "ATTRIBUTION.md").is_file()


def test_a_black_frame_shows_nothing_much(detector: Detector) -> None:
    assert (detector.detect(np.zeros((480, 640, 3), np.uint8)).scores < 0.5).all()


@pytest.mark.parametrize("shape", [(1, 1, 3), (2, 900, 3), (90, 60, 3)])
def test_odd_frames_are_survived(detector: Detector, shape: tuple[int, ...]) -> None:
    seen = detector.detect(np.zeros(shape, np.uint8))
    assert np.isfinite(seen.boxes_px).all()
    assert seen.rooms.sum() == pytest.approx(1, abs=1e-4)


def test_the_same_frame_gives_the_same_answer(detector: Detector) -> None:
    frame = np.random.default_rng(0).integers(0, 255, (480, 640, 3), dtype=np.uint8)
    first, second = detector.detect(frame), detector.detect(frame)
    np.testing.assert_array_equal(first.boxes_px, second.boxes_px)
    np.testing.assert_array_equal(first.scores, second.scores)
