"""The reflex of a replay: it sees the depth images of then, and now and then an obstacle that
somebody holds before the camera. Is the base held as long as it is there, and only so long?

The base is the recorded one, which drives on: what is held before its camera stays there. An image
counts from when the loop took it.
"""

import statistics
import threading
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from runtime.config import Config
from runtime.core.motion.caution import FREE, Caution
from runtime.core.optics.upright import upright_mount
from runtime.core.settings import NavigateConfig
from runtime.core.types import F32, Observation, Pose, Scan, Twist
from runtime.loops.plans import Tick
from runtime.replay.script import Turn, observed
from runtime.replay.stand_ins import FilmClock
from runtime.robot.images.camera_images import DepthImage
from runtime.robot.optics import DepthSight
from runtime.robot.reflex import Reflex, swept
from runtime.robot.sync import RawMessage
from runtime.robot.transforms import CameraConfig

HELD_S: Final = 3.0  # an obstacle, and nothing for as long before and after it
RESUME_S: Final = 0.3  # after it is gone, at most
FALSE_SHARE: Final = 0.01  # of the turns that drive, at most


@dataclass
class HeldAccount:
    """Of turns of control that wanted to drive forward: `held` while an obstacle was there, of
    which the base was told to stand in `stood`; `free` while none was, with `false` stops. How long
    after the first image without it the base was told to go on, s, each time."""

    held: int = 0
    stood: int = 0
    free: int = 0
    false: int = 0
    resumed_s: list[float] = field(default_factory=list)

    @property
    def well(self) -> bool:
        """Whether it was held all that time, went on soon, and stood for nothing else."""
        on_again = max(self.resumed_s, default=0.0) <= RESUME_S
        return 0 < self.held == self.stood and on_again and self.false <= FALSE_SHARE * self.free

    def in_words(self) -> str:
        """For people."""
        if not self.held:
            return "an obstacle was held before the camera, but the base did not drive meanwhile"
        again = "never on again"
        if self.resumed_s:
            middle, most = statistics.median(self.resumed_s), max(self.resumed_s)
            again = f"on again after {middle:.2f} s, {most:.2f} s at most"
        return (
            f"an obstacle held before the camera: stood in {self.stood} of {self.held} turns that "
            f"would have driven; {again}; false stops: {self.false} of {self.free} turns that drove"
        )


class ReflexAgain:
    """Shown each frame's turn, asked in each turn of control, and told what came of it; `clock`:
    of the control loop."""

    def __init__(self, config: Config) -> None:
        self.account, self.clock, self._frame = HeldAccount(), FilmClock(), _Frame()
        body, changed = swept(config.navigate), threading.Condition()
        self._reflex = Reflex(self._frame, changed, self.clock, body, config.camera)
        self._camera, self._radius_m = config.camera, body.radius_m
        self._began_s: float | None = None
        self._there, self._gone_s = False, 0.0
        self._waits = False  # to go on, since it is gone
        self._wished = Twist()

    def sweeps(self, config: NavigateConfig, camera: CameraConfig) -> None:
        """A goal brings another body, or camera."""
        self._reflex.sweeps(swept(config), camera)
        self._camera, self._radius_m = camera, config.robot.radius_m

    def show(self, turn: Turn) -> None:
        """The frame that a turn began with, with or without an obstacle in it."""
        obs, now_s = observed(turn), float(turn.told["now_s"])
        began_s = self._began_s = now_s if self._began_s is None else self._began_s
        there = int((now_s - began_s) / HELD_S) % 2 == 1
        if self._there and not there:
            self._gone_s, self._waits = now_s, True
        self._there = there
        depth_m = obs.depth_m
        if there:
            mount = obs.mount or upright_mount(self._camera)
            depth_m = _obstructed(depth_m, self._radius_m - mount.x_m)
        self._frame.obs, self._frame.image = obs, DepthImage(depth_m.copy(), 1.0)
        self._reflex.look(RawMessage(obs.stamp_ns, b"", now_s))

    def caution(self, twist: Twist, pose: Pose | None) -> Caution:
        """What it leaves of a command now."""
        self._wished = twist
        return self._reflex.caution(twist, pose) if self._began_s is not None else FREE

    def note(self, tick: Tick) -> None:
        """What a turn of control came to."""
        account, stands = self.account, tick.sent is None or tick.sent.v_mps <= 0
        if self._began_s is None or self._wished.v_mps <= 0:
            if self._waits:
                self._gone_s = tick.now_s  # it does not want to go on yet
            return
        if self._there:
            account.held += 1
            account.stood += stands
        elif not self._waits:
            account.free += 1
            account.false += stands
        elif not stands:
            account.resumed_s.append(tick.now_s - self._gone_s)
            self._waits = False


def _obstructed(depth_m: F32, ahead_m: float) -> F32:
    """(H, W) m, with something in the middle third, so far along the optical axis."""
    third, seen = depth_m.shape[1] // 3, depth_m.copy()
    seen[:, third:-third] = max(ahead_m, 0.05)
    return seen


class _Frame:
    """The newest frame, as the reflex asks for it."""

    def __init__(self) -> None:
        self.obs: Observation | None = None
        self.image = DepthImage(np.zeros((1, 1), np.float32), 1.0)

    def newest_depth(self) -> RawMessage | None:
        return None  # it is shown

    def depth(self, raw: RawMessage) -> DepthImage:
        return self.image

    def pose_at(self, stamp_ns: int, alone: bool = False) -> Pose | None:
        return self.obs.pose if self.obs is not None else None

    def sight(self, depth: RawMessage, depth_m: F32) -> DepthSight | None:
        """What was recorded is upright already, and of colour's camera."""
        obs = self.obs
        return DepthSight(depth_m, obs.intrinsics, obs.mount) if obs is not None else None

    def near_scan(self, stamp_ns: int) -> Scan | None:
        return self.obs.scan if self.obs is not None else None
