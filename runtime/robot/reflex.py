"""The reflex: every depth image as it comes, before any colour is there to match it and before any
map knows of it, is held against the way that the body is about to sweep.

A thread of its own decodes the newest image, which its frame is then spared, and finds what stands
near (`core/mapping`); the control loop asks in every turn what of its command that allows.
"""

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, Protocol

from runtime.clock import Clock
from runtime.core.mapping.floor_plane import mount_by_floor
from runtime.core.mapping.near_memory import Nearby, NearMemory
from runtime.core.mapping.near_points import near_points
from runtime.core.motion.caution import FREE, Caution
from runtime.core.motion.courses import STILL
from runtime.core.motion.reflex import cautioned, sure_mps
from runtime.core.motion.safety import Halt, HaltKind, SafetyConfig
from runtime.core.motion.velocity_policy import FRESH_S
from runtime.core.settings import NavigateConfig
from runtime.core.types import F32, Mount, Pose, Scan, Twist
from runtime.errors import ConfigError, SensorError
from runtime.robot.images.camera_images import DepthImage
from runtime.robot.optics import DepthSight
from runtime.robot.sync import RawMessage
from runtime.robot.transforms import FIXED, CameraConfig

IDLE_S: Final = 2.0  # without a question nobody drives, and no image is looked at
POSE_S: Final = 0.05  # odometry may come so much later than an image of the same moment
UNSEEN_S: Final = 999.0  # nothing was ever seen
SAFETY: Final = SafetyConfig()


@dataclass(frozen=True)
class SweptBody:
    """What drives: a disc, how high it is, how it brakes, and how far its camera's depth is good;
    m and m/s^2."""

    radius_m: float
    height_m: float
    brake_mps2: float
    max_depth_m: float


def swept(config: NavigateConfig) -> SweptBody:
    """As it is configured."""
    robot, brake_mps2 = config.robot, config.control.brake_mps2
    return SweptBody(robot.radius_m, robot.height_m, brake_mps2, config.map.max_depth_m)


def check(config: NavigateConfig) -> None:
    """ConfigError for a speed from which the robot would not halt before what steps in front."""
    most, control = config.control.max_speed_mps, config.control
    sure = sure_mps(config.robot.radius_m, control.brake_mps2, config.map.max_depth_m)
    if not most <= sure:
        raise ConfigError(
            f"control.max_speed_mps: is {most:g}; by depth images up to {FRESH_S:g} s old, braking "
            f"with {control.brake_mps2:g} m/s^2 (control.brake_mps2), the robot halts before what "
            f"steps in front from {math.floor(100 * sure) / 100:g} m/s: set that, or less"
        )


class DepthStreams(Protocol):
    """The sensor streams, as far as depth is concerned; see `SensorStreams`."""

    def newest_depth(self) -> RawMessage | None: ...

    def depth(self, raw: RawMessage) -> DepthImage: ...

    def pose_at(self, stamp_ns: int, alone: bool = False) -> Pose | None: ...

    def sight(self, depth: RawMessage, depth_m: F32) -> DepthSight | None: ...

    def near_scan(self, stamp_ns: int) -> Scan | None: ...


