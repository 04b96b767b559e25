"""A search: where its camera is, and what a goal may not ask for."""

import contextlib
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import boxes
import numpy as np
import pytest
from apartment import INTRINSICS, MOUNT, NO_DETECTIONS, TWO_ROOMS, Apartment
from fake_models import FakeModels
from open_floor import bed

from runtime.config import Config, load
from runtime.core.geometry import rays
from runtime.core.objects.gone import LOOKS
from runtime.core.types import Detections, Hint, Mount, Observation, Pose
from runtime.errors import ConfigError
from runtime.loops.goal_request import Terms
from runtime.loops.order import understand
from runtime.loops.search import JOURNAL_FILE, Search, seen

NODDING = Mount(z_m=0.93, pitch_rad=0.12)


def nodded(obs: Observation) -> Observation:
    """An empty floor as the camera sees it when it nods."""
    table = rays(INTRINSICS, NODDING, 1)
    depth = np.where(table.up < 0, -NODDING.z_m / np.minimum(table.up, -1e-6), 0)
    depth = np.where(depth <= 5.0, depth, 0).astype(np.float32)
    return Observation(obs.stamp_ns, obs.rgb, depth, obs.pose, obs.intrinsics, NODDING)


def terms(directory: Path) -> Terms:
    return Terms(harness=True, directory=lambda: directory)


def free_cells(tmp_path: Path, mount: str) -> int:
    home = Apartment.of(TWO_ROOMS, Pose(3.0, 3.6, 0.0))
    models = FakeModels(home)

    def configure(more):
        return load(None, [f"camera.mount='{mount}'", *more])

    search = Search.begin(understand({"goal": "bed"}, models, configure, terms(tmp_path)))
    world = search.perceive(search.prepared(nodded(home.observe())), NO_DETECTIONS, models)
    search.end("seen")
    models.panel.close()
    assert world.lens is not None
    lens = world.lens[1]
    if mount == "fixed":
        assert (lens.z_m, lens.pitch_rad) == (MOUNT.z_m, 0.0)
    else:
        assert lens.z_m == pytest.approx(NODDING.z_m, abs=0.01)
        assert lens.pitch_rad == pytest.approx(NODDING.pitch_rad, abs=0.01)
    return int(world.map.free.sum())


def test_the_floor_is_kept_where_the_mount_is_known_by_the_frame(tmp_path: Path) -> None:
    fixed, floor, tf = (free_cells(tmp_path, mount) for mount in ("fixed", "floor", "tf"))
    assert tf > 5 * fixed
    assert floor == pytest.approx(tf, rel=0.02)


@contextlib.contextmanager
def search_for(
    home: Apartment, goal: str, tmp_path: Path, *settings: str
) -> Iterator[tuple[Search, FakeModels]]:
    models = FakeModels(home)

    def loaded(more: list[str]) -> Config:
        return load(None, [*settings, *more])

    order = understand({"goal": goal}, models, loaded, terms(tmp_path))
    search = Search.begin(order)
    yield search, models
    search.end("seen")
    models.panel.close()


def test_a_pose_far_off_the_map_is_none_of_it(tmp_path: Path) -> None:
    home = Apartment.of(TWO_ROOMS, Pose(3.0, 3.6, 0.0))
    with search_for(home, "bed", tmp_path) as (search, _):
        obs = search.prepared(home.observe())
        far = replace(obs, pose=Pose(1003.0, 3.6, 0.0))
        assert search.astray(obs) == ""
        assert search.astray(far) == ""  # a map begins wherever it begins
        search.survey(obs)
        assert search.astray(obs) == ""
        assert (
            search.astray(far) == "odometry tells (1003.0, 3.6) m, farther off than a map reaches"
        )


def test_what_flies_is_dropped_before_anything_looks(tmp_path: Path) -> None:
    home = Apartment.of(TWO_ROOMS, Pose(3.0, 3.6, 0.0))
    with search_for(home, "bed", tmp_path) as (search, _):
        obs = home.observe()
        obs.depth_m[:, :100], obs.depth_m[:, 100:] = 1.0, 4.0
        obs.depth_m[:, 100] = 2.0  # between the edge of one thing and what is behind it
        clean = search.prepared(obs)
        assert (clean.depth_m[10:-10, 100] == 0).all()
        assert (clean.depth_m[10:-10, 90:100] == 1.0).all()
        assert (clean.depth_m[10:-10, 103:] == 4.0).all()
        assert clean.mount == search.config.camera
        known = np.full_like(obs.depth_m, 3.0)  # as the reflex has it
        assert search.prepared(replace(obs, solid_m=known)).depth_m is known


