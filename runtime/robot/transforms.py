"""Where the camera is on the base, by `tf`: a tree of frames, each told relative to its parent."""

import math
import struct
import threading
from bisect import bisect_right
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final, Literal

import numpy as np

from runtime.core.geometry import mount_of
from runtime.core.keys import key
from runtime.core.optics.upright import quarters_of
from runtime.core.types import F64, Mount
from runtime.errors import ConfigError, SensorError
from runtime.robot import wire
from runtime.robot.bounds import check_frame
from runtime.robot.wire import FrameTransform

TF, TF_STATIC = "tf", "tf_static"  # their names on every robot
RAW_KEPT: Final = 2000  # messages between two images
FRAMES: Final = 500  # on one robot; more names are somebody's mistake
KEPT: Final = 200  # of a frame, the newest
HELD_NS: Final = 250_000_000  # how far from its stamp a transform may be used
CLOCK_BACK_NS: Final = 1_000_000_000  # a stamp so much older: a clock was set back
DEPTH: Final = 64  # frames above one another, else they run in a circle
STEEP_RAD: Final = math.radians(75.0)
UP_RAD: Final = math.radians(30.0)  # on its side besides: a body's frame, x ahead, that nods
_DIGITS: Final = 3  # a mount is told to 1 mm and 1 mrad: one that rests does not tremble


@dataclass(frozen=True)
class CameraConfig(Mount):
    """[camera]: the mount, and whether it is that."""

    mount: Literal["fixed", "tf", "floor"] = key(
        "fixed",
        'Whether the camera stays as it is mounted; "tf": tf says where it is, "floor": it tilts '
        "or is carried, and the floor that it sees says how.",
    )
    base_frame: str = key(
        "base_link", "Frame of the base in tf, on the floor.", research="camera_base_frame"
    )
    frame: str = key(
        "", "The camera's optical frame in tf; \"\": the depth image's.", research="camera_frame"
    )
    depth_unit_m: float = key(
        0.0,
        "What one step of a depth image is; 0: 1 mm where it has 16 bits, 1 m where it has floats.",
        "m",
        within=(0.0, 1.0),
    )
    depth_nothing_m: float = key(
        0.0,
        "Depth that reads so much or more is nothing, as simulated cameras have it that give their "
        "farthest where nothing is near; 0: no such number.",
        "m",
        within=(0.0, 100.0),
    )

    depth_at: tuple[float, ...] = key(
        (),
        "Where the depth camera is on the colour camera, where depth is not colour's, pixel by "
        "pixel, and tf_static does not say: [x, y, z, roll, pitch, yaw], x ahead, y left, z up; "
        "six zeros: depth is colour's, whatever its frame is called.",
        "m, rad",
        within=(-3.2, 3.2),
    )

    @property
    def turned(self) -> int:
        """By how many quarter turns it leans to the right."""
        return quarters_of(self.roll_rad)

    @property
    def by_tf(self) -> tuple[str, str] | None:
        """The base's and the camera's frame where tf is gone by."""
        return (self.base_frame, self.frame) if self.mount == "tf" else None


FIXED: Final = CameraConfig()


def check(config: CameraConfig) -> None:
    """ConfigError for values that do not go together."""
    if len(config.depth_at) not in (0, 6):
        raise ConfigError(
            f"camera.depth_at: has {len(config.depth_at)} values, must have none, or x, y, z (m), "
            "roll, pitch, yaw (rad)"
        )


class UnplacedError(SensorError):
    """tf does not say where something is; perhaps it will."""


@dataclass
class _Link:
    """A frame below its parent: what was told of it, oldest first."""

    parent: str
    static: bool
    told: deque[FrameTransform] = field(default_factory=lambda: deque(maxlen=KEPT))


