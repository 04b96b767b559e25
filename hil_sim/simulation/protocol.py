"""Benchmark protocols: what the robot can do and sense, and what counts as success.

`hm3d`: HM3D ObjectNav 2022 (habitat-challenge). STOP within 0.1 m, geodesic, of a place that is
within 1.0 m of the object and sees it.

`robothor`: RoboTHOR 2021. STOP with the object visible and within 1.0 m. Visible here: at least
100 pixels of it in the frame that STOP answered; within: from the robot to its box, on the plan
(AI2-THOR measures to the object's position, up to half its size more). Actions are noisy; the
odometry, as the challenge's GPS and compass, is not. The camera is held level; episodes begin with
it 30 degrees down, and `tilt="episode"` keeps it there.

`onrobot`: a differential drive under velocity commands, with a noisy camera, slipping wheels and
drifting odometry. Success as hm3d's, within 0.25 m: a base that brakes, and whose odometry is a
few centimetres off, cannot end closer than that on purpose.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hil_sim.simulation.noise import NONE, USUAL, Noise, parse_noise
from runtime.core.types import Intrinsics
from runtime.errors import ConfigError


@dataclass(frozen=True)
class GoalSighting:
    """One instance of the goal, in one frame."""

    pixels: int
    depth_m: float  # median of its pixels; inf when none is seen
    box_m: float  # from the robot to its footprint, on the plan


@dataclass(frozen=True)
class Ending:
    """How an episode ended, for a protocol's success rule."""

    stopped: bool  # the robot itself said stop
    distance_m: float  # geodesic, to the nearest success position; inf when cut off
    sightings: tuple[GoalSighting, ...] = ()  # in the last frame


@dataclass(frozen=True)
class DifferentialDrive:
    """A differential drive. Commands are cut to its limits; one that no other follows within
    `watchdog_s` expires, and the base brakes."""

    speed_mps: float = 0.5
    turn_radps: float = 1.5
    accel_mps2: float = 0.8
    turn_accel_radps2: float = 4.0
    watchdog_s: float = 0.5


@dataclass(frozen=True)
class Protocol:
    """One benchmark's robot, camera and rule. With a `base` the robot drives continuously;
    without one it takes discrete actions."""

    name: str
    success: Callable[[Ending], bool]
    max_steps: int = 500  # observations
    observe_s: float = 0.5  # simulated time between two of them
    step_m: float = 0.25
    turn_rad: float = math.radians(30)
    base: DifferentialDrive | None = None
    width: int = 640
    height: int = 480
    hfov_rad: float = math.radians(79)
    camera_z_m: float = 0.88
    tilt_rad: float = 0.0  # of the camera, positive looks down
    depth_min_m: float = 0.0
    depth_max_m: float = math.inf
    whole_mm: bool = False  # depth is told so, as most cameras do
    noise: Noise = NONE
    laser: bool = False  # a scan on `scan`
    bumper: bool = False  # whether something is touched, on `bumper`
    cliffs: bool = False  # what is under sensors at the body's rim, on `cliff/...`

    @property
    def intrinsics(self) -> Intrinsics:
        """Square pixels, principal point in the middle."""
        focal = self.width / 2 / math.tan(self.hfov_rad / 2)
        return Intrinsics(focal, focal, self.width / 2, self.height / 2, self.width, self.height)

    @property
    def settings(self) -> tuple[str, ...]:
        """What the runtime must know of this robot, as `--set` values."""
        camera = (f"camera.z_m={self.camera_z_m!r}", f"camera.pitch_rad={self.tilt_rad!r}")
        return (*camera, 'research.control_mode="velocity"') if self.base else camera

    def sensed(self, depth_m: NDArray[np.float32]) -> NDArray[np.float32]:
        """(H, W) depth, m -> what the sensor reads; 0 outside its range."""
        inside = (depth_m >= self.depth_min_m) & (depth_m <= self.depth_max_m)
        sensed: NDArray[np.float32] = np.where(inside, depth_m, 0).astype(np.float32)
        if self.whole_mm:
            sensed = (np.round(sensed * 1000) / 1000).astype(np.float32)
        return sensed


SUCCESS_M = 0.1
ONROBOT_SUCCESS_M = 0.25
VISIBLE_PIXELS, VISIBLE_M = 100, 1.0
EPISODE_TILT_RAD = math.radians(30)
EXTRAS = ("laser", "bumper", "cliffs")


def _near(end: Ending) -> bool:
    return end.stopped and end.distance_m <= SUCCESS_M


def _about_near(end: Ending) -> bool:
    return end.stopped and end.distance_m <= ONROBOT_SUCCESS_M


def _visible(end: Ending) -> bool:
    return end.stopped and any(
        s.pixels >= VISIBLE_PIXELS and s.box_m <= VISIBLE_M for s in end.sightings
    )


HM3D = Protocol(
    name="hm3d",
    success=_near,
    depth_min_m=0.5,
    depth_max_m=5.0,
)
ROBOTHOR = Protocol(
    name="robothor", success=_visible, camera_z_m=0.87, noise=Noise(motion=USUAL.motion)
)
ONROBOT = replace(
    HM3D,
    name="onrobot",
    success=_about_near,
    max_steps=1500,
    observe_s=0.2,
    base=DifferentialDrive(),
    depth_min_m=0.3,
    noise=replace(USUAL, motion=0.0),
)
PROTOCOLS = {protocol.name: protocol for protocol in (HM3D, ROBOTHOR, ONROBOT)}


def protocol_named(
    name: str, tilt: str = "level", noise: Iterable[str] = (), extras: Iterable[str] = ()
) -> Protocol:
    """A protocol by name, perhaps with other noise (`parse_noise`), a tilted camera
    (`tilt="episode"`) or `extras` (EXTRAS). ConfigError lists the known ones."""
    if name not in PROTOCOLS:
        raise ConfigError(f"protocol {name}: unknown; known: {', '.join(sorted(PROTOCOLS))}")
    protocol = PROTOCOLS[name]
    if tilt not in ("level", "episode"):
        raise ConfigError(f"tilt {tilt}: must be level or episode")
    if tilt == "episode":
        if name != "robothor":
            raise ConfigError(f"tilt episode: protocol {name}'s camera is level; use robothor")
        protocol = replace(protocol, tilt_rad=EPISODE_TILT_RAD)
    wanted = set(extras)
    for extra in sorted(wanted - set(EXTRAS)):
        raise ConfigError(f"sensor {extra}: unknown; known: {', '.join(EXTRAS)}")
    return replace(
        protocol,
        laser="laser" in wanted,
        bumper="bumper" in wanted,
        cliffs="cliffs" in wanted,
        noise=parse_noise(noise, protocol.noise),
    )
