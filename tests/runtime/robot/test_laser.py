"""Which scan goes with an image, and where its beams lie."""

import math

import numpy as np
import pytest
from other_half import laser_scan

from runtime.core.types import Pose
from runtime.errors import SensorError
from runtime.robot import wire, wire_senses
from runtime.robot.laser import LaserMount, Scans, as_configured, as_placed, in_map
from runtime.robot.session import SensesConfig
from runtime.robot.sync import RawMessage, Rings
from runtime.robot.wire import Stamped

S = 1_000_000_000
HERE = Pose(2.0, 1.0, math.pi / 2)


def scanned(mount: LaserMount, turn: float = 0.0, step_s: float = 0.0, n: int = 4):
    """Beams a quarter of a turn apart, of 1, 2, 3, ... m."""
    payload = laser_scan(list(range(1, n + 1)), 5 * S, 0.0, math.pi / 2, step_s=step_s)
    told = wire_senses.decode_scan(payload, "scan")
    before = Stamped(5 * S, HERE)
    after = Stamped(5 * S + S // 10, Pose(2.0, 1.0, HERE.yaw_rad + turn / 10))
    return in_map(told, mount, before, after)


def points(scan) -> np.ndarray:
    aim = np.stack([np.cos(scan.headings_rad), np.sin(scan.headings_rad)], axis=1)
    return (np.array(scan.at_xy) + scan.ranges_m[:, None] * aim).round(4) + 0.0


def test_beams_lie_where_base_and_laser_are():
    scan = scanned(LaserMount(0.1, 0.0, 0.0))
    assert scan.at_xy == pytest.approx((2.0, 1.1))
    assert points(scan).tolist() == [[2.0, 2.1], [0.0, 1.1], [2.0, -1.9], [6.0, 1.1]]


def test_a_laser_may_look_back_and_hang_upside_down():
    behind = points(scanned(LaserMount(0.0, 0.0, math.pi)))
    assert behind.tolist() == [[2.0, 0.0], [4.0, 1.0], [2.0, 4.0], [-2.0, 1.0]]
    hanging = points(scanned(LaserMount(0.0, 0.0, 0.0, hangs=True)))
    assert hanging.tolist() == [[2.0, 2.0], [4.0, 1.0], [2.0, -2.0], [-2.0, 1.0]]


def test_a_beam_is_as_far_turned_as_the_base_was_by_then():
    still, turning = (
        scanned(LaserMount(0.0, 0.0, 0.0), turn, step_s=0.01).headings_rad for turn in (0.0, 1.0)
    )
    assert (turning - still).tolist() == pytest.approx([0.0, 0.01, 0.02, 0.03], abs=1e-6)


def test_where_a_laser_is_by_tf():
    hanging = np.diag([1.0, -1.0, -1.0, 1.0])
    hanging[:3, 3] = 0.2, 0.1, 0.3
    assert as_placed(hanging, "laser") == LaserMount(0.2, 0.1, 0.0, True)
    assert as_placed(np.eye(4), "laser") == as_configured(SensesConfig())
    leaning = np.eye(4)
    c, s = math.cos(0.4), math.sin(0.4)
    leaning[:3, :3] = [[c, 0, s], [0, 1, 0], [-s, 0, c]]
    with pytest.raises(SensorError, match="tf: laser leans by 23 degrees"):
        as_placed(leaning, "laser")


def rings(*stamps_s: float) -> Rings:
    found = Rings(20_000_000, 250_000_000, lockstep=False)
    for at_s in stamps_s:
        stamp = round(at_s * S)
        found.file("odom", RawMessage(stamp, wire.encode_odometry(HERE, stamp), at_s))
    return found


def raw(at_s: float) -> RawMessage:
    return RawMessage(round(at_s * S), b"", at_s)


def test_the_newest_scan_of_about_an_images_time_goes_with_it_and_only_once():
    scans, odometry = Scans(), rings(*(9.5 + 0.05 * n for n in range(12)))
    for at_s in (9.8, 9.9, 10.02, 10.2):  # of the last there is no odometry yet
        scans.file(raw(at_s))
    found = scans.take(10 * S, odometry)
    assert found is not None
    assert found.scan.stamp_ns == round(10.02 * S)
    assert found.before.stamp_ns <= found.scan.stamp_ns <= found.after.stamp_ns
    assert scans.take(10 * S, odometry) is None


def test_an_old_scan_goes_with_no_image():
    scans = Scans()
    scans.file(raw(9.5))
    assert scans.take(10 * S, rings(9.4, 9.6, 9.9, 10.1)) is None


def test_a_scan_by_another_clock_is_told():
    scans = Scans()
    scans.file(raw(4000.0))
    with pytest.raises(SensorError, match=r"scan: stamped \+3990.0 s from the image"):
        scans.take(10 * S, rings(9.9, 10.1))


def test_after_its_clock_was_set_back_the_scans_of_before_are_forgotten():
    scans = Scans()
    for at_s in (50.0, 10.0):
        scans.file(raw(at_s))
    assert scans.take(10 * S, rings(9.9, 10.1)) is not None
