"""Surfaces that were not seen finely enough are gone to and faced, and told of in the end."""

import math

import numpy as np
import pytest
from apartment import NO_DETECTIONS, looked_from
from open_floor import POSE, RADIUS_M, axes, floor

from runtime import navigate
from runtime.core.looking_closer import FAR_M, LEAST_M, doubts, look_closer, missed_patches
from runtime.core.mapping.fineness import FLOOR, RAISED, GoalSize
from runtime.core.objects.instances import Evidence, Instance
from runtime.core.resorts import Resort
from runtime.core.settings import SearchConfig
from runtime.core.types import Action, Intrinsics, Mount, Observation, Pose
from runtime.core.world import Command, Mode, Progress, World

CFG = navigate.NavigateConfig(search=SearchConfig(last_looks="closer"))
AFAR = navigate.NavigateConfig(search=SearchConfig(last_looks="afar"))
TABLE = (2.0, 0.0)
HALF_M = 0.8
MUG = GoalSize(0.12, 0.0)


def world(wanted: GoalSize = MUG, code: int = 60, sides: int = 1) -> World:
    """A table on a floor, which was seen as finely as `code` says, from the sides of those bits."""
    found = World.begin("mug", ("mug", "table"), (), POSE, RADIUS_M, 0)
    found.map = floor()
    x, y = axes(found.map)
    top = (np.abs(x - TABLE[0]) < HALF_M) & (np.abs(y - TABLE[1]) < HALF_M)
    found.map.evidence[top] = 10
    found.map.changed()
    closer = found.explored.closer
    closer.wanted = wanted
    closer.fineness.fit(found.map.frame)
    closer.fineness.fine[FLOOR][:] = 255
    closer.fineness.level[:] = _coarse(top)
    closer.fineness.fine[RAISED][_coarse(top)] = code
    closer.fineness.sides[:] = sides
    found.newest = looked_from(POSE)
    navigate.with_frontiers(found, CFG)
    return found


