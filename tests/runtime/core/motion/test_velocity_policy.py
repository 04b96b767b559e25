"""Velocities that follow a field: within limits, to the goal, and never into anything."""

import math
from dataclasses import replace

import numpy as np
import pytest
from apartment import MOUNT, NO_DETECTIONS, TWO_ROOMS, Apartment
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime import navigate
from runtime.core.distances.planner import Field, march
from runtime.core.distances.terrain import Terrain
from runtime.core.geometry import GridFrame
from runtime.core.motion import velocity_policy
from runtime.core.motion.courses import STILL, Along, ControlConfig, Spin, Toward
from runtime.core.motion.footing import Footing
from runtime.core.types import Action, Pose, Twist
from runtime.core.world import World

CFG = ControlConfig(mode="velocity")
RADIUS = 0.18
CELL = 0.05


def ground(plan: str) -> Terrain:
    """`#` wall, `?` unknown, else free; one character a cell of 5 cm, first line the largest y."""
    import cv2

    lines = plan.strip("\n").split("\n")
    signs = np.array([list(line) for line in reversed(lines)])
    occupied = signs == "#"
    free = ~occupied & (signs != "?")
    away = cv2.distanceTransform((~occupied).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5)
    clearance = (away * CELL - CELL / 2).astype(np.float32)
    traversable = free & (clearance >= RADIUS + 0.02)
    speed = np.where(traversable, 1.0, 0.0).astype(np.float32)
    frame = GridFrame(0.0, 0.0, CELL, *signs.shape)
    return Terrain(frame, clearance, traversable, speed)


def corridor(bend_at: int, width: int, length: int = 60) -> Terrain:
    """A corridor along x that turns up at a right angle, closed on all sides."""
    cells = np.full((length, length), "#")
    cells[1 : 1 + width, 1 : bend_at + width] = "."
    cells[1:-1, bend_at : bend_at + width] = "."
    return ground("\n".join("".join(row) for row in cells[::-1]))


def field_to(terrain: Terrain, x: float, y: float) -> Field:
    sources = np.zeros(terrain.frame.shape, bool)
    sources[terrain.frame.cell(x, y)] = True
    return march(terrain, sources)


def moved(pose: Pose, twist: Twist, dt_s: float) -> Pose:
    """Exact differential drive."""
    turn = twist.w_radps * dt_s
    chord = twist.v_mps * dt_s * (1.0 if abs(turn) < 1e-9 else math.sin(turn / 2) / (turn / 2))
    heading = pose.yaw_rad + turn / 2
    x, y = pose.x_m + chord * math.cos(heading), pose.y_m + chord * math.sin(heading)
    return Pose(x, y, math.remainder(pose.yaw_rad + turn, math.tau))


def touches(terrain: Terrain, pose: Pose) -> bool:
    row, col = terrain.frame.cell(pose.x_m, pose.y_m)
    # half a cell's diagonal is what a centre's distance may be off by
    return float(terrain.clearance_m[row, col]) < RADIUS - 0.03


@settings(max_examples=20, deadline=None)
@given(
    yaw=st.floats(-math.pi, math.pi),
    width=st.integers(11, 24),
    bend=st.integers(20, 30),
    dt=st.sampled_from([0.05, 0.1, 0.2]),
)
def test_a_bent_corridor_is_driven_to_its_end_without_touching(
    yaw: float, width: int, bend: int, dt: float
):
    terrain = corridor(bend, width)
    middle = (1 + width / 2) * CELL
    goal = ((bend + width / 2) * CELL, 57 * CELL - width * CELL / 2)
    field = field_to(terrain, *goal)
    pose, twist, path = Pose(middle, middle, yaw), STILL, []
    for _ in range(round(60 / dt)):
        before = twist
        twist = velocity_policy.velocity(Along(terrain, field), pose, RADIUS, CFG, before, dt)
        assert 0.0 <= twist.v_mps <= CFG.max_speed_mps
        assert abs(twist.w_radps) <= CFG.max_turn_radps
        assert twist.v_mps - before.v_mps <= CFG.max_accel_mps2 * dt + 1e-9
        assert abs(twist.w_radps - before.w_radps) <= CFG.max_turn_accel_radps2 * dt + 1e-9
        pose = moved(pose, twist, dt)
        assert not touches(terrain, pose)
        path.append((pose.x_m, pose.y_m))
        if field.at(pose.x_m, pose.y_m) <= 0 and twist == STILL:
            break
    assert math.dist(path[-1], goal) < 0.15
    assert twist == STILL


