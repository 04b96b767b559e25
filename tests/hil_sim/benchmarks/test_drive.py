"""What a detector might say of a recorded frame, and the world that a drive begins with."""

import numpy as np

from hil_sim.benchmarks import drive
from runtime.core.types import Pose

LABELS = {
    "boxes": [[10, 20, 200, 300], [300, 50, 420, 200]],
    "names": ["sofa", "plant"],
    "scores": [1.0, 1.0],
    "depths_m": [2.0, 3.0],
    "room": "kitchen",
}


def test_a_frame_has_so_many_detections_and_the_truth_is_among_them():
    seen = drive.detected(LABELS, 3)
    assert len(seen.scores) == len(seen.labels) == len(seen.boxes_px) == drive.BOXES
    assert (seen.boxes_px[:2] == np.array(LABELS["boxes"])).all()
    assert seen.scores[:2].min() > seen.scores[2:].max()
    assert (seen.boxes_px[:, 2:] > seen.boxes_px[:, :2]).all()
    np.testing.assert_allclose(np.linalg.norm(seen.embeddings, axis=1), 1.0, rtol=1e-5)
    again = drive.detected(LABELS, 3)
    assert (again.embeddings == seen.embeddings).all()


def test_where_nothing_is_in_view_nothing_is_detected():
    nothing = {"boxes": [], "names": [], "scores": [], "depths_m": [], "room": None}
    assert len(drive.detected(nothing, 0).scores) == 0


def test_a_drive_begins_where_the_map_does():
    config = drive.configuration()
    world = drive.begin(config)
    assert world.pose == Pose(0.0, 0.0, 0.0)
    assert world.map.free[world.map.frame.cell(0.0, 0.0)]
