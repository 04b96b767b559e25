"""Whether names on the bus are names, before anything is opened by them."""

from dataclasses import fields
from typing import Final

import zenoh

from runtime.errors import ConfigError
from runtime.robot.session import PACKED, BusConfig

NEEDED: Final = ("color", "depth", "camera_info", "odom", "cmd_vel")  # by each robot, one topic


PACKINGS: Final = ("compressed", "compressedDepth", "theora", "ffmpeg", "zstd", "draco")
"""What image_transport's topics end in; of those few are read."""


def check_topics(config: BusConfig) -> None:
    """ConfigError for a topic that is none, is needed and not there, is used for two things, or has
    images that cannot be read."""
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
    _check_images(config)


def _check_images(config: BusConfig) -> None:
    for stream, ends in PACKED.items():
        topic: str = getattr(config.topics, stream)
        last = topic.rpartition("/")[2]
        if last in PACKINGS and f"/{last}" not in ends:
            rather = topic.removesuffix(last) + ends[-1][1:]
            raise ConfigError(
                f'bus.topics.{stream}: {last} is not read; must be the raw image, or "{rather}"'
            )
    if strange := [name for name in config.compressed if name not in PACKED]:
        raise ConfigError(f'bus.compressed: "{strange[0]}" is none of "color" and "depth"')
