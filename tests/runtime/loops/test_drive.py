"""What is done with a frame."""

from dataclasses import replace
from pathlib import Path

from goal_bench import Bench

from runtime.core.local_policy import GIVE_UP_AFTER_S
from runtime.core.motion.safety import HaltKind
from runtime.core.types import Pose
from runtime.loops.camera_watch import REPEATS_S
from runtime.robot.base import WELL, BaseCondition


def test_while_a_camera_repeats_itself_nothing_is_mapped_and_the_base_is_held(tmp_path: Path):
    bench = Bench(tmp_path)
    bench.ask()
    bench.frames()
    assert bench.life.drive is not None
    drive, last = bench.life.drive, bench.home.observe()
    world = drive.search.world
    assert world is not None
    seen, plans = world.stamp_ns, len(bench.plans)
    for x_m, base in ((4.3, WELL), (4.6, BaseCondition(hand="sticks"))):
        bench.base = base
        elsewhere = replace(last, pose=Pose(x_m, 3.0, 0.0), stamp_ns=last.stamp_ns + 1)
        for _ in range(2):  # an image may come twice
            drive.see(elsewhere, bench.clock.now_s())
            bench.clock.advance(REPEATS_S)
        assert world.stamp_ns == seen
    held, *led = bench.plans[plans:]
    assert held.doubt is not None
    assert held.doubt.kind is HaltKind.FRAME
    assert {(plan.course, plan.doubt) for plan in led} == {(None, None)}
    assert drive.camera.repeated == 4
    bench.base = WELL
    bench.stand(4.3, 3.0)
    bench.frames()
    assert bench.plans[-1].doubt is None
    assert world.stamp_ns > seen
    bench.close()


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
