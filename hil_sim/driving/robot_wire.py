"""How a robot's topics are on Zenoh: behind zenoh-bridge-ros2dds, or natively by rmw_zenoh.

Written down here once more, with hashes as ROS 2's own packages (Jazzy) carry them: a runtime that
speaks it otherwise is not understood.
"""

import struct
import time
from typing import Final, Literal

Spoken = Literal["ros2dds", "rmw_zenoh"]

_IMAGE: Final = (
    "sensor_msgs::msg::dds_::Image_",
    "RIHS01_d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47",
)
_TWIST: Final = (
    "geometry_msgs::msg::dds_::Twist_",
    "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
)
_BOOL: Final = (
    "std_msgs::msg::dds_::Bool_",
    "RIHS01_feb91e995ff9ebd09c0cb3d2aed18b11077585839fb5db80193b62d74528f6c9",
)
_TYPES: Final = {
    "camera/color/image_raw": _IMAGE,
    "camera/depth/image_raw": _IMAGE,
    "camera/color/camera_info": (
        "sensor_msgs::msg::dds_::CameraInfo_",
        "RIHS01_b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275",
    ),
    "odom": (
        "nav_msgs::msg::dds_::Odometry_",
        "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
    ),
    "cmd_vel": _TWIST,
    "cmd_vel_teleop": _TWIST,
    "battery_state": (
        "sensor_msgs::msg::dds_::BatteryState_",
        "RIHS01_4bee5dfce981c98faa6828b868307a0a73f992ed0789f374ee96c8f840e69741",
    ),
    "scan": (
        "sensor_msgs::msg::dds_::LaserScan_",
        "RIHS01_64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828",
    ),
    "bumper": _BOOL,
    "stop": _BOOL,
    "cliff": (
        "sensor_msgs::msg::dds_::Range_",
        "RIHS01_b42b62562e93cbfe9d42b82fe5994dfa3d63d7d5c90a317981703f7388adff3a",
    ),
    "rfnav": (
        "std_msgs::msg::dds_::String_",
        "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
    ),
}
"""By topic, or by what stands before its first slash."""
_GID: Final = bytes(range(16))  # of all that this robot publishes


class RobotWire:
    """Keys and attachments of one robot, in domain 0, whose topics are called as by default."""

    def __init__(self, spoken: Spoken = "ros2dds") -> None:
        self.spoken, self._count = spoken, 0

    def key(self, topic: str) -> str:
        """Where a topic is; it may have a wildcard after its first slash."""
        if self.spoken == "ros2dds":
            return topic
        kind = _TYPES.get(topic) or _TYPES[topic.split("/")[0]]
        return "/".join(("0", topic, *kind))

    def topic(self, key: str) -> str:
        """The other way round."""
        return key if self.spoken == "ros2dds" else "/".join(key.split("/")[1:-2])

    def attachment(self) -> bytes | None:
        """What goes with the next message."""
        if self.spoken == "ros2dds":
            return None
        self._count += 1
        return struct.pack("<qqB", self._count, time.time_ns(), len(_GID)) + _GID

    @property
    def settings(self) -> tuple[str, ...]:
        """How the runtime is told of it."""
        return (f'bus.dialect="{self.spoken}"', 'bus.distro="jazzy"', "bus.domain=0")