@settings(max_examples=60, deadline=None)
@given(
    x=st.floats(0.35, 1.2),
    y=st.floats(0.3, 1.2),
    yaw=st.floats(-math.pi, math.pi),
    v=st.floats(0, 0.4),
    w=st.floats(-1, 1),
    ahead=st.sampled_from("#?"),
)
def test_whatever_was_driven_before_the_robot_can_halt_on_known_ground(x, y, yaw, v, w, ahead):
    rows = [list("#" * 40)] + [list("#" + "." * 28 + ahead * 10 + "#") for _ in range(30)]
    terrain = ground("\n".join("".join(row) for row in [*rows, rows[0]]))
    field = field_to(terrain, 0.8, 0.8)
    pose = Pose(x, y, yaw)
    twist = velocity_policy.velocity(Along(terrain, field), pose, RADIUS, CFG, Twist(v, w), 0.2)
    if twist.v_mps == 0:
        return
    start = terrain.frame.cell(pose.x_m, pose.y_m)
    least = min(RADIUS, float(terrain.clearance_m[start])) - 0.03
    speed, curve = twist.v_mps, twist.w_radps / twist.v_mps
    for n in range(200):  # held for as long as a command may act, then braked along the curve
        speed = twist.v_mps if n * 0.02 < velocity_policy.HOLD_S else speed - CFG.brake_mps2 * 0.02
        if speed <= 0:
            break
        pose = moved(pose, Twist(speed, speed * curve), 0.02)
        row, col = terrain.frame.cell(pose.x_m, pose.y_m)
        assert float(terrain.clearance_m[row, col]) >= least


def test_unknown_ground_ahead_is_not_driven_onto():
    terrain = ground("\n".join(["#" * 40] + ["#" + "." * 20 + "?" * 18 + "#"] * 20 + ["#" * 40]))
    field = Field(terrain.frame, np.where(terrain.traversable, 1.0, np.inf))
    field.arrival_m[:, :] = np.arange(40, 0, -1)  # a field that leads into the unknown
    pose, twist = Pose(0.5, 0.5, 0.0), STILL
    for _ in range(200):
        twist = velocity_policy.velocity(Along(terrain, field), pose, RADIUS, CFG, twist, 0.1)
        pose = moved(pose, twist, 0.1)
        assert pose.x_m < 21 * CELL
    assert pose.x_m > 0.7


def as_planned(terrain: Terrain, pose: Pose) -> Terrain:
    """What the planner makes of it: right around the robot every free cell is passable."""
    rows, cols = np.indices(terrain.frame.shape)
    xy = terrain.frame.centres(np.stack([rows, cols], axis=-1).astype(np.int32))
    near = np.hypot(*(xy - pose.xy).transpose(2, 0, 1)) < 0.35
    passable = terrain.traversable | (near & (terrain.clearance_m > 0))
    speed = np.where(passable, np.maximum(terrain.speed, 0.25), 0).astype(np.float32)
    return Terrain(terrain.frame, terrain.clearance_m, passable, speed)


@pytest.mark.parametrize("gap", [0.10, 0.16, 0.22, 0.28])
@pytest.mark.parametrize("half", [0, 2, 5])
def test_a_robot_right_before_something_gets_around_it(gap: float, half: int):
    cells = np.full((60, 60), ".")
    cells[[0, -1], :] = cells[:, [0, -1]] = "#"
    cells[30 - half : 31 + half, 30] = "#"
    bare = ground("\n".join("".join(row) for row in cells[::-1]))
    pose, twist = Pose(1.5 - gap, 1.52, 0.0), STILL
    obstacles = bare.frame.centres(np.argwhere(bare.clearance_m < 0).astype(np.int32))
    least = min(gap, RADIUS) - 0.03
    for n in range(400):
        if n % 4 == 0:  # a frame, and a plan made of it
            terrain = as_planned(bare, pose)
            field = field_to(terrain, 2.5, 1.52)
        twist = velocity_policy.velocity(Along(terrain, field), pose, RADIUS, CFG, twist, 0.05)
        pose = moved(pose, twist, 0.05)
        assert np.hypot(*(obstacles - pose.xy).T).min() >= least
        if field.at(pose.x_m, pose.y_m) <= 0:
            return
    raise AssertionError(f"still at {pose}")


