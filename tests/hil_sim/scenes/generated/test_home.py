import functools
import itertools
import json
import random

import numpy as np
import pytest

from hil_sim.ground_truth.episodes import HM3D_GOALS
from hil_sim.ground_truth.freespace import FreeSpace, build_free_space, categories_of
from hil_sim.scenes.format import Scene, room_at
from hil_sim.scenes.furniture.boxes import ROBOT_M, Box, box_of, furniture
from hil_sim.scenes.furniture.shapes.named import BUILTINS
from hil_sim.scenes.furniture.surfaces import lies_on, resting_place
from hil_sim.scenes.generated.home import generate
from hil_sim.scenes.scene_file import check_meshes, load_scene, parse_scene, scene_to_json
from hil_sim.scenes.viewpoints import floor_of, viewpoints

pytestmark = pytest.mark.slow  # homes are drawn

HOMES = [*(f"train {seed}" for seed in range(8)), "val 0", "val 1", "maple", "cedar"]


@functools.cache
def home(name: str) -> Scene:
    if " " in name:
        split, seed = name.split()
        return generate(int(seed), split)
    return load_scene(name)


def free_space(scene: Scene) -> FreeSpace:
    """Free space with furniture as boxes: stricter than its true shape."""
    boxes = [box_of(obj) for obj in scene.objects]
    for wall in scene.walls:
        boxes += wall_pieces(scene, wall.start, wall.end, wall.thickness_m)
    return build_free_space(scene, np.concatenate([triangles(box) for box in boxes]))


def wall_pieces(
    scene: Scene, start: tuple[float, float], end: tuple[float, float], thickness: float
) -> list[Box]:
    a, b = np.array(start), np.array(end)
    length, along = float(np.hypot(*(b - a))), (b - a) / np.hypot(*(b - a))
    cuts = [0.0, length]
    for door in scene.doors:
        t = sorted(float((np.array(p) - a) @ along) for p in (door.start, door.end))
        off = abs(np.array([-along[1], along[0]]) @ (np.array(door.start) - a))
        if off < 0.05 and t[0] > -0.05 and t[1] < length + 0.05:
            cuts += t
    yaw = float(np.arctan2(along[1], along[0]))
    middles = [
        (s, e, a + along * (s + e) / 2)
        for s, e in zip(sorted(cuts)[::2], sorted(cuts)[1::2], strict=True)
    ]
    return [Box(m[0], m[1], e - s, thickness, yaw, 0.0, 2.5) for s, e, m in middles if e > s]


def triangles(box: Box) -> np.ndarray:
    """(N, 3, 3): the sides of a box and its middle plane."""
    c = box.corners()
    faces = [(c, box.z0), (c, box.z1), (c, (box.z0 + box.z1) / 2)]
    flat = [np.c_[[q[0], q[i], q[i + 1]], [z] * 3] for q, z in faces for i in (1, 2)]
    upright = []
    for p, q in zip(c, np.roll(c, -1, axis=0), strict=True):
        upright += [
            [[*p, box.z0], [*q, box.z0], [*q, box.z1]],
            [[*p, box.z0], [*q, box.z1], [*p, box.z1]],
        ]
    return np.concatenate([np.array(flat), np.array(upright)])


@pytest.mark.parametrize("name", HOMES)
def test_nothing_interpenetrates_and_everything_is_indoors(name: str) -> None:
    scene = home(name)
    solid = [(box_of(o), resting_place(o)) for o in scene.objects if box_of(o).z1 > 0.03]
    for (a, seat_a), (b, seat_b) in itertools.combinations(solid, 2):
        in_seat = (seat_a and lies_on(b, seat_a)) or (seat_b and lies_on(a, seat_b))
        assert in_seat or not a.overlaps(b), (a, b)
    for obj in scene.objects:
        assert room_at(scene, *obj.position_m[:2]) is not None, obj.id


@pytest.mark.parametrize("name", HOMES)
def test_every_room_is_reachable_and_doors_are_clear(name: str) -> None:
    scene = home(name)
    space = free_space(scene)
    door = scene.doors[0]
    middles = [(np.array(d.start) + d.end) / 2 for d in scene.doors]
    field = space.distance_field(np.array(middles[:1]))
    for middle, door in zip(middles, scene.doors, strict=True):
        assert np.isfinite(space.distance(field, *middle)), door
        assert np.hypot(*np.subtract(door.end, door.start)) >= 0.8 - 1e-6
    rooms = {room_at(scene, *p).name for p in space.points(np.argwhere(np.isfinite(field)))}  # type: ignore[union-attr]
    assert rooms == {room.name for room in scene.rooms}
    assert ROBOT_M > 0.18


@pytest.mark.parametrize("name", HOMES)
def test_a_home_is_a_valid_scene_with_known_meshes(name: str) -> None:
    scene = home(name)
    data = json.loads(json.dumps(scene_to_json(scene)))
    assert parse_scene(data, name) == scene
    known = {mesh.id for meshes in furniture().values() for mesh in meshes}
    check_meshes(scene, known | {f"builtin:{name}" for name in BUILTINS})


def test_a_seed_gives_the_same_home() -> None:
    assert generate(5) == generate(5)
    assert generate(5) != generate(6)
    assert generate(5).objects != generate(5, "val").objects


@pytest.mark.slow
def test_held_out_meshes_never_appear_in_training() -> None:
    held_out = {m.id for meshes in furniture().values() for m in meshes if m.split == "val"}
    used = {obj.mesh for seed in range(20) for obj in generate(seed).objects}
    assert held_out
    assert not held_out & used


@pytest.mark.parametrize("name", ["maple", "cedar"])
def test_the_homes_hold_the_hm3d_goals(name: str) -> None:
    scene = load_scene(name)
    present = {obj.category for obj in scene.objects}
    for goal in HM3D_GOALS:
        assert present & set(categories_of(goal)), goal
    assert {"refrigerator", "sink", "bathtub", "stove", "table"} <= present
    assert len(scene.objects) >= 40
    types = {room.type for room in scene.rooms}
    assert {"kitchen", "bathroom", "bedroom", "living room", "hallway"} <= types


def test_viewpoints_stand_on_free_floor_and_repeat() -> None:
    scene = generate(3)
    poses = viewpoints(random.Random(1), scene, 40)
    floor = floor_of(scene)
    assert poses == viewpoints(random.Random(1), scene, 40)
    for x, y, _ in poses:
        cell = floor.cell(x, y)
        assert cell is not None
        assert floor.standing[cell]
