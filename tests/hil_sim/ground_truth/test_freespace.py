import math
from dataclasses import replace

import numpy as np
import pytest

from hil_sim.ground_truth.episodes import (
    HM3D_GOALS,
    SHORTEST_M,
    Episode,
    Start,
    check_start,
    load_suite,
    sample_episode,
    save_suite,
)
from hil_sim.ground_truth.freespace import (
    CELL_M,
    FreeSpace,
    build_free_space,
    categories_of,
    instances,
    scene_hash,
    success_cells,
)
from hil_sim.scenes.format import Hole, Room, Scene, SceneError, SceneObject, room_at
from hil_sim.scenes.scene_file import load_scene


def quad(x0: float, y0: float, x1: float, y1: float, z0: float, z1: float) -> np.ndarray:
    """(2, 3, 3) upright rectangle from (x0, y0) to (x1, y1)."""
    a, b, c, d = (x0, y0, z0), (x1, y1, z0), (x1, y1, z1), (x0, y0, z1)
    return np.array([[a, b, c], [a, c, d]], float)


def two_rooms(door_z: float = 3.0) -> FreeSpace:
    """6 x 3 m, a wall at x = 3 with an opening at y 1..2, a sofa in the right room."""
    scene = Scene(
        name="two",
        walls=(),
        doors=(),
        rooms=(Room("all", "living room", ((0, 0), (6, 0), (6, 3), (0, 3))),),
        objects=(
            SceneObject("sofa", "sofa", "m", (5.0, 0.5, 0.0), 0.0, (1.0, 0.6, 0.8)),
            SceneObject("rug", "other", "m", (1.0, 1.0, 0.0), 0.0, (1.0, 0.6, 0.01)),
        ),
    )
    sides = [(0, 0, 6, 0), (6, 0, 6, 3), (6, 3, 0, 3), (0, 3, 0, 0), (3, 0, 3, 1), (3, 2, 3, 3)]
    shapes = [quad(*side, 0.0, 2.5) for side in sides]
    shapes += [quad(3, 1, 3, 2, door_z, 2.5 if door_z < 2.5 else 3.5)]
    sofa = [(4.5, 0.2, 5.5, 0.2), (5.5, 0.2, 5.5, 0.8), (5.5, 0.8, 4.5, 0.8), (4.5, 0.8, 4.5, 0.2)]
    shapes += [quad(*side, 0.0, 0.8) for side in sofa]
    return build_free_space(scene, np.concatenate(shapes))


def test_free_cells_keep_the_body_clear_of_holes() -> None:
    room = Room("all", "living room", ((0, 0), (4, 0), (4, 3), (0, 3)))
    hole = Hole(((1.5, 0.0), (2.5, 0.0), (2.5, 2.0), (1.5, 2.0)), 2.0)
    outer = [(0, 0, 4, 0), (4, 0, 4, 3), (4, 3, 0, 3), (0, 3, 0, 0)]
    scene = Scene("pit", (), (), (room,), (), holes=(hole,))
    space = build_free_space(scene, np.concatenate([quad(*side, 0.0, 2.5) for side in outer]))
    assert space.is_free(1.0, 1.0)
    assert space.is_free(2.0, 2.5)
    assert not space.is_free(2.0, 1.0)
    assert not space.is_free(1.4, 1.0)
    way = space.distance_field(np.array([[3.2, 1.0]]))
    assert space.distance(way, 0.8, 1.0) > 3.0  # around it, and not across


def test_free_cells_keep_the_body_clear_of_walls() -> None:
    space = two_rooms()
    assert space.is_free(1.0, 1.5)
    assert space.is_free(3.0, 1.5)
    assert not space.is_free(0.15, 1.5)
    assert not space.is_free(3.0, 1.1)
    assert not space.is_free(5.0, 0.9)
    assert not space.is_free(-0.2, 1.5)
    assert space.nearest_free(0.15, 1.5) is not None
    assert space.nearest_free(3.0, 0.4) is None


def test_what_is_above_the_body_or_flat_on_the_floor_does_not_block() -> None:
    assert two_rooms(door_z=0.9).is_free(3.0, 1.5)
    assert not two_rooms(door_z=0.8).is_free(3.0, 1.5)


def test_geodesic_distance_goes_through_the_opening() -> None:
    space = two_rooms()
    field = space.distance_field(np.array([[4.0, 2.6]]))
    straight = math.dist((2.0, 2.6), (4.0, 2.6))
    through = space.distance(field, 2.0, 2.6)
    corner = (3.0, 2.0 - 0.22)
    assert through == pytest.approx(2 * math.dist((2.0, 2.6), corner), rel=0.06)
    assert through > straight
    assert space.distance(field, 4.0, 2.6) == 0.0
    assert space.distance(field, 4.5, 2.6) == pytest.approx(0.5, abs=CELL_M)
    shut = two_rooms(door_z=0.0)
    assert math.isinf(shut.distance(shut.distance_field(np.array([[4.0, 2.6]])), 2.0, 2.6))