def clutter(rng: np.random.Generator) -> Terrain:
    """A room of 2.5 m with things strewn about."""
    cells = np.full((50, 50), ".")
    cells[[0, -1], :] = cells[:, [0, -1]] = "#"
    for _ in range(14):
        row, col = rng.integers(3, 47, 2)
        cells[row : row + rng.integers(1, 4), col : col + rng.integers(1, 4)] = "#"
    return ground("\n".join("".join(row) for row in cells[::-1]))


def somewhere(bare: Terrain, rng: np.random.Generator, least: float, most: float) -> np.ndarray:
    while True:
        xy = rng.uniform(0.3, 2.2, 2)
        if least < bare.clearance_m[bare.frame.cell(*xy)] < most:
            return xy


@pytest.mark.parametrize("seed", range(20))
def test_from_any_tight_spot_the_robot_reaches_its_goal_and_comes_no_closer(seed: int):
    rng = np.random.default_rng(seed)
    bare = clutter(rng)
    pose, twist = Pose(*somewhere(bare, rng, 0.08, 0.3), rng.uniform(-3, 3)), STILL
    goal = somewhere(bare, rng, 0.25, 9.0)
    obstacles = bare.frame.centres(np.argwhere(bare.clearance_m < 0).astype(np.int32))
    least = min(float(np.hypot(*(obstacles - pose.xy).T).min()), RADIUS + 0.025) - 0.035
    for n in range(1200):
        if n % 4 == 0:
            terrain = as_planned(bare, pose)
            field = field_to(terrain, *goal)
        if n == 0 and not math.isfinite(field.at(pose.x_m, pose.y_m)):
            return  # walled in
        twist = velocity_policy.velocity(Along(terrain, field), pose, RADIUS, CFG, twist, 0.05)
        pose = moved(pose, twist, 0.05)
        assert np.hypot(*(obstacles - pose.xy).T).min() >= least
        if field.at(pose.x_m, pose.y_m) <= 0:
            return
    raise AssertionError(f"still at {pose}")


def test_a_heading_far_off_is_turned_on_the_spot():
    terrain = corridor(25, 12)
    field = field_to(terrain, 1.3, 0.35)
    twist = velocity_policy.velocity(
        Along(terrain, field), Pose(0.35, 0.35, 3.0), RADIUS, CFG, STILL, 0.2
    )
    assert twist.v_mps == 0
    assert twist.w_radps < 0  # the shorter way round


def test_no_way_at_all_turns_to_see_more():
    terrain = corridor(25, 12)
    nowhere = Field(terrain.frame, np.full(terrain.frame.shape, np.inf))
    course = Along(terrain, nowhere)
    twist = velocity_policy.velocity(course, Pose(0.35, 0.35, 0.0), RADIUS, CFG, STILL, 0.2)
    assert twist.v_mps == 0
    assert twist.w_radps > 0


@given(yaw=st.floats(-math.pi, math.pi), v=st.floats(0, 0.4), w=st.floats(-1, 1))
def test_facing_ends_facing_and_brakes_before_it_turns(yaw: float, v: float, w: float):
    pose, twist = Pose(0.0, 0.0, yaw), Twist(v, w)
    goal = (1.0, 5.0)
    for _ in range(200):
        before = twist
        twist = velocity_policy.steer(Toward(goal), pose, before, 0.1, RADIUS, CFG)
        assert twist.v_mps <= before.v_mps
        if before.v_mps > velocity_policy.CREEP_MPS and twist.v_mps > 0:  # along the same curve
            assert twist.w_radps / twist.v_mps == pytest.approx(before.w_radps / before.v_mps)
        pose = moved(pose, twist, 0.1)
    error = math.atan2(goal[1] - pose.y_m, goal[0] - pose.x_m) - pose.yaw_rad
    assert abs(math.remainder(error, math.tau)) <= velocity_policy.FACING_RAD
    assert twist == STILL


