"""What is put in the way of a robot that drives at speed: whether it is touched, and how long it
takes until zero is commanded.

    trials = HazardTrials(wanted, kinds, seed)
    run_hazards(episode, home, runtime, protocol, method, log_dir, trials, speed_mps)

The body appears with the frame that first shows it, as whatever steps in front does, and goes again
some seconds later.
"""

import math
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hil_sim.driving.base_wires import CmdVelWire
from hil_sim.driving.camera_process import CameraProcess, Glance, Shot
from hil_sim.driving.episode_run import run_episode
from hil_sim.driving.hazard_trials import (
    SEEN_PX,
    SIZES,
    TOLD_S,
    HazardTrial,
    HazardTrials,
    halting_m,
)
from hil_sim.driving.link import HarnessError, Runtime
from hil_sim.driving.lockstep import EpisodeRun
from hil_sim.driving.realtime import drive
from hil_sim.driving.stage import StagedHome
from hil_sim.ground_truth.episodes import Episode
from hil_sim.ground_truth.freespace import BODY_RADIUS_M
from hil_sim.simulation.body import ROUND, Body
from hil_sim.simulation.faults import When
from hil_sim.simulation.mishaps import Mishaps
from hil_sim.simulation.protocol import DifferentialDrive, Protocol
from runtime.core.geometry import rays
from runtime.core.types import Mount, Pose, Twist

AT_SPEED = 0.7  # of the speed allowed, from which on something appears,
STRAIGHT_RADPS = 0.25  # and no faster turned than that
STANDS_S = 3.0  # so long what appeared stays,
BETWEEN_S = 2.0  # and so long after it nothing does
RESUMED_S = 5.0  # after which nobody waits any more for the robot to go on
TOUCHED_M = 0.05  # between body and thing, when it is that which was run into
NEAR_SIDE_M = 0.1  # from where it is nearest: of its near side
NEAR_M = 0.03  # of its surface: a pixel is of it
EVERY_PX = 3  # one of so many, each way, is looked at: the base waits meanwhile


def run_hazards(
    episode: Episode,
    home: StagedHome,
    runtime: Runtime,
    protocol: Protocol,
    method: str,
    log_dir: Path,
    trials: HazardTrials,
    speed_mps: float,
    search: int = 0,
    renderer: str = "auto",
) -> None:
    """One episode in real time, no faster than that, and what can be tried in it; HarnessError
    where it failed."""
    protocol = replace(protocol, base=protocol.base or DifferentialDrive())
    with CameraProcess(home.scene, protocol, episode.id, trials.seed, renderer) as camera:

        def play(run: EpisodeRun) -> None:
            hazards = _Hazards(run, camera, trials, speed_mps, search)
            run.mishaps = hazards
            drive(run, hazards, base_wire=hazards.wire)

        result = run_episode(
            episode, home, runtime, protocol, method, log_dir, seed=trials.seed, play=play,
            settings=(f"control.max_speed_mps={speed_mps!r}",),
        )  # fmt: skip
    if result.ended.failed:
        raise HarnessError(result.ended.why)