class Reflex:
    """`caution`, `doubt` and `close` may be called from any thread. `changed` is notified whenever
    something came; `urgent` is called, in the reflex's thread, when what is driven now has to be
    slower. `stale_s`: how old the newest image may be that it has looked at."""

    def __init__(
        self,
        streams: DepthStreams,
        changed: threading.Condition,
        clock: Clock,
        body: SweptBody,
        camera: CameraConfig = FIXED,
        topic: str = "depth",
        urgent: Callable[[], None] = lambda: None,
        stale_s: float = SAFETY.depth_stale_s,
    ) -> None:
        self.urgent, self._stale_s = urgent, stale_s
        self._streams, self._changed, self._clock = streams, changed, clock
        self._topic, self._memory = topic, NearMemory()
        self._body, self._camera = body, camera
        self._mount: Mount | None = None  # as it was in the image before
        self._near: Nearby | None = None
        self._looked_s = -math.inf  # as of when, by arrival and stamp, it knows what is near
        self._unplaced_s = -math.inf  # as of when the newest image is, where it lacks odometry
        self._blank_s = -math.inf  # or a single reading
        self._unusable = "", math.inf  # the newest image that could not be looked at; since when
        self._asked, self._asked_s = STILL, -IDLE_S
        self._braked_mps, self._brakes_s = 0.0, -IDLE_S  # from how fast it was stopped; until when
        self._closed = False
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="reflex", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def sweeps(self, body: SweptBody, camera: CameraConfig) -> None:
        """From the next image on, it is that body, and the camera is there."""
        self._body, self._camera, self._mount = body, camera, None

    def caution(self, twist: Twist, pose: Pose | None) -> Caution:
        """What is near leaves of a velocity that is about to be driven, from where the base is now;
        raises what ended the reflex, if anything did."""
        if self._error is not None:
            raise self._error
        now_s, brake = self._clock.now_s(), self._body.brake_mps2
        self._asked, self._asked_s = twist, now_s
        if twist.v_mps > 0 and self._is_blind(now_s):
            since_s = min(now_s - self._looked_s, UNSEEN_S)
            what = f"{self._topic}: without a single reading for {since_s:.1f} s"
            return Caution(HaltKind.FRAME, what, most_mps=0.0)
        caution = self._judge(twist, pose)
        if caution.most_mps <= 0 and twist.v_mps > self._braked_mps:
            self._braked_mps, self._brakes_s = twist.v_mps, now_s + twist.v_mps / brake
        elif now_s >= self._brakes_s:
            self._braked_mps = 0.0
        elif twist.v_mps > 0:  # it is told to go on while it still rolls as fast as it was
            rolling = self._judge(Twist(self._braked_mps, twist.w_radps), pose)
            return replace(rolling, most_mps=0.0) if rolling != FREE else caution
        return caution

    def doubt(self) -> Halt | None:
        """Why nothing is driven: what is near was looked at too long ago, or no image could ever be
        looked at. What lacks odometry is told by whoever waits for that, and so is that no image
        has come yet."""
        now_s = self._clock.now_s()
        age_s = now_s - self._looked_s
        if math.isinf(age_s):
            error, since_s = self._unusable
            return Halt(HaltKind.FRAME, error) if now_s - since_s > self._stale_s else None
        unplaced = now_s - self._unplaced_s <= self._stale_s
        if age_s <= self._stale_s or unplaced or self._is_blind(now_s):
            return None
        what = f"{self._topic}: the newest image that can be used is {age_s:.1f} s old"
        return Halt(HaltKind.FRAME, f"{what}, safety.depth_stale_s is {self._stale_s:g}")

    def look(self, image: RawMessage) -> None:
        """What an image shows near by, in the thread of who calls: the reflex's own, once it was
        started. One that is damaged is counted where it is matched."""
        try:
            depth_m = self._streams.depth(image).solid()  # its frame may take it, too
            sight = self._streams.sight(image, depth_m)
        except SensorError as error:
            self._unusable = str(error), min(self._unusable[1], self._clock.now_s())
            return
        if sight is None:
            return
        pose = self._pose_at(image.stamp_ns)
        self._unplaced_s = image.arrival_s if pose is None else -math.inf
        if pose is None:
            return
        depth_m, intrinsics = sight.depth_m, sight.intrinsics
        if not depth_m.any():
            self._blank_s = image.arrival_s
            return
        body, nominal = self._body, sight.mounted(self._camera)
        mount = sight.mount or nominal
        if self._camera.mount == "floor":
            mount = mount_by_floor(depth_m, intrinsics, nominal, self._mount or nominal)
        self._mount = mount
        seen = near_points(depth_m, intrinsics, mount, body.height_m, body.max_depth_m)
        near = self._memory.add(seen, depth_m, pose, intrinsics, mount, image.stamp_ns)
        scan = self._streams.near_scan(image.stamp_ns)
        self._near = self._memory.with_scan(near, scan, pose, body.radius_m)
        self._looked_s, self._unusable = image.arrival_s, ("", math.inf)
        caution = self._judge(self._asked, pose)
        if caution.allowed(self._asked) != self._asked:
            self.urgent()

    def close(self) -> None:
        """End the thread. Idempotent; not holding `changed`."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        if self._thread.is_alive():
            self._thread.join(timeout=1.0)

    # -- inside --------------------------------------------------------------------------------

    def _judge(self, twist: Twist, pose: Pose | None) -> Caution:
        near = self._near
        if near is None or pose is None:
            return FREE  # how old what is known may be is the guard's business
        return cautioned(twist, pose, near, self._body.radius_m, self._body.brake_mps2)

    def _is_blind(self, now_s: float) -> bool:
        """Whether images come, and show nothing: too near, too far, or a lens that is covered. It
        does not drive on by them; it may turn, for it may have driven up to a wall."""
        seen, blank = now_s - self._looked_s, now_s - self._blank_s
        return seen > self._stale_s >= blank

    def _run(self) -> None:
        last: RawMessage | None = None
        try:
            while True:
                with self._changed:
                    while (newest := self._streams.newest_depth()) is last and not self._closed:
                        self._clock.wait(self._changed, self._clock.now_s() + 1.0)
                    if self._closed:
                        return
                last = newest
                if newest is not None and self._clock.now_s() - self._asked_s < IDLE_S:
                    self.look(newest)
        except BaseException as error:  # noqa: BLE001 -- raised again by `caution`
            self._error = error

    def _pose_at(self, stamp_ns: int) -> Pose | None:
        """Where the base was; the odometry after an image may come a little after it, or is not
        waited for."""
        until_s = self._clock.now_s() + POSE_S
        with self._changed:
            while not self._closed and self._clock.now_s() < until_s:
                pose = self._streams.pose_at(stamp_ns)
                if pose is not None:
                    return pose
                self._clock.wait(self._changed, until_s)
            return self._streams.pose_at(stamp_ns, alone=True)