def test_without_a_course_the_robot_halts():
    assert (
        velocity_policy.steer(None, Pose(0, 0, 0), Twist(0.05, 0.2), 0.2, RADIUS, CFG).v_mps == 0.0
    )
    twist = velocity_policy.steer(Spin(0.6), Pose(0, 0, 0), STILL, 0.1, RADIUS, CFG)
    assert twist == Twist(0.0, pytest.approx(CFG.max_turn_accel_radps2 * 0.1))


NAV = navigate.NavigateConfig(control=CFG)
HOLD_S = 0.2


def drive(home: Apartment, goal: str, limit: int, closest) -> tuple[World, list]:
    """The whole loop in velocity mode: a twist is held for 0.2 s between observations."""
    world, commands = None, []
    for _ in range(limit):
        obs = home.observe()
        if world is None:
            world = World.begin(goal, ("toilet",), (), obs.pose, RADIUS)
        seen = home.detect(("toilet",), obs) if home.things else NO_DETECTIONS
        navigate.perceive(world, obs, seen, MOUNT, NAV)
        why = navigate.due(world, NAV)
        if why:
            snap = navigate.snapshot(world, why, NAV)
            navigate.adopt(world, navigate.decide(snap, closest, None, NAV))
        commands.append(navigate.steer(world, navigate.act(world, NAV), NAV))
        if commands[-1].action is Action.STOP:
            break
        for _ in range(10):
            ahead = moved(home.pose, commands[-1].twist, HOLD_S / 10)
            if home.fits(ahead.x_m, ahead.y_m):
                home.pose = ahead
            else:
                home.collisions += 1
                home.pose = Pose(home.pose.x_m, home.pose.y_m, ahead.yaw_rad)
        home.stamp_ns += 100_000_000
    assert world is not None
    return world, commands


class Silent:
    def ask(self, brief, by):
        from runtime.core.types import Ballot

        return Ballot()


@pytest.mark.slow
def test_the_whole_loop_drives_to_the_target_faces_it_and_stops():
    there = Apartment.of(TWO_ROOMS, Pose(1.0, 3.2, 0.5))
    there.things = {"toilet": (7.4, 2.2, 0.3)}
    world, commands = drive(there, "toilet", 600, Silent())
    assert commands[-1].mode == "stop"
    assert commands[-1].reason.startswith("found")
    assert commands[-1].twist == STILL
    assert math.hypot(there.pose.x_m - 7.4, there.pose.y_m - 2.2) < 1.3
    ((x_m, y_m),) = [thing.xy for thing in world.semantic.called("toilet")]
    bearing = math.atan2(y_m - there.pose.y_m, x_m - there.pose.x_m)
    assert abs(math.remainder(bearing - there.pose.yaw_rad, math.tau)) < 0.3
    assert world.body.collisions <= 1  # a graze where the body had passed before
    looks = [c for c in commands if c.mode == "look"]
    assert 2 * math.pi / 0.6 / HOLD_S * 0.9 < len(looks) < 2 * math.pi / 0.6 / HOLD_S * 1.3
    assert all(isinstance(c.course, Along | Toward | Spin) for c in commands[:-1])


@pytest.mark.slow
def test_a_robot_that_sees_no_depth_may_turn_but_not_drive():
    there = Apartment.of(TWO_ROOMS, Pose(1.0, 3.2, 0.5))
    observe, count = there.observe, [0]

    def blinded():
        obs = observe()
        count[0] += 1
        return replace(obs, depth_m=obs.depth_m * 0) if 70 <= count[0] < 85 else obs

    there.observe = blinded  # type: ignore[method-assign]
    _, commands = drive(there, "toilet", 100, Silent())
    speeds = [c.twist.v_mps for c in commands]
    assert max(speeds[60:69]) > 0.1
    assert not any(speeds[69:84])
    assert max(speeds[84:]) > 0.1


@pytest.mark.slow
def test_an_invisible_obstacle_is_felt_and_driven_around():
    there = Apartment.of(TWO_ROOMS, Pose(2.0, 3.0, 0.0))
    row, col = int(3.0 / 0.02), int(2.5 / 0.02)
    there.heights[row - 12 : row + 12, col : col + 4] = 0.05  # too low for the camera's floor test
    world, _ = drive(there, "toilet", 250, Silent())
    assert math.hypot(there.pose.x_m - 2.0, there.pose.y_m - 3.0) > 1.0
    assert world.body.collisions <= there.collisions


