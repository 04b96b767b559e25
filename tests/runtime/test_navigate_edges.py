"""The whole loop beside a stairwell and on a platform, in whole steps and in velocities: it goes
about its search, and never falls."""

import math
from dataclasses import replace

import numpy as np
import pytest
from apartment import NO_DETECTIONS
from pit import LEVEL, RADIUS_M, TILTED, Pit

from runtime import navigate
from runtime.core.motion.courses import ControlConfig
from runtime.core.motion.discrete_policy import FORWARD_M, TURN_RAD
from runtime.core.types import Action, Ballot, Observation, Pose, Twist
from runtime.core.world import CREEPING, World

STAIRWELL = Pit((0.0, 1.0, -1.3, 1.3, 2.7), low=(-2.5, -2.5), high=(4.0, 3.5))
PLATFORM = Pit((-1.6, 1.6, -1.2, 1.2, 0.75), low=(-4.0, -4.0), high=(4.0, 4.0), island=True)
SMALL = Pit((-0.4, 0.4, -0.3, 0.3, 0.75), low=(-3.0, -3.0), high=(3.0, 3.0), island=True)
STEPS = 120
TICK_S, OBSERVE_S = 0.02, 0.2


@pytest.fixture(autouse=True, scope="module")
def every_pixel_is_used():
    """So that the small image shows as much as one of 320 x 240."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("runtime.core.mapping.grid.STRIDE", 1)
        yield


class Silent:
    def ask(self, brief, by):
        return Ballot()


def beside(rng: np.random.Generator, gap_m: float) -> Pose:
    """A start that far from one of the stairwell's long edges."""
    x = -gap_m if rng.random() < 0.5 else 1.0 + gap_m
    return Pose(x, float(rng.uniform(-1.0, 1.0)), float(rng.uniform(-math.pi, math.pi)))


def near_the_rim(rng: np.random.Generator, gap_m: float) -> Pose:
    """One that far from the platform's rim."""
    side, along = int(rng.integers(4)), float(rng.uniform(-0.8, 0.8))
    x, y = (
        (1.6 - gap_m, along),
        (-1.6 + gap_m, along),
        (along, 1.2 - gap_m),
        (along, -1.2 + gap_m),
    )[side]
    return Pose(x, y, float(rng.uniform(-math.pi, math.pi)))


def relative(pose: Pose, start: Pose) -> Pose:
    """As odometry tells it."""
    dx, dy = pose.x_m - start.x_m, pose.y_m - start.y_m
    c, s = math.cos(start.yaw_rad), math.sin(start.yaw_rad)
    yaw = math.remainder(pose.yaw_rad - start.yaw_rad, math.tau)
    return Pose(c * dx + s * dy, c * dy - s * dx, yaw)


def search(pit: Pit, start: Pose, mode: str, steps: int = STEPS) -> tuple[list[Pose], list[str]]:
    """Where it was, and what it said it did."""
    cfg = navigate.NavigateConfig(control=ControlConfig(mode=mode))
    pose, stamp, poses, said = start, 0, [start], []
    world = World.begin("toilet", ("toilet",), (), relative(start, start), RADIUS_M)
    for _ in range(steps):
        stamp += round(OBSERVE_S * 1e9)
        seen = pit.observe(pose)
        here = relative(pose, start)
        obs = Observation(stamp, seen.rgb, seen.depth_m, here, seen.intrinsics)
        navigate.perceive(world, obs, NO_DETECTIONS, pit.mount, cfg)
        if why := navigate.due(world, cfg):
            snap = navigate.snapshot(world, why, cfg)
            navigate.adopt(world, navigate.decide(snap, Silent(), None, cfg))
        command = navigate.steer(world, navigate.act(world, cfg), cfg)
        said.append(command.reason)
        if command.action is Action.STOP:
            break
        for twist, seconds in told(command.action, command.twist):
            pose = rolled(pit, pose, twist, seconds)
            poses.append(pose)
            if pit.falls(pose.x_m, pose.y_m):
                return poses, said
    return poses, said


def told(action: Action, twist: Twist | None) -> list[tuple[Twist, float]]:
    """What the base does until the next observation."""
    if twist is not None:
        return [(twist, TICK_S)] * round(OBSERVE_S / TICK_S)
    if action is Action.MOVE_FORWARD:
        return [(Twist(FORWARD_M / 10, 0.0), 1.0)] * 10
    return [(Twist(0.0, TURN_RAD if action is Action.TURN_LEFT else -TURN_RAD), 1.0)]


def rolled(pit: Pit, pose: Pose, twist: Twist, seconds: float) -> Pose:
    yaw = pose.yaw_rad + twist.w_radps * seconds
    way, middle = twist.v_mps * seconds, (pose.yaw_rad + yaw) / 2
    x, y = pose.x_m + way * math.cos(middle), pose.y_m + way * math.sin(middle)
    at = (pose.x_m, pose.y_m) if pit.hits(x, y) else (x, y)
    return Pose(*at, yaw)


@pytest.mark.parametrize("mode", ["discrete", "velocity"])
@pytest.mark.parametrize("mount", [LEVEL, TILTED])
@pytest.mark.parametrize(
    ("pit", "place"), [(STAIRWELL, beside), (PLATFORM, near_the_rim)], ids=["stairwell", "platform"]
)
def test_from_beside_an_edge_the_robot_searches_and_does_not_fall(pit, place, mount, mode):
    rng, far = np.random.default_rng(7), []
    for _ in range(3):
        start = place(rng, float(rng.uniform(0.21, 0.45)))
        poses, _ = search(replace(pit, mount=mount), start, mode)
        assert not any(pit.falls(pose.x_m, pose.y_m) for pose in poses), start
        far.append(max(math.hypot(p.x_m - start.x_m, p.y_m - start.y_m) for p in poses))
    assert max(far) > FORWARD_M  # it is not that it stays where it is


@pytest.mark.parametrize("mode", ["discrete", "velocity"])
def test_on_a_table_it_stays(mode):
    poses, said = search(SMALL, Pose(0.0, 0.0, 0.3), mode, steps=200)
    assert not any(SMALL.falls(pose.x_m, pose.y_m) for pose in poses)
    assert "nothing left to explore: hardly any free floor was seen: the robot is shut" in said[-1]


def test_where_it_creeps_it_says_so():
    """A wall 0.8 m before and behind, and nothing of the floor between them in view."""
    hall = Pit(None, low=(-0.8, -0.9), high=(0.8, 3.0))
    _, said = search(hall, Pose(0.0, -0.2, math.pi), "velocity", steps=150)
    assert not any(CREEPING in reason for reason in said[:20])  # it looks around first
    creeps = [reason for reason in said if CREEPING in reason]
    assert len(creeps) < len(said)
