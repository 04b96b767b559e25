"""Instances: whose footprint is believed, and what a box whose middle shows something else says."""

import math
from dataclasses import replace

import numpy as np
import pytest

from runtime.core.mapping.grid import NavigationMap
from runtime.core.objects.catalogue import OBJECT_CONFIDENCE
from runtime.core.objects.instances import CUT_WEIGHT, MAX_STEP, MISS_STEP, Instance
from runtime.core.objects.semantic_map import SemanticMap, place
from runtime.core.types import Detections, Intrinsics, Mount, Observation, Pose

LENS = Intrinsics(97.0, 97.0, 80.0, 60.0, 160, 120)
OUTLINE = np.zeros((3, 2))


def seen(pose: Pose, depth_m: float, known: float | None = None, core: float | None = None):
    """One box in the middle of an image that is `depth_m` away, its core perhaps nearer."""
    depth = np.full((120, 160), depth_m, np.float32)
    if core is not None:
        depth[52:68, 70:90] = core
    obs = Observation(0, np.zeros((120, 160, 3), np.uint8), depth, pose, LENS)
    return obs, Detections(
        np.array([[65, 48, 95, 72]], np.float32),
        np.array([0.9], np.float32),
        np.zeros(1, np.int32),
        np.zeros((1, 0), np.float32),
        np.zeros(0, np.float32),
        depths_m=np.zeros(0, np.float32) if known is None else np.array([known], np.float32),
    )


def mapped(*views) -> Instance:
    grid = NavigationMap.around(Pose(0, 0, 0), 0.18)
    semantic = SemanticMap.empty(("chair",), (), grid.frame)
    for obs, detections in views:
        place(semantic, grid, obs, detections, OUTLINE, Mount())
    assert len(semantic.instances) == 1
    return semantic.instances[1]


def test_a_much_nearer_view_draws_the_footprint_anew():
    far = seen(Pose(0, 0, 0), 4.0)
    near = seen(Pose(2.4, 0, 0), 1.4)
    instance = mapped(far, near)
    assert instance.range_m == pytest.approx(1.4)
    assert instance.cells_xy[:, 0].max() < 3.95  # what the far view said is gone
    alone = mapped(near)
    assert instance.cells_xy.tolist() == alone.cells_xy.tolist()


def test_a_far_view_adds_evidence_but_no_footprint():
    near, far = seen(Pose(2.4, 0, 0), 1.4), seen(Pose(0, 0.0, 0), 4.0)
    once, twice = mapped(near), mapped(near, far)
    assert twice.cells_xy.tolist() == once.cells_xy.tolist()
    assert twice.log_odds > once.log_odds


def test_views_from_about_as_near_are_joined():
    instance = mapped(seen(Pose(0, 0, 0), 2.0), seen(Pose(0, 0.3, 0), 2.0))
    alone = mapped(seen(Pose(0, 0, 0), 2.0))
    assert len(instance.cells_xy) > len(alone.cells_xy)


def test_what_stands_before_a_thing_and_hangs_together_with_nothing_of_it_is_left_out():
    obs, detections = seen(Pose(0, 0, 0), 3.0, known=3.0)
    obs.depth_m[64:72, 65:95] = 2.72
    assert mapped((obs, detections)).cells_xy[:, 0].min() > 2.9


def test_depth_that_the_detector_knows_is_believed_over_the_middle_of_the_box():
    hidden = mapped(seen(Pose(0, 0, 0), 3.0, core=1.0))  # a table leg in front
    assert math.hypot(*hidden.xy) == pytest.approx(1.0, abs=0.1)
    known = mapped(seen(Pose(0, 0, 0), 3.0, known=3.0, core=1.0))
    assert math.hypot(*known.xy) == pytest.approx(3.0, abs=0.1)


@pytest.mark.parametrize(("left", "whole"), [(65.0, True), (0.5, False), (129.0, False)])
def test_a_box_at_a_side_of_the_image_is_a_part_of_something(left: float, whole: bool):
    obs, detections = seen(Pose(0, 0, 0), 3.0)
    box = np.array([[left, 48, left + 30, 72]], np.float32)
    instance = mapped((obs, replace(detections, boxes_px=box)))
    weight = 1.0 if whole else CUT_WEIGHT
    assert instance.log_odds == pytest.approx(weight * MAX_STEP)


def test_of_two_names_in_one_image_the_surer_speaks_and_the_other_loses_nothing():
    grid = NavigationMap.around(Pose(0, 0, 0), 0.18)
    semantic = SemanticMap.empty(("mug", "cup", "pot"), (), grid.frame)
    names = (("mug", 0), ("cup", 1), ("pot", 2))

    def show(y_m: float, *scored: tuple[int, float]) -> dict[str, float]:
        """One box, called that (label, score), from a pose beside the others."""
        obs, one = seen(Pose(0, y_m, math.atan2(-y_m, 3.0)), 3.0)
        both = replace(
            one,
            boxes_px=np.repeat(one.boxes_px, len(scored), 0),
            scores=np.array([score for _, score in scored], np.float32),
            labels=np.array([label for label, _ in scored], np.int32),
            embeddings=np.ones((len(scored), 1), np.float32),
        )
        place(semantic, grid, obs, both, OUTLINE, Mount())
        assert len(semantic.instances) == 1
        known = semantic.instances[1].evidence
        return {name: known[name].odds if name in known else 0.0 for name, _ in names}

    first = show(0.0, (2, 0.5))
    second = show(0.8, (0, 0.9), (1, 0.89))
    assert second["mug"] == pytest.approx(MAX_STEP)
    assert second["cup"] == 0.0
    assert second["pot"] == pytest.approx(first["pot"] - MISS_STEP)
    third = show(-0.8, (0, 0.88), (1, 0.9))
    assert third["cup"] == pytest.approx(MAX_STEP)
    assert third["mug"] == second["mug"]


def test_the_catalogue_follows_what_is_placed_and_missed():
    grid = NavigationMap.around(Pose(0, 0, 0), 0.18)
    semantic = SemanticMap.empty(("chair",), (), grid.frame)
    assert not semantic.catalogue.sure
    views = [seen(Pose(x, y, 0), 3.0 - x) for x, y in ((0.0, 0.0), (0.5, 0.0), (0.0, 0.5))]
    for obs, detections in views:
        place(semantic, grid, obs, detections, OUTLINE, Mount())
        sure = {i.id for i in semantic.instances.values() if i.confidence >= OBJECT_CONFIDENCE}
        assert semantic.catalogue.sure == sure
        assert semantic.called("chair") == list(semantic.instances.values())
    assert sure
    for obs, detections in views * 40:
        arrays = "boxes_px", "scores", "labels", "embeddings"
        nothing = replace(detections, **{name: getattr(detections, name)[:0] for name in arrays})
        place(semantic, grid, obs, nothing, OUTLINE, Mount())
    assert not semantic.catalogue.sure
    assert all(i.confidence < OBJECT_CONFIDENCE for i in semantic.instances.values())
