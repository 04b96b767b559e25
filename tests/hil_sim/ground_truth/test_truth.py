"""What the truth of a bundled home tells, as far as nothing has to be drawn for it."""

from types import SimpleNamespace

import pytest

from hil_sim.ground_truth.truth import SceneTruth
from hil_sim.ground_truth.witness import standing_at
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.scene_file import load_scene


def test_things_are_all_objects_where_they_stand():
    scene = load_scene("cedar")
    truth = SceneTruth(SimpleNamespace(scene=scene), Assets())
    things = truth.things()
    assert [name for name, _ in things] == [one.category for one in scene.objects]
    for one, (_, box) in zip(scene.objects, things, strict=True):
        assert box.mean(axis=0) == pytest.approx(one.position_m[:2])
    stool = next(one for one in scene.objects if one.id == "stool-1")
    assert standing_at(things, *stool.position_m[:2]) == ("stool",)
