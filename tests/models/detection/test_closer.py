"""A part of an image, and what is found in it put back where it is."""

import numpy as np

from models.detection.closer import joined, joined_views, part, whole
from models.detection.detections import RawDetections
from models.detection.detector import DetectorView

WINDOW = (100, 50, 300, 200)
INSIDE, CUT, LARGE = (20.0, 30.0, 60.0, 70.0), (0.0, 30.0, 40.0, 70.0), (10.0, 10.0, 150.0, 100.0)


def seen(*rows: tuple[int, float, tuple[float, ...]]) -> RawDetections:
    boxes = np.array([r[2] for r in rows], np.float32).reshape(-1, 4)
    scores = np.array([r[1] for r in rows], np.float32)
    none = np.zeros(0, np.float32)
    labels = np.array([r[0] for r in rows], np.int32)
    return RawDetections(boxes, scores, labels, np.zeros((len(rows), 0), np.float32), none, none)


def test_the_part_is_clipped_to_the_image() -> None:
    rgb = np.arange(240 * 320 * 3, dtype=np.uint32).reshape(240, 320, 3).astype(np.uint8)
    assert np.array_equal(part(rgb, WINDOW), rgb[50:200, 100:300])
    assert part(rgb, (200, 100, 400, 300)).shape == (140, 120, 3)


def test_what_is_cut_off_or_large_is_left_to_the_whole_image() -> None:
    boxes = np.array([INSIDE, CUT, LARGE], np.float32)
    assert whole(boxes, WINDOW).tolist() == [True, False, False]
    assert whole(boxes[:0], WINDOW).shape == (0,)


def test_what_the_part_adds_is_where_it_is() -> None:
    near = seen((1, 0.8, INSIDE), (1, 0.9, CUT))
    both = joined(seen((0, 0.6, (10, 10, 40, 40))), near, WINDOW)
    assert both.labels.tolist() == [1, 0]
    assert both.boxes_px[0].tolist() == [120, 80, 160, 120]
    # the same thing in both is one detection, the surer one
    again = joined(seen((1, 0.9, (121, 81, 160, 120))), near, WINDOW)
    np.testing.assert_allclose(again.scores, [0.9])


def test_views_are_joined_as_detections_are() -> None:
    rows = np.eye(2, 4, dtype=np.float32)
    boxes = np.array([INSIDE, CUT], np.float32)
    near = DetectorView(boxes, np.array([0.5, 0.9], np.float32), rows, rows[0])
    view = DetectorView(boxes[:1], np.array([0.7], np.float32), rows[:1], rows[1])
    both = joined_views(view, near, WINDOW)
    assert both.boxes_px.tolist() == [list(INSIDE), [120, 80, 160, 120]]
    np.testing.assert_allclose(both.objectness, [0.7, 0.5])
    assert both.regions.shape == (2, 4)
    assert both.scene is view.scene
