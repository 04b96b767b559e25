"""What was heard of a robot: values that are judged afterwards, and that a test may make up."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import cv2
import numpy as np

from runtime.core.types import F32, F64, U8, Intrinsics, Mount
from runtime.doctor.advertised import Advertised

KEPT: Final = 20_000  # messages of a topic that are remembered one by one
WIDTH_PX: Final = 320  # of the images that are compared with each other


@dataclass(frozen=True)
class Arrival:
    """A message: its stamp, None where its type has none; when it came, by the monotonic clock and
    by the wall's; its size."""

    stamp_ns: int | None
    arrival_s: float
    wall_s: float
    size: int

    @property
    def age_s(self) -> float | None:
        """By its stamp; negative where that is ahead of this computer's clock."""
        return None if self.stamp_ns is None else self.wall_s - self.stamp_ns / 1e9


@dataclass
class HeardTopic:
    """All that came on a topic. `topic`: as it is configured; `kind`: the ROS 2 type that is
    expected there; `what`: how it describes itself (encoding and size of an image); `frame`: its
    `frame_id`; `read`: messages that were decoded, of images only some; `bad`: those that the
    runtime could not use, the last of them for `error`."""

    topic: str
    kind: str
    arrivals: list[Arrival] = field(default_factory=list)
    received: int = 0
    what: str = ""
    frame: str = ""
    read: int = 0
    bad: int = 0
    error: str = ""

    def came(self, arrival: Arrival) -> None:
        self.received += 1
        if len(self.arrivals) < KEPT:
            self.arrivals.append(arrival)

    def failed(self, error: Exception) -> None:
        self.bad += 1
        self.error = str(error)

    @property
    def rate_hz(self) -> float:
        """Messages a second, from the first to the last; 0 for fewer than two."""
        if len(self.arrivals) < 2:
            return 0.0
        span_s = self.arrivals[-1].arrival_s - self.arrivals[0].arrival_s
        return (len(self.arrivals) - 1) / span_s if span_s > 0 else 0.0

    @property
    def gaps_s(self) -> F64:
        """(N - 1,) between arrivals."""
        return np.diff(np.array([one.arrival_s for one in self.arrivals], np.float64))

    @property
    def jitter_s(self) -> float | None:
        """How far nineteen of twenty gaps are within their median; None for fewer than three."""
        gaps = self.gaps_s
        if len(gaps) < 3:
            return None
        return float(np.percentile(np.abs(gaps - np.median(gaps)), 95))

    @property
    def age_s(self) -> float | None:
        """The median age by stamps; None where there are none."""
        ages = [one.age_s for one in self.arrivals if one.age_s is not None]
        return float(np.median(ages)) if ages else None


@dataclass(frozen=True)
class HeardPose:
    """Odometry as it was told: frames, position (2,) m in the plane, quaternion (4,) x, y, z, w of
    length 1."""

    stamp_ns: int
    frame: str
    child: str
    xy: tuple[float, float]
    quaternion: tuple[float, float, float, float]

    @property
    def yaw_rad(self) -> float:
        x, y, z, w = self.quaternion
        return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


@dataclass(frozen=True)
class HeardInfo:
    """A CameraInfo as it was told. `model`, `distortion`: of its lens."""

    intrinsics: Intrinsics
    frame: str
    model: str = ""
    distortion: tuple[float, ...] = ()


@dataclass(frozen=True)
class Glimpse:
    """An image, small and grey (h, w), and the depth of its pixels (h, w) m, 0 where unknown; None
    where there was none of its time and shape."""

    stamp_ns: int
    grey: U8
    depth_m: F32 | None = None


def glimpse(stamp_ns: int, rgb: U8, depth_m: F32 | None) -> Glimpse:
    """(H, W, 3) and (H, W) m -> what is kept of them."""
    height, width = rgb.shape[:2]
    small = min(width, WIDTH_PX), max(1, round(height * min(1.0, WIDTH_PX / width)))
    grey = np.asarray(cv2.resize(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), small), np.uint8)
    if depth_m is None or depth_m.shape != (height, width):
        return Glimpse(stamp_ns, grey)
    near = cv2.resize(depth_m, small, interpolation=cv2.INTER_NEAREST)
    return Glimpse(stamp_ns, grey, np.asarray(near, np.float32))


@dataclass(frozen=True)
class NetworkHeard:
    """The bus itself. `routers`, `peers`: how many this session is linked to; `told`: what those
    say of themselves; `base`: whether somebody listens for velocities, None where that is not
    known; `commands`: velocities that somebody else commanded meanwhile; `runtime`: whether an
    `rfnav run` is on the bus; `error`: why it could not be opened."""

    routers: int = 0
    peers: int = 0
    told: tuple[str, ...] = ()
    base: bool | None = None
    commands: int = 0
    runtime: bool = False
    error: str = ""

    @property
    def alone(self) -> bool:
        return not self.routers and not self.peers


@dataclass
class Hearing:
    """Of one listening. `streams`: by the names of `bus.topics`; `advertised`: what others say that
    they publish, none where nobody tells. What the runtime made of it: `frames`, how many; of some
    the depth (H, W) m, of one the colour image; `intrinsics` and, where tf is gone by, the `mount`
    of them; `errors` by topic, the last, and why the base would be `held` now, "" where not."""

    seconds: float
    streams: Mapping[str, HeardTopic]
    network: NetworkHeard = field(default_factory=NetworkHeard)
    advertised: Sequence[Advertised] = ()
    odometry: list[HeardPose] = field(default_factory=list)
    info: HeardInfo | None = None
    frames: int = 0
    depths: list[F32] = field(default_factory=list)
    rgb: U8 | None = None
    intrinsics: Intrinsics | None = None
    mount: Mount | None = None
    glimpses: list[Glimpse] = field(default_factory=list)
    errors: Mapping[str, str] = field(default_factory=dict)
    held: str = ""