def footprints(space: FreeSpace) -> list[np.ndarray]:
    found = []
    for obj in space.scene.objects:
        (x, y, _), (w, d, _) = obj.position_m, obj.size_m or (0, 0, 0)
        corners = [(-w, -d), (w, -d), (w, d), (-w, d)]
        found.append(np.array([(x + u / 2, y + v / 2) for u, v in corners]))
    return found


def test_success_is_near_and_in_view() -> None:
    space = two_rooms()

    def look(x_m: float, y_m: float, yaw_rad: float) -> np.ndarray:
        assert math.cos(yaw_rad - math.atan2(0.5 - y_m, 5.0 - x_m)) > 0.999
        return np.array([500 if x_m > 5.0 else 100, 0])

    cells = success_cells(space, "couch", footprints(space), look)
    points = space.points(cells)
    assert len(points) > 20
    assert points[:, 0].min() > 5.0 - 2 * CELL_M
    assert points[:, 1].max() <= 0.8 + 1.0
    assert all(space.free[tuple(cell)] for cell in cells)


def test_goal_words_name_scene_categories() -> None:
    assert categories_of("tv monitor") == ("television",)
    assert categories_of("  Potted  Plant ") == ("plant",)
    assert categories_of("toilet") == ("toilet",)
    with pytest.raises(
        SceneError, match="two: goal 'toilet': no such object here; there are: sofa"
    ):
        instances(two_rooms().scene, "toilet")


def test_what_is_never_labelled_is_no_goal() -> None:
    scene = two_rooms().scene
    both = replace(scene, objects=(*scene.objects, replace(scene.objects[0], category="other")))
    with pytest.raises(SceneError, match=r"goal 'other': no such object here; there are: sofa$"):
        instances(both, "other")
    bare = replace(scene, objects=tuple(replace(obj, category="other") for obj in scene.objects))
    for goal in ("other", "bed"):
        with pytest.raises(SceneError, match=f"two: goal '{goal}': no object here can be a goal"):
            instances(bare, goal)


def _all_seen(x_m: float, y_m: float, yaw_rad: float) -> np.ndarray:
    return np.array([999, 0])


def sampled(seed: int) -> Episode:
    space = two_rooms()
    success = success_cells(space, "sofa", footprints(space), _all_seen)
    return sample_episode(space, success, "sofa", seed, lambda x, y, yaw: x > 3)


def test_episodes_repeat_by_seed_and_start_far_and_out_of_sight() -> None:
    assert sampled(1) == sampled(1)
    starts = [sampled(seed) for seed in range(8)]
    assert len({episode.start for episode in starts}) == 8
    for episode in starts:
        assert episode.shortest_path_m >= SHORTEST_M
        assert episode.start.x_m <= 3
        check_start(episode, two_rooms())


def test_a_start_inside_furniture_is_refused() -> None:
    episode = Episode("e", "two", Start(5.0, 0.5, 0.0), "sofa", 1.0)
    with pytest.raises(SceneError, match=r"e: start \(5, 0.5\): inside furniture"):
        check_start(episode, two_rooms())


def test_a_suite_survives_saving_and_bad_ones_are_named(tmp_path) -> None:  # type: ignore[no-untyped-def]
    episodes = tuple(sampled(seed) for seed in range(3))
    save_suite(episodes, tmp_path / "s.json")
    assert load_suite(tmp_path / "s.json") == episodes
    with pytest.raises(SceneError, match=r"t.json: two episodes have the id .*; give each one of"):
        save_suite((episodes[0], episodes[0]), tmp_path / "t.json")
    with pytest.raises(SceneError, match="suite nope: unknown; known: "):
        load_suite("nope")
    (tmp_path / "s.json").write_text('{"format": "rf-nav-suite/1", "episodes": [{"id": "a"}]}')
    with pytest.raises(SceneError, match=r"episodes\[0\]: scene: missing"):
        load_suite(tmp_path / "s.json")


def test_the_hash_names_the_content() -> None:
    assert scene_hash(two_rooms().scene) == scene_hash(two_rooms().scene)
    changed = Scene("two", (), (), two_rooms().scene.rooms, ())
    assert scene_hash(changed) != scene_hash(two_rooms().scene)


def test_the_smoke_suite_keeps_the_samplers_rules() -> None:
    episodes = load_suite("smoke")
    assert len({episode.id for episode in episodes}) == 24
    for name in ("maple", "cedar"):
        own = [episode for episode in episodes if episode.scene == name]
        assert sorted(episode.goal for episode in own) == sorted(HM3D_GOALS * 2)
        scene = load_scene(name)
        for episode in own:
            assert room_at(scene, episode.start.x_m, episode.start.y_m) is not None
            assert instances(scene, episode.goal)
            assert episode.shortest_path_m >= SHORTEST_M
