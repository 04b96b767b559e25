"""One look is not enough, nor are two from one place."""

from runtime.core.geometry import placed
from runtime.core.mapping.settling import Settling
from runtime.core.types import Pose


def test_it_takes_a_second_look_from_elsewhere_that_tells_the_same():
    frame = Pose(3.0, -1.0, 2.0)  # of now, on the known map

    def at(here: Pose, aside: float = 0.0) -> tuple[Pose, Pose]:
        true = placed(frame, here)
        return here, Pose(true.x_m + aside, true.y_m, true.yaw_rad)

    settling = Settling()
    assert not settling.settles(*at(Pose(0, 0, 0)))
    assert not settling.settles(*at(Pose(0.5, 0, 1.0)))  # too near to the first
    assert not settling.settles(*at(Pose(2.0, 0, 1.0), aside=0.5))  # elsewhere: it begins anew
    assert not settling.settles(*at(Pose(3.5, 0, 1.0)))  # and does not go with the last
    assert settling.settles(*at(Pose(5.0, 0, 1.0), aside=0.2))


def test_a_look_that_is_turned_tells_something_else():
    settling = Settling()
    assert not settling.settles(Pose(0, 0, 0), Pose(1, 1, 0))
    assert not settling.settles(Pose(2, 0, 0), Pose(3, 1, 0.2))
    assert settling.settles(Pose(4, 0, 0), placed(Pose(3, 1, 0.2), Pose(2, 0, 0)))