def test_a_closer_look_is_offered_where_the_table_is(tmp_path: Path) -> None:
    home = Apartment.of(TWO_ROOMS, Pose(3.0, 3.6, 0.0))
    offered = []

    class Looks(FakeModels):
        def detect(self, rgb: np.ndarray, window=None) -> Detections:
            offered.append(window())
            return NO_DETECTIONS

    with search_for(home, "bed", tmp_path) as (search, _):
        table = rays(INTRINSICS, MOUNT, 1)
        height = np.where(table.up < 0, (0.6 - MOUNT.z_m) / np.minimum(table.up, -1e-6), 0)
        on = (height > 0.7) & (height < 2.0)
        obs = replace(home.observe(), depth_m=np.where(on, height, 4.0).astype(np.float32))
        seen(search, search.prepared(obs), Looks(home), bus=None, labels_s=0.0)
        bare = replace(obs, depth_m=np.full_like(obs.depth_m, 4.0))
        seen(search, search.prepared(bare), Looks(home), bus=None, labels_s=0.0)
    assert offered[0] is not None
    assert offered[1] is None


class TwoBoxes:
    """A bus on which a bed and a lamp are told of."""

    def labels(self, stamp_ns: int, timeout_s: float) -> dict[str, object]:
        boxes = [[10, 10, 60, 50], [90, 20, 99, 40]]
        names, scores = ["bed", "lamp"], [1.0, 1.0]
        return {"boxes": boxes, "names": names, "scores": scores, "room": None}


def test_boxes_of_the_bus_go_with_the_room_and_view_of_the_detector(tmp_path: Path) -> None:
    home = Apartment.of(TWO_ROOMS, Pose(3.0, 3.6, 0.0))
    home.things = {"sofa": (4.5, 3.6, 0.3)}
    view, room = np.array([0.6, 0.8], np.float32), np.array([0.7], np.float32)
    parts = np.ones((4, 6, 8), np.float32)

    class Looks(FakeModels):
        def detect(self, rgb: np.ndarray, window=None) -> Detections:
            told = super().detect(rgb)
            assert len(told.boxes_px) == 1
            return replace(told, rooms=room, scene=view, features=parts)

    def looked(source: str) -> Detections:
        told = f"research.detector_source='{source}'"
        with search_for(home, "bed", tmp_path, told) as (search, _):
            obs = search.prepared(home.observe())
            found = seen(search, obs, Looks(home), TwoBoxes(), 0.0)
        assert found is not None
        return found

    both, topic = looked("both"), looked("topic")
    assert both.boxes_px.tolist() == topic.boxes_px.tolist() == [[10, 10, 60, 50]]
    assert (both.rooms is room, both.scene is view, both.features is parts) == (True, True, True)
    assert (topic.rooms.size, topic.scene.size, topic.features.size) == (0, 0, 0)


def test_experts_hear_of_new_objects_only_where_there_is_time_ahead(tmp_path: Path) -> None:
    home = Apartment.of(TWO_ROOMS, Pose(5.2, 2.3, 0.0))
    home.things = {"bed": (7.4, 2.2, 0.3)}
    with search_for(home, "bed", tmp_path) as (search, models):
        noticed = []
        models.notice = lambda goal, names: noticed.append(names)  # type: ignore[method-assign]
        obs = search.prepared(home.observe())
        outline = search.survey(obs)
        search.place(obs, models.detect(obs.rgb), outline, models, ahead=False)
        assert search.world is not None
        assert search.world.semantic.instances
        assert noticed == []
        search.world.semantic.instances.clear()
        search.place(obs, models.detect(obs.rgb), outline, models)
        assert noticed == [("bed",)]


