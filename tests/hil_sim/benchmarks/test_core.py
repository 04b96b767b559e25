"""The rows of the table, of a drive that is timed."""

import numpy as np
import pytest
from apartment import INTRINSICS

from hil_sim.benchmarks import core, drive
from hil_sim.benchmarks.stopwatch import StageTimes
from hil_sim.simulation.protocol import HM3D
from runtime.core.distances.kept_plan import KeptPlan
from runtime.core.distances.terrain import Terrain
from runtime.core.geometry import GridFrame
from runtime.core.types import Pose


@pytest.fixture
def recorded() -> drive.RecordedDrive:
    """A robot that turns before a wall, in an image of 640 x 480."""
    assert INTRINSICS.width < HM3D.width
    count, jpeg = 4, drive.as_jpeg(np.zeros((HM3D.height, HM3D.width, 3), np.uint8))
    depth = np.full((count, HM3D.height, HM3D.width), 2000, np.uint16)
    poses = np.array([(0.0, 0.0, 0.5 * n) for n in range(count)])
    nothing = {"boxes": [[50, 50, 300, 400]], "names": ["sofa"], "scores": [1.0], "room": None}
    return drive.RecordedDrive(depth, (jpeg,) * count, poses, (nothing,) * count)


def test_every_row_of_the_table_is_measured(recorded: drive.RecordedDrive):
    config = drive.configuration()
    world = drive.begin(config)
    rows = core.rows(core.timed(recorded, world, config, 4))
    assert [row.stage for row in rows] == list(core.GOALS)
    planned = {core.VALID, core.TOUCHED}  # nowhere to go to yet
    assert all(0 < row.median_ms <= row.p99_ms for row in rows if row.stage not in planned)
    assert world.body.step == 4


def test_a_plan_across_a_floor_is_a_plan():
    times = core.across(side=60, times=2)
    assert len(times.seconds["across"]) == 2


def test_a_plan_that_was_kept_is_told_from_others():
    clear = np.ones((60, 60), np.float32)
    floor = Terrain(GridFrame(0.0, 0.0, 0.05, 60, 60), clear, clear > 0, clear)
    plan, times = KeptPlan(), StageTimes()
    with core.watching_plans(times):
        for goal in ([[2, 2]], [[2, 2]], [[2, 50]]):
            plan.toward(floor, np.array(goal, np.int32), Pose(2.0, 2.0, 0.0))
            times.next_frame()
    assert len(times.seconds[core.VALID]) == 1
    assert len(times.seconds[core.TOUCHED]) == 2


def test_the_machine_is_named_with_what_counts():
    assert "scikit-fmm" in core.machine()