def _coarse(mask: np.ndarray) -> np.ndarray:
    rows, cols = mask.shape
    part: np.ndarray = mask.reshape(rows // 2, 2, cols // 2, 2).any(axis=(1, 3))
    return part


def driven(found: World, sees: bool = True, most: int = 200) -> list[Command]:
    """Step by step, until no look is worth it; with `sees` what is within 2 m ahead gets finer."""
    said: list[Command] = []
    while (command := look_closer(found, CFG)) is not None and len(said) < most:
        said.append(command)
        at, turn = found.pose, {Action.TURN_LEFT: 1, Action.TURN_RIGHT: -1}.get(command.action, 0)
        ahead_m = 0.25 if command.action is Action.MOVE_FORWARD else 0.0
        x, y = at.x_m + ahead_m * math.cos(at.yaw_rad), at.y_m + ahead_m * math.sin(at.yaw_rad)
        found.pose = Pose(x, y, math.remainder(at.yaw_rad + turn * math.pi / 6, math.tau))
        found.newest = looked_from(found.pose)
        if sees:
            _see(found)
        navigate.with_frontiers(found, CFG)
    return said


def _see(found: World) -> None:
    fine, at = found.explored.closer.fineness, found.pose
    assert fine.frame is not None
    rows, cols = np.indices(fine.frame.shape)
    xy = fine.frame.centres(np.stack([rows, cols], axis=-1).astype(np.int32))
    dx, dy = xy[..., 0] - at.x_m, xy[..., 1] - at.y_m
    ahead = dx * math.cos(at.yaw_rad) + dy * math.sin(at.yaw_rad)
    seen = (ahead > 0.3) & (np.hypot(dx, dy) < 1.6) & (ahead > 0.85 * np.hypot(dx, dy))
    fine.fine[RAISED][seen & (fine.fine[RAISED] > 0)] = 200


def test_a_table_seen_from_afar_is_gone_to_and_looked_at():
    found = world()
    said = driven(found)
    assert said[0].mode is Mode.CLOSER
    assert said[0].reason.startswith("go and look closer at the surface at (2.")
    assert len(said[0].path_xy) > 5
    bearing_rad = math.atan2(TABLE[1] - found.pose.y_m, TABLE[0] - found.pose.x_m)
    assert abs(math.remainder(bearing_rad - found.pose.yaw_rad, math.tau)) < 0.7
    gap_m = max(np.abs(found.pose.xy - TABLE)) - HALF_M
    assert LEAST_M - 0.3 < gap_m < FAR_M[0] + 0.3
    assert len(said) < 150
    assert look_closer(found, CFG) is None


def test_what_was_seen_finely_enough_is_left():
    assert look_closer(world(code=220, sides=255), CFG) is None
    assert look_closer(world(GoalSize(1.5, 0.0), code=150, sides=255), CFG) is None


def test_what_was_seen_finely_is_looked_at_from_another_side():
    """It was looked at from the west, where the robot is: bits 1 and 3."""
    found = world(code=150, sides=(1 << 1) | (1 << 3))
    assert driven(found, sees=False)
    assert abs(found.pose.y_m) > HALF_M


def test_a_look_that_brings_nothing_is_not_repeated():
    found = world()
    said = driven(found, sees=False)
    assert said
    assert len(said) < 120
    assert found.explored.closer.done
    assert doubts(found)[0].likely == pytest.approx(doubts(world())[0].likely)


def test_a_robot_that_is_held_up_near_by_looks_from_where_it_is():
    found = world()
    found.pose = Pose(0.3, -0.3, math.pi)
    navigate.with_frontiers(found, CFG)
    first = look_closer(found, CFG)
    assert first is not None
    assert first.reason.startswith("go and look closer")
    found.pursuit.progress[found.pursuit.aim] = Progress(best_m=0.01, run_m=0.01, idle=10.0)
    held_up = look_closer(found, CFG)
    assert held_up is not None
    assert held_up.reason.startswith("look closer at ")
    assert held_up.action in (Action.TURN_LEFT, Action.TURN_RIGHT)


def test_it_is_the_first_that_is_tried_when_no_frontier_is_left():
    found = world()
    found.explored.given_up[:] = True
    navigate.with_frontiers(found, CFG)
    assert navigate._finish(found, CFG).reason == Resort.CLOSER.reason
    assert navigate._finish(found, CFG).mode is Mode.CLOSER
    found.explored.closer.fineness.sides[:] = 255
    found.explored.closer.fineness.fine[:] = 255
    assert navigate._finish(found, CFG).reason == Resort.RETRY.reason


def test_only_one_of_the_two_last_looks_is_made():
    found = world()
    edges = {f.cells_xy.tobytes() for f in found.frontiers}
    found.explored.looked[:] = ~found.map.free  # all of the floor was seen only from afar
    found.explored.resort = Resort.FAINT
    by_cfg = [navigate.with_frontiers(found, cfg).frontiers for cfg in (CFG, AFAR)]
    closer, afar = ({f.cells_xy.tobytes() for f in found} for found in by_cfg)
    assert closer == edges < afar
    assert navigate._finish(found, CFG).mode is Mode.CLOSER
    assert navigate._finish(found, AFAR).mode is not Mode.CLOSER


def before_the_table() -> Observation:
    depth = np.full((480, 640), 0.9, np.float32)
    return Observation(
        1, np.zeros((480, 640, 3), np.uint8), depth, Pose(0.6, 0.0, 0.0),
        Intrinsics(400.0, 400.0, 320.0, 240.0, 640, 480),
    )  # fmt: skip


def test_who_looks_again_at_what_was_seen_from_afar_keeps_nothing_of_it():
    found = World.begin("mug", ("mug", "table"), (), POSE, RADIUS_M, 0)
    navigate.perceive(found, before_the_table(), NO_DETECTIONS, Mount(), AFAR)
    assert found.explored.closer.fineness.frame is None
    assert doubts(found) == missed_patches(found) == ()
    assert navigate.outlook(found, "test", AFAR).patches == ()
    assert "likely" not in navigate._nothing_left(found).reason


def test_surfaces_that_were_not_seen_finely_are_places_of_the_belief():
    found = world()
    seen = navigate.outlook(found, "test", CFG)
    assert seen.patches
    assert {patch.id for patch in seen.patches} == {p.id for p in missed_patches(found)}


def test_what_the_detector_looked_at_is_booked():
    found = world()
    before = found.explored.closer.fineness.fine.copy()
    navigate.perceive(found, before_the_table(), NO_DETECTIONS, Mount(), CFG)
    fine = found.explored.closer.fineness
    assert (fine.fine >= before).all()
    assert fine.frame is not None
    row, col = fine.frame.cell(1.52, 0.0)
    assert fine.fine[RAISED][row, col] > before[RAISED][row, col]


def test_what_no_way_leads_to_is_only_told_of():
    found = world()
    x, y = axes(found.map)
    ring = np.hypot(x - TABLE[0], y - TABLE[1])
    found.map.evidence[(ring > 1.7) & (ring < 2.0)] = 20  # a fence, with the table behind it
    found.map.stood[(ring > 1.7) & (ring < 2.0)] = 255
    found.map.changed()
    found.explored.closer.fineness.fine[RAISED][
        found.explored.closer.fineness.fine[RAISED] == 0
    ] = 255
    navigate.with_frontiers(found, CFG)
    assert look_closer(found, CFG) is None
    assert doubts(found)


def test_not_found_says_where_it_may_still_be():
    found = world()
    cells = np.stack(np.meshgrid(np.arange(1.2, 2.8, 0.05), np.arange(-0.8, 0.8, 0.05)), axis=-1)
    table = Instance(
        4, {"table": Evidence(4.0)}, TABLE, 0.7, cells.reshape(-1, 2) + 0.025, views=[POSE]
    )
    found.semantic.instances[4] = table
    (doubt,) = doubts(found)[:1]
    assert doubt.on == "table"
    assert 0.5 < doubt.likely < 0.6
    assert math.dist(doubt.xy, TABLE) < HALF_M
    assert 4.0 < doubt.seen_m < 8.0
    told = navigate._nothing_left(found).reason
    assert "most likely still on the table at (" in told
    assert f"seen from no nearer than {doubt.seen_m:.1f} m" in told
    found.explored.closer.fineness.fine[RAISED][:] = 0
    assert "never looked at" in str(doubts(found)[0])
