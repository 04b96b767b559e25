"""What is remembered is the same elsewhere, and never surer than what is seen."""

import math

import numpy as np
import pytest
from lived_in import EMBEDDING, lived_in

from runtime.core.geometry import GridFrame, placed, seen_from
from runtime.core.keepsake import (
    VIEWS_KEPT,
    Keepsake,
    forget_looks,
    keepsake_of,
    meet_again,
    take_in,
    turned_onto,
)
from runtime.core.mapping.drops import DROP_AT
from runtime.core.mapping.grid import MISS, OCCUPIED_AT
from runtime.core.objects.semantic_map import SemanticMap
from runtime.core.types import Pose
from runtime.core.world import MOST_SIDE_M, World

ORIGIN = Pose(0.0, 0.0, 0.0)


def kept(world: World | None = None, on: Pose = ORIGIN) -> Keepsake:
    return keepsake_of(world or lived_in(), on, "eyes")


def begun(at: Pose = ORIGIN) -> World:
    return World.begin("sofa", ("sofa", "mug"), ("hall", "kitchen"), at, 0.18)


def test_it_holds_all_that_is_known_and_no_more():
    world = lived_in()
    known = kept(world)
    copy, grid = known.map, world.map
    for name in ("occupied", "free", "unknown"):
        mine, theirs = getattr(copy, name), getattr(grid, name)
        if name != "unknown":
            assert mine.sum() == theirs.sum()
        row, col = known.frame.cell(2.05, 0.0)
        assert mine[row, col] == theirs[grid.frame.cell(2.05, 0.0)]
    assert known.frame.rows < grid.frame.rows / 3


def test_nobody_changes_it_any_more():
    world = lived_in()
    known = kept(world)
    world.map.evidence[:] = 0
    world.semantic.instances[1].evidence["mug"].odds = -5.0
    world.semantic.instances[1].cells_xy[:] = 9.0
    assert known.layers["evidence"].any()
    (mug,) = known.instances
    assert mug.evidence["mug"].odds == 3.0
    assert mug.cells_xy.max() < 2.0


def test_what_views_said_is_of_one_search_alone():
    (mug,) = kept().instances
    assert mug.views == [ORIGIN]
    assert not mug.looks
    assert not mug.evidence["mug"].backing
    assert math.isinf(mug.evidence["mug"].near_m)
    assert mug.evidence["sofa"].rejections == 1


def test_of_many_views_the_latest_are_kept_and_what_came_after_a_rejection_is_known():
    world = lived_in()
    mug = world.semantic.instances[1]
    mug.views = [Pose(float(n), 0.0, 0.0) for n in range(VIEWS_KEPT + 5)]
    mug.evidence["mug"].since, mug.evidence["sofa"].since = 3, 20
    (kept_mug,) = kept(world).instances
    assert kept_mug.views == mug.views[5:]
    assert kept_mug.evidence["mug"].since == 0
    assert kept_mug.views_as("sofa") == mug.views_as("sofa")


@pytest.mark.parametrize("at", [ORIGIN, Pose(1.23, -0.4, 0.0), Pose(-2.0, 3.0, 2.1)])
def test_in_another_frame_it_lies_where_it_was(at: Pose):
    """`at`: where the old frame's origin is in the new one."""
    known = kept()
    world = begun(placed(at, Pose(-1.0, 0.3, 0.0)))
    new = take_in(world, turned_onto(known, at, world.map.frame))

    def cell(x: float, y: float) -> tuple[int, int]:
        there = placed(at, Pose(x, y, 0.0))
        return world.map.frame.cell(there.x_m, there.y_m)

    assert world.map.free[cell(1.0, 0.5)]
    assert world.map.occupied[cell(2.05, 0.5)]
    assert world.map.occupied[cell(0.0, -1.15)]  # the drop
    assert world.map.driven[cell(1.0, 0.025)]
    assert world.map.unknown[cell(1.0, 1.5)]
    assert world.semantic.room_around(world.map.frame, placed(at, ORIGIN).xy, 0.5) == "kitchen"
    (mug,) = new
    there = placed(at, Pose(*kept().instances[0].xy, 0.0))
    assert math.dist(mug.xy, (there.x_m, there.y_m)) < 1e-6
    assert mug.views == [placed(at, ORIGIN)]
    assert len(mug.cells_xy) >= 1
    cells = world.map.frame.cells(mug.cells_xy)
    assert np.allclose(world.map.frame.centres(cells), mug.cells_xy)
    assert world.keyframes[0].pose == placed(at, ORIGIN)


