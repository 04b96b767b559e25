import json
import math
from pathlib import Path
from random import Random

import numpy as np
import pytest

from hil_sim.ground_truth.labels import LABELLED, CameraView, labels, seen_room, to_optical
from hil_sim.scenes.format import Room, Scene, SceneObject
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.furniture.boxes import box_of
from hil_sim.training_frames.frames import FRAMES_A_HOME, collect, counts, homes, photograph, render

SIZE = (416, 320)
HFOV = math.radians(79)
AHEAD = CameraView(0.0, 0.0, 1.0, 0.0, 0.0, HFOV)


def scene(*objects: SceneObject) -> Scene:
    rooms = (
        Room("a", "kitchen", ((-1, -2), (3, -2), (3, 2), (-1, 2))),
        Room("b", "bedroom", ((3, -2), (9, -2), (9, 2), (3, 2))),
    )
    return Scene("s", (), (), rooms, objects)


def cube(category: str, x: float) -> SceneObject:
    return SceneObject(f"{category}{x}", category, "m", (x, 0.0, 0.5), 0.0, (1.0, 1.0, 1.0))


def painted(index: int, box: tuple[int, int, int, int]) -> np.ndarray:
    seen = np.full((320, 416), -1, np.int32)
    x, y, w, h = box
    seen[y : y + h, x : x + w] = index
    return seen


def test_optical_axes_follow_yaw_and_pitch() -> None:
    turned = CameraView(1.0, 2.0, 0.5, math.pi / 2, 0.0, HFOV)
    left, up, ahead = to_optical(np.array([[0.0, 2, 0.5], [1, 2, 1.5], [1, 4, 0.5]]), turned)
    assert left == pytest.approx([-1, 0, 0])
    assert up == pytest.approx([0, -1, 0])
    assert ahead == pytest.approx([0, 0, 2])
    lifted = CameraView(0, 0, 0, 0, math.pi / 4, HFOV)
    assert to_optical(np.array([[1.0, 0, 1]]), lifted)[0] == pytest.approx([0, 0, math.sqrt(2)])


def test_a_box_bounds_the_visible_pixels() -> None:
    home = scene(cube("chair", 4.0))
    seen, depth = painted(0, (180, 130, 60, 60)), np.full((320, 416), 4.0, np.float32)
    (label,) = labels(home, [box_of(o) for o in home.objects], AHEAD, depth, seen)
    assert label.category == "chair"
    assert label.bbox == (180, 130, 60, 60)
    assert label.area == 3600
    assert not label.ignore


def test_small_or_hidden_objects_are_to_be_ignored() -> None:
    home = scene(cube("chair", 4.0))
    boxes, far = [box_of(o) for o in home.objects], np.full((320, 416), 4.0, np.float32)
    (small,) = labels(home, boxes, AHEAD, far, painted(0, (200, 150, 9, 9)))
    assert small.ignore
    # A wall at 1 m hides all but a strip of the cube.
    hidden = np.full((320, 416), 1.0, np.float32)
    (strip,) = labels(home, boxes, AHEAD, hidden, painted(0, (180, 130, 8, 60)))
    assert strip.area > 400
    assert strip.ignore


def test_what_has_no_name_gets_no_label() -> None:
    home = scene(cube("other", 4.0))
    boxes, depth = [box_of(o) for o in home.objects], np.ones((320, 416), np.float32)
    assert labels(home, boxes, AHEAD, depth, painted(0, (180, 130, 60, 60))) == []
    assert "other" not in LABELLED


def test_the_room_is_the_cameras_own_unless_another_fills_the_view() -> None:
    near, far = np.full((320, 416), 2.0, np.float32), np.full((320, 416), 6.0, np.float32)
    assert seen_room(scene(), AHEAD, near) == "kitchen"
    assert seen_room(scene(), AHEAD, far) == ""
    assert seen_room(scene(), CameraView(20, 0, 1, 0, 0, HFOV), near) == ""


def test_shards_become_one_coco_file(tmp_path: Path) -> None:
    (tmp_path / "shards").mkdir()
    label = {"category": "sofa", "bbox": [1, 2, 30, 40], "area": 900, "ignore": False}
    rows = [
        {"file_name": f"{i}.jpg", "room": "kitchen", "objects": [label, {**label, "ignore": True}]}
        for i in range(3)
    ]
    (tmp_path / "shards" / "train-4.json").write_text(json.dumps(rows))
    coco = collect(tmp_path, ["train-4"], 2, SIZE)
    assert [image["file_name"] for image in coco["images"]] == ["0.jpg", "1.jpg"]
    assert coco["images"][0]["room"] == "kitchen"
    assert [a["iscrowd"] for a in coco["annotations"]] == [0, 1, 0, 1]
    assert counts(coco)["sofa"] == 2
    assert counts(coco)["bed"] == 0


def test_replicas_come_first_and_stay_in_their_split() -> None:
    names = homes("val", 7, 16 * FRAMES_A_HOME, replicas=True)
    assert names[0] == "FloorPlan_Val1_1"
    assert names[14:] == ["FloorPlan_Val3_5", "val-7"]
    assert homes("train", 7, 2 * FRAMES_A_HOME, replicas=False) == ["train-7", "train-8"]


def test_cluttered_and_varied_homes_come_last() -> None:
    names = homes("train", 3, 1, False, cluttered=FRAMES_A_HOME + 1, varied=1)
    assert names == ["train-3", "train-3-cluttered", "train-4-cluttered", "train-3-varied"]


def test_a_photograph_repeats_by_seed_and_keeps_its_shape() -> None:
    rgb = np.full((32, 48, 3), 128, np.uint8)
    one, two = photograph(Random(1), rgb), photograph(Random(1), rgb)
    assert one.dtype == np.uint8
    assert one.shape == rgb.shape
    assert (one == two).all()


@pytest.mark.slow
@pytest.mark.skipif(not Assets().present, reason="the furniture is not in the cache")
def test_only_a_home_furnished_by_type_teaches_room_types(tmp_path: Path) -> None:
    names = homes("train", 3, 1, False, cluttered=1, varied=1)
    coco = render(tmp_path, 3 * FRAMES_A_HOME, names, SIZE, workers=2)
    rooms = {image["file_name"].rsplit("-", 1)[0]: set() for image in coco["images"]}
    for image in coco["images"]:
        rooms[image["file_name"].rsplit("-", 1)[0]].add(image["room"])
    assert len(rooms["train-3"]) > 1
    assert rooms["train-3-cluttered"] == rooms["train-3-varied"] == {""}


@pytest.mark.slow
@pytest.mark.skipif(not Assets().present, reason="the furniture is not in the cache")
def test_a_home_is_rendered_and_kept(tmp_path: Path) -> None:
    names = homes("train", 0, 3, replicas=False)
    coco = render(tmp_path, 3, names, SIZE, workers=1)
    assert len(coco["images"]) == 3
    assert len(list((tmp_path / "images").glob("*.jpg"))) == FRAMES_A_HOME
    before = {p: p.stat().st_mtime_ns for p in (tmp_path / "images").iterdir()}
    assert render(tmp_path, 3, names, SIZE, workers=1) == coco
    assert before == {p: p.stat().st_mtime_ns for p in (tmp_path / "images").iterdir()}
