"""Where the bus is: configuration, topics, and opening a Zenoh session."""

import json
from dataclasses import dataclass, field
from typing import Literal

import zenoh

from runtime.errors import BusError


@dataclass(frozen=True)
class TopicsConfig:
    """Names on the bus, without leading slash. A colour topic that ends in /compressed is one."""

    color: str = "camera/color/image_raw"
    depth: str = "camera/depth/image_raw"
    camera_info: str = "camera/color/camera_info"
    odom: str = "odom"
    pose: str = ""  # geometry_msgs/PoseStamped of a SLAM; used in place of odom when set
    cmd_vel: str = "cmd_vel"
    action: str = "rfnav/action"
    state: str = "rfnav/state"
    decision: str = "rfnav/decision"
    feedback: str = "rfnav/feedback"
    detections: str = "rfnav/detections"  # read when detector.source is "topic"
    goal: str = "rfnav/goal"
    cancel: str = "rfnav/cancel"
    status: str = "rfnav/status"


@dataclass(frozen=True)
class BusConfig:
    """Where the bus is and what runs on it. Scouting is off as soon as an endpoint is given."""

    mode: str = "peer"  # or "client" (of a router or bridge)
    connect: tuple[str, ...] = ()  # e.g. "tcp/127.0.0.1:7447"
    listen: tuple[str, ...] = ()
    prefix: str = ""  # the robot's ROS namespace
    topics: TopicsConfig = field(default_factory=TopicsConfig)
    pair_tolerance_s: float = 0.02  # between a colour image and its depth image
    odometry_gap_s: float = 0.25  # longest span that is interpolated over
    sensor_timeout_s: float = 5.0  # how long a stream may stay away before the first frame
    cmd_vel_type: Literal["Twist", "TwistStamped"] = "Twist"
    cmd_vel_frame: str = "base_link"  # of a TwistStamped

    def key(self, topic: str) -> str:
        """Zenoh key of a topic, in the ros2dds dialect."""
        return "/".join(part for part in (self.prefix.strip("/"), topic.strip("/")) if part)


def open_session(config: BusConfig) -> zenoh.Session:
    """A Zenoh session as configured; BusError when that is impossible.

    A peer whose `connect` endpoint is not there yet keeps trying in the background.
    """
    if config.mode not in ("peer", "client"):
        raise BusError(f"bus.mode: {config.mode!r} is not a mode: use peer or client")
    if config.mode == "client" and not config.connect:
        raise BusError('bus.connect: a client needs a router, e.g. ["tcp/127.0.0.1:7447"]')
    settings: dict[str, object] = {
        "mode": config.mode,
        "connect/endpoints": list(config.connect),
        "transport/shared_memory/enabled": False,
    }
    if config.connect or config.listen:
        settings["scouting/multicast/enabled"] = False
        settings["scouting/gossip/enabled"] = False
        settings["scouting/delay"] = 0
        settings["listen/endpoints"] = list(config.listen)  # none: no open port beside them
    where = ", ".join((*config.connect, *config.listen)) or "multicast scouting"
    try:
        zenoh_config = zenoh.Config()
        for key, value in settings.items():
            zenoh_config.insert_json5(key, json.dumps(value))
        return zenoh.open(zenoh_config)
    except zenoh.ZError as error:
        what = " ".join(str(error).split(" at /")[0].split())
        raise BusError(f"bus ({config.mode}, {where}): cannot be opened: {what}") from error