def test_the_way_back_to_the_saved_frame_goes_with_it():
    on = Pose(3.0, 1.0, 0.4)
    at = Pose(-1.0, 2.0, 1.9)
    turned = turned_onto(kept(on=on), at, GridFrame(0.0, 0.0, 0.05, 10, 10))
    point = Pose(0.7, 0.2, 0.1)
    before, now = placed(on, point), placed(turned.on, placed(at, point))
    assert (before.x_m, before.y_m) == pytest.approx((now.x_m, now.y_m))
    assert seen_from(now, before).yaw_rad == pytest.approx(0.0)


def test_what_is_seen_now_stays_as_it_is_seen():
    known, world = kept(), begun()
    row, col = world.map.frame.cell(2.05, 0.5)
    world.map.evidence[row, col] = -4  # the wall has gone
    world.map.changed()
    take_in(world, turned_onto(known, ORIGIN, world.map.frame))
    assert world.map.evidence[row, col] == -4
    assert world.map.free[row, col]


def test_one_look_overrules_what_is_remembered():
    known, world = kept(), begun()
    take_in(world, turned_onto(known, ORIGIN, world.map.frame))
    far = world.map.frame.cell(1.5, 0.5)
    assert world.map.evidence[far] == -MISS
    assert world.map.evidence[world.map.frame.cell(2.05, 0.5)] == OCCUPIED_AT
    assert world.map.drops.max() == DROP_AT


def test_a_thing_that_is_seen_is_not_met_twice():
    known, world = kept(), begun()
    world.semantic.instances.update(lived_in().semantic.instances)
    assert take_in(world, turned_onto(known, ORIGIN, world.map.frame)) == ()
    other = lived_in().semantic.instances[1]
    other.evidence = {"sofa": other.evidence["sofa"]}  # there, but it was never called a mug
    world = begun()
    world.semantic.instances[1] = other
    assert len(take_in(world, turned_onto(known, ORIGIN, world.map.frame))) == 1


def test_things_that_are_met_have_ids_of_their_own():
    semantic = SemanticMap.empty(("mug",), (), begun().map.frame)
    semantic.next_id = 7
    met = meet_again(semantic, kept().instances * 2)
    assert list(semantic.instances) == [7, 8] == [thing.id for thing in met]
    assert semantic.next_id == 9


def test_a_map_grows_to_hold_it_but_no_farther_than_maps_may():
    known, world = kept(), begun()
    cols = world.map.frame.cols
    take_in(world, turned_onto(known, Pose(20.0, 0.0, 0.0), world.map.frame))
    assert world.map.frame.cols > cols
    assert world.semantic.rooms.shape[1:] == world.map.frame.shape
    assert world.map.free[world.map.frame.cell(21.0, 0.5)]
    before = world.map.frame
    take_in(world, turned_onto(known, Pose(0.0, 2 * MOST_SIDE_M, 0.0), world.map.frame))
    assert world.map.frame == before


def test_a_lasers_obstacles_are_remembered_with_a_laser_and_without():
    world = lived_in()
    row, col = world.map.frame.cell(0.025, 0.925)
    world.map.laser.evidence = np.zeros(world.map.frame.shape, np.int8)
    world.map.laser.barred = np.zeros(world.map.frame.shape, bool)
    world.map.laser.evidence[row, col] = 20
    world.map.changed()
    known = kept(world)
    assert known.map.occupied[known.frame.cell(0.025, 0.925)]
    for laser in (False, True):
        world = begun(Pose(-1.5, 0.0, 0.0))
        if laser:
            world.map.laser.evidence = np.zeros(world.map.frame.shape, np.int8)
            world.map.laser.barred = np.zeros(world.map.frame.shape, bool)
        take_in(world, turned_onto(known, ORIGIN, world.map.frame))
        assert world.map.occupied[world.map.frame.cell(0.025, 0.925)]


def test_embeddings_of_other_eyes_are_forgotten_the_rest_is_not():
    known = kept()
    bare = forget_looks(known)
    assert known.instances[0].embedding_sum.tolist() == EMBEDDING.tolist()
    assert bare.instances[0].embedding.size == 0
    assert bare.keyframes == ()
    assert bare.instances[0].xy == known.instances[0].xy
