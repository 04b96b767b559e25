"""What is done with a frame."""

from dataclasses import replace
from pathlib import Path

import pytest
from apartment import TWO_ROOMS, Apartment
from goal_bench import Bench

from runtime.core.local_policy import GIVE_UP_AFTER_S
from runtime.core.types import Pose
from runtime.loops.drive import _frozen


@pytest.mark.parametrize(
    ("x", "same", "frozen"), [(0.0, True, False), (0.2, True, True), (0.2, False, False)]
)
def test_what_a_camera_shows_again_from_elsewhere_is_no_news(x: float, same: bool, frozen: bool):
    first = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, 0.0)).observe()
    rgb = first.rgb if same else first.rgb + 1
    later = replace(first, rgb=rgb.copy(), depth_m=first.depth_m.copy(), pose=Pose(4.0 + x, 3.0, 0))
    assert _frozen(first, later) is frozen


def test_while_the_base_is_held_no_aim_is_given_up(tmp_path: Path):
    bench = Bench(tmp_path)
    bench.ask()
    bench.frames()
    assert bench.life.drive is not None
    world = bench.life.drive.search.world
    assert world is not None
    world.explored.looks_left = 0
    bench.frames(2)
    aim = world.pursuit.aim
    late_s = world.pursuit.progress[aim].idle = GIVE_UP_AFTER_S - 1.0
    for withheld, given_up in ((True, False), (False, True)):
        bench.withheld = withheld
        bench.frames(30)
        assert (world.pursuit.progress[aim].idle < late_s) is given_up
    bench.close()
