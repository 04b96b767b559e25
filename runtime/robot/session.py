"""Where the bus is: configuration, topics, and opening a Zenoh session."""

import json
import os
from dataclasses import dataclass, field
from typing import Final, Literal

import zenoh

from runtime.core.keys import key
from runtime.errors import BusError, ConfigError
from runtime.robot.endpoints import TlsConfig, check_endpoint, check_files

ACTION = "rfnav/action"  # our own names on the bus, the same on every robot
STATE = "rfnav/state"
DECISION = "rfnav/decision"
FEEDBACK = "rfnav/feedback"
LABELS = "rfnav/labels"  # read unless `research.detector_source` is "model"
QUESTION = "rfnav/question"  # to a harness, and what it answers, where experts are told
VOTES = "rfnav/votes"
GOAL = "rfnav/goal"
CANCEL = "rfnav/cancel"
STATUS = "rfnav/status"
STOP = "rfnav/stop"
RELEASE = "rfnav/release"
PACKED: Final = {"color": ("/compressed",), "depth": ("/compressed", "/compressedDepth")}
"""What the topics of such images end in, as image_transport has it."""
DRAWN: Final = ("map", "path", "frontiers", "objects", "detections", "zones", "diagnostics")
DEFAULT_LISTEN: Final = ("tcp/127.0.0.1:7447",)  # Zenoh's own port, on this computer alone
OWN_TOPICS = {
    "action": ACTION, "state": STATE, "decision": DECISION, "feedback": FEEDBACK,
    "labels": LABELS,
}  # fmt: skip
"""What is published and heard; what is asked is in `requests.py`, each kind on `rfnav/KIND`."""


@dataclass(frozen=True)
class TopicsConfig:
    """Names on the bus, without leading slash. From `pose` on, but for cmd_vel, they are used where
    somebody publishes on them; "" is not listened to."""

    color: str = key(
        "camera/color/image_raw", "Colour images; those of /compressed are compressed."
    )
    depth: str = key(
        "camera/depth/image_raw",
        "Depth images, of colour's camera or one beside it; those of /compressedDepth are "
        "compressed.",
    )
    camera_info: str = key("camera/color/camera_info", "The camera's intrinsics.")
    odom: str = key("odom", "nav_msgs/Odometry of the base.")
    pose: str = key("", "geometry_msgs/PoseStamped of a SLAM, used in place of odom when set.")
    cmd_vel: str = key("cmd_vel", "Where velocities are commanded.")
    teleop: str = key(
        "cmd_vel_teleop",
        "Twist(Stamped) of a hand on the sticks; while it speaks, we do not.",
    )
    battery: str = key("battery_state", "sensor_msgs/BatteryState.")
    scan: str = key("scan", "sensor_msgs/LaserScan of a level laser.")
    bumper: str = key("bumper", "std_msgs/Bool, true while something is touched.")
    cliff: str = key("cliff/*", "sensor_msgs/Range of sensors that look down at the body's rim.")
    stop: str = key("stop", "std_msgs/Bool of a stop button: once true, until rfnav/release.")
    hazards: str = key(
        "hazard_detection", "irobot_create_msgs/HazardDetectionVector: bumper, cliffs, wheels."
    )


@dataclass(frozen=True)
class BusConfig:
    """Where the bus is and what runs on it. Nobody is looked for, and nobody finds us: only
    endpoints that are given are used."""

    mode: Literal["peer", "client"] = key(
        "peer", '"peer", or "client" of a router or bridge such as zenoh-bridge-ros2dds.'
    )
    connect: tuple[str, ...] = key((), 'Endpoints to connect to, e.g. "tcp/127.0.0.1:7447".')
    listen: tuple[str, ...] = key(
        (),
        'Endpoints to listen on; where none to connect to is given either, "tcp/127.0.0.1:7447". '
        "Beyond this computer both are tls/HOST:PORT, with [bus.tls].",
    )
    dialect: Literal["ros2dds", "rmw_zenoh"] = key(
        "ros2dds",
        'How ROS 2 is spoken: "ros2dds" behind zenoh-bridge-ros2dds, "rmw_zenoh" with nodes whose '
        "RMW that is.",
    )
    distro: Literal["humble", "jazzy", "kilted", "lyrical"] = key(
        "jazzy", "The ROS 2 distribution of those nodes."
    )
    domain: int = key(0, "Their ROS_DOMAIN_ID.", within=(0, 232))
    prefix: str = key("", "The robot's ROS namespace.")
    cmd_vel_type: Literal["Twist", "TwistStamped"] = key(
        "Twist", '"TwistStamped" is what newer ROS 2 bases want.'
    )
    cmd_vel_frame: str = key("base_link", "Frame of a TwistStamped.")
    compressed: tuple[str, ...] = key(
        (),
        'Of "color" and "depth", what comes as CompressedImage although its topic\'s name does not '
        "end in /compressed or /compressedDepth.",
    )
    draws: tuple[str, ...] = key(
        DRAWN, "What is published for others to draw; [] for nothing of it."
    )
    map_frame: str = key(
        "",
        'Frame of a localisation\'s map, e.g. "map", where its tf corrects odometry (REP 105): '
        "poses and places are told in it, too.",
    )
    topics: TopicsConfig = field(default_factory=TopicsConfig)
    tls: TlsConfig = field(default_factory=TlsConfig)

    @property
    def endpoints(self) -> tuple[tuple[str, str], ...]:
        """(key, endpoint) of all that are used."""
        listen = self.listen or (() if self.connect or self.mode == "client" else DEFAULT_LISTEN)
        named = [("bus.connect", end) for end in self.connect]
        return (*named, *(("bus.listen", end) for end in listen))

    @property
    def secured(self) -> bool:
        """Whether certificates are used."""
        return any(endpoint.startswith("tls/") for _, endpoint in self.endpoints)

    def is_packed(self, stream: str) -> bool:
        """Whether color or depth comes as CompressedImage."""
        topic: str = getattr(self.topics, stream)
        return stream in self.compressed or topic.endswith(PACKED[stream])

    def key(self, topic: str) -> str:
        """Zenoh key of our own requests, whatever the dialect."""
        return "/".join(part for part in (self.prefix.strip("/"), topic.strip("/")) if part)


