"""Whether names on the bus are names, before anything is opened by them."""

from dataclasses import fields
from typing import Final

import zenoh

from runtime.errors import ConfigError
from runtime.robot.session import BusConfig

NEEDED: Final = ("color", "depth", "camera_info", "odom", "cmd_vel")  # by each robot, one topic


def check_topics(config: BusConfig) -> None:
    """ConfigError for a topic that is none, is needed and not there, or is used for two things."""
    used: dict[str, str] = {}
    for one in fields(config.topics):
        topic = getattr(config.topics, one.name)
        if not topic and one.name not in NEEDED:
            continue
        name = f"bus.topics.{one.name}"
        if one.name in NEEDED and (not topic.strip("/") or "*" in topic):
            raise ConfigError(f'{name}: is "{topic}", must be one topic, e.g. "{one.default}"')
        try:
            zenoh.KeyExpr(config.key(topic))
        except zenoh.ZError as error:
            wrong = f'"{config.key(topic)}" is no name on the bus'
            example = one.default or "robot/pose"
            raise ConfigError(f'{name}: {wrong}; must be like "{example}"') from error
        if (other := used.setdefault(topic.strip("/"), name)) != name:
            raise ConfigError(f"{name}: {topic} is {other} too: two things, two topics")