@given(st.floats(0.0, 5.0), st.floats(0.0, 0.5), st.floats(0.1, 2.0))
def test_the_speed_that_sight_allows_falls_with_its_age_without_a_step(age, more, full):
    cfg = replace(CFG, max_speed_mps=full)
    now, later = (velocity_policy.sighted_mps(a, cfg) for a in (age, age + more))
    assert 0 < later <= now <= full
    assert now - later <= cfg.brake_mps2 * more + 1e-9  # as it can surely brake


def test_in_a_room_a_robot_that_saw_long_ago_keeps_farther_from_the_wall():
    terrain = corridor(bend_at=40, width=12)
    field = field_to(terrain, 2.4, 2.5)
    pose = Pose(1.55, 0.35, 0.0)  # 1.1 m before the wall
    fast = Twist(0.4, 0.0)
    speeds = [
        velocity_policy.velocity(Along(terrain, field), pose, RADIUS, CFG, fast, 1.0, age_s).v_mps
        for age_s in (0.0, 0.4, 1.0, 1.5, 1.9)
    ]
    assert speeds[0] == speeds[1] > speeds[2] > speeds[4]
    assert speeds == sorted(speeds, reverse=True)


def over_ground(floor_until_m: float, blind: bool) -> Along:
    """A hall along x whose floor is known as far as told; beyond it is blind, or nothing."""
    terrain = corridor(40, 20)
    x = (np.arange(terrain.frame.cols) + 0.5) * CELL
    known = np.broadcast_to(x <= floor_until_m, terrain.frame.shape)
    beyond = terrain.traversable & ~known & blind
    footing = Footing(terrain.frame, terrain.traversable & known, beyond)
    return Along(terrain, field_to(terrain, 2.4, 0.5), footing)


def end_of(course: Along, cliffs_watch: bool = False, seconds: float = 12.0) -> tuple[float, float]:
    """Where it comes to, x in m, and how fast it was at most beyond 1.2 m."""
    pose, twist, fastest = Pose(0.4, 0.5, 0.0), STILL, 0.0
    for _ in range(round(seconds / 0.05)):
        twist = velocity_policy.steer(
            course, pose, twist, 0.05, RADIUS, CFG, cliffs_watch=cliffs_watch
        )
        pose = moved(pose, twist, 0.05)
        fastest = max(fastest, twist.v_mps) if pose.x_m > 1.2 else fastest
    return pose.x_m, fastest


def test_where_the_floor_that_was_seen_ends_the_robot_halts_on_it():
    x_m, _ = end_of(over_ground(1.2, blind=False))
    assert 1.0 < x_m < 1.2 - RADIUS / 2 + CELL


def test_what_was_never_in_view_is_crept_over():
    x_m, fastest = end_of(over_ground(1.2, blind=True), seconds=20.0)
    assert x_m > 1.4
    assert 0 < fastest <= 0.05


def test_where_cliffs_are_watched_the_speed_lets_it_halt_within_its_radius():
    x_m, fastest = end_of(over_ground(1.2, blind=False), cliffs_watch=True)
    assert x_m > 2.0
    assert 0.05 < fastest <= velocity_policy.within_rim_mps(RADIUS, CFG) < CFG.max_speed_mps


@pytest.mark.parametrize("cliffs_watch", [True, False])
def test_floor_that_was_only_swept_is_slow_where_sensors_could_tell_that_it_is_none(
    cliffs_watch: bool,
):
    swept = over_ground(9.0, blind=False)
    x = (np.arange(swept.terrain.frame.cols) + 0.5) * CELL
    seen = swept.footing.floor & (x <= 1.0)
    course = replace(swept, footing=replace(swept.footing, seen=seen))
    x_m, fastest = end_of(course, cliffs_watch)
    assert x_m > 2.0
    rim_mps = velocity_policy.within_rim_mps(RADIUS, CFG)
    assert fastest <= rim_mps if cliffs_watch else fastest > 1.2 * rim_mps


def test_on_floor_that_was_seen_nothing_is_slower():
    whole = over_ground(9.0, blind=False)
    bare = replace(whole, footing=None)
    assert end_of(whole) == end_of(bare)