@dataclass(frozen=True)
class SensesConfig:
    """[senses]: what the robot may have beside its camera. Where tf is read, it says where the
    laser is, and not these keys."""

    cliff_m: float = key(
        0.1, "A cliff sensor that measures more has no floor under it.", "m", within=(0.005, 1.0)
    )
    laser_x_m: float = key(
        0.0, "How far the laser is ahead of the base's middle.", "m", within=(-3.0, 3.0)
    )
    laser_y_m: float = key(0.0, "How far it is to the left of it.", "m", within=(-3.0, 3.0))
    laser_yaw_rad: float = key(
        0.0, "Where its angle 0 points; positive is to the left.", "rad", within=(-3.2, 3.2)
    )


def check(config: BusConfig, files: bool = False) -> None:
    """ConfigError for a bus that would be open to strangers, or cannot be opened. `files`: also
    for certificates that are not there."""
    if config.mode == "client" and not config.connect:
        raise ConfigError('bus.connect: a client needs a router, e.g. ["tcp/127.0.0.1:7447"]')
    for name in config.draws:
        if name not in DRAWN:
            raise ConfigError(f"bus.draws: {name}: must be of {', '.join(DRAWN)}")
    for name, endpoint in config.endpoints:
        check_endpoint(name, endpoint, config.tls)
    if files and config.secured:
        check_files(config.tls)


def open_session(config: BusConfig) -> zenoh.Session:
    """A Zenoh session as configured; BusError when that is impossible, ConfigError when it would be
    open to strangers.

    A peer whose `connect` endpoint is not there yet keeps trying in the background.
    """
    if config.mode not in ("peer", "client"):
        raise BusError(f"bus.mode: {config.mode!r} is not a mode: use peer or client")
    check(config, files=True)
    where = ", ".join(endpoint for _, endpoint in config.endpoints)
    try:
        zenoh_config = zenoh.Config()
        for key, value in session_settings(config).items():
            zenoh_config.insert_json5(key, os.path.expandvars(json.dumps(value)))
        return zenoh.open(zenoh_config)
    except zenoh.ZError as error:
        what = " ".join(str(error).split(" at /")[0].split())
        if not config.connect and not config.listen:  # somebody is there, whom we did not expect
            what += f'; if that is a bridge or a router: bus.connect = ["{DEFAULT_LISTEN[0]}"]'
        elif config.mode == "client":
            what += "; is the bridge or router up, and bus.connect where it listens?"
        raise BusError(f"bus ({config.mode}, {where}): cannot be opened: {what}") from error


def session_settings(config: BusConfig) -> dict[str, object]:
    """By Zenoh's names. What is off by Zenoh's default is said too: defaults change. Of files that
    are in $CREDENTIALS_DIRECTORY it says so: the guard, to which this is handed, has its own."""
    settings: dict[str, object] = {
        "mode": config.mode,
        "connect/endpoints": list(config.connect),
        "listen/endpoints": [end for name, end in config.endpoints if name == "bus.listen"],
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "scouting/delay": 0,
        "adminspace/enabled": False,
        "adminspace/permissions": {"read": False, "write": False},
        "plugins_loading/enabled": False,
        "transport/link/protocols": ["tcp", "tls"],
        "transport/shared_memory/enabled": False,
    }
    if config.secured:
        ca, certificate, private_key = config.tls.named.values()
        within = "transport/link/tls"
        settings |= {
            f"{within}/root_ca_certificate": ca,
            f"{within}/enable_mtls": True,
            f"{within}/listen_certificate": certificate,
            f"{within}/listen_private_key": private_key,
            f"{within}/connect_certificate": certificate,
            f"{within}/connect_private_key": private_key,
            f"{within}/verify_name_on_connect": True,
            f"{within}/close_link_on_expiration": True,
        }
    return settings
