"""The replicas: all 75 scenes, and the geometry they are made with."""

import json
import math
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hil_sim.scenes.format import ROOM_TYPES, Wall, contains, polygon_area
from hil_sim.scenes.furniture.boxes import box_of
from hil_sim.scenes.furniture.surfaces import resting_place
from hil_sim.scenes.robothor import metadata
from hil_sim.scenes.robothor.evidence import OUTER
from hil_sim.scenes.robothor.facing import faced
from hil_sim.scenes.robothor.footprints import Footprint, footprint
from hil_sim.scenes.robothor.metadata import APARTMENTS, MetadataError, Thing, apartment, rooms
from hil_sim.scenes.robothor.regions import regions, room_type
from hil_sim.scenes.robothor.scenes import CATEGORY, GOALS, PARTS, SEATS, robothor_scene
from hil_sim.scenes.robothor.walls import layouts
from hil_sim.scenes.scene_file import parse_scene, scene_to_json

pytestmark = pytest.mark.slow  # all replicas are built

needs_metadata = pytest.mark.skipif(
    not metadata.metadata_path().is_file(), reason="no metadata here; run `hil-sim assets pull`"
)


def thing(kind: str = "Sofa", asset: str = "sofa_1", **changes: object) -> Thing:
    plain = Thing(f"{kind}|1", kind, asset, (5, -3, 0), (0, 0, 0), (4, -3.4, 0), (6, -2.6, 0.8))
    return replace(plain, **changes)  # type: ignore[arg-type]


@needs_metadata
@pytest.mark.parametrize("layout", sorted({name[:-2] for name in APARTMENTS}))
def test_scenes_are_whole(layout):
    x0, y0, x1, y1 = OUTER
    for name in (f"{layout}_{variant}" for variant in range(1, 6)):
        scene = robothor_scene(name)
        again = parse_scene(json.loads(json.dumps(scene_to_json(scene))), name)
        assert scene_to_json(again) == scene_to_json(scene)
        assert {obj.category for obj in scene.objects} >= set(GOALS.values())
        for obj in scene.objects:
            corners = box_of(obj).corners()
            assert (corners > np.array([x0, y0]) - 0.01).all(), (name, obj)
            assert (corners < np.array([x1, y1]) + 0.01).all(), (name, obj)
            assert obj.position_m[2] >= 0.0
        assert len(scene.objects) == sum(t.type not in PARTS for t in apartment(name))
        assert sum(polygon_area(room.polygon) for room in scene.rooms) == pytest.approx(34.15, 0.01)


@needs_metadata
def test_the_same_name_gives_the_same_scene_and_scenes_differ():
    one = robothor_scene("FloorPlan_Val1_1")
    assert robothor_scene("FloorPlan_Val1_1") == one
    meshes = [
        {obj.mesh for obj in robothor_scene(f"FloorPlan_Val1_{i}").objects if obj.category == kind}
        for i in range(1, 6)
        for kind in ("mug",)
    ]
    assert len(set().union(*meshes)) > 1


@needs_metadata
def test_what_stands_on_something_stands_on_it():
    lying = 0
    for name in APARTMENTS[::7]:
        things = [t for t in apartment(name) if t.type not in PARTS]
        objects = robothor_scene(name).objects
        heights = {t.id: obj for t, obj in zip(things, objects, strict=True)}
        for t, obj in zip(things, objects, strict=True):
            seats = [heights[i] for i in t.parents if i.split("|")[0] in SEATS]
            if seats and (place := resting_place(seats[0])):
                assert place.z1 - 0.001 <= obj.position_m[2] <= place.z1 + 0.4
                lying += 1
            elif t.type in ("Mug", "Bowl", "Laptop"):
                assert obj.position_m[2] == pytest.approx(max(t.low_m[2], 0), abs=0.002)
            carriers = [
                heights[i] for i in t.parents if i.startswith("DiningTable") and i in heights
            ]
            for table in carriers:
                assert table.size_m is not None
                assert obj.position_m[2] <= table.position_m[2] + table.size_m[2] + 0.15
    assert lying > 20


@needs_metadata
def test_furniture_against_a_wall_shows_its_front():
    """Of sofas and dressers, hardly one looks into a wall 30 cm before it."""
    wrong = total = 0
    x0, y0, x1, y1 = OUTER
    for name in APARTMENTS:
        for obj in robothor_scene(name).objects:
            if obj.category in ("sofa", "dresser", "television", "picture"):
                assert obj.size_m is not None
                reach = obj.size_m[1] / 2 + 0.3
                x = obj.position_m[0] + reach * math.sin(obj.yaw_rad)
                y = obj.position_m[1] - reach * math.cos(obj.yaw_rad)
                wrong += not (x0 < x < x1 and y0 < y < y1)
                total += 1
    assert total > 400
    assert wrong / total < 0.02


@needs_metadata
def test_single_rooms_are_read():
    assert [len(rooms(kind)) for kind in metadata.ROOM_LISTS] == [30] * 4
    assert any(t.type == "Toilet" for t in rooms("bathroom")[0])
    with pytest.raises(MetadataError, match="unknown kind 'garage'; one of kitchen"):
        rooms("garage")


