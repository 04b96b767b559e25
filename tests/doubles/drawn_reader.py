"""Messages of ROS 2 read by MCAP's own reader, which has no code in common with rosbags."""

from typing import Any

from mcap_ros2._dynamic import generate_dynamic

from runtime.robot import wire


def read(payload: bytes, kind: str) -> Any:
    """CDR -> a message, by the definition that a recording carries."""
    definition, _ = wire.STORE.generate_msgdef(kind, ros_version=2)
    return generate_dynamic(kind, definition)[kind](payload)
