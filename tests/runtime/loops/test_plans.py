"""What a recorder is told of a plan."""

import numpy as np
import pytest

from runtime.core.distances.planner import Field
from runtime.core.distances.terrain import Terrain
from runtime.core.geometry import GridFrame
from runtime.core.motion.courses import Along, ControlConfig, Course, Spin, Toward
from runtime.core.motion.safety import Halt, HaltKind
from runtime.loops.plans import Plan, told_plan

FRAME = GridFrame(0.0, 0.0, 0.05, 2, 2)
CELLS = np.zeros((2, 2))
ALONG = Along(
    Terrain(FRAME, CELLS.astype(np.float32), CELLS > 0, CELLS.astype(np.float32)),
    Field(FRAME, CELLS),
)


@pytest.mark.parametrize(
    ("course", "name", "toward"),
    [
        (Spin(0.5), "spin", Spin(0.5)),
        (Toward((1.0, 2.0)), "toward", Toward((1.0, 2.0))),
        (ALONG, "along", None),
        (None, "none", None),
    ],
)
def test_a_plan_is_told_without_its_field(course: Course | None, name: str, toward: object):
    limits = ControlConfig(max_speed_mps=0.3)
    assert told_plan(7, Plan(course, 12.5, 0.18, limits, {"mode": "frontier"})) == {
        "number": 7,
        "course": name,
        "toward": toward,
        "frame_s": 12.5,
        "radius_m": 0.18,
        "limits": limits,
    }


def test_what_is_in_doubt_is_told_with_its_plan():
    doubt = Halt(HaltKind.FRAME, "the camera repeats itself")
    plan = Plan(None, 12.5, 0.18, ControlConfig(), doubt=doubt)
    assert told_plan(1, plan)["doubt"] == doubt
    assert plan.drives
    assert not Plan(None, 12.5, 0.18, ControlConfig()).drives
