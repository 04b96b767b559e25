"""What is done with a frame."""

from dataclasses import replace

import pytest
from apartment import TWO_ROOMS, Apartment

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
