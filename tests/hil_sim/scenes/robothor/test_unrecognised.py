"""The list of goals that no person would recognise, and who leaves them out."""

import pytest

from hil_sim.ground_truth.goals import categories_of
from hil_sim.scenes.format import Room, Scene, SceneObject
from hil_sim.scenes.robothor import metadata, unrecognised
from hil_sim.scenes.robothor.metadata import APARTMENTS
from hil_sim.scenes.robothor.scenes import GOALS, robothor_scene


def scene(*ids: str) -> Scene:
    objects = tuple(SceneObject(id, "vase", "builtin:vase", (1.0, 1.0, 0.0)) for id in ids)
    square = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0))
    return Scene("FloorPlan_Val1_1", (), (), (Room("all", "kitchen", square),), objects)


def test_a_goal_is_left_out_when_all_of_it_is_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    table = {"FloorPlan_Val1_1": {"vase-1": "hidden", "vase-2": "a dish"}}
    monkeypatch.setattr(unrecognised, "listed", lambda: table)
    assert unrecognised.unrecognised(scene("vase-1"), ("vase",)) == "hidden"
    assert unrecognised.unrecognised(scene("vase-1", "vase-2"), ("vase",)) == "a dish; hidden"
    assert unrecognised.unrecognised(scene("vase-1", "vase-3"), ("vase",)) == ""
    assert unrecognised.unrecognised(scene("vase-1"), ("mug",)) == ""


@pytest.mark.skipif(not metadata.metadata_path().is_file(), reason="no metadata here")
def test_what_is_listed_is_a_goal_of_its_scene_with_a_reason() -> None:
    goals = {c for goal in GOALS.values() for c in categories_of(goal)}
    assert set(unrecognised.listed()) <= set(APARTMENTS)
    for name, reasons in unrecognised.listed().items():
        category = {obj.id: obj.category for obj in robothor_scene(name).objects}
        for id, why in reasons.items():
            assert category[id] in goals, (name, id)
            assert len(why) > 5, (name, id)