class Transforms:
    """Any thread may call. What is damaged is told to `bad`, holding no lock, and the rest is gone
    on with."""

    def __init__(self, bad: Callable[[SensorError], None]) -> None:
        self._bad, self._damaged = bad, deque[SensorError]()
        self._reading = threading.Lock()
        # By topic: what never moves is told once, and nothing that comes often may push it out.
        self._raw = {topic: deque[bytes](maxlen=RAW_KEPT) for topic in (TF_STATIC, TF)}
        self._links: dict[str, _Link] = {}

    def file(self, topic: str, payload: bytes) -> None:
        """Keep a message of `TF` or `TF_STATIC`."""
        self._raw[topic].append(payload)

    @property
    def known(self) -> bool:
        """Whether anything was told at all."""
        return bool(self._links or any(self._raw.values()))

    def mount(self, base: str, camera: str, stamp_ns: int) -> Mount:
        """The camera's optical frame on the base at that time; SensorError when tf does not say."""
        placed = self.placed(base, camera, stamp_ns)
        mount = mount_of(placed[:3, :3], placed[:3, 3], _DIGITS)
        on_its_side = quarters_of(mount.roll_rad) % 2 and mount.pitch_rad < -UP_RAD
        if on_its_side or abs(mount.pitch_rad) > STEEP_RAD:
            where = "up, on its side" if on_its_side else "straight down"
            where = "straight up" if mount.pitch_rad < -STEEP_RAD else where
            raise SensorError(
                f"{TF}: {camera} looks {where}: set "
                "research.camera_frame to the optical frame (x right, y down, z ahead)"
            )
        return mount

    def placed(self, base: str, frame: str, stamp_ns: int | None = None) -> F64:
        """(4, 4) from a frame to the base's at that time, or as it was told last; UnplacedError
        when tf does not say."""
        try:
            with self._reading:
                self._decode()
                return self._between(base, frame, stamp_ns)
        finally:
            while self._damaged:
                self._bad(self._damaged.popleft())

    def _between(self, base: str, frame: str, stamp_ns: int | None) -> F64:
        base, frame = base.lstrip("/"), frame.lstrip("/")
        up, down = self._above(frame), self._above(base)
        shared = next((one for one in up if one in down), None)
        if shared is None:
            told = ", ".join(sorted(self._links)) or "nothing"
            raise UnplacedError(
                f"{TF}: no way from {base} to {frame}; known are {told}: publish it, or set "
                "research.camera_base_frame and research.camera_frame"
            )
        to_shared = self._to(shared, frame, up, stamp_ns)
        from_base = self._to(shared, base, down, stamp_ns)
        found: F64 = np.linalg.inv(from_base) @ to_shared
        return found

    def _decode(self) -> None:
        """Take in what was filed."""
        for topic, raw in self._raw.items():
            while raw:
                try:
                    told = wire.decode_transforms(raw.popleft(), topic)
                except SensorError as error:
                    told = [error]
                for one in told:
                    if isinstance(one, SensorError):
                        self._damaged.append(one)
                    else:
                        self._take_in(one, topic == TF_STATIC)

    def _take_in(self, one: FrameTransform, static: bool) -> None:
        if one.child not in self._links and len(self._links) >= FRAMES:
            self._damaged.append(
                SensorError(f"{TF}: {one.child}: more than {FRAMES} frames on one robot")
            )
            return
        link = self._links.get(one.child)
        if link is None or link.parent != one.parent:
            link = self._links[one.child] = _Link(one.parent, static)
        newest_ns = link.told[-1].stamp_ns if link.told else one.stamp_ns
        if link.static or one.stamp_ns < newest_ns - CLOCK_BACK_NS:
            link.told.clear()
        if not link.told or one.stamp_ns > link.told[-1].stamp_ns:
            link.told.append(one)

    def _above(self, frame: str) -> list[str]:
        """The frame, its parent, and so on."""
        found = [frame]
        while found[-1] in self._links and len(found) < DEPTH:
            found.append(self._links[found[-1]].parent)
        return found

    def _to(self, top: str, frame: str, above: list[str], stamp_ns: int | None) -> F64:
        """(4, 4) from a frame to one above it."""
        placed = np.eye(4)
        for name in above[: above.index(top)]:
            placed = _matrix(self._at(name, stamp_ns)) @ placed
        return placed

    def _at(self, frame: str, stamp_ns: int | None) -> FrameTransform:
        """What was told of a frame, at a time: between its neighbours, or the nearest; or last."""
        link = self._links[frame]
        if link.static or stamp_ns is None:
            return link.told[-1]
        n = bisect_right(link.told, stamp_ns, key=lambda one: one.stamp_ns)
        before, after = link.told[max(0, n - 1)], link.told[min(n, len(link.told) - 1)]
        away_ns = min(abs(stamp_ns - before.stamp_ns), abs(stamp_ns - after.stamp_ns))
        if away_ns > HELD_NS:
            raise UnplacedError(
                f"{TF}: {frame} was told {away_ns / 1e9:.2f} s from the image's time: publish it "
                "at 10 Hz or more, by the camera's clock"
            )
        return _between(before, after, stamp_ns)


def _between(before: FrameTransform, after: FrameTransform, stamp_ns: int) -> FrameTransform:
    """A straight line, and the shorter way round; outside of the two, the nearer."""
    span_ns = after.stamp_ns - before.stamp_ns
    share = min(1.0, max(0.0, (stamp_ns - before.stamp_ns) / span_ns)) if span_ns else 0.0
    a, b = before.quaternion, after.quaternion
    turned = (1 - share) * a + share * (b if a @ b >= 0 else -b)
    moved = (1 - share) * before.translation_m + share * after.translation_m
    unit = turned / np.linalg.norm(turned)
    return FrameTransform(before.parent, before.child, stamp_ns, moved, unit)


def _matrix(one: FrameTransform) -> F64:
    """(4, 4), from the child to its parent."""
    x, y, z, w = one.quaternion
    placed = np.eye(4)
    placed[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    placed[:3, 3] = one.translation_m
    return placed


def peek_frame(payload: bytes, topic: str) -> str:
    """The frame_id of any message that starts with a std_msgs/Header, without decoding the rest."""
    wire.peek_stamp(payload, topic)  # it is a stamped message
    order = "<" if payload[1] else ">"
    size = struct.unpack_from(order + "I", payload, 12)[0] if len(payload) >= 16 else 0
    if not 0 < size <= len(payload) - 16:
        raise SensorError(f"{topic}: {len(payload)} bytes have no frame_id")
    return check_frame(payload[16 : 15 + size].decode("utf-8", "replace"), topic)
