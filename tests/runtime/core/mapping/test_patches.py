"""Surfaces in patches: what may bear the goal, how likely it was missed there, and is there."""

import numpy as np
import pytest
from open_floor import axes, floor

from runtime.core.mapping.fineness import FLOOR, RAISED, GoalSize
from runtime.core.mapping.grid import NavigationMap
from runtime.core.mapping.patches import HIDDEN_M2, PRESENT, Closer, Patch, Surfaces
from runtime.core.mapping.zones import Zone
from runtime.core.types import F32

MUG = GoalSize(0.12, 0.0)
NEAR_PX_M = 330.0


def home(wanted: GoalSize = MUG) -> tuple[NavigationMap, Closer]:
    """Two tables on a floor: one was seen finely, at (2, 0), one from afar, at (-2, 0)."""
    grid, closer = floor(), Closer(wanted)
    x, y = axes(grid)
    for at in (2.0, -2.0):
        grid.evidence[(np.abs(x - at) < 0.4) & (np.abs(y) < 0.4)] = 10
    grid.changed()
    fine = closer.fineness
    frame = fine.fit(grid.frame)
    rows, cols = np.indices(frame.shape)
    xy = frame.centres(np.stack([rows, cols], axis=-1).reshape(-1, 2).astype(np.int32))
    tops = [(np.abs(xy - (at, 0.0)) < 0.4).all(axis=1).reshape(frame.shape) for at in (2.0, -2.0)]
    fine.fine[FLOOR][:] = 255
    fine.level[:] = tops[0] | tops[1]
    fine.fine[RAISED][tops[0]] = 220
    fine.fine[RAISED][tops[1]] = 60
    fine.sides[:] = 1
    fine.sides[RAISED][tops[0]] = 255
    return grid, closer


def surfaces(grid: NavigationMap, closer: Closer, weights: F32 | None = None) -> Surfaces:
    return Surfaces.of(grid, closer, NEAR_PX_M, weights)


def every(found: Surfaces) -> tuple[Patch, ...]:
    return found.patches(lambda likely, gain: likely >= 0.0)


def about(patches: tuple[Patch, ...], x_m: float) -> list[Patch]:
    return [p for p in patches if np.hypot(p.xy[0] - x_m, p.xy[1]) < 0.8]


def test_the_goal_is_likely_where_it_would_have_been_missed():
    found = surfaces(*home())
    near, far = about(every(found), 2.0), about(every(found), -2.0)
    assert sum(p.likely for p in far) > 3 * sum(p.likely for p in near)
    assert max(p.missed for p in near) < 0.4 < min(p.missed for p in far if p.area_m2 > 0.05)
    assert sum(p.gain for p in far) > 0.1
    assert sum(p.gain for p in near) < 0.01
    assert all(p.gain <= p.likely for p in every(found))


def test_all_chances_together_leave_what_is_hidden_or_nowhere():
    """Were nothing looked at, it would be on what is known or hidden, with PRESENT."""
    grid, closer = home()
    closer.fineness.fine[:] = 0
    found = surfaces(grid, closer)
    blind = sum(p.likely for p in every(found))
    known_m2 = float(found.borne_m2.sum())
    assert blind == pytest.approx(PRESENT * known_m2 / (known_m2 + HIDDEN_M2), rel=1e-3)
    closer.fineness.fine[:] = 255
    assert sum(p.likely for p in every(surfaces(grid, closer))) < blind - 0.05


def test_what_stands_on_floors_is_not_on_tables():
    grid, closer = home(GoalSize(0.12, 1.0))
    x, y = axes(grid)
    grid.evidence[(np.abs(x) < 0.2) & (np.abs(y - 2.0) < 0.2)] = 10  # something that is no table
    grid.changed()
    floors = surfaces(grid, closer).borne_m2[RAISED]
    tables = surfaces(*home()).borne_m2[RAISED]
    assert floors.max() > 5 * floors[closer.fineness.level[surfaces(grid, closer).window]].max()
    assert tables.max() > 0.8 * floors.max()


def test_a_patch_keeps_its_id_when_the_map_grows():
    grid, closer = home()
    before = {p.id: p.xy for p in every(surfaces(grid, closer))}
    grid.grow(np.array([-11.0, -11.0]), 6.0)
    after = {p.id: p.xy for p in every(surfaces(grid, closer))}
    assert before.keys() <= after.keys()
    for id, xy in before.items():
        assert after[id] == pytest.approx(xy, abs=1e-6)


def test_nothing_is_looked_for_in_a_zone():
    grid, closer = home()
    corners = ((-3.0, -1.0), (-1.0, -1.0), (-1.0, 1.0), (-3.0, 1.0))
    grid.zones.put((Zone("", corners),), grid.frame)
    assert not about(every(surfaces(grid, closer)), -2.0)
    assert about(every(surfaces(grid, closer)), 2.0)


def test_where_floor_drops_nothing_stands():
    grid, closer = home()
    x, y = axes(grid)
    before = surfaces(grid, closer).borne_m2.sum()
    grid.drops[(np.abs(x) < 0.5) & (np.abs(y - 2.0) < 0.5)] = 20
    grid.changed()
    assert surfaces(grid, closer).borne_m2.sum() <= before


def test_others_may_say_where_it_rather_is():
    grid, closer = home()
    frame = closer.fineness.fit(grid.frame)
    weights = np.ones((2, *frame.shape), np.float32)
    weights[:, :, : frame.cols // 2] = 0.0
    assert not about(every(surfaces(grid, closer, weights)), -2.0)


def test_the_layers_are_forgotten_for_another_goal_and_what_was_visited():
    _, closer = home()
    closer.done.add(7)
    fresh = closer.afresh()
    assert (fresh.done, fresh.visit) == (set(), None)
    assert not fresh.fineness.fine.any()
    assert fresh.fineness.level.any()