def test_unknown_scenes_are_named():
    with pytest.raises(MetadataError, match="FloorPlan_Val4_1: unknown; RoboTHOR has FloorPlan_T"):
        robothor_scene("FloorPlan_Val4_1")


def test_a_wheel_that_is_damaged_or_another_is_refused(tmp_path):
    wheel, target = tmp_path / "p.whl", tmp_path / "metadata.json"
    wheel.write_bytes(b"PK no wheel")
    with pytest.raises(MetadataError, match=r"p.whl: holds no readable"):
        metadata.unpack(wheel, target)
    with zipfile.ZipFile(wheel, "w") as archive:
        archive.writestr(metadata.MEMBER, "{}")
    with pytest.raises(MetadataError, match=r"sha256 is .* must be"):
        metadata.unpack(wheel, target)
    assert not target.exists()


def test_goals_and_categories_are_ours():
    assert len(GOALS) == 12
    assert set(GOALS) <= set(CATEGORY)
    assert GOALS["HousePlant"] == "plant"


@given(
    width=st.floats(0.3, 2.0), depth=st.floats(0.3, 2.0), degrees=st.integers(0, 359),
    x=st.floats(2, 8), y=st.floats(-4, -2),
)  # fmt: skip
def test_an_inflated_box_is_brought_back(width, depth, degrees, x, y):
    """Unnamed and turned: the axis-aligned box alone gives the sides, but near 45 degrees."""
    yaw = math.pi - math.radians(degrees)
    assume(abs(math.cos(2 * yaw)) > 0.4)
    c, s = abs(math.cos(yaw)), abs(math.sin(yaw))
    half_x, half_y = (width * c + depth * s) / 2, (width * s + depth * c) / 2
    low, high = (x - half_x, y - half_y, 0.0), (x + half_x, y + half_y, 0.9)
    box = footprint(thing("Table", "", turn_deg=(0, degrees, 0), low_m=low, high_m=high))
    assert (box.x, box.y) == (pytest.approx(x), pytest.approx(y))
    if min(width, depth) > 0.35 * max(2 * half_x, 2 * half_y):
        near = 0.12 * max(width, depth)  # within 4 degrees of a right angle nothing is solved
        assert box.width == pytest.approx(width, abs=near)
        assert box.depth == pytest.approx(depth, abs=near)


def test_the_front_is_forward_unless_it_looks_into_a_wall():
    box = footprint(thing())  # forward is +y
    assert math.cos(faced(thing(), box, [], []).yaw_rad) == pytest.approx(-1)
    behind, before = (Wall((0, y), (9, y)) for y in (-3.5, -2.5))
    assert math.cos(faced(thing(), box, [behind], []).yaw_rad) == pytest.approx(-1)
    assert math.cos(faced(thing(), box, [before], []).yaw_rad) == pytest.approx(1)
    lamp = thing("FloorLamp")
    assert math.cos(faced(lamp, box, [before], []).yaw_rad) == pytest.approx(-1)


def test_reversed_assets_and_unnamed_chairs():
    bed = thing("Bed", "Bed_2")
    assert math.cos(faced(bed, footprint(bed), [], []).yaw_rad) == pytest.approx(1)
    chair = thing("Chair", "")
    table = Footprint(5.9, -3.0, 1.0, 1.0, 0.0, 0.0, 0.7)
    turned = faced(chair, footprint(chair), [], [table])
    assert math.sin(turned.yaw_rad) == pytest.approx(1)  # the front looks to +x, at the table
    assert (turned.width, turned.depth) == (pytest.approx(0.8), pytest.approx(2.0))


@pytest.mark.parametrize("layout", sorted(layouts()))
def test_regions_tile_the_apartment_and_stop_at_walls(layout):
    walls = layouts()[layout].walls
    found = regions(OUTER, walls)
    assert sum(polygon_area(p) for p in found) == pytest.approx(8.78 * 3.89, 1e-6)
    rng = np.random.default_rng(0)
    for x, y in rng.uniform(OUTER[:2], OUTER[2:], (200, 2)).tolist():
        assert sum(contains(p, x, y) for p in found) == 1
    for (ax, ay), (bx, by) in walls:
        if math.dist((ax, ay), (bx, by)) > 1.5:
            x, y = (ax + bx) / 2 + 0.007, (ay + by) / 2 + 0.007
            across = (0.0, 0.05) if ay == by else (0.05, 0.0)
            sides = [
                [contains(p, x + k * across[0], y + k * across[1]) for p in found] for k in (-1, 1)
            ]
            assert sides[0] != sides[1]


def test_room_types_follow_furniture():
    box = Footprint(0, 0, 1, 1, 0, 0, 1)
    assert room_type([]) == "hallway"
    assert room_type([("Bed", box), ("Desk", box)]) == "bedroom"
    assert room_type([("Sofa", box), ("Television", box)]) == "living room"
    assert room_type([("DiningTable", box)]) == "dining room"
    assert room_type([("Desk", box)]) in ROOM_TYPES