class _Hazards(Mishaps):
    """The hazards of one episode: it puts them there, and watches camera, base and commands."""

    def __init__(
        self,
        run: EpisodeRun,
        camera: CameraProcess,
        trials: HazardTrials,
        speed_mps: float,
        search: int,
    ) -> None:
        home = run.home
        super().__init__((), run.seed, run.episode, home.scene, home.ground, home.populate)
        assert isinstance(run.driver, Runtime)
        self._run, self._camera, self._trials = run, camera, trials
        self._speed_mps, self._search, self.busy = speed_mps, search, camera.busy
        self.wire = _WatchedWire(run.driver, self._heard, self._rolled)
        self._trial: HazardTrial | None = None
        self._body: Body | None = None
        self._glance: Glance | None = None
        self._began_s = self._ended_s = self._rolled_s = time.monotonic()
        self._shown_s: float | None = None
        self._collisions, self._rolled_mps = 0, 0.0
        self._last, self._stood = Twist(), False  # commanded; stood when the body went
        self._rng = np.random.default_rng([trials.seed, search])

    # -- as the loop's mishaps, camera and wire ------------------------------------------------

    def move_bodies(self, when: When, robot: Pose) -> None:
        """Put something there, take it away again; all before the world is looked at."""
        now_s, trial = time.monotonic(), self._trial
        if trial is None:
            self._try(now_s, robot)
        elif self._body is not None:
            if now_s - self._began_s > STANDS_S:
                self._body, self._ended_s = None, now_s
                self._stood = self._last == Twist()
        elif trial.resumed_s is not None or not self._stood or now_s - self._ended_s > RESUMED_S:
            self._trials.done.append(trial)
            self._trial, self._ended_s = None, now_s
        self.bodies = (self._body,) if self._body is not None else ()
        self.populate(self.bodies)
        if self._trial is None and self._trials.next_kind() is None:
            self._run.tally.robot = replace(self._run.tally.robot, stopped=True)

    def look(self, glance: Glance) -> None:
        self._glance = glance
        self._camera.look(glance)
        self.busy = self._camera.busy

    def seen(self) -> Shot | None:
        sight, glance, trial = self._camera.seen(), self._glance, self._trial
        self.busy = self._camera.busy
        if sight is not None and glance is not None and glance.bodies and trial is not None:
            pixels = pixels_of(
                glance.bodies[0], sight.true_depth_m, glance.pose, self._run.protocol
            )
            if trial.zero_s is None:
                trial.pixels = max(trial.pixels, pixels)
            if pixels >= SEEN_PX and self._shown_s is None:
                self._shown(trial)
        return sight

    # -- inside --------------------------------------------------------------------------------

    def _try(self, now_s: float, robot: Pose) -> None:
        """Where the robot goes fast and straight, and there is room: something ahead."""
        twist, kind = self._run.tally.robot.twist, self._trials.next_kind()
        fast = twist.v_mps >= AT_SPEED * self._speed_mps and abs(twist.w_radps) < STRAIGHT_RADPS
        if kind is None or not fast or now_s - self._ended_s < BETWEEN_S:
            return
        sizes, ahead_m = SIZES[kind], float(self._rng.uniform(*self._trials.ahead_m))
        size = sizes[int(self._rng.integers(len(sizes)))]
        deep_m = size[0] if kind in ROUND else size[1]
        middle_m = BODY_RADIUS_M + ahead_m + deep_m / 2
        x, y, hit = self.ground.move(robot.x_m, robot.y_m, robot.yaw_rad, middle_m + deep_m / 2)
        if hit:
            return
        x = robot.x_m + middle_m * math.cos(robot.yaw_rad)
        y = robot.y_m + middle_m * math.sin(robot.yaw_rad)
        self._body = Body(kind, x, y, robot.yaw_rad + math.pi / 2, size)
        self._trial = HazardTrial(kind, ahead_m, size[2], twist.v_mps, self._search)
        self._began_s, self._shown_s = now_s, None
        self._collisions = self._run.tally.robot.collisions

    def _gap_m(self) -> float:
        """Between the body and what is there."""
        assert self._body is not None
        at = self._run.tally.robot.pose
        return self._body.distance_m(at.x_m, at.y_m) - BODY_RADIUS_M

    def _rolled(self) -> None:
        """Fifty times a second: how near it came, and whether it runs into what is there."""
        robot, now_s = self._run.tally.robot, time.monotonic()
        passed_s, self._rolled_s = now_s - self._rolled_s, now_s
        rolled_mps, self._rolled_mps = self._rolled_mps, robot.twist.v_mps
        trial = self._trial
        if trial is None or self._body is None:
            return
        gap_m = self._gap_m()
        trial.gap_m = min(trial.gap_m, gap_m)
        if gap_m > TOUCHED_M or not robot.touching:
            return
        if not trial.touched and robot.collisions > self._collisions:
            trial.touched, trial.touch_mps = True, rolled_mps
        if trial.touched and robot.order_left_s > 0 and robot.order.v_mps > 0:
            trial.pushed_s += passed_s

    def _shown(self, trial: HazardTrial) -> None:
        """The first image that shows it is on its way to the runtime."""
        self._shown_s = time.monotonic()
        if self._body is None:
            return
        brake_mps2, gap_m = self._trials.brake_mps2, self._gap_m()
        trial.due = halting_m(self._last.v_mps, brake_mps2, TOLD_S) >= gap_m
        if halting_m(self._last.v_mps, brake_mps2) <= gap_m:
            trial.slow_s = 0.0

    def _heard(self, twist: Twist) -> None:
        """A command on its way to the base."""
        trial, now_s, self._last = self._trial, time.monotonic(), twist
        if trial is None:
            return
        if self._body is None:
            if self._stood and trial.resumed_s is None and twist != Twist():
                trial.resumed_s = now_s - self._ended_s
            return
        shown_s = now_s - self._shown_s if self._shown_s is not None else None
        halts = halting_m(twist.v_mps, self._trials.brake_mps2) <= self._gap_m()
        if trial.slow_s is None and halts:
            trial.slow_s = shown_s
        if trial.zero_s is None and twist.v_mps <= 0:
            trial.zero_s, trial.shown_zero_s = now_s - self._began_s, shown_s


class _WatchedWire(CmdVelWire):
    """Tells of each command before the base has it, and of each time that it rolled."""

    def __init__(
        self, runtime: Runtime, heard: Callable[[Twist], None], rolled: Callable[[], None]
    ) -> None:
        super().__init__(runtime)
        self._tell, self._rolled = heard, rolled

    def command(self, now_s: float) -> Twist | None:
        twist = super().command(now_s)
        if twist is not None:
            self._tell(twist)
        return twist

    def report(self, pose: Pose, stamp_ns: int, now_s: float) -> None:
        super().report(pose, stamp_ns, now_s)
        self._rolled()


def pixels_of(body: Body, true_depth_m: NDArray[np.float32], pose: Pose, protocol: Protocol) -> int:
    """About how many pixels of a true depth image (H, W) m, within the sensor's range, are of the
    near side of a body that stands on the floor, scene frame: of a low box a camera may see the far
    part of its top alone, which does not tell where it begins."""
    mount = Mount(z_m=protocol.camera_z_m, pitch_rad=protocol.tilt_rad)
    table = rays(protocol.intrinsics, mount, EVERY_PX)
    first = EVERY_PX // 2
    depth = protocol.sensed(true_depth_m[first::EVERY_PX, first::EVERY_PX])
    ahead, left = depth * table.forward, depth * table.left
    up = depth * table.up + mount.z_m
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    near_m = body.distance_m(pose.x_m, pose.y_m) + NEAR_SIDE_M
    near = np.hypot(ahead, left) < near_m
    x, y = pose.x_m + c * ahead - s * left - body.x_m, pose.y_m + s * ahead + c * left - body.y_m
    width, deep, high = body.size_m
    c, s = math.cos(body.yaw_rad), math.sin(body.yaw_rad)
    if body.kind in ROUND:
        inside = np.hypot(x, y) < width / 2 + NEAR_M
    else:
        inside = np.abs(c * x + s * y) < width / 2 + NEAR_M
        inside &= np.abs(c * y - s * x) < deep / 2 + NEAR_M
    shown = inside & near & (depth > 0) & (up > NEAR_M) & (up < high + NEAR_M)
    return EVERY_PX * EVERY_PX * int(shown.sum())
