"""Which ROS 2 types the runtime reads on which topics."""

from dataclasses import replace
from typing import Final

from runtime.robot import wire, wire_senses
from runtime.robot.dialects.dialect import Qos, RosTopic
from runtime.robot.optics import info_topic
from runtime.robot.session import LABELS, BusConfig
from runtime.robot.transforms import TF, TF_STATIC

SENSOR: Final = Qos(reliable=False, depth=5)  # what comes again soon
LATEST: Final = Qos(reliable=False)
TRANSFORMS: Final = 100  # kept of tf, as by tf2's own listeners
IMAGES: Final = ("color", "depth")

TF_TOPICS: Final = (
    RosTopic(TF, wire.TF_MESSAGE, Qos(depth=TRANSFORMS)),
    RosTopic(TF_STATIC, wire.TF_MESSAGE, Qos(latched=True, depth=TRANSFORMS)),
)
LABELS_TOPIC: Final = RosTopic(LABELS, wire.STRING)


def heard_topics(config: BusConfig) -> dict[str, RosTopic]:
    """By stream or sense, of those that have a topic."""
    topics = config.topics
    pose = wire.POSE_STAMPED if topics.pose else wire.ODOMETRY
    found = {
        "color": _image(topics.color),
        "depth": _image(topics.depth),
        "camera_info": RosTopic(topics.camera_info, wire.CAMERA_INFO, SENSOR),
        "depth_info": RosTopic(info_topic(topics.depth), wire.CAMERA_INFO, SENSOR),
        "odom": RosTopic(topics.pose or topics.odom, pose, LATEST),
        "scan": RosTopic(topics.scan, wire_senses.LASER_SCAN, SENSOR),
        "teleop": RosTopic(topics.teleop, wire.TWIST, LATEST, wire.TWIST_STAMPED),
        "battery": RosTopic(topics.battery, wire_senses.BATTERY_STATE, LATEST),
        "bumper": RosTopic(topics.bumper, wire_senses.BOOL, LATEST),
        "cliff": RosTopic(topics.cliff, wire_senses.RANGE, SENSOR),
        "hazards": RosTopic(topics.hazards, wire_senses.HAZARDS, LATEST),
        "stop": RosTopic(topics.stop, wire_senses.BOOL),
    }
    for stream in IMAGES:
        if config.is_packed(stream):
            found[stream] = replace(found[stream], kind=wire.COMPRESSED_IMAGE)
    return {name: topic for name, topic in found.items() if topic.name}


def _image(name: str) -> RosTopic:
    return RosTopic(name, wire.IMAGE, SENSOR)
