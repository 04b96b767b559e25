"""What a doctor might have heard of a robot, made up by hand."""

import math

import numpy as np

from runtime.config import Config
from runtime.core.types import Intrinsics
from runtime.doctor.hearing import (
    Arrival,
    HeardInfo,
    HeardPose,
    HeardTopic,
    Hearing,
    NetworkHeard,
)
from runtime.doctor.reading import topics_heard

S = 10**9
BEGAN_S = 1_700_000_000.0  # by the wall's clock
LEVEL = Intrinsics(97.06, 97.06, 80.0, 60.0, 160, 120)
FRAME = "camera_color_optical_frame"


def came(
    heard: HeardTopic,
    hz: float,
    seconds: float = 5.0,
    age_s: float = 0.01,
    clock_s: float = 0.0,
) -> HeardTopic:
    """Messages at an even rate; `clock_s`: how far their clock is ahead of ours."""
    for n in range(round(hz * seconds)):
        at_s = n / hz
        stamp_ns = round((BEGAN_S + at_s - age_s + clock_s) * S)
        heard.came(Arrival(stamp_ns, 100.0 + at_s, BEGAN_S + at_s, 1000))
    heard.read = heard.received
    return heard


def floor_depth(
    height_m: float = 0.88, pitch_rad: float = 0.0, k: Intrinsics = LEVEL
) -> np.ndarray:
    """(H, W) m: an endless floor, and a wall 4 m ahead, as a camera sees them that is so high and
    looks down by that pitch. By hand, without the runtime's own geometry."""
    v = (np.arange(k.height) + 0.5 - k.cy) / k.fy  # down, per metre along the axis
    down = v * math.cos(pitch_rad) + math.sin(pitch_rad)
    ahead = math.cos(pitch_rad) - v * math.sin(pitch_rad)
    with np.errstate(divide="ignore"):
        depth = np.minimum(np.where(down > 0, height_m / down, np.inf), 4.0 / ahead)
    return np.repeat(depth[:, None], k.width, axis=1).astype(np.float32)


def healthy(config: Config) -> Hearing:
    """Of a robot that stands, with nothing wrong about it."""
    streams = topics_heard(config)
    for name, hz in (("color", 10.0), ("depth", 10.0), ("camera_info", 10.0), ("odom", 20.0)):
        came(streams[name], hz)
        streams[name].frame = FRAME
    streams["color"].what, streams["depth"].what = "rgb8 160x120", "16UC1 160x120"
    heard = Hearing(5.0, streams, NetworkHeard(routers=1, told=("router 1.5.0",), base=True))
    heard.info, heard.intrinsics, heard.frames = HeardInfo(LEVEL, FRAME), LEVEL, 50
    heard.depths = [floor_depth()] * 3
    heard.odometry = [still(n) for n in range(100)]
    return heard


def still(n: int, frame: str = "odom", child: str = "base_link") -> HeardPose:
    """The n-th of a robot that stands, 20 a second."""
    return HeardPose(n * S // 20, frame, child, (1.0, 2.0), (0.0, 0.0, 0.0, 1.0))