def test_who_sees_is_handed_the_keyframes_once_there_is_time_for_new_ones(tmp_path: Path) -> None:
    home = Apartment.of(TWO_ROOMS, Pose(5.2, 2.3, 0.0))
    with search_for(home, "bed", tmp_path, "keyframes.image_width_px=64") as (search, models):
        held = []
        models.hold = lambda frames: held.append(len(frames))  # type: ignore[method-assign]
        obs = search.prepared(home.observe())
        outline = search.survey(obs)
        edges = np.kron(np.eye(2, dtype=np.uint8), np.full((240, 320), 200, np.uint8))
        sharp = replace(obs, rgb=np.repeat(edges[:, :, None], 3, axis=2))
        blurred = replace(obs, rgb=np.full_like(sharp.rgb, 90))

        def place(seen: Observation, x_m: float, ahead: bool) -> list[int]:
            seen = replace(seen, pose=Pose(x_m, 2.3, 0.0))
            search.place(seen, models.detect(seen.rgb), outline, models, ahead)
            return held

        assert place(sharp, 5.2, ahead=False) == [1]  # what was held before is of another search
        assert place(sharp, 5.8, ahead=False) == [1]
        assert place(blurred, 5.8, ahead=True) == [1, 2]  # kept while there was no time
        assert place(blurred, 5.8, ahead=True) == [1, 2]
        assert place(sharp, 6.4, ahead=True) == [1, 2, 3]


@pytest.mark.parametrize("key", ["mount='tf'", "mount='fixed'"])
def test_frames_of_tf_do_not_change_with_a_goal(tmp_path: Path, key: str) -> None:
    models = FakeModels(Apartment.of(TWO_ROOMS, Pose(3.0, 3.6, 0.0)))
    own = "camera.mount='tf'"
    settings = [f"camera.{key}", "research.camera_frame='other'"]
    body = {"goal": "bed", "settings": settings}
    with pytest.raises(ConfigError, match=r"^camera.mount: tf is read from the start or not"):
        understand(body, models, lambda more: load(None, [own, *more]), terms(tmp_path))
    models.panel.close()


def test_tf_does_not_come_with_a_goal(tmp_path: Path) -> None:
    models = FakeModels(Apartment.of(TWO_ROOMS, Pose(3.0, 3.6, 0.0)))
    body = {"goal": "bed", "settings": ["camera.mount='tf'"]}
    with pytest.raises(ConfigError, match=r"^camera.mount: tf is read from the start or not"):
        understand(body, models, lambda more: load(None, more), terms(tmp_path))
    models.panel.close()
    assert models.asked == []


def test_what_has_gone_from_the_map_is_journaled(tmp_path: Path) -> None:
    models = FakeModels(Apartment.of(TWO_ROOMS, boxes.HERE))
    request = {"goal": "bed", "log_dir": str(tmp_path)}
    order = understand(request, models, lambda more: load(None, more), terms(tmp_path))
    search = Search.begin(order)
    label = np.array([order.names.index("bed")], np.int32)
    box, none = np.array([[277, 237, 363, 410]], np.float32), np.zeros(0, np.float32)
    there = Detections(box, np.full(1, 0.9, np.float32), label, np.zeros((1, 8), np.float32), none)
    bed, wall = boxes.Box(2.0, 0.0, (0.4, 0.4), 0.0, 0.9), boxes.wall(4.5)
    search.perceive(search.prepared(boxes.seen(boxes.depth_of(wall, bed))), there, models)
    for _ in range(LOOKS):
        obs = search.prepared(boxes.seen(boxes.depth_of(wall)))
        search.perceive(obs, NO_DETECTIONS, models)
    search.end("seen")
    models.panel.close()
    lines = [json.loads(line) for line in (tmp_path / JOURNAL_FILE).read_text().splitlines()]
    (told,) = [line for line in lines if line["kind"] == "gone"]
    assert [thing["name"] for thing in told["objects"]] == ["bed"]


def test_where_the_goal_was_said_to_be_is_known_to_its_world_and_to_the_next_goals(
    tmp_path: Path,
) -> None:
    home = Apartment.of(TWO_ROOMS, Pose(3.0, 3.6, 0.0))
    models = FakeModels(home)
    order = understand({"goal": "bed"}, models, lambda more: load(None, more), terms(tmp_path))
    order = replace(order, goal=replace(order.goal, near=("table",), rooms=("bathroom",)))
    first, second = Search.begin(order), Search.begin(order)
    world = first.perceive(first.prepared(home.observe()), NO_DETECTIONS, models)
    assert world.explored.hint == Hint(("table",), ("bathroom",))
    world.semantic.instances[1] = bed()
    second.inherit(world, models)
    assert second.world is not None
    assert second.world.explored.hint == Hint(("table",), ("bathroom",), frozenset({1}))
    for search in (first, second):
        search.end("seen")
    models.panel.close()
