"""A home among others that are known."""

from apartment import MOUNT, TWO_ROOMS, Apartment

from hil_sim.benchmarks import drive, growth
from runtime import navigate
from runtime.core.types import Pose


def test_all_around_is_known_and_the_home_itself_is_not():
    config, home = drive.configuration(), Apartment.of(TWO_ROOMS, Pose(1.0, 3.2, 0.0))
    explored = drive.begin(config)
    for n in range(12):
        home.pose = Pose(1.0, 3.2, n * 0.5)
        obs = home.observe()
        navigate.perceive(explored, obs, home.detect((), obs), MOUNT, config.navigate)
    side = 600
    world = growth.surrounded(explored, side, config)
    known = side * side - int(world.map.unknown.sum() - (world.map.frame.rows**2 - side**2))
    assert 0.7 * side * side < known < side * side
    own = explored.map.known_window()
    assert world.map.unknown.sum() > 0.8 * (own[0].stop - own[0].start)
    before = growth.megabytes(world)
    assert before > growth.megabytes(drive.begin(config))
